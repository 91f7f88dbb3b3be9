"""The loops of an interior-point iteration over runs of contact points, compiled by numba.

The contact points of two blocks lie side by side, from `runs[j]` to `runs[j + 1]`: their motion is that of one block
seen from the other, and their forces act on both alike. So blocks are looked up, and matrices written, once a run.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled import compiled


@compiled
def packed(
    row: Any, normal: Array, tangent: Array, friction: Array, compliance: Array, runs: Any
) -> tuple[Any, Array, Array, Array]:
    """What the loops need of the runs and of their contact points.

    Rows of a run's first block, movable where one is, and of the other, (j, 2); the lever (j, 2) from the other to it;
    of a point the normal and the moments of n and t about the first block, (c, 4); n and t of its unit rays and the
    compliances along them, (c, 4).
    """
    pairs, c = len(runs) - 1, len(row)
    ends, lever = np.empty((pairs, 2), np.intp), np.empty((pairs, 2))
    arm, law = np.empty((c, 4)), np.empty((c, 4))
    for j in range(pairs):
        start = runs[j]
        first = row[start, 0] if row[start, 0] >= 0 else row[start, 1]
        ends[j, 0], ends[j, 1] = first, row[start, 0] + row[start, 1] - first
        for k in range(start, runs[j + 1]):
            own = 0 if row[k, 0] == first else 3
            arm[k, 0], arm[k, 1] = normal[k, own], normal[k, own + 1]
            arm[k, 2], arm[k, 3] = normal[k, own + 2], tangent[k, own + 2]
            n = 1.0 / np.sqrt(1.0 + friction[k] ** 2)
            t = friction[k] * n
            law[k, 0], law[k, 1] = n, t
            law[k, 2], law[k, 3] = n * n * compliance[k, 0], t * t * compliance[k, 1]
        other = 5 if row[start, 0] == first else 2
        n, t = -normal[start, other] - arm[start, 2], -tangent[start, other] - arm[start, 3]
        nx, nz = arm[start, 0], arm[start, 1]
        lever[j, 0], lever[j, 1] = n * nz - t * nx, -n * nx - t * nz
    return ends, lever, arm, law


@compiled
def seen(j: int, ends: Any, lever: Array, x: Array) -> tuple[float, float, float]:
    """The motion of a run's first block as seen from the other, at the first one's centre."""
    i, o = ends[j, 0], ends[j, 1]
    if i < 0:
        return 0.0, 0.0, 0.0
    if o < 0:
        return x[i], x[i + 1], x[i + 2]
    turn = x[o + 2]
    return x[i] - x[o] + lever[j, 1] * turn, x[i + 1] - x[o + 1] - lever[j, 0] * turn, x[i + 2] - turn


@compiled
def act(j: int, ends: Any, lever: Array, fx: float, fz: float, moment: float, total: Array) -> None:
    """Forces of a run on its first block, about its centre, and their reactions on the other, added to `total`."""
    i, o = ends[j, 0], ends[j, 1]
    if i >= 0:
        total[i] += fx
        total[i + 1] += fz
        total[i + 2] += moment
    if o >= 0:
        total[o] -= fx
        total[o + 1] -= fz
        total[o + 2] -= lever[j, 0] * fz - lever[j, 1] * fx + moment


@compiled
def lacking(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, gap: Array, x: Array, s: Array, z: Array, r: Array,
    short: Array,
) -> None:  # fmt: skip
    """What z lacks of the rays' gaps, z − Rᵀ(g + A₀ᵀx + CRs), into `r`; A₀Rs is added to `short`."""
    for j in range(len(ends)):
        dx, dz, turn = seen(j, ends, lever, x)
        fx, fz, moment = 0.0, 0.0, 0.0
        for k in range(runs[j], runs[j + 1]):
            nx, nz, mn, mt = arm[k, 0], arm[k, 1], arm[k, 2], arm[k, 3]
            n, t, cn, ct = law[k, 0], law[k, 1], law[k, 2], law[k, 3]
            together, apart = s[k, 0] + s[k, 1], s[k, 0] - s[k, 1]
            along = n * (gap[k, 0] + nx * dx + nz * dz + mn * turn) + cn * together
            across = t * (gap[k, 1] + nz * dx - nx * dz + mt * turn) + ct * apart
            r[k, 0], r[k, 1] = z[k, 0] - along - across, z[k, 1] - along + across
            fn, ft = n * together, t * apart
            fx += fn * nx + ft * nz
            fz += fn * nz - ft * nx
            moment += fn * mn + ft * mt
        act(j, ends, lever, fx, fz, moment, short)


@compiled
def stiffen(j: int, ends: Any, lever: Array, stiffness: Any, band: Array) -> None:
    """A run's stiffness against motions of its first block, seen from the other, into the band."""
    i, o = ends[j, 0], ends[j, 1]
    xx, xz, zz, xm, zm, mm = stiffness
    if i < 0:
        return
    band[i, 0] += xx
    band[i, 1] += xz
    band[i, 2] += xm
    band[i + 1, 0] += zz
    band[i + 1, 1] += zm
    band[i + 2, 0] += mm
    if o < 0:
        return
    lx, lz = lever[j, 0], lever[j, 1]
    # the last column of the stiffness against motions of the other block, which turns about its own centre
    tx, tz, tm = xm + lx * xz - lz * xx, zm + lx * zz - lz * xz, mm + lx * zm - lz * xm
    band[o, 0] += xx
    band[o, 1] += xz
    band[o, 2] += tx
    band[o + 1, 0] += zz
    band[o + 1, 1] += tz
    band[o + 2, 0] += tm + lx * tz - lz * tx
    between = ((xx, xz, tx), (xz, zz, tz), (xm, zm, tm))
    for h in range(3):
        for e in range(3):
            if i > o:
                band[o + e, i + h - o - e] -= between[h][e]
            else:
                band[i + h, o + e - i - h] -= between[h][e]
