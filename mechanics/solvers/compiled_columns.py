"""The loops of an interior-point iteration over contact points stored by columns, (n, c), compiled by numba.

What concerns a point alone is done in loops over columns, which become vector instructions; what blocks see and feel of
their contact points goes by runs (see compiled_runs). Both are done for a part of RUNS runs at a time, so that what
passes from one to the other, `work` (WORK, points of the largest part), stays in the fastest memory.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled_runs import act, seen, stiffen
from mechanics.solvers.compiler import compiler, larger

WORK = 6  # numbers of a point
RUNS = 64  # of a part
compiled = compiler("contract", "reassoc")
_apart = compiler("contract", "reassoc", apart=True)
_plain = compiler()  # runs are short: their loops are no vectors


@compiled
def columns(points: Array) -> Array:
    """What belongs to the points, (c, n), by columns, (n, c)."""
    return np.ascontiguousarray(points.T)


@compiled
def work_space(runs: Any) -> Array:
    """Of the largest part."""
    largest = 0
    for first in range(0, len(runs) - 1, RUNS):
        largest = max(largest, runs[min(first + RUNS, len(runs) - 1)] - runs[first])
    return np.empty((WORK, largest))


@compiled
def matrix(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, mass: Array, s: Array, z: Array, inverse: Array,
    work: Array, band: Array,
) -> None:  # fmt: skip
    """As kernels.interior_matrix; 1/s, too, into `inverse` (5, c)."""
    band[:] = 0.0
    for i in range(len(mass)):
        band[i, 0] = mass[i]
    for first in range(0, len(ends), RUNS):
        last = min(first + RUNS, len(ends))
        k, e = runs[first], runs[last]
        _stiffness(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e],
            law[0, k:e], law[1, k:e], law[2, k:e], law[3, k:e],
            s[0, k:e], s[1, k:e], z[0, k:e], z[1, k:e],
            inverse[0, k:e], inverse[1, k:e], inverse[2, k:e], inverse[3, k:e], inverse[4, k:e],
            work[0], work[1], work[2], work[3], work[4], work[5],
        )  # fmt: skip
        _assemble(first, last, runs, ends, lever, work, band)


@compiled
def right_hand_side(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, r: Array, p: Array, inverse: Array, short: Array,
    work: Array, rhs: Array,
) -> None:  # fmt: skip
    """As kernels.interior_rhs: what z lacks is `r` (2, c), what s z does `p` (2, c), what equilibrium does `short`."""
    rhs[:] = short
    for first in range(0, len(ends), RUNS):
        last = min(first + RUNS, len(ends))
        k, e = runs[first], runs[last]
        _bearing(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e], law[0, k:e], law[1, k:e],
            r[0, k:e], r[1, k:e], p[0, k:e], p[1, k:e],
            inverse[0, k:e], inverse[1, k:e], inverse[2, k:e], inverse[3, k:e], inverse[4, k:e],
            work[0], work[1], work[2],
        )  # fmt: skip
        _act_together(first, last, runs, ends, lever, work, rhs)


@compiled
def changes_with(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, s: Array, z: Array, r: Array, p: Array, inverse: Array,
    dx: Array, ds: Array, dz: Array, work: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """As kernels.interior_step, and the sums of z ds, s dz and ds dz."""
    of_force, of_gap, zds, sdz, both = 1.0, 1.0, 0.0, 0.0, 0.0
    for first in range(0, len(ends), RUNS):
        last = min(first + RUNS, len(ends))
        k, e = runs[first], runs[last]
        _see(first, last, runs, ends, lever, dx, work)
        found = _changes(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e], law[0, k:e], law[1, k:e],
            r[0, k:e], r[1, k:e], p[0, k:e], p[1, k:e],
            inverse[0, k:e], inverse[1, k:e], inverse[2, k:e], inverse[3, k:e], inverse[4, k:e],
            s[0, k:e], s[1, k:e], z[0, k:e], z[1, k:e], work[0], work[1], work[2],
            ds[0, k:e], ds[1, k:e], dz[0, k:e], dz[1, k:e],
        )  # fmt: skip
        of_force, of_gap = max(of_force, found[0]), max(of_gap, found[1])
        zds, sdz, both = zds + found[2], sdz + found[3], both + found[4]
    return 1.0 / of_force, 1.0 / of_gap, zds, sdz, both


@_apart
def corrected(p: Array, ds: Array, dz: Array, centre: float) -> None:
    """What the corrector takes from s z, all (2 c,): `p`, and what a predictor leaves beyond the `centre`."""
    for k in range(len(p)):
        p[k] += ds[k] * dz[k] - centre


@_apart
def advance(share: float, s: Array, z: Array, ds: Array, dz: Array, r: Array, p: Array) -> float:
    """A share of the step is gone: s, z, s z and what z lacks, all (2 c,), after it, written; the sum of s z."""
    product, rest = 0.0, 1.0 - share
    for k in range(len(s)):
        force, apart = s[k] + share * ds[k], z[k] + share * dz[k]
        s[k], z[k], p[k], r[k] = force, apart, force * apart, rest * r[k]
        product += force * apart
    return product


@_plain
def _assemble(first: int, last: int, runs: Any, ends: Any, lever: Array, work: Array, band: Array) -> None:
    """The stiffness of runs, sums of the six rows of `work`, into the band."""
    start = runs[first]
    for j in range(first, last):
        xx, xz, zz, xm, zm, mm = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(runs[j] - start, runs[j + 1] - start):
            xx, xz, zz = xx + work[0, k], xz + work[1, k], zz + work[2, k]
            xm, zm, mm = xm + work[3, k], zm + work[4, k], mm + work[5, k]
        stiffen(j, ends, lever, (xx, xz, zz, xm, zm, mm), band)


@_plain
def _act_together(
    first: int, last: int, runs: Any, ends: Any, lever: Array, work: Array, total: Array
) -> None:
    """The forces of runs, sums of the first three rows of `work`, added to `total`."""
    start = runs[first]
    for j in range(first, last):
        fx, fz, moment = 0.0, 0.0, 0.0
        for k in range(runs[j] - start, runs[j + 1] - start):
            fx, fz, moment = fx + work[0, k], fz + work[1, k], moment + work[2, k]
        act(j, ends, lever, fx, fz, moment, total)


@_plain
def _see(first: int, last: int, runs: Any, ends: Any, lever: Array, moved: Array, work: Array) -> None:
    """The motions of runs, for each of their points, into the first three rows of `work`."""
    start = runs[first]
    for j in range(first, last):
        x, z, turn = seen(j, ends, lever, moved)
        for k in range(runs[j] - start, runs[j + 1] - start):
            work[0, k], work[1, k], work[2, k] = x, z, turn


@_apart
def _stiffness(
    nx: Array, nz: Array, mn: Array, mt: Array, n: Array, t: Array, cn: Array, ct: Array, s0: Array, s1: Array,
    z0: Array, z1: Array, first: Array, second: Array, off: Array, one: Array, two: Array,
    xx: Array, xz: Array, zz: Array, xm: Array, zm: Array, mm: Array,
) -> None:  # fmt: skip
    """(RᵀCR + Z/S)⁻¹, 1/s, and the stiffness of the points that follows, against motions of the first block."""
    for k in range(len(n)):
        # divisions are slow: both sides times s s
        left, right, both = z0[k] * s1[k], z1[k] * s0[k], s0[k] * s1[k]
        det = 1.0 / (4.0 * cn[k] * ct[k] * both + (cn[k] + ct[k]) * (left + right) + z0[k] * z1[k])
        a, b = ((cn[k] + ct[k]) * both + right) * det, ((cn[k] + ct[k]) * both + left) * det
        c, both = (ct[k] - cn[k]) * both * det, 1.0 / both
        first[k], second[k], off[k], one[k], two[k] = a, b, c, s1[k] * both, s0[k] * both
        knn, knt = n[k] * n[k] * (a + b + 2.0 * c), n[k] * t[k] * (a - b)
        ktt = t[k] * t[k] * (a + b - 2.0 * c)
        px, pz = knn * nx[k] + knt * nz[k], knn * nz[k] - knt * nx[k]
        qx, qz = knt * nx[k] + ktt * nz[k], knt * nz[k] - ktt * nx[k]
        pm, qm = knn * mn[k] + knt * mt[k], knt * mn[k] + ktt * mt[k]
        xx[k], xz[k], zz[k] = nx[k] * px + nz[k] * qx, nx[k] * pz + nz[k] * qz, nz[k] * pz - nx[k] * qz
        xm[k], zm[k], mm[k] = nx[k] * pm + nz[k] * qm, nz[k] * pm - nx[k] * qm, mn[k] * pm + mt[k] * qm


@_apart
def _bearing(
    nx: Array, nz: Array, mn: Array, mt: Array, n: Array, t: Array, r0: Array, r1: Array, p0: Array, p1: Array,
    first: Array, second: Array, off: Array, one: Array, two: Array, x: Array, z: Array, m: Array,
) -> None:  # fmt: skip
    """The forces that bear what z and s z lack, r − p/s, as those on the first block, about its centre."""
    for k in range(len(n)):
        a, b = r0[k] - p0[k] * one[k], r1[k] - p1[k] * two[k]
        left, right = first[k] * a + off[k] * b, off[k] * a + second[k] * b
        fn, ft = n[k] * (left + right), t[k] * (left - right)
        x[k], z[k], m[k] = fn * nx[k] + ft * nz[k], fn * nz[k] - ft * nx[k], fn * mn[k] + ft * mt[k]


@_apart
def _changes(
    nx: Array, nz: Array, mn: Array, mt: Array, n: Array, t: Array, r0: Array, r1: Array, p0: Array, p1: Array,
    first: Array, second: Array, off: Array, one: Array, two: Array, s0: Array, s1: Array, z0: Array, z1: Array,
    x: Array, y: Array, turn: Array, ds0: Array, ds1: Array, dz0: Array, dz1: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Of forces and gaps, with the motion of the first block as seen; the most of its force, and gap, that a ray loses.

    And the sums as in changes_with. A maximum is not asked what it does with what is no number: a step that comes of it
    is never certified.
    """
    of_force, of_gap, zds, sdz, both = 1.0, 1.0, 0.0, 0.0, 0.0
    for k in range(len(n)):
        along = n[k] * (nx[k] * x[k] + nz[k] * y[k] + mn[k] * turn[k])
        across = t[k] * (nz[k] * x[k] - nx[k] * y[k] + mt[k] * turn[k])
        a, b = r0[k] - p0[k] * one[k] - along - across, r1[k] - p1[k] * two[k] - along + across
        left, right = first[k] * a + off[k] * b, off[k] * a + second[k] * b
        to_left, to_right = -(p0[k] + z0[k] * left) * one[k], -(p1[k] + z1[k] * right) * two[k]
        ds0[k], ds1[k], dz0[k], dz1[k] = left, right, to_left, to_right
        of_force = larger(of_force, larger(-left * one[k], -right * two[k]))
        of_gap = larger(of_gap, larger(-to_left / z0[k], -to_right / z1[k]))
        zds += z0[k] * left + z1[k] * right
        sdz += s0[k] * to_left + s1[k] * to_right
        both += left * to_left + right * to_right
    return of_force, of_gap, zds, sdz, both
