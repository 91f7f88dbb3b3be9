"""Whether blocks make a layout that can be analysed: no overlaps, nothing floating, no gaps by mistake."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechanics.block import Block
from mechanics.errors import DrawingError
from mechanics.joints import Joints
from mechanics.joints import find_joints
from mechanics.types import Array, Index

NEAR = 20.0  # edges that face each other within so many tolerances were likely meant to touch
LISTED = 20  # problems of one kind that are told in full

Polygons = NDArray[np.object_]


def check_layout(blocks: Sequence[Block], tolerance: float) -> tuple[str, ...]:
    """Check that blocks make an assembly, with the `tolerance` (m) with which its joints are found.

    Returns warnings: edges that face each other at more than the tolerance but less than `NEAR`
    tolerances with nothing between them, and supports that touch nothing. Raises one DrawingError that
    lists, with number, layer, handle and coordinates in m: blocks nowhere wider than the tolerance;
    blocks drawn twice; blocks that overlap by more than the tolerance (a circle of that diameter fits
    into the common area, or a vertex lies that deep inside); movable blocks that no chain of joints
    connects to a support.
    """
    polygons = shapely.polygons([shapely.linearrings(b.polygon) for b in blocks])
    problems = _too_thin(blocks, polygons, tolerance) + _overlaps(blocks, polygons, tolerance)
    joints = find_joints(blocks, tolerance)
    body, floating = _bodies(blocks, joints)
    gaps, parts = _gaps(blocks, polygons, tolerance)
    problems += _floating(blocks, body, floating)
    problems += listed(
        [gap for gap, (i, j) in zip(gaps, body[parts], strict=True) if floating[i] or floating[j]]
    )
    if problems:
        raise DrawingError(itemised("the blocks do not make an assembly", problems))
    return *listed(gaps), *_idle_supports(blocks, polygons, tolerance)


def listed(items: Sequence[str]) -> list[str]:
    """Return the items, those beyond `LISTED` being only counted."""
    more = len(items) - LISTED
    return [*items[:LISTED], f"and {more} more of this kind"] if more > 0 else list(items)


def itemised(heading: str, items: Sequence[str]) -> str:
    """Return one item as it is, several under a heading, one a line."""
    return items[0] if len(items) == 1 else "\n  - ".join([f"{heading}:", *items])


def _too_thin(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[str]:
    thin = np.flatnonzero(shapely.is_empty(_eroded(polygons, tolerance))).tolist()
    return listed(
        [
            f"{_name(blocks, i)} at {_at(blocks[i].centroid)} is nowhere wider than the joint tolerance of "
            f"{tolerance:.3g} m; remove it, or lower the tolerance"
            for i in thin
        ]
    )


def _overlaps(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[str]:
    pairs = _overlapping(blocks, polygons, tolerance)
    told = []
    for i, j in pairs[: LISTED + 1].tolist():
        common = shapely.intersection(polygons[i], polygons[j])
        where = _at(shapely.get_coordinates(shapely.point_on_surface(common))[0])
        both = f"{_name(blocks, i)} and {_name(blocks, j)}"
        if shapely.hausdorff_distance(polygons[i], polygons[j]) <= tolerance:
            told.append(f"{both} are the same outline drawn twice, at {where}; delete one")
        else:
            told.append(f"{both} overlap by {common.area:.3g} m² around {where}; correct their outlines")
    return listed(told + [""] * (len(pairs) - len(told)))


def _overlapping(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> Index:
    """Return the pairs (p, 2) of blocks that overlap by more than the tolerance, in order."""
    cores = _eroded(polygons, tolerance)
    i, j = shapely.STRtree(cores).query(cores, predicate="intersects")
    owner = np.repeat(np.arange(len(blocks)), [len(b.polygon) for b in blocks])
    vertices = shapely.points(np.concatenate([b.polygon for b in blocks]))
    v, k = shapely.STRtree(polygons).query(vertices, predicate="within")
    deep = shapely.distance(vertices[v], shapely.boundary(polygons[k])) > tolerance
    pairs = np.sort(np.concatenate([np.stack([i, j], 1), np.stack([owner[v], k], 1)[deep]]), axis=1)
    return np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)


def _eroded(polygons: Polygons, tolerance: float) -> Polygons:
    """Take a rim of half the tolerance off: what two eroded polygons share is their common area, eroded."""
    eroded: Polygons = shapely.buffer(polygons, -0.5 * tolerance)
    return eroded


def _bodies(blocks: Sequence[Block], joints: Joints) -> tuple[Index, NDArray[np.bool_]]:
    """Return the body (b,) of jointed blocks each block belongs to, and which bodies have no support."""
    n = len(blocks)
    graph = coo_array((np.ones(len(joints.a)), (joints.a, joints.b)), shape=(n, n))
    count, body = connected_components(graph, directed=False)
    floating = np.ones(count, dtype=bool)
    floating[body[[b.support is not None for b in blocks]]] = False
    return np.asarray(body, dtype=np.intp), floating


def _floating(blocks: Sequence[Block], body: Index, floating: NDArray[np.bool_]) -> list[str]:
    if floating.all():
        return ["no block is a support; name one in the table of a layer: support = …"]
    told = []
    order = np.argsort(body, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(body))[:-1]):
        i = members[0]
        if not floating[body[i]]:
            continue
        block = f"{_name(blocks, i)} at {_at(blocks[i].centroid)}"
        told.append(
            f"{block} touches nothing; move it to the block it should rest on, or delete it"
            if len(members) == 1
            else f"{block} and {len(members) - 1} more touch one another but nothing that leads to a support"
        )
    return listed(told)


def _gaps(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> tuple[list[str], Index]:
    """Return texts (g) and blocks (g, 2) of the gaps that were likely meant to be joints."""
    facing = find_joints(blocks, NEAR * tolerance)
    pair = np.stack([facing.a, facing.b], axis=1)
    sides = polygons[pair]  # (f, 2)
    ends = shapely.points(facing.ends)  # (f, 2)
    apart = shapely.distance(ends[:, :, None], sides[:, None, :]).sum(axis=2)  # (f, 2): at either end
    middle = facing.ends.mean(axis=1)
    at, k = shapely.STRtree(polygons).query(shapely.points(middle), predicate="dwithin", distance=tolerance)
    between = at[(k != pair[at, 0]) & (k != pair[at, 1])]
    open_ = apart.max(axis=1) > 1.001 * tolerance
    open_[between] = False
    texts = [
        f"{_name(blocks, a)} and {_name(blocks, b)} face each other at {_at(p)} across {_width(low, high)} "
        f"m, more than the joint tolerance of {tolerance:.3g} m: no joint; if they should touch, draw them so"
        for (a, b), (low, high), p in zip(
            pair[open_], np.sort(apart[open_], axis=1), middle[open_], strict=True
        )
    ]
    return texts, pair[open_]


def _idle_supports(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[str]:
    i, j = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=tolerance)
    alone = np.setdiff1d(np.flatnonzero([b.support is not None for b in blocks]), i[i != j]).tolist()
    return listed(
        [f"{_name(blocks, k)} at {_at(blocks[k].centroid)} is a support and touches nothing" for k in alone]
    )


def _name(blocks: Sequence[Block], index: int) -> str:
    block = blocks[index]
    origin = [f'layer "{block.layer}"'] * bool(block.layer) + [f"handle {block.handle}"] * bool(block.handle)
    return f"block {index}" + (f" ({', '.join(origin)})" if origin else "")


def _at(point: Array) -> str:
    x, z = np.round(point, 9) + 0.0  # no −0, no rounding's remains
    return f"({x:.6g}, {z:.6g}) m"


def _width(low: float, high: float) -> str:
    return f"{high:.3g}" if high - low < 0.01 * high else f"{low:.3g} to {high:.3g}"
