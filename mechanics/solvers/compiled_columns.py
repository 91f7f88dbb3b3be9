"""The loops of an interior-point iteration over contact points stored by columns, (n, c), compiled by numba.

What concerns a point alone is done in loops over columns, which become vector instructions; what blocks see and feel of
their contact points goes by runs (see compiled_runs). Both are done for a part of the runs at a time, so that what
passes from one to the other, `work` (WORK, points of the largest part), stays in the fastest memory. Columns go to the
loops one by one, as arrays that do not overlap.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled import diagonal
from mechanics.solvers.compiled_runs import act, part_of, see, stiffen
from mechanics.solvers.compiler import compiler, larger

WORK = 6  # numbers of a point
compiled = compiler("contract", "reassoc")
_apart = compiler("contract", "reassoc", apart=True)


@compiled
def columns(points: Array, runs: Any) -> Array:
    """What belongs to the points, (c, 2), by columns, (2, c)."""
    found = np.empty((2, len(points)))
    for k in range(len(points)):
        found[0, runs.column[k]], found[1, runs.column[k]] = points[k, 0], points[k, 1]
    return found


@compiled
def points_of(found: Array, runs: Any, points: Array) -> None:
    """What stands by columns, (2, c), back into `points` (c, 2)."""
    for k in range(len(points)):
        points[k, 0], points[k, 1] = found[0, runs.column[k]], found[1, runs.column[k]]


@compiled
def work_space(runs: Any) -> Array:
    """Of the largest part."""
    largest = 0
    for q in range(len(runs.parts)):
        first, last, length, _ = part_of(runs, q)
        largest = max(largest, (last - first) * length)
    return np.empty((WORK, largest))


@compiled
def lacking(
    runs: Any, lever: Array, arm: Array, law: Array, gap: Array, x: Array, s: Array, z: Array, r: Array,
    work: Array, short: Array,
) -> None:  # fmt: skip
    """What z lacks of the rays' gaps, z − Rᵀ(g + A₀ᵀx + CRs), into `r`; A₀Rs is added to `short`."""
    for q in range(len(runs.parts)):
        part = part_of(runs, q)
        k, e = _columns(part)
        see(part, runs.ends, lever, x, work)
        _lacking(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e],
            law[0, k:e], law[1, k:e], law[2, k:e], law[3, k:e],
            gap[0, k:e], gap[1, k:e], s[0, k:e], s[1, k:e], z[0, k:e], z[1, k:e],
            r[0, k:e], r[1, k:e], work[0], work[1], work[2],
        )  # fmt: skip
        act(part, runs.ends, lever, work, short)


@compiled
def matrix(
    runs: Any, lever: Array, arm: Array, law: Array, mass: Array, s: Array, z: Array, inverse: Array, work: Array,
    stored: Array, pattern: Any,
) -> None:  # fmt: skip
    """M̄ + B(RᵀCR + Z/S)⁻¹Bᵀ into `stored`, B = A₀R; the inverses and 1/s into `inverse` (5, c).

    R holds the unit rays of the friction cones, ∝ (1, ±μ); s (2, c) > 0 are the forces along them, z > 0 their gaps.
    Rows of `inverse`: its first and second diagonal entry, the one off the diagonal, 1/s of either ray.
    """
    diagonal(mass, stored, pattern)
    for q in range(len(runs.parts)):
        part = part_of(runs, q)
        k, e = _columns(part)
        _stiffness(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e],
            law[0, k:e], law[1, k:e], law[2, k:e], law[3, k:e],
            s[0, k:e], s[1, k:e], z[0, k:e], z[1, k:e],
            inverse[0, k:e], inverse[1, k:e], inverse[2, k:e], inverse[3, k:e], inverse[4, k:e],
            work[0], work[1], work[2], work[3], work[4], work[5],
        )  # fmt: skip
        stiffen(part, runs, lever, work, stored, pattern)


@compiled
def right_hand_side(
    runs: Any, lever: Array, arm: Array, law: Array, r: Array, p: Array, inverse: Array, short: Array, work: Array,
    rhs: Array,
) -> None:  # fmt: skip
    """The right-hand side, into `rhs` (m,), of the step that takes z to z − r, s z to s z − p and equilibrium to zero.

    `r` (2, c): the residual of z (see lacking), `p` (2, c): the change of s z, `short` (m,): the unbalanced forces.
    """
    rhs[:] = short
    for q in range(len(runs.parts)):
        part = part_of(runs, q)
        k, e = _columns(part)
        _bearing(
            arm[0, k:e], arm[1, k:e], arm[2, k:e], arm[3, k:e], law[0, k:e], law[1, k:e],
            r[0, k:e], r[1, k:e], p[0, k:e], p[1, k:e],
            inverse[0, k:e], inverse[1, k:e], inverse[2, k:e], inverse[3, k:e], inverse[4, k:e],
            work[0], work[1], work[2],
        )  # fmt: skip
        act(part, runs.ends, lever, work, rhs)


@compiled
def changes_with(
    runs: Any, lever: Array, arm: Array, law: Array, s: Array, z: Array, r: Array, p: Array, inverse: Array,
    dx: Array, ds: Array, dz: Array, work: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """The steps in s and z that go with `dx` (m,), into `ds`, `dz` (2, c).

    Returned: the shares, at most 1, of these steps at which the first force and the first gap vanish; and the sums of
    z ds, s dz and ds dz.
    """
    of_force, of_gap, zds, sdz, both = 1.0, 1.0, 0.0, 0.0, 0.0
    for q in range(len(runs.parts)):
        part = part_of(runs, q)
        k, e = _columns(part)
        see(part, runs.ends, lever, dx, work)
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


@compiled
def _columns(part: Any) -> tuple[int, int]:
    first, last, length, at = part
    return at, at + (last - first) * length


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


@_apart
def _lacking(
    nx: Array, nz: Array, mn: Array, mt: Array, n: Array, t: Array, cn: Array, ct: Array, gap: Array, slide: Array,
    s0: Array, s1: Array, z0: Array, z1: Array, r0: Array, r1: Array, x: Array, y: Array, turn: Array,
) -> None:  # fmt: skip
    """What gaps lack; and the forces, as those on the first block about its centre, in place of its motion as seen."""
    for k in range(len(n)):
        together, apart = s0[k] + s1[k], s0[k] - s1[k]
        along = n[k] * (gap[k] + nx[k] * x[k] + nz[k] * y[k] + mn[k] * turn[k]) + cn[k] * together
        across = t[k] * (slide[k] + nz[k] * x[k] - nx[k] * y[k] + mt[k] * turn[k]) + ct[k] * apart
        r0[k], r1[k] = z0[k] - along - across, z1[k] - along + across
        fn, ft = n[k] * together, t[k] * apart
        x[k], y[k] = fn * nx[k] + ft * nz[k], fn * nz[k] - ft * nx[k]
        turn[k] = fn * mn[k] + ft * mt[k]


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
