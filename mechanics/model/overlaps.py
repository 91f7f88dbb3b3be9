"""Blocks that are drawn over each other: copies, frames, overlaps, each told once, with what would mend it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from mechanics.faults import Fault
from mechanics.messages import Message, message
from mechanics.model.block import Block
from mechanics.model.dxf import can_change
from mechanics.types import Array, Index, Mask

NEAR = 20.0  # edges that face each other within this many tolerances were likely meant to touch
MOST_OVERLAPS = (1000, 4)  # pairs of blocks, and so many for each block: more teach nothing
MANY = 3  # a block that overlaps at least this many others is reported once, not with each of them
GRID = 1e-9  # of a block's width: step of the grid on which outlines are laid over each other
CHUNK = 64  # blocks whose neighbours are looked for at a time

Polygons = NDArray[np.object_]


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Pairs (p, 2) of blocks that overlap; `surplus` (b,): copies, and frames around others.

    `cut_short`: there are more pairs than are looked for.
    """

    faults: list[Fault]
    pairs: Index
    surplus: Mask
    cut_short: bool


def find_overlaps(
    blocks: Sequence[Block], polygons: Polygons, tolerance: float, most: int | None = None
) -> Overlaps:
    """Find the blocks that overlap by more than the tolerance (m), at most `most` pairs of them."""
    most = MOST_OVERLAPS[0] + MOST_OVERLAPS[1] * len(blocks) if most is None else most
    pairs, cut_short = _overlapping(blocks, polygons, tolerance, most)
    surplus = np.zeros(len(blocks), dtype=bool)
    faults = [*_copies(blocks, polygons, pairs, tolerance, surplus)]
    faults += _overlap_faults(blocks, polygons, pairs[~surplus[pairs].any(axis=1)], tolerance, surplus)
    if cut_short:
        text = f"more than {most} pairs of blocks overlap, and no more were looked for; mend these first"
        faults.append(Fault("overlap", text))
    return Overlaps(faults, pairs, surplus, cut_short)


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
    blocks: Sequence[Block], polygons: Polygons, pairs: Index, tolerance: float, surplus: Mask
) -> Iterator[Fault]:
    """Yield outlines drawn more than once, to be deleted where their role is the same; mark these as surplus."""
    bounds, rims = shapely.bounds(polygons), shapely.boundary(polygons)
    shapely.prepare(rims)

    def within(a: int, b: int) -> bool:
        return bool(shapely.dwithin(rims[a], shapely.points(blocks[b].polygon), tolerance).all())

    alike = (abs(bounds[pairs[:, 0]] - bounds[pairs[:, 1]]) <= tolerance).all(axis=1)
    copies: dict[int, list[int]] = defaultdict(list)
    for i, j in pairs[alike].tolist():
        if not surplus[i] and not surplus[j] and within(i, j) and within(j, i):
            copies[i].append(j)
            surplus[j] = True
    for i, found in copies.items():
        where = shapely.get_coordinates(shapely.point_on_surface(polygons[i]))
        others = " and ".join(name_of(blocks, j) for j in found[:2])
        more = f" and {len(found) - 2} more" if len(found) > 2 else ""
        times = "twice" if len(found) == 1 else f"{len(found) + 1} times"
        text = (
            f"{name_of(blocks, i)} and {others}{more} are the same outline drawn {times}, "
            f"at {place_of(where[0])}; keep one"
        )
        same = [j for j in found if _role(blocks[j]) == _role(blocks[i])]
        gone = tuple(handle for j in same if can_change(handle := blocks[j].handle))
        yield Fault(
            "twice", text, where, (blocks[i].polygon,), "delete" if gone else "", (blocks[i].handle, *gone)
        )


def _role(block: Block) -> tuple[object, ...]:
    """Return all that a block is, but for its place."""
    return (
        block.material, block.depth, block.support, block.vertical_load, block.load_has_mass, block.segments,
    )  # fmt: skip


def _overlap_faults(
    blocks: Sequence[Block], polygons: Polygons, pairs: Index, tolerance: float, surplus: Mask
) -> Iterator[Fault]:
    """Yield blocks that overlap MANY others, frames among them, marked as surplus, then the remaining pairs."""
    partners: dict[int, set[int]] = defaultdict(set)
    for i, j in pairs.tolist():
        partners[i].add(j)
        partners[j].add(i)
    for i in sorted(partners, key=lambda each: (-len(partners[each]), each)):
        if len(others := sorted(partners[i])) < MANY:  # the others have been told meanwhile
            continue
        for j in others:
            partners[j].discard(i)
        partners[i].clear()
        surplus[i] = bool(shapely.contains_properly(polygons[i], polygons[others]).all())
        some = ", ".join(str(j) for j in others[:3]) + (", …" if len(others) > 3 else "")
        if surplus[i]:
            corner = blocks[i].polygon[:1]
            text = (
                f"{name_of(blocks, i)} at {place_of(corner[0])} encloses {len(others)} other blocks ({some}); "
                "if it is a frame freeze its layer, or write ignore = true for it, else delete it"
            )
            yield Fault("frame", text, corner, (np.concatenate([blocks[i].polygon, corner]),))
            continue
        common, where = _common(polygons[i], shapely.union_all(polygons[others]))
        text = (
            f"{name_of(blocks, i)} around {place_of(where[0])} overlaps {len(others)} other blocks ({some})"
        )
        yield Fault("overlap", f"{text}; correct its outline", where, _rings(common))
    for i, j in sorted((i, j) for i, others in partners.items() for j in others if i < j):
        common, where = _common(polygons[i], polygons[j])
        text = (
            f"{name_of(blocks, i)} and {name_of(blocks, j)} overlap by {common.area:.3g} m² "
            f"around {place_of(where[0])}; correct their outlines"
        )
        fits = can_fit(blocks, (i, j), depth_of(polygons[i], polygons[j]), tolerance)
        yield Fault("overlap", text, where, _rings(common), "fit" if fits else "")


def can_fit(blocks: Sequence[Block], pair: Sequence[int], width: float, tolerance: float) -> bool:
    """Whether a repair may make two blocks meet that overlap by, or leave a gap of, so much, m."""
    return width <= NEAR * tolerance and any(can_change(blocks[i].handle) for i in pair)


def depth_of(one: shapely.Polygon, other: shapely.Polygon) -> float:
    """Return how far two polygons overlap, m: how deep a vertex lies in the other one, or how wide their common is."""
    common, _ = _common(one, other)
    deepest = 2.0 * float(common.area) / max(float(common.length), 1e-300)
    for outer, inner in ((one, other), (other, one)):
        corners = shapely.points(shapely.get_coordinates(inner))
        inside = corners[shapely.contains(outer, corners)]
        deepest = max(deepest, float(shapely.distance(outer.boundary, inside).max(initial=0.0)))
    return deepest


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


def polygons_of(blocks: Sequence[Block]) -> Polygons:
    """Return the outlines (b,) of blocks."""
    found: Polygons = shapely.polygons([shapely.linearrings(b.polygon) for b in blocks])
    return found


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
