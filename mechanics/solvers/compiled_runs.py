"""The loops of an interior-point iteration over runs of contact points, compiled by numba.

The contact points of two blocks lie side by side (see runs.Runs): their motion is that of one block seen from the
other, and their forces act on both alike. So blocks are looked up, and matrices written, once a run. `work` holds what
belongs to the points of a part, a row for each quantity; of its first columns, after a sum, what belongs to the runs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiler import compiler

compiled = compiler()
_apart = compiler(apart=True)


@compiled
def pack(
    row: Any, normal: Array, tangent: Array, friction: Array, compliance: Array, runs: Any
) -> tuple[Array, Array, Array]:
    """What the loops need of the runs and, by columns, of their contact points.

    The lever (j, 2) from the other block of a run to the first; of a point the normal and the moments of n and t about
    the first block, (4, c); n and t of its unit rays and the compliances along them, (4, c).
    """
    lever, arm, law = np.empty((len(runs.ends), 2)), np.empty((4, len(row))), np.empty((4, len(row)))
    for q in range(len(runs.parts)):
        first, last, length, _ = part_of(runs, q)
        for j in range(first, last):
            k = runs.start[j]
            own, other = (0, 3) if row[k, 0] == runs.ends[j, 0] else (3, 0)
            nx, nz = normal[k, own], normal[k, own + 1]
            n, t = -normal[k, other + 2] - normal[k, own + 2], -tangent[k, other + 2] - tangent[k, own + 2]
            lever[j, 0], lever[j, 1] = n * nz - t * nx, -n * nx - t * nz
            for k in range(runs.start[j], runs.start[j] + length):
                own, c = 0 if row[k, 0] == runs.ends[j, 0] else 3, runs.column[k]
                arm[0, c], arm[1, c] = normal[k, own], normal[k, own + 1]
                arm[2, c], arm[3, c] = normal[k, own + 2], tangent[k, own + 2]
                n = 1.0 / np.sqrt(1.0 + friction[k] ** 2)
                t = friction[k] * n
                law[0, c], law[1, c] = n, t
                law[2, c], law[3, c] = n * n * compliance[k, 0], t * t * compliance[k, 1]
    return lever, arm, law


@compiled
def part_of(runs: Any, q: int) -> tuple[int, int, int, int]:
    """First and end of the runs of a part, the length that all have, and their first column."""
    return runs.parts[q, 0], runs.parts[q, 1], runs.parts[q, 2], runs.parts[q, 3]


@compiled
def see(part: Any, ends: Any, lever: Array, x: Array, work: Array) -> None:
    """The motions of first blocks as seen from the others, at their own centres, for each point, into three rows."""
    first, last, length, _ = part
    for j in range(first, last):
        i, o = ends[j, 0], ends[j, 1]
        dx, dz, turn = 0.0, 0.0, 0.0
        if i >= 0:
            dx, dz, turn = x[i], x[i + 1], x[i + 2]
            if o >= 0:
                dx -= x[o] - lever[j, 1] * x[o + 2]
                dz -= x[o + 1] + lever[j, 0] * x[o + 2]
                turn -= x[o + 2]
        work[0, j - first], work[1, j - first], work[2, j - first] = dx, dz, turn
    count, done = last - first, 1
    while done < length:
        more = min(done, length - done)
        for q in range(3):
            _copy(work[q, done * count : (done + more) * count], work[q])
        done += more


@compiled
def act(part: Any, ends: Any, lever: Array, work: Array, total: Array) -> None:
    """Forces on first blocks, about their centres, three rows of points, and their reactions, added to `total`."""
    _sum(part, work, 3)
    first, last, _, _ = part
    for j in range(first, last):
        fx, fz, moment = work[0, j - first], work[1, j - first], work[2, j - first]
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
def stiffen(part: Any, runs: Any, lever: Array, work: Array, stored: Array, pattern: Any) -> None:
    """The stiffness against motions of first blocks as seen from the others, six rows of points, into a matrix."""
    _sum(part, work, 6)
    first, last, _, _ = part
    for j in range(first, last):
        k = j - first
        xx, xz, zz, xm, zm, mm = work[0, k], work[1, k], work[2, k], work[3, k], work[4, k], work[5, k]
        i, o = runs.ends[j, 0], runs.ends[j, 1]
        if i < 0:
            continue
        at, step = pattern.own[i // 3], pattern.step[i // 3]
        p, q, r = stored[at:], stored[at + step :], stored[at + 2 * step :]
        p[0], p[1], p[2], q[1], q[2], r[2] = p[0] + xx, p[1] + xz, p[2] + xm, q[1] + zz, q[2] + zm, r[2] + mm
        if o < 0:
            continue
        lx, lz = lever[j, 0], lever[j, 1]
        # the last column of the stiffness against motions of the other block, which turns about its own centre
        tx, tz, tm = xm + lx * xz - lz * xx, zm + lx * zz - lz * xz, mm + lx * zm - lz * xm
        mm = tm + lx * tz - lz * tx
        at, step = pattern.own[o // 3], pattern.step[o // 3]
        p, q, r = stored[at:], stored[at + step :], stored[at + 2 * step :]
        p[0], p[1], p[2], q[1], q[2], r[2] = p[0] + xx, p[1] + xz, p[2] + tx, q[1] + zz, q[2] + tz, r[2] + mm
        if i < o:  # the columns are the first block's
            tx, xm, tz, zm = xm, tx, zm, tz
        at, step = pattern.between[runs.start[j]], pattern.stride[runs.start[j]]
        p, q, r = stored[at:], stored[at + step :], stored[at + 2 * step :]
        p[0], p[1], p[2] = p[0] - xx, p[1] - xz, p[2] - xm
        q[0], q[1], q[2] = q[0] - xz, q[1] - zz, q[2] - zm
        r[0], r[1], r[2] = r[0] - tx, r[1] - tz, r[2] - tm


@compiled
def _sum(part: Any, work: Array, rows: int) -> None:
    """Of the points of each run, in its own column."""
    first, last, length, _ = part
    count, left = last - first, length
    while left > 1:
        half = left // 2
        for q in range(rows):
            _add(work[q, : half * count], work[q, (left - half) * count :])
        left -= half


@_apart
def _add(total: Array, more: Array) -> None:
    for k in range(len(total)):
        total[k] += more[k]


@_apart
def _copy(to: Array, of: Array) -> None:
    for k in range(len(to)):
        to[k] = of[k]
