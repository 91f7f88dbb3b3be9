"""The loops of the interior point over all joints: residuals, matrix, changes, products, reach of an iteration.

What is known of joints (joint_law) is kept in rows of LANES of them (rows, KNOWN): the same quantity of eight joints
side by side, so that loops over the lanes `k` of a row `s` become vector instructions.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from mechanics.kernels.interior.joint_law import (  # isort: skip
    BM, BP, C1, C2, CG1, CG2, CLM, CLP, CN1, CN2, CT, CY1, CY2, CZM, CZP, DPP, DPV, DUP, DUU, DUV, DVP, DVU,
    DVV, FN, FP, FT, G1, G2, KAPPA, LANES, LM, LP, MPHI, MU, MV, N1, N2, OFF, RN, RP, RT, S11, S12, S22, Y1,
    Y2, ZM, ZP, agree, aim, change, follow, missing, read, stiffness,
)  # fmt: skip
from mechanics.kernels.jit import inlined, larger, looped
from mechanics.kernels.joint import LEVERS, SHIFTS, SLIDE, H
from mechanics.kernels.law import STRENGTH
from mechanics.kernels.matrix import bend, diagonal, motion, push, stiffen, turn
from mechanics.types import Array

TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
LEAST = 0.1  # of the target: smaller products are corrected
MOST = 10.0  # of the target: larger products are corrected
UNDER_STRENGTH = 0.9  # of the strength of a joint: the most of its force where a search begins
SHORTER = 100  # times that an iteration is shortened for joints not to be crushed
# what does not change: `row` (j, 2), `places` (j, PLACE), `law` (j, LAW), `curved` (j, CURVED) or empty; `which` (j,):
# their places among the joints of the pattern
ProgramJoints = namedtuple("ProgramJoints", "row places law curved which")


@looped
def _lanes(joints: Any, r: int) -> int:
    """Number of joints in row r of `known`."""
    return min(LANES, len(joints.row) - r * LANES)


@looped
def unbalanced(residual: Array, size: float) -> float:
    """The largest force of a residual (m,), moments by the size of a block."""
    largest = 0.0
    for i in range(0, len(residual), 3):
        largest = max(largest, abs(residual[i]), abs(residual[i + 1]), abs(residual[i + 2]) / size)
    return largest


@looped
def dot(a: Array, b: Array) -> float:
    """Σ ab."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@looped
def evaluate(
    joints: Any, x: Array, f: Array, y: Array, least: float, known: Array, residual: Array
) -> tuple[float, float, float]:
    """Residuals of all joints into `known`, their forces onto `residual`.

    Returns the largest residual of gaps, the mean product, and the mean of the forces times what their beds yield.
    """
    row, places = joints.row, joints.places
    off, total, yielded = 0.0, 0.0, 0.0
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            j = r * LANES + k
            read(places[j], joints.law[j], row[j, 0], row[j, 1], x, f[j], y[j], s, k)
        for k in range(lanes):
            missing(s, k, least)
            off = larger(off, s[OFF + k])
            total += (
                s[G1 + k] * s[Y1 + k] + s[G2 + k] * s[Y2 + k] + s[LP + k] * s[ZP + k] + s[LM + k] * s[ZM + k]
            )
            n1, n2 = s[N1 + k], s[N2 + k]
            yielded += s[S11 + k] * n1 * n1 + s[S22 + k] * n2 * n2 - 2.0 * s[S12 + k] * n1 * n2
    for j in range(len(row)):
        n1, n2 = f[j, 0], f[j, 1]
        push(places[j], row[j, 0], row[j, 1], n1 + n2, places[j, H] * (n2 - n1), f[j, 2], residual)
    count = max(4.0 * len(row), 1.0)
    return off, total / count, yielded / count


@looped
def curve_all(joints: Any, x: Array, total: Array) -> None:
    """Add to `total` (m,) what the forces of all joints change as their blocks move by x (m,)."""
    row, places = joints.row, joints.places
    for j in range(len(joints.curved)):
        c = joints.curved[j]
        turn(c, row[j, 0], row[j, 1], x, total)
        u, phi, v = motion(places[j], row[j, 0], row[j, 1], x)
        slide = c[SLIDE] * u + c[SLIDE + 1] * phi + c[SLIDE + 2] * v
        p = c[SHIFTS + 1] * slide + c[LEVERS] * u + c[LEVERS + 1] * phi
        push(places[j], row[j, 0], row[j, 1], c[SHIFTS] * slide, p, c[SHIFTS + 2] * slide, total)


@looped
def assemble(
    joints: Any, known: Array, held: Array, lower: Array, upper: Array, two: bool, pattern: Any
) -> None:  # fmt: skip
    """BᵀDB − G and the diagonal `held` (m,): the lower triangle, and the upper one where there are `two`.

    One triangle is that of a symmetric matrix: friction that changes with N is left out where ψ < 1.
    """
    row, places, which = joints.row, joints.places, joints.which
    diagonal(held, lower, pattern)
    if two:
        diagonal(held, upper, pattern)
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            stiffness(s, k)
        for k in range(lanes):
            j = r * LANES + k
            uu, up, uv, pp, pv, vv = s[DUU + k], s[DUP + k], s[DUV + k], s[DPP + k], s[DPV + k], s[DVV + k]
            pu, vu, vp = (up, s[DVU + k], s[DVP + k]) if two else (up, uv, pv)
            if two and len(joints.curved):
                c = joints.curved[j]
                n, m, t = c[SHIFTS], c[SHIFTS + 1], c[SHIFTS + 2]
                u, phi, v = c[SLIDE], c[SLIDE + 1], c[SLIDE + 2]
                uu, up, uv = uu - n * u, up - n * phi, uv - n * v
                pu, pp, pv = pu - m * u - c[LEVERS], pp - m * phi - c[LEVERS + 1], pv - m * v
                vu, vp, vv = vu - t * u, vp - t * phi, vv - t * v
            at, a, b = places[j], row[j, 0], row[j, 1]
            stiffen(which[j], at, a, b, (uu, up, uv, pu, pp, pv, vu, vp, vv), lower, pattern)
            if two:
                stiffen(which[j], at, a, b, (uu, pu, vu, up, pp, vp, uv, pv, vv), upper, pattern)
    for j in range(len(joints.curved)):
        bend(which[j], row[j, 0], row[j, 1], joints.curved[j], lower, pattern)
        if two:
            bend(which[j], row[j, 0], row[j, 1], joints.curved[j], upper, pattern)


@looped
def aim_all(joints: Any, known: Array, target: float, dx: Array) -> None:
    """Add to the right-hand side `dx` (m,) the forces that cancel the residuals of all joints."""
    row, places = joints.row, joints.places
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            aim(s, k, target)
        for k in range(lanes):
            j = r * LANES + k
            push(places[j], row[j, 0], row[j, 1], s[RN + k], s[RP + k], s[RT + k], dx)


@looped
def follow_all(joints: Any, known: Array, dx: Array, target: float, stiff: float, agreed: bool) -> None:
    """Let motions and forces of all joints follow displacements dx (m,), and forces `agreed` with gaps."""
    row, places = joints.row, joints.places
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            j = r * LANES + k
            s[MU + k], s[MPHI + k], s[MV + k] = motion(places[j], row[j, 0], row[j, 1], dx)
        for k in range(lanes):
            follow(s, k)
        if agreed:
            for k in range(lanes):
                agree(s, k, target, stiff)


@looped
def push_all(joints: Any, known: Array, dx: Array, total: Array) -> None:
    """Add to `total` (m,) the changes of forces N, P, T, and of those whose direction dx changes."""
    row, places = joints.row, joints.places
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            j = r * LANES + k
            push(places[j], row[j, 0], row[j, 1], s[FN + k], s[FP + k], s[FT + k], total)
    curve_all(joints, dx, total)


@looped
def change_all(joints: Any, known: Array, target: float, stiff: float) -> tuple[float, float]:
    """Changes of all unknowns of joints; by what share of themselves forces and gaps fall at most."""
    most_f, most_g = 0.0, 0.0
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            change(s, k, target, stiff)
            ends = larger(-s[CG1 + k] / s[G1 + k], -s[CG2 + k] / s[G2 + k])
            bounds = larger(-s[CZP + k] / s[ZP + k], -s[CZM + k] / s[ZM + k])
            gaps = larger(-s[CY1 + k] / s[Y1 + k], -s[CY2 + k] / s[Y2 + k])
            slips = larger(-s[CLP + k] / s[LP + k], -s[CLM + k] / s[LM + k])
            most_f, most_g = larger(most_f, larger(ends, bounds)), larger(most_g, larger(gaps, slips))
    return most_f, most_g


@looped
def predicted(joints: Any, known: Array, reach_f: float, reach_g: float) -> float:
    """The sum of products after a predictor of these lengths; its terms of second order become their corrections."""
    total = 0.0
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            g1, g2, zp, zm = s[CG1 + k], s[CG2 + k], s[CZP + k], s[CZM + k]
            y1, y2, lp, lm = s[CY1 + k], s[CY2 + k], s[CLP + k], s[CLM + k]
            s[C1 + k], s[C2 + k], s[BP + k], s[BM + k] = g1 * y1, g2 * y2, zp * lp, zm * lm
            total += (s[G1 + k] + reach_f * g1) * (s[Y1 + k] + reach_g * y1)
            total += (s[G2 + k] + reach_f * g2) * (s[Y2 + k] + reach_g * y2)
            total += (s[ZP + k] + reach_f * zp) * (s[LP + k] + reach_g * lp)
            total += (s[ZM + k] + reach_f * zm) * (s[LM + k] + reach_g * lm)
    return total


@looped
def correct_stray(joints: Any, known: Array, reach_f: float, reach_g: float, target: float) -> None:
    """Correct the products that would be far from their target (Gondzio)."""
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            end1 = (s[G1 + k] + reach_f * s[CG1 + k]) * (s[Y1 + k] + reach_g * s[CY1 + k])
            end2 = (s[G2 + k] + reach_f * s[CG2 + k]) * (s[Y2 + k] + reach_g * s[CY2 + k])
            forth = (s[ZP + k] + reach_f * s[CZP + k]) * (s[LP + k] + reach_g * s[CLP + k])
            back = (s[ZM + k] + reach_f * s[CZM + k]) * (s[LM + k] + reach_g * s[CLM + k])
            s[C1 + k] += _stray(end1, target)
            s[C2 + k] += _stray(end2, target)
            s[BP + k] += _stray(forth, target)
            s[BM + k] += _stray(back, target)


@inlined
def _stray(product: float, target: float) -> float:
    """Addition to the correction of a product that would become this."""
    wanted = -larger(-larger(product, LEAST * target), -MOST * target)
    return -larger(wanted - product, -MOST * target)


@looped
def keep_within_strength(places: Array, law: Array, f: Array) -> None:
    """Scale N₁, N₂ and T, f (j, 3), of joints at places (j, PLACE) to a share of the strength, where it is finite."""
    for k in range(len(f)):
        most = 2.0 * places[k, H] * law[k, STRENGTH]
        if most == np.inf:
            continue
        n, low = f[k, 0] + f[k, 1], min(f[k, 0], f[k, 1])
        share = min(1.0, UNDER_STRENGTH * most / n, UNDER_STRENGTH * 2.0 * low * most / (n * n))
        for e in range(3):
            f[k, e] *= share


@looped
def within_strength(joints: Any, known: Array, reach: float) -> float:
    """A reach, at most that given, at which no joint has crushed."""
    for r in range(len(known)):
        for k in range(_lanes(joints, r)):
            reach = _within(known[r], k, reach)
    return reach


@looped
def _within(s: Array, k: int, reach: float) -> float:
    """A reach at which crushing, which is curved, leaves both ends a share of what they had."""
    if s[KAPPA + k] == 0.0:
        return reach
    for _ in range(SHORTER):  # rounding may leave nothing of what an end had
        n1, n2 = s[N1 + k] + reach * s[CN1 + k], s[N2 + k] + reach * s[CN2 + k]
        least, keeps = s[KAPPA + k] * (n1 + n2) ** 2, 1.0 - TO_THE_BOUND
        if n1 - least > keeps * s[G1 + k] and n2 - least > keeps * s[G2 + k]:
            return reach
        reach *= 0.7
    return 0.0


@looped
def advance(joints: Any, known: Array, reach_f: float, reach_g: float, f: Array, y: Array) -> None:
    """Forces f (j, 3) by a share of their changes, gaps and slips y (j, 4) by another."""
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            j = r * LANES + k
            f[j, 0] += reach_f * s[CN1 + k]
            f[j, 1] += reach_f * s[CN2 + k]
            f[j, 2] += reach_f * s[CT + k]
            y[j, 0] += reach_g * s[CY1 + k]
            y[j, 1] += reach_g * s[CY2 + k]
            y[j, 2] += reach_g * s[CLP + k]
            y[j, 3] += reach_g * s[CLM + k]
