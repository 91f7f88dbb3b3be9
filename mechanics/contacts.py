"""Contact points of the joints, and their gaps and compatibility in a configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from mechanics.block import Array, Block
from mechanics.joints import Index, Joints


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contact points k of the joints: the two ends of each of their segments, seen from either side (paper, §2).

    Where two segments of a joint meet, their points on one side are at one place, always: they are one point, twice as
    stiff. So m segments have 2(m + 1) points, not 4m, along the joint on the side of its block a, then of b.

    Point k belongs to block `a` and faces a surface of block `b`. `p` (c, 2): the point, in a's axes; `q` (c, 2):
    its foot on the surface, in b's axes; `n` (c, 2): the surface's outward normal, in b's axes (all from the
    centroids, axes as drawn). Point and foot coincide as drawn: a drawing's inaccuracy within the tolerance is no
    gap. `friction` (c,); `stiffness` (c, 2) kN/m, normal and tangential (NaN where a block has none); `joint` (c,);
    `room` (c, 2) m: how far the point may slide along the surface before it leaves it.
    """

    a: Index
    b: Index
    p: Array
    q: Array
    n: Array
    friction: Array
    stiffness: Array
    joint: Index
    room: Array

    def __len__(self) -> int:
        return len(self.a)

    def take(self, index: Index) -> Contacts:
        """The contacts of the given indices."""
        return Contacts(*(getattr(self, f.name)[index] for f in fields(self)))


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Contacts in a configuration: `gap` (c,) and `slide` (c,) in m, and the rows of A₀ᵀ.

    `normal`, `tangent` (c, 6): change of gap and of slide per unit x, z, ω of block a, then of block b.
    """

    gap: Array
    slide: Array
    normal: Array
    tangent: Array


def place_contacts(blocks: Sequence[Block], joints: Joints, segments: Index) -> Contacts:
    """Contact points of joints divided into `segments` (j,) equal parts.

    k_n of a point = k_jn l d / 4 for each segment that ends there, with l the segment's length and d the smaller depth
    (paper, §4). Between unlike stones the two half-joints act in series and the smaller friction governs.
    """
    points = segments + 1
    joint = np.repeat(np.arange(len(joints.a)), points)
    number = np.arange(len(joint)) - np.repeat(np.cumsum(points) - points, points)
    length = joints.length[joint] / segments[joint]
    meeting = np.where((number == 0) | (number == segments[joint]), 1.0, 2.0)
    along = number * length
    t = joints.tangent[joint]
    n = np.stack([-t[:, 1], t[:, 0]], axis=1)
    place = joints.ends[joint, 0] + along[:, None] * t
    centroid = np.array([b.centroid for b in blocks])
    depth = np.array([b.depth for b in blocks])
    mu = np.array([b.material.friction for b in blocks])
    k = np.array([(b.material.normal_stiffness or np.nan, b.material.tangential_stiffness) for b in blocks])

    a, b = joints.a[joint], joints.b[joint]
    with np.errstate(divide="ignore"):
        series = 2.0 / (1.0 / k[a] + 1.0 / k[b])
    stiffness = series * (meeting * length * np.minimum(depth[a], depth[b]) / 4.0)[:, None]
    friction = np.minimum(mu[a], mu[b])
    # the slide is measured along the facing surface's own tangent, a quarter turn clockwise from its normal
    room_a, room_b = (room[joint] - along[:, None] for room in (joints.room_a, joints.room_b))
    sides = [
        Contacts(
            owner,
            facing,
            place - centroid[owner],
            place - centroid[facing],
            normal,
            friction,
            stiffness,
            joint,
            room,
        )
        for owner, facing, normal, room in ((a, b, n, room_b), (b, a, -n, -room_a[:, ::-1]))
    ]
    every = Contacts(*(np.concatenate([getattr(c, f.name) for c in sides]) for f in fields(Contacts)))
    return every.take(np.argsort(every.joint, kind="stable"))


def kinematics(contacts: Contacts, positions: Array) -> Kinematics:
    """Gaps and compatibility of the contacts for block positions (b, 3): x, z of the centroid, rotation.

    Exact for finite rotations; the rows are the exact derivatives there (design.md §2).
    """
    cos, sin = np.cos(positions[:, 2]), np.sin(positions[:, 2])
    a, b = contacts.a, contacts.b
    arm_a = _turn(contacts.p, cos[a], sin[a])
    n = _turn(contacts.n, cos[b], sin[b])
    t = np.stack([n[:, 1], -n[:, 0]], axis=1)
    point = positions[a, :2] + arm_a
    arm_b = point - positions[b, :2]
    offset = arm_b - _turn(contacts.q, cos[b], sin[b])

    def rows(u: Array) -> Array:
        return np.concatenate([u, _cross(arm_a, u)[:, None], -u, -_cross(arm_b, u)[:, None]], axis=1)

    return Kinematics(_dot(n, offset), _dot(t, offset), rows(n), rows(t))


def _turn(v: Array, cos: Array, sin: Array) -> Array:
    return np.stack([cos * v[:, 0] - sin * v[:, 1], sin * v[:, 0] + cos * v[:, 1]], axis=1)


def _cross(p: Array, q: Array) -> Array:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]


def _dot(p: Array, q: Array) -> Array:
    return np.einsum("ij,ij->i", p, q)
