"""Blocks that lie in one another: copies, frames around others, and outlines that overlap; each reported once."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from mechanics.faults import Fault
from mechanics.messages import Message, message
from mechanics.model.block import Block
from mechanics.types import Array, Index

MANY = 3  # a block that overlaps at least this many others is reported once, not with each of them
SHOWN = 100  # of those others, in a picture
MOST_PAIRS = 200_000  # of blocks that overlap: there is nothing to be learnt from more
GRID = 1e-9  # of a block's width: step of the grid on which outlines are laid over each other
CHUNK = 64  # blocks whose neighbours are looked for at a time

Polygons = NDArray[np.object_]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Overlaps:
    """`faults`; `pairs` (p, 2) of blocks that overlap; `surplus` (b,): copies, and frames around other blocks.

    `original` (b,): the block that a copy repeats, −1 for what is no copy. `cut_short`: there are more than the most
    that are looked for.
    """

    faults: list[Fault]
    pairs: Index
    surplus: Flags
    original: Index
    cut_short: bool


def overlaps_of(
    blocks: Sequence[Block], polygons: Polygons, tolerance: float, most: int = MOST_PAIRS
) -> Overlaps:
    """Find the blocks that overlap by more than the tolerance (m), `most` pairs.

    A circle of that diameter fits into the common area, or a vertex lies that deep inside.
    """
    pairs, cut_short = _overlapping(blocks, polygons, tolerance, most)
    surplus, original = np.zeros(len(blocks), dtype=bool), np.full(len(blocks), -1)
    faults = [*_copies(blocks, polygons, pairs, tolerance, surplus, original)]
    others = pairs[~surplus[pairs].any(axis=1)]
    faults += _overlap_faults(blocks, polygons, others, surplus)
    if cut_short:
        text = f"more than {most} pairs of blocks overlap, and no more were looked for; mend these first"
        faults.append(Fault("overlap", text))
    return Overlaps(faults, pairs, surplus, original, cut_short)


def eroded(polygons: Polygons, tolerance: float) -> Polygons:
    """Take a rim of half the tolerance off: what two eroded polygons share is their common area, eroded."""
    cores: Polygons = shapely.buffer(polygons, -0.5 * tolerance)
    return cores


def name_of(blocks: Sequence[Block], index: int) -> Message:
    """Return number, layer and handle of a block, for a message."""
    block = blocks[index]
    origin = [f'layer "{block.layer}"'] * bool(block.layer) + [f"handle {block.handle}"] * bool(block.handle)
    if not origin:
        return message("block {number}", number=index)
    return message("block {number} ({where})", number=index, where=", ".join(origin))


def place_of(point: Array) -> str:
    """Return a point (2,) m as text, for a message."""
    x, z = np.round(point, 9) + 0.0  # no −0, no rounding's remains
    before = len(str(int(abs(np.asarray(point)).max())))
    digits = max(6, before + 4)  # far from the origin, too, to a tenth of a millimetre
    return f"({x:.{digits}g}, {z:.{digits}g}) m"


def _overlapping(
    blocks: Sequence[Block], polygons: Polygons, tolerance: float, most: int
) -> tuple[Index, bool]:
    """Return the pairs (p, 2) of blocks that overlap, in order, and whether there are more than the `most`."""
    owner = np.repeat(np.arange(len(blocks)), [len(b.polygon) for b in blocks])
    vertices = shapely.points(np.concatenate([b.polygon for b in blocks]))
    rims = shapely.boundary(polygons)
    for prepared in (polygons, rims):
        shapely.prepare(prepared)
    cores = eroded(polygons, tolerance)
    core_tree, vertex_tree = shapely.STRtree(cores), shapely.STRtree(vertices)
    found = np.empty((0, 2), dtype=np.intp)
    for first in range(0, len(blocks), CHUNK):
        chosen = slice(first, first + CHUNK)
        i, j = core_tree.query(cores[chosen], predicate="intersects")
        k, v = vertex_tree.query(polygons[chosen])
        k, v = (k + first)[owner[v] != k + first], v[owner[v] != k + first]
        # the rim first: whether a point lies inside takes all edges at its height, of rough edges as many as there are
        deep = ~shapely.dwithin(rims[k], vertices[v], tolerance)
        deep[deep] = shapely.contains(polygons[k[deep]], vertices[v[deep]])
        near = np.concatenate([np.stack([i + first, j], 1), np.stack([owner[v], k], 1)[deep]])
        near = np.sort(near[near[:, 0] != near[:, 1]], axis=1)
        found = np.unique(np.concatenate([found, near]), axis=0) if len(near) else found
        if len(found) > most:
            return found[:most], True
    return found, False


def _copies(
    blocks: Sequence[Block],
    polygons: Polygons,
    pairs: Index,
    tolerance: float,
    surplus: Flags,
    original: Index,
) -> Iterator[Fault]:
    """Yield outlines that are drawn more than once, and mark the later ones as surplus, each with its original."""
    bounds, rims = shapely.bounds(polygons), shapely.boundary(polygons)
    shapely.prepare(rims)
    alike = (abs(bounds[pairs[:, 0]] - bounds[pairs[:, 1]]) <= tolerance).all(axis=1)
    copies: dict[int, list[int]] = defaultdict(list)
    for i, j in pairs[alike].tolist():
        if surplus[i] or surplus[j] or not _within(blocks, rims, i, j, tolerance):
            continue
        copies[i].append(j)
        surplus[j], original[j] = True, i
    for i, found in copies.items():
        where = shapely.get_coordinates(shapely.point_on_surface(polygons[i]))
        others = " and ".join(name_of(blocks, j) for j in found[:2])
        more = f" and {len(found) - 2} more" if len(found) > 2 else ""
        times = "twice" if len(found) == 1 else f"{len(found) + 1} times"
        text = (
            f"{name_of(blocks, i)} and {others}{more} are the same outline drawn {times}, "
            f"at {place_of(where[0])}; keep one"
        )
        yield Fault("twice", text, where, (blocks[i].polygon,))


def _within(blocks: Sequence[Block], rims: Polygons, i: int, j: int, tolerance: float) -> bool:
    """Whether every vertex of either outline lies within the tolerance of the other."""
    return all(
        bool(shapely.dwithin(rims[a], shapely.points(blocks[b].polygon), tolerance).all())
        for a, b in ((i, j), (j, i))
    )


def _overlap_faults(
    blocks: Sequence[Block], polygons: Polygons, pairs: Index, surplus: Flags
) -> Iterator[Fault]:
    """Yield overlaps: first each block that overlaps MANY others, most of them first, then the remaining pairs.

    One that encloses all others that it overlaps is a frame, and is marked as surplus.
    """
    partners: dict[int, set[int]] = defaultdict(set)
    for i, j in pairs.tolist():
        partners[i].add(j)
        partners[j].add(i)
    queue = [(-len(others), i) for i, others in partners.items() if len(others) >= MANY]
    heapq.heapify(queue)
    while queue:
        count, i = heapq.heappop(queue)
        now = len(partners[i])
        if now < -count:  # some have been reported meanwhile
            if now >= MANY:
                heapq.heappush(queue, (-now, i))
            continue
        others = sorted(partners.pop(i))
        for j in others:
            partners[j].discard(i)
        surplus[i] = bool(shapely.contains_properly(polygons[i], polygons[others]).all())
        yield _one_with_many(blocks, polygons, i, others, bool(surplus[i]))
    for i in sorted(partners):
        for j in sorted(partners[i]):
            if i < j:
                yield _one_with_one(blocks, polygons, i, j)


def _one_with_many(
    blocks: Sequence[Block], polygons: Polygons, i: int, others: list[int], frame: bool
) -> Fault:
    some = ", ".join(str(j) for j in others[:3]) + (", …" if len(others) > 3 else "")
    if frame:
        text = (
            f"encloses {len(others)} other blocks ({some}); if it is a frame freeze its layer, else delete it"
        )
        corner = blocks[i].polygon[:1]
        ring = np.concatenate([blocks[i].polygon, corner])
        return Fault("frame", f"{name_of(blocks, i)} at {place_of(corner[0])} {text}", corner, (ring,))
    common, where = _common(polygons[i], shapely.union_all(polygons[others[:SHOWN]]))
    text = f"overlaps {len(others)} other blocks ({some}); correct its outline"
    return Fault("overlap", f"{name_of(blocks, i)} around {place_of(where[0])} {text}", where, _rings(common))


def _one_with_one(blocks: Sequence[Block], polygons: Polygons, i: int, j: int) -> Fault:
    common, where = _common(polygons[i], polygons[j])
    text = (
        f"{name_of(blocks, i)} and {name_of(blocks, j)} overlap by {common.area:.3g} m² "
        f"around {place_of(where[0])}; correct their outlines"
    )
    return Fault("overlap", text, where, _rings(common))


def _common(one: shapely.Geometry, other: shapely.Geometry) -> tuple[shapely.Geometry, Array]:
    """Return the area that two outlines share, and a point (1, 2) in it, m.

    On a grid about a corner: of outlines with nearly the same edges a plain overlay may return a whole one, or nothing.
    """
    bounds = shapely.bounds(one)
    corner, width = bounds[:2], float(np.ptp(bounds[[0, 2]]))
    near = [shapely.transform(each, lambda points: points - corner) for each in (one, other)]
    common = shapely.intersection(*near, grid_size=GRID * width)
    if common.is_empty:  # shallower than the grid
        common = shapely.intersection(*near)
    common = shapely.transform(common, lambda points: points + corner)
    return common, shapely.get_coordinates(shapely.point_on_surface(common))


def _rings(area: shapely.Geometry) -> tuple[Array, ...]:
    parts = shapely.get_parts(area)
    rings = shapely.get_exterior_ring(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    return tuple(shapely.get_coordinates(ring) for ring in rings)
