"""Faces that blocks may touch with although they did not as drawn, and joints that blocks have left for good.

A corner of one block near an edge of another that it points at makes a pair of that edge and of the flatter of the two
edges that meet in the corner: a joint like any other, whose overlap, gap and touched face follow from its kinematics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from mechanics.kernels.joint import A1, A2, B1, B2, FACE, MEET, PX, PZ, QX, QZ, TAX, TAZ, TBX, TBZ, H
from mechanics.model.block import Block, block_edges, turned
from mechanics.model.contacts import Contacts, between, end_gaps
from mechanics.types import Array, Index

POINTS_AT = 0.3  # sine of the angle by which a corner's edges may lean towards the face at which it points
STEEPEST = 0.3  # cosine between two faces of a joint
DEEPEST = 0.5  # of the thinner block: how far a corner may lie in another block that holds it


@dataclass(frozen=True, eq=False)
class Outlines:
    """Edges of all blocks, in their blocks' axes from the centroids: `start`, `end` (e, 2), `owner` (e,), in a ring.

    `before` (e,): the edge that ends where this one starts.
    """

    blocks: tuple[Block, ...]
    start: Array
    end: Array
    owner: Index
    before: Index

    @classmethod
    def of(cls, blocks: Sequence[Block]) -> Outlines:
        """The outlines of blocks as drawn."""
        start, end, owner = block_edges(blocks)
        centroid = np.array([b.centroid for b in blocks])[owner]
        count = np.bincount(owner, minlength=len(blocks))
        first = np.cumsum(count) - count
        at = np.arange(len(owner))
        before = np.where(at == first[owner], first[owner] + count[owner] - 1, at - 1)
        return cls(tuple(blocks), start - centroid, end - centroid, owner, before)

    @cached_property
    def corners(self) -> tuple[Index, Index]:
        """First corner (b,) and number of corners (b,) of each block."""
        count = np.bincount(self.owner, minlength=len(self.blocks))
        return np.cumsum(count) - count, count

    @cached_property
    def direction(self) -> Array:
        """Unit vectors (e, 2) along the edges, in their blocks' axes."""
        d = self.end - self.start
        return d / np.hypot(*d.T)[:, None]

    @cached_property
    def length(self) -> Array:
        """Lengths of the edges (e,), m."""
        return np.hypot(*(self.end - self.start).T)

    @cached_property
    def thickness(self) -> Array:
        """Of the blocks (b,), m: twice the area over the outline, which of a thin one is its thickness."""
        area = np.array([block.area for block in self.blocks])
        return 2.0 * area / np.bincount(self.owner, self.length, len(self.blocks))


def near(outlines: Outlines, drawn: Contacts, now: Contacts, positions: Array, reach: float) -> Contacts:
    """Return the contacts that are possible while no corner moves farther than `reach` (m) from `positions` (b, 3).

    The `drawn` ones come first; those without overlap whose blocks do not point at each other any more are out of
    reach. `now`: the contacts so far, which stay while they overlap.
    """
    a, b, edges, at_a, at_b = _pairs(outlines, positions, reach)
    places = now.places(positions)
    kept = places[:, H] > 0.0
    known = {tuple(e): k for k, e in enumerate(map(tuple, drawn.edges.tolist()))}
    found = {tuple(e) for e in edges.tolist()}
    alive = np.array([tuple(e) in found for e in drawn.edges.tolist()], dtype=bool)
    alive |= kept[: len(drawn)]
    faces = drawn.faces.copy()
    faces[~alive, A2] = faces[~alive, A1] - 1.0
    first = replace(drawn, faces=faces)
    new = np.array([tuple(e) not in known for e in edges.tolist()], dtype=bool)
    if not new.any():
        return first
    return first.joined(_met(outlines, drawn, a[new], b[new], edges[new], at_a[new], at_b[new]))


def _pairs(outlines: Outlines, positions: Array, reach: float) -> tuple[Index, Index, Index, Array, Array]:
    """Blocks a < b, edges (k, 2) of theirs, and in their blocks' axes the points (k, 2) of these that are nearest."""
    own = outlines.owner
    corner = positions[own, :2] + turned(outlines.start, positions[own, 2])
    along = turned(outlines.direction, positions[own, 2])
    low, high = np.full((len(positions), 2), np.inf), np.full((len(positions), 2), -np.inf)
    np.minimum.at(low, own, corner)
    np.maximum.at(high, own, corner)
    boxes = shapely.box(*(low - 0.5 * reach).T, *(high + 0.5 * reach).T)
    one, other = shapely.STRtree(boxes).query(boxes)
    fixed = np.array([block.support is not None for block in outlines.blocks])
    keep = (one != other) & ~(fixed[one] & fixed[other])
    one, other = one[keep], other[keep]
    # every corner of one block with every edge of the other
    begin, count = outlines.corners
    sizes = count[one] * count[other]
    pair = np.repeat(np.arange(len(one)), sizes)
    place = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    c = begin[one[pair]] + place // count[other[pair]]
    f = begin[other[pair]] + place % count[other[pair]]
    apart = corner[c] - corner[f]
    t = (apart * along[f]).sum(axis=1)
    outward = np.stack([along[f][:, 1], -along[f][:, 0]], axis=1)
    d = (apart * outward).sum(axis=1)
    # a corner is not held by a face through which it would have to pass the block behind, or its own
    inside = DEEPEST * np.minimum(outlines.thickness[own[c]], outlines.thickness[own[f]])
    close = (d <= reach) & (d >= -np.minimum(reach, inside))
    close &= (t >= -reach) & (t <= outlines.length[f] + reach)
    c, f, t, outward = c[close], f[close], t[close], outward[close]
    # the corner is convex and points at the face
    after, before = along[c], along[outlines.before[c]]
    convex = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0.0
    leans = np.minimum((after * outward).sum(axis=1), -(before * outward).sum(axis=1))
    points = convex & (leans >= -POINTS_AT)
    c, f, t, after, before = c[points], f[points], t[points], after[points], before[points]
    flat_after, flat_before = -(after * along[f]).sum(axis=1), -(before * along[f]).sum(axis=1)
    e = np.where(flat_after >= flat_before, c, outlines.before[c])
    flat = np.maximum(flat_after, flat_before) > STEEPEST
    c, f, t, e = c[flat], f[flat], t[flat], e[flat]
    on_face = outlines.start[f] + np.clip(t, 0.0, outlines.length[f])[:, None] * outlines.direction[f]
    swap = own[e] > own[f]
    edges = np.where(swap[:, None], np.stack([f, e], axis=1), np.stack([e, f], axis=1))
    at_a = np.where(swap[:, None], on_face, outlines.start[c])
    at_b = np.where(swap[:, None], outlines.start[c], on_face)
    edges, chosen = np.unique(edges, axis=0, return_index=True)
    return own[edges[:, 0]], own[edges[:, 1]], edges, at_a[chosen], at_b[chosen]


def _met(
    outlines: Outlines, drawn: Contacts, a: Index, b: Index, edges: Index, at_a: Array, at_b: Array
) -> Contacts:
    """The contacts of pairs of edges (k, 2), seen from their nearest points `at_a`, `at_b` (k, 2)."""
    e, f = edges.T
    ta, tb = outlines.direction[e], -outlines.direction[f]
    faces = np.zeros((len(e), FACE))
    faces[:, [PX, PZ]], faces[:, [QX, QZ]] = at_a, at_b
    faces[:, [TAX, TAZ]], faces[:, [TBX, TBZ]] = ta, tb
    faces[:, A1] = ((outlines.start[e] - at_a) * ta).sum(axis=1)
    faces[:, A2] = faces[:, A1] + outlines.length[e]
    faces[:, B1] = ((outlines.end[f] - at_b) * tb).sum(axis=1)
    faces[:, B2] = faces[:, B1] + outlines.length[f]
    faces[:, MEET] = drawn.tolerance
    found = between(outlines.blocks, a, b, faces, 0, edges, drawn.tolerance)
    # what touches within the tolerance as drawn does so without a gap, a wider one is a gap; blocks that are drawn into
    # each other by it do so at most twice as far; corners, which no stone has sharper, must overlap by it
    centroid = np.array([block.centroid for block in outlines.blocks])
    places = found.places(np.column_stack([centroid, np.zeros(len(centroid))]))
    gap, overlap = end_gaps(places).min(axis=1), 2.0 * places[:, H]
    touch = (gap <= drawn.tolerance) & (gap >= -2.0 * drawn.tolerance) & (overlap > -2.0 * drawn.tolerance)
    faces[touch, PX] += gap[touch] * ta[touch, 1]
    faces[touch, PZ] -= gap[touch] * ta[touch, 0]
    faces[:, A1] += drawn.tolerance
    faces[:, A2] -= drawn.tolerance
    return replace(found, faces=faces)
