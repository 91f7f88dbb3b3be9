"""Dry joints: pairs of edges of blocks that touch, divided at partial overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from mechanics.model.block import Block
from mechanics.types import Array, Index, Mask


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints between blocks `a` and `b` (j,), as drawn.

    `ends` (j, 2, 2) m: the two ends of the overlap, midway between the two edges; the tangent runs from the first
    to the second and the normal, a quarter turn anticlockwise from it, points from b into a.
    `room_a`, `room_b` (j, 2) m: first and last coordinate of the edge of a (of b) along the tangent, from the first
    end. `edges` (j, 2): indices of the two edges among those of all blocks (see block_edges).
    """

    a: Index
    b: Index
    ends: Array
    room_a: Array
    room_b: Array
    edges: Index

    @property
    def length(self) -> Array:
        """Overlap (j,), m."""
        return np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)

    @property
    def tangent(self) -> Array:
        """Unit vectors (j, 2) from the first to the second end."""
        return (self.ends[:, 1] - self.ends[:, 0]) / self.length[:, None]


def default_tolerance(outlines: Sequence[Block | Array]) -> float:
    """Return a thousandth of the median edge, m: more than the rounding of a drawing, less than a real gap.

    `outlines`: blocks, or corners (n, 2) m of outlines.
    """
    rings = [each.polygon if isinstance(each, Block) else each for each in outlines]
    return 1e-3 * float(np.median(np.concatenate([_lengths(ring) for ring in rings])))


def find_joints(blocks: Sequence[Block], tolerance: float) -> Joints:
    """Return the joints of an assembly.

    Two edges of different blocks form a joint if they run in opposite directions, overlap by more than `tolerance` (m),
    and at no place along the overlap farther apart than `tolerance`. Running bond and L- or T-contacts are partial
    overlaps and need no extra vertices; vertices in the middle of a straight edge are ignored. Two supports have no
    joint.
    """
    start, end, owner = block_edges(blocks)
    first, second = _candidates(start, end, owner, tolerance)
    fixed = np.array([b.support is not None for b in blocks])
    keep = ~(fixed[owner[first]] & fixed[owner[second]])
    first, second = first[keep], second[keep]

    unit = (end - start) / np.hypot(*(end - start).T)[:, None]
    t = unit[first] - unit[second]
    size = np.hypot(*t.T)
    keep = size > 1.9  # opposite directions to about 35°: the distance at the overlap's ends decides
    first, second, t = first[keep], second[keep], t[keep] / size[keep, None]
    n = np.stack([-t[:, 1], t[:, 0]], axis=1)

    # along the common tangent, from the start of the first edge; the first edge runs forward, the second back
    along = [_dot(p - start[first], t) for p in (start[first], end[first], end[second], start[second])]
    across = [_dot(p - start[first], n) for p in (start[first], end[first], end[second], start[second])]
    low, high = np.maximum(along[0], along[2]), np.minimum(along[1], along[3])
    overlap = high - low
    position = [
        [_interpolate(s, along[k], along[k + 1], across[k], across[k + 1]) for s in (low, high)]
        for k in (0, 2)
    ]
    apart = np.maximum(abs(position[0][0] - position[1][0]), abs(position[0][1] - position[1][1]))
    keep = (overlap > tolerance) & (apart <= tolerance)

    middle = [0.5 * (position[0][e] + position[1][e]) for e in (0, 1)]
    ends = np.stack(
        [start[first] + s[:, None] * t + m[:, None] * n for s, m in zip((low, high), middle, strict=True)],
        axis=1,
    )
    rooms = [np.stack([along[k] - low, along[k + 1] - low], axis=1)[keep] for k in (0, 2)]
    a, b, edges = owner[first][keep], owner[second][keep], np.stack([first, second], axis=1)[keep]
    order = np.lexsort((b, a))
    return Joints(a[order], b[order], ends[keep][order], rooms[0][order], rooms[1][order], edges[order])


def _candidates(start: Array, end: Array, owner: Index, tolerance: float) -> tuple[Index, Index]:
    """Return the pairs of edges of different blocks that are somewhere closer than the tolerance (m)."""
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=1.01 * tolerance)
    keep = owner[first] < owner[second]
    return first[keep], second[keep]


def block_edges(blocks: Sequence[Block]) -> tuple[Array, Array, Index]:
    """Return the straight edges of all blocks: start (e, 2) m, end (e, 2) m, block (e,)."""
    vertices = np.concatenate([b.polygon for b in blocks])
    owner = np.repeat(np.arange(len(blocks)), [len(b.polygon) for b in blocks])
    corners = _corners(vertices, owner)
    start, owner = vertices[corners], owner[corners]
    return start, start[_following(owner)], owner


def _following(owner: Index) -> Index:
    """Return the number of the next vertex around the block of each (v,); those of a block follow one another."""
    begin = np.searchsorted(owner, owner)
    following = np.arange(1, len(owner) + 1)
    last = np.append(owner[1:] != owner[:-1], True)
    following[last] = begin[last]
    return following


def _corners(v: Array, owner: Index) -> Mask:
    """Return at which vertices (n, 2) the outline of their block changes direction by more than rounding."""
    following = _following(owner)
    after, before = v[following] - v, np.empty_like(v)
    before[following] = after
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    one, other = np.hypot(*before.T), np.hypot(*after.T)
    found: Mask = abs(turn) > 1e-9 * one * other + 2.0 * np.spacing(abs(v).max()) * (one + other)
    return found


def _lengths(v: Array) -> Array:
    return np.hypot(*(np.roll(v, -1, axis=0) - v).T)


def _dot(p: Array, q: Array) -> Array:
    return np.einsum("ij,ij->i", p, q)


def _interpolate(s: Array, s0: Array, s1: Array, y0: Array, y1: Array) -> Array:
    return y0 + (y1 - y0) * (s - s0) / (s1 - s0)
