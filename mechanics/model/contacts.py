"""Contacts: pairs of faces that touch as drawn or as blocks move, with their properties, and joints left for good.

A corner of one block near an edge of another that it points at makes a pair of that edge and of the flatter of the two
edges that meet in the corner: a joint like any other, whose overlap, gap and touched face follow from its kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from mechanics.kernels.joint import (
    A1,
    A2,
    B1,
    B2,
    BETA,
    FACE,
    LENGTH,
    LEVEL,
    LX,
    LZ,
    MEET,
    MPHI,
    MU,
    MV,
    NX,
    NZ,
    PHI,
    PLACE,
    PX,
    PZ,
    H,
    U,
    V,
    place,
)
from mechanics.kernels.law import STEEPEST
from mechanics.model.block import Block, Joints, Tie, block_edges, preceding
from mechanics.types import Array, Index, Mask, turned

ACROSS = 1e-7  # of the tension: a force across the tie, without which the cone of friction had no inside
RIGID = 10.0  # times the stiffest joint: a rigid tie in analyses with elastic joints
# of the shorter face of a joint: how near two corners meet. Their normal turns as they slide past each other: if it
# turned over less slip than joints yield in shear, hinges at corners would be unstable
CORNER = 3e-3
POINTS_AT = 0.3  # sine of the angle by which a corner's edges may lean towards the face at which it points
FACING = 0.3  # least cosine between two faces of a joint
DEEPEST = 0.5  # of the thinner block: how far a corner may lie in another block that holds it


@dataclass(frozen=True, eq=False)
class Contacts:
    """Pairs of faces of blocks `a` and `b` (j,), those of the drawn joints first, then ties, then those that met later.

    `faces` (j, FACE): see kernels.joint. `friction` (j,); `bed` (j,) kN/m² and `shear` (j,) kN/m: stiffness per
    length of the joint and of the whole joint in shear (NaN where a block has no stiffness); `strength` (j,) kN/m:
    per length of the joint; `segments` (j,): of a bed of points, 0 for the exact bed. `edges` (j, 2): the edges of the
    faces, among the edges of all blocks. `tolerance` (m): faces drawn no farther apart touch.
    """

    a: Index
    b: Index
    faces: Array
    friction: Array
    bed: Array
    shear: Array
    strength: Array
    segments: Index
    edges: Index
    tolerance: float

    def __len__(self) -> int:
        return len(self.a)

    def take(self, index: Index) -> Contacts:
        """Return the contacts `index` (k,)."""
        return self._with(lambda name: getattr(self, name)[index])

    def joined(self, more: Contacts) -> Contacts:
        """Return these contacts followed by others."""
        return self._with(lambda name: np.concatenate([getattr(self, name), getattr(more, name)]))

    def _with(self, array: Callable[[str], Any]) -> Contacts:
        """Return contacts of the same tolerance with the arrays of these names."""
        return replace(self, **{f.name: array(f.name) for f in fields(self) if f.name != "tolerance"})

    def places(self, positions: Array) -> Array:
        """Return the geometry (j, PLACE) of the contacts at block positions (b, 3): see kernels.joint."""
        found = np.empty((len(self), PLACE))
        place(self.a, self.b, self.faces, positions, found)
        return found

    @property
    def blocks(self) -> Index:
        """The blocks (j, 2) of each."""
        return np.stack([self.a, self.b], axis=1)

    @property
    def sides(self) -> tuple[Array, Array, Array]:
        """Of the faces of a and b: reference points and tangents (j, 2, 2), and limits along them (j, 2, 2)."""
        point, along = self.faces[:, :A1].reshape(-1, 2, 2, 2).transpose(2, 0, 1, 3)
        return point, along, self.faces[:, A1:MEET].reshape(-1, 2, 2)

    @cached_property
    def ties(self) -> Mask:
        """Which contacts (j,) are ties."""
        return self.faces[:, LENGTH] > 0.0


def end_gaps(places: Array) -> Array:
    """Return the gaps (j, 2), m, at the lower and the upper end of the overlaps."""
    half = places[:, H] * places[:, PHI]
    return np.stack([places[:, U] - half, places[:, U] + half], axis=1)


def rows(places: Array) -> Array:
    """Return B (j, 3, 6): change of u, φ and v per unit x, z, ω of block a, then of block b."""
    n = places[:, [NX, NZ]]
    t = np.stack([n[:, 1], -n[:, 0]], axis=1)
    lever = places[:, [LX, LZ]]
    found = np.zeros((len(places), 3, 6))
    for row, (direction, moment) in enumerate(
        [(n, places[:, MU]), (np.zeros_like(n), places[:, MPHI]), (t, places[:, MV])]
    ):
        found[:, row, :2], found[:, row, 2] = direction, moment
        found[:, row, 3:5] = -direction
        found[:, row, 5] = -(moment + lever[:, 0] * direction[:, 1] - lever[:, 1] * direction[:, 0])
    return found


def relative_motion(places: Array, moved: Array) -> Array:
    """Return BΔx (j, 3): changes of u, φ and v as blocks a and b move by x, z, ω (j, 6)."""
    return np.asarray(np.einsum("jrc,jc->jr", rows(places), moved))


def forces_on_blocks(places: Array, forces: Array) -> Array:
    """Return Bᵀc (j, 6): forces and moments of N, P and T (j, 3) on blocks a and b."""
    return np.asarray(np.einsum("jrc,jr->jc", rows(places), forces))


@dataclass(frozen=True, eq=False)
class FaceLines:
    """Pairs of faces (j,) as drawn, of block a and of block b.

    `ends` (j, 2, 2, 2) m: start and end of either face, along their common direction; `middle` (j, 2, 2) m: the point
    of either face from which slips count, one point for faces that touch as drawn.
    """

    ends: Array
    middle: Array


def face_lines(contacts: Contacts, centroid: Array) -> FaceLines:
    """Return the faces of contacts as drawn; `centroid` (b, 2) m of the blocks."""
    point, along, limits = contacts.sides
    middle = centroid[contacts.blocks] + point
    return FaceLines(middle[:, :, None] + limits[..., None] * along[:, :, None], middle)


def kinematic_contacts(
    lines: FaceLines, blocks: Index, centroid: Array, friction: Array, tolerance: float, drawn: int
) -> Contacts:
    """Return contacts whose faces and friction (j,) alone are known: enough for gaps and slips, for no forces.

    `blocks` (j, 2): a and b of each; `centroid` (b, 2) m; `tolerance` m. The first `drawn` touch as drawn.
    """
    along = lines.ends[:, :, 1] - lines.ends[:, :, 0]
    along = along / np.hypot(*along.transpose(2, 0, 1))[..., None]
    reach = np.einsum("jfei,jfi->jfe", lines.ends - lines.middle[:, :, None], along)
    faces = faces_of(lines.middle - centroid[blocks], along, reach, tolerance)
    faces[:drawn, MEET] = _meet(faces[:drawn], tolerance)
    unknown = np.full(len(blocks), np.nan)
    return Contacts(
        a=blocks[:, 0], b=blocks[:, 1], faces=faces, friction=friction, bed=unknown, shear=unknown,
        strength=unknown, segments=np.zeros(len(blocks), dtype=np.intp),
        edges=np.zeros((len(blocks), 2), dtype=np.intp), tolerance=tolerance,
    )  # fmt: skip


def drawn_contacts(blocks: Sequence[Block], joints: Joints, segments: int, tolerance: float) -> Contacts:
    """Return the contacts of the joints as drawn, without the gaps of the drawing within the tolerance."""
    centroid = np.array([b.centroid for b in blocks])
    middle, half = joints.ends.mean(axis=1), 0.5 * joints.length[:, None]
    point = middle[:, None] - centroid[joints.blocks]
    limits = np.stack([joints.room_a - half, joints.room_b - half], axis=1)
    faces = faces_of(point, np.repeat(joints.tangent[:, None], 2, axis=1), limits, tolerance)
    faces[:, MEET] = _meet(faces, tolerance)
    return between(blocks, joints.a, joints.b, faces, segments, joints.edges, tolerance)


def faces_of(point: Array, along: Array, limits: Array, meet: float) -> Array:
    """Return faces (j, FACE) of what `Contacts.sides` gives, and how near corners `meet` (m)."""
    faces = np.zeros((len(point), FACE))
    faces[:, :A1] = np.stack([point, along], axis=2).reshape(-1, A1)
    faces[:, A1:MEET] = limits.reshape(-1, MEET - A1)
    faces[:, MEET] = meet
    return faces


def _meet(faces: Array, tolerance: float) -> Array:
    """Return how near corners of faces (j, FACE) that touch as drawn meet (j,), m."""
    return np.maximum(CORNER * shorter_face(faces), tolerance)


def shorter_face(faces: Array) -> Array:
    """Return the length of the shorter face (j,), m."""
    return np.minimum(faces[:, A2] - faces[:, A1], faces[:, B2] - faces[:, B1])


def between(
    blocks: Sequence[Block], a: Index, b: Index, faces: Array, segments: int, edges: Index, tolerance: float
) -> Contacts:
    """Return contacts of `faces` (j, FACE): stones in series, least μ and depth; `segments` where blocks have none."""
    depth = np.array([block.depth for block in blocks])
    mu = np.array([block.material.friction for block in blocks], dtype=float)
    mu[mu > STEEPEST] = np.inf
    k = np.array([(b.material.normal_stiffness or np.nan, b.material.tangential_stiffness) for b in blocks])
    strength = np.array([block.material.compressive_strength for block in blocks])
    wished = np.array([block.segments or segments for block in blocks], dtype=np.intp)
    with np.errstate(divide="ignore"):
        series = 2.0 / (1.0 / k[a] + 1.0 / k[b])
    thin = np.minimum(depth[a], depth[b])
    length = np.minimum(faces[:, A2], faces[:, B2]) - np.maximum(faces[:, A1], faces[:, B1])
    length = np.where(length > tolerance, length, shorter_face(faces))
    return Contacts(
        a=a, b=b, faces=faces, friction=np.minimum(mu[a], mu[b]), bed=series[:, 0] * thin,
        shear=series[:, 1] * thin * length, strength=np.minimum(strength[a], strength[b]) * thin,
        segments=np.maximum(wished[a], wished[b]), edges=edges, tolerance=tolerance,
    )  # fmt: skip


def end_points(contacts: Contacts, positions: Array) -> Array:
    """Return the lower and the upper end (j, 2, 2), m, of the overlaps, midway between the two faces."""
    slid, at = contacts.places(positions)[:, V], positions[contacts.blocks]
    point, along, limits = contacts.sides
    p, q = (at[..., :2] + turned(point, at[..., 2])).transpose(1, 0, 2)
    tangent_a, tangent_b = turned(along, at[..., 2]).transpose(1, 0, 2)
    low = np.maximum(limits[:, 0, 0], limits[:, 1, 0] - slid)
    high = np.minimum(limits[:, 0, 1], limits[:, 1, 1] - slid)
    ends = [0.5 * (p + s[:, None] * tangent_a + q + (s + slid)[:, None] * tangent_b) for s in (low, high)]
    return np.stack(ends, axis=1)


def tie_contacts(
    ties: Sequence[Tie], ends: Array, blocks: Index, centroid: Array, drawn: Contacts
) -> Contacts:
    """Return the contacts of ties with `ends` (t, 2, 2) m in the `blocks` (t, 2), beside the `drawn` joints.

    The normal of such a joint is the tie's line: its tension is N, its elongation the closing, its yielding the
    crushing; P and T are none. Its length is 1 m: bed and strength are stiffness and yield force. A rigid one is RIGID
    times as stiff as the stiffest joint where joints are elastic. Centroids (b, 2) m count from the ends' origin.
    """
    count = len(ties)
    limits = np.broadcast_to([-0.5, 0.5], (count, 2, 2))
    faces = faces_of(ends - centroid[blocks], np.zeros((count, 2, 2)), limits, 1.0)
    joint = drawn.bed * shorter_face(drawn.faces)
    stiffest = RIGID * float(joint.max()) if len(joint) and not np.isnan(joint).any() else 1.0
    faces[:, LENGTH] = [tie.taut_length for tie in ties]
    number = np.arange(count)
    return Contacts(
        a=blocks[:, 0], b=blocks[:, 1], faces=faces, friction=np.full(count, ACROSS), tolerance=drawn.tolerance,
        bed=np.array([tie.stiffness or stiffest for tie in ties]).reshape(count), shear=np.full(count, np.inf),
        strength=np.array([tie.yield_force for tie in ties]).reshape(count),
        segments=np.zeros(count, dtype=np.intp),
        edges=np.stack([-1 - number, -1 - number], axis=1),  # no edges of blocks: numbers of its own
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Outlines:
    """Edges of all blocks, in their blocks' axes from the centroids: `start`, `end` (e, 2), `owner` (e,), in a ring."""

    blocks: tuple[Block, ...]
    start: Array
    end: Array
    owner: Index

    @classmethod
    def of(cls, blocks: Sequence[Block]) -> Outlines:
        """The outlines of blocks as drawn."""
        start, end, owner = block_edges(blocks)
        centroid = np.array([b.centroid for b in blocks])[owner]
        return cls(tuple(blocks), start - centroid, end - centroid, owner)

    @cached_property
    def corners(self) -> tuple[Index, Index]:
        """First corner (b,) and number of corners (b,) of each block."""
        count = np.bincount(self.owner, minlength=len(self.blocks))
        return np.cumsum(count) - count, count

    @cached_property
    def before(self) -> Index:
        """The edge (e,) that ends where each one starts."""
        return preceding(self.owner)

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
    edges, at = _pairs(outlines, positions, reach)
    places = now.places(positions)
    kept = places[:, H] > 0.0
    base = (len(outlines.owner), 1)
    found, known = edges @ base, drawn.edges @ base  # a number for each pair of edges
    alive = np.isin(known, found) | kept[: len(drawn)]
    faces = drawn.faces.copy()
    faces[~alive, A2] = faces[~alive, A1] - 1.0
    first = replace(drawn, faces=faces)
    new = ~np.isin(found, known)
    if not new.any():
        return first
    return first.joined(_met(outlines, drawn, edges[new], at[new]))


def _pairs(outlines: Outlines, positions: Array, reach: float) -> tuple[Index, Array]:
    """Edges (k, 2) of blocks a < b, and in their blocks' axes the points (k, 2, 2) of these that are nearest."""
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
    flat = np.maximum(flat_after, flat_before) > FACING
    c, f, t, e = c[flat], f[flat], t[flat], e[flat]
    on_face = outlines.start[f] + np.clip(t, 0.0, outlines.length[f])[:, None] * outlines.direction[f]
    edges, at = np.stack([e, f], axis=1), np.stack([outlines.start[c], on_face], axis=1)
    swap = own[e] > own[f]
    edges[swap], at[swap] = edges[swap, ::-1], at[swap, ::-1]
    edges, chosen = np.unique(edges, axis=0, return_index=True)
    return edges, at[chosen]


def _met(outlines: Outlines, drawn: Contacts, edges: Index, at: Array) -> Contacts:
    """The contacts of pairs of edges (k, 2), seen from their nearest points (k, 2, 2)."""
    e, f = edges.T
    along = np.stack([outlines.direction[e], -outlines.direction[f]], axis=1)
    begin = ((np.stack([outlines.start[e], outlines.end[f]], axis=1) - at) * along).sum(axis=2)
    faces = faces_of(at, along, np.stack([begin, begin + outlines.length[edges]], axis=2), drawn.tolerance)
    a, b = outlines.owner[edges].T
    found = between(outlines.blocks, a, b, faces, 0, edges, drawn.tolerance)
    # what touches within the tolerance as drawn does so without a gap, a wider one is a gap; blocks that are drawn into
    # each other by it do so at most twice as far; corners, which no stone has sharper, must overlap by it, and coincide
    # where they are drawn within three times it of each other; within twice, some still stood on a face of the other
    centroid = np.array([block.centroid for block in outlines.blocks])
    drawing = np.column_stack([centroid, np.zeros(len(centroid))])
    places = found.places(drawing)
    gap, overlap = end_gaps(places).min(axis=1), 2.0 * places[:, H]
    touch = (gap <= drawn.tolerance) & (gap >= -2.0 * drawn.tolerance) & (overlap > -2.0 * drawn.tolerance)
    faces[touch, PX : PZ + 1] += gap[touch, None] * along[touch, 0, ::-1] * (1.0, -1.0)
    faces[:, [A1, B1]] += 0.5 * drawn.tolerance
    faces[:, [A2, B2]] -= 0.5 * drawn.tolerance
    wide = faces.copy()
    wide[:, MEET] *= 3.0
    beta, phi = replace(found, faces=wide).places(drawing)[:, [BETA, PHI]].T
    beyond = np.where(touch & (beta > 0.0) & (beta < 1.0), (1.0 - 2.0 * beta) * wide[:, MEET], 0.0)
    faces[:, B2] -= np.where(phi <= LEVEL, beyond, 0.0)
    faces[:, B1] += np.where(phi > LEVEL, beyond, 0.0)
    return replace(found, faces=faces)
