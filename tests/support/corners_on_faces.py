"""A stack of two blocks by a scheme that shares nothing with the program's.

Corners upon faces, small fixed steps at velocity level (Moreau and Jean, without bounce), contact forces by the
method of Gauss and Seidel.
"""

from __future__ import annotations

import numpy as np

from mechanics.kernels.jit import compiler
from mechanics.types import GRAVITY, Array

compiled = compiler()
SWEEPS, SOLVED = 100, 1e-10
BASE = (4.0, 0.2)  # m


@compiled
def closed_contacts(x: Array, half: Array, rows: Array) -> Array:
    """Whether corners lie on or in a face (6,); `rows` (6, 2, 3, 3): normal, tangential of blocks' x, z, ω."""
    closed = np.zeros(6, np.bool_)
    rows[:] = 0.0
    # lower corners of both blocks, then the upper ones of the first, each on the face that looks at them
    for c in range(6):
        corners, face, up = (1, 0, 1.0) if c < 2 else ((2, 1, 1.0) if c < 4 else (1, 2, -1.0))
        cos, sin = np.cos(x[corners, 2]), np.sin(x[corners, 2])
        along, across = (2 * (c % 2) - 1) * half[corners, 0], -up * half[corners, 1]
        arm = np.array([cos * along - sin * across, sin * along + cos * across])
        other = x[corners, :2] + arm - x[face, :2]
        normal = up * np.array([-np.sin(x[face, 2]), np.cos(x[face, 2])])
        tangent = np.array([normal[1], -normal[0]])
        closed[c] = other @ normal <= half[face, 1] and abs(other @ tangent) <= half[face, 0] + 1e-9
        for d, way in enumerate((normal, tangent)):
            rows[c, d, corners, :2], rows[c, d, face, :2] = way, -way
            rows[c, d, corners, 2] = arm[0] * way[1] - arm[1] * way[0]
            rows[c, d, face, 2] = -(other[0] * way[1] - other[1] * way[0])
    return closed


@compiled
def collide(rows: Array, closed: Array, inverse: Array, friction: float, impulses: Array, v: Array) -> None:
    """Change velocities v (3, 3) and impulses (6, 2) until closed contacts obey Coulomb's law."""
    for c in range(6):
        for d in range(2):
            impulses[c, d] *= closed[c]
            v += inverse * rows[c, d] * impulses[c, d]
    for _ in range(SWEEPS):
        change = 0.0
        for c in np.flatnonzero(closed):
            for d in range(2):
                row = rows[c, d]
                least, most = (
                    (0.0, np.inf) if d == 0 else (-friction * impulses[c, 0], friction * impulses[c, 0])
                )
                wanted = impulses[c, d] - (row * v).sum() / (row * inverse * row).sum()
                more = min(max(wanted, least), most) - impulses[c, d]
                v += inverse * row * more
                impulses[c, d] += more
                change = max(change, abs(more))
        if change < SOLVED:
            return


@compiled
def time_of_fall(width: float, height: float, friction: float, base: Array, step: float) -> float:
    """When (s) one of two equal blocks upon each other has turned by 1 rad; infinite: never.

    `base` (k,) m/s²: accelerations of the base in the middles of steps, s.
    """
    half = 0.5 * np.array([BASE, (width, height), (width, height)])
    inverse = np.zeros((3, 3))  # of masses; a block's is 1
    inverse[1:, :2], inverse[1:, 2] = 1.0, 3.0 / (half[1] ** 2).sum()
    x, v, impulses, rows = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((6, 2)), np.zeros((6, 2, 3, 3))
    x[0, 1], x[1, 1], x[2, 1] = -half[0, 1], half[1, 1], 3.0 * half[1, 1]
    for k in range(len(base)):
        closed = closed_contacts(x + 0.5 * step * v, half, rows)
        new = v.copy()
        new[1:, 0] -= step * base[k]
        new[1:, 1] -= step * GRAVITY
        collide(rows, closed, inverse, friction, impulses, new)
        x += 0.5 * step * (v + new)
        v = new
        if np.abs(x[:, 2]).max() > 1.0:
            return (k + 1) * step
    return np.inf
