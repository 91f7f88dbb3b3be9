"""The loops of an interior-point iteration over contact points stored by columns, (n, c), compiled by numba.

What concerns a point alone is done for all of them, in loops over few enough columns that they become vector
instructions (more of them, and the compiler no longer looks whether they overlap); what blocks see and feel of their
contact points goes by runs (see compiled_runs). `work` (WORK, c) is space for what passes from one to the other.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled_runs import act, seen, stiffen
from mechanics.solvers.compiler import compiler

WORK = 9
compiled = compiler("contract", "reassoc")
_plain = compiler()  # runs are short: their loops are no vectors
# a maximum is not asked what it does with what is no number: a step that comes of it is never certified
_ordered = compiler("contract", "reassoc", "nnan", "nsz")


@compiled
def columns(points: Array) -> Array:
    """What belongs to the points, (c, n), by columns, (n, c)."""
    return np.ascontiguousarray(points.T)


@compiled
def matrix(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, mass: Array, s: Array, z: Array, inverse: Array,
    work: Array, band: Array,
) -> None:  # fmt: skip
    """As kernels.interior_matrix; 1/s, too, into `inverse` (5, c)."""
    xx, xz, zz, xm, zm, mm = work[0], work[1], work[2], work[3], work[4], work[5]
    knn, knt, ktt = work[6], work[7], work[8]
    _stiffness(*_four(law), s[0], s[1], z[0], z[1], *_five(inverse), knn, knt, ktt)
    _about_block(*_four(arm), knn, knt, ktt, xx, xz, zz, xm, zm, mm)
    _assemble(runs, ends, lever, mass, work, band)


@compiled
def right_hand_side(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, r: Array, p: Array, inverse: Array,
    short: Array, v: Array, work: Array, rhs: Array,
) -> None:  # fmt: skip
    """As kernels.interior_rhs; what z and s z lack together, r − p/s, into `v` (2, c)."""
    x, z, m, fn, ft = work[0], work[1], work[2], work[3], work[4]
    _bearing(r[0], r[1], p[0], p[1], *_five(inverse), law[0], law[1], v[0], v[1], fn, ft)
    _forces(*_four(arm), fn, ft, x, z, m)
    rhs[:] = short
    _act_together(runs, ends, lever, work, rhs)


@compiled
def changes_with(
    runs: Any, ends: Any, lever: Array, arm: Array, law: Array, s: Array, z: Array, v: Array, p: Array, inverse: Array,
    dx: Array, ds: Array, dz: Array, work: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """As kernels.interior_step, and the sums of z ds, s dz and ds dz."""
    x, y, turn, along, across = work[0], work[1], work[2], work[3], work[4]
    _see(runs, ends, lever, dx, work)
    _openings(*_four(arm), x, y, turn, law[0], law[1], along, across)
    _changes(along, across, v[0], v[1], *_five(inverse), ds[0], ds[1])
    _answers(p.ravel(), z.ravel(), inverse[3:].ravel(), ds.ravel(), dz.ravel())
    return _reach(s.ravel(), z.ravel(), inverse[3:].ravel(), ds.ravel(), dz.ravel())


@compiled
def corrected(p: Array, ds: Array, dz: Array, centre: float) -> None:
    """What the corrector takes from s z, all (2 c,): `p`, and what a predictor leaves beyond the `centre`."""
    for k in range(len(p)):
        p[k] += ds[k] * dz[k] - centre


@compiled
def advance(share: float, s: Array, z: Array, ds: Array, dz: Array, r: Array, p: Array) -> float:
    """A share of the step is gone: s, z, s z and what z lacks, all (2 c,), after it, written; the sum of s z."""
    product, rest = 0.0, 1.0 - share
    for k in range(len(s)):
        force, apart = s[k] + share * ds[k], z[k] + share * dz[k]
        s[k], z[k], p[k], r[k] = force, apart, force * apart, rest * r[k]
        product += force * apart
    return product


@compiled
def _four(rows: Array) -> tuple[Array, Array, Array, Array]:
    return rows[0], rows[1], rows[2], rows[3]


@compiled
def _five(rows: Array) -> tuple[Array, Array, Array, Array, Array]:
    return rows[0], rows[1], rows[2], rows[3], rows[4]


@_plain
def _assemble(runs: Any, ends: Any, lever: Array, mass: Array, work: Array, band: Array) -> None:
    """Mass, and the stiffness of runs: sums of the first six rows of `work`."""
    band[:] = 0.0
    for i in range(len(mass)):
        band[i, 0] = mass[i]
    for j in range(len(ends)):
        xx, xz, zz, xm, zm, mm = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(runs[j], runs[j + 1]):
            xx, xz, zz = xx + work[0, k], xz + work[1, k], zz + work[2, k]
            xm, zm, mm = xm + work[3, k], zm + work[4, k], mm + work[5, k]
        stiffen(j, ends, lever, (xx, xz, zz, xm, zm, mm), band)


@_plain
def _act_together(runs: Any, ends: Any, lever: Array, work: Array, total: Array) -> None:
    """The forces of runs, sums of the first three rows of `work`, added to `total`."""
    for j in range(len(ends)):
        fx, fz, moment = 0.0, 0.0, 0.0
        for k in range(runs[j], runs[j + 1]):
            fx, fz, moment = fx + work[0, k], fz + work[1, k], moment + work[2, k]
        act(j, ends, lever, fx, fz, moment, total)


@_plain
def _see(runs: Any, ends: Any, lever: Array, moved: Array, work: Array) -> None:
    """The motions of runs, for each of their points, into the first three rows of `work`."""
    for j in range(len(ends)):
        x, z, turn = seen(j, ends, lever, moved)
        for k in range(runs[j], runs[j + 1]):
            work[0, k], work[1, k], work[2, k] = x, z, turn


@compiled
def _stiffness(
    n: Array, t: Array, cn: Array, ct: Array, s0: Array, s1: Array, z0: Array, z1: Array, first: Array, second: Array,
    off: Array, one: Array, two: Array, knn: Array, knt: Array, ktt: Array,
) -> None:  # fmt: skip
    """(RᵀCR + Z/S)⁻¹, 1/s, and the stiffness of the points that follows."""
    for k in range(len(n)):
        # divisions are slow: both sides times s s
        left, right, both = z0[k] * s1[k], z1[k] * s0[k], s0[k] * s1[k]
        det = 1.0 / (4.0 * cn[k] * ct[k] * both + (cn[k] + ct[k]) * (left + right) + z0[k] * z1[k])
        a, b = ((cn[k] + ct[k]) * both + right) * det, ((cn[k] + ct[k]) * both + left) * det
        c, both = (ct[k] - cn[k]) * both * det, 1.0 / both
        first[k], second[k], off[k], one[k], two[k] = a, b, c, s1[k] * both, s0[k] * both
        knn[k], knt[k] = n[k] * n[k] * (a + b + 2.0 * c), n[k] * t[k] * (a - b)
        ktt[k] = t[k] * t[k] * (a + b - 2.0 * c)


@compiled
def _about_block(
    nx: Array, nz: Array, mn: Array, mt: Array, knn: Array, knt: Array, ktt: Array, xx: Array, xz: Array, zz: Array,
    xm: Array, zm: Array, mm: Array,
) -> None:  # fmt: skip
    """The same against motions of the first block at its centre."""
    for k in range(len(nx)):
        px, pz = knn[k] * nx[k] + knt[k] * nz[k], knn[k] * nz[k] - knt[k] * nx[k]
        qx, qz = knt[k] * nx[k] + ktt[k] * nz[k], knt[k] * nz[k] - ktt[k] * nx[k]
        pm, qm = knn[k] * mn[k] + knt[k] * mt[k], knt[k] * mn[k] + ktt[k] * mt[k]
        xx[k], xz[k], zz[k] = nx[k] * px + nz[k] * qx, nx[k] * pz + nz[k] * qz, nz[k] * pz - nx[k] * qz
        xm[k], zm[k], mm[k] = nx[k] * pm + nz[k] * qm, nz[k] * pm - nx[k] * qm, mn[k] * pm + mt[k] * qm


@compiled
def _bearing(
    r0: Array, r1: Array, p0: Array, p1: Array, first: Array, second: Array, off: Array, one: Array, two: Array,
    n: Array, t: Array, v0: Array, v1: Array, fn: Array, ft: Array,
) -> None:  # fmt: skip
    """What z and s z lack, and the forces that bear it."""
    for k in range(len(n)):
        a, b = r0[k] - p0[k] * one[k], r1[k] - p1[k] * two[k]
        left, right = first[k] * a + off[k] * b, off[k] * a + second[k] * b
        v0[k], v1[k], fn[k], ft[k] = a, b, n[k] * (left + right), t[k] * (left - right)


@compiled
def _forces(
    nx: Array, nz: Array, mn: Array, mt: Array, fn: Array, ft: Array, x: Array, z: Array, m: Array
) -> None:  # fmt: skip
    """Normal and tangential forces as those on the first block, about its centre."""
    for k in range(len(nx)):
        x[k], z[k] = fn[k] * nx[k] + ft[k] * nz[k], fn[k] * nz[k] - ft[k] * nx[k]
        m[k] = fn[k] * mn[k] + ft[k] * mt[k]


@compiled
def _openings(
    nx: Array, nz: Array, mn: Array, mt: Array, x: Array, y: Array, turn: Array, n: Array, t: Array, along: Array,
    across: Array,
) -> None:  # fmt: skip
    """Shares of the rays' openings that stem from gap and slide, by the motion of the first block as seen."""
    for k in range(len(n)):
        along[k] = n[k] * (nx[k] * x[k] + nz[k] * y[k] + mn[k] * turn[k])
        across[k] = t[k] * (nz[k] * x[k] - nx[k] * y[k] + mt[k] * turn[k])


@compiled
def _changes(
    along: Array, across: Array, v0: Array, v1: Array, first: Array, second: Array, off: Array, one: Array, two: Array,
    ds0: Array, ds1: Array,
) -> None:  # fmt: skip
    for k in range(len(v0)):
        a, b = v0[k] - along[k] - across[k], v1[k] - along[k] + across[k]
        ds0[k], ds1[k] = first[k] * a + off[k] * b, off[k] * a + second[k] * b


@compiled
def _answers(p: Array, z: Array, per_s: Array, ds: Array, dz: Array) -> None:
    for k in range(len(p)):
        dz[k] = -(p[k] + z[k] * ds[k]) * per_s[k]


@_ordered
def _reach(
    s: Array, z: Array, per_s: Array, ds: Array, dz: Array
) -> tuple[float, float, float, float, float]:
    # the most of its force, and of its gap, that a ray loses in the step
    of_force, of_gap, zds, sdz, both = 1.0, 1.0, 0.0, 0.0, 0.0
    for k in range(len(s)):
        of_force, of_gap = max(of_force, -ds[k] * per_s[k]), max(of_gap, -dz[k] / z[k])
        zds += z[k] * ds[k]
        sdz += s[k] * dz[k]
        both += ds[k] * dz[k]
    return 1.0 / of_force, 1.0 / of_gap, zds, sdz, both
