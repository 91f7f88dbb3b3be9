"""The program over joints by a primal-dual interior-point method: static or dynamic, rigid or elastic.

Unknown are the displacements x, the multiplier α and per joint the forces N₁, N₂ > 0 at the ends of the overlap and T,
with |T| < μN, their gaps y₁, y₂ > 0 and the slips λ₊, λ₋ > 0:

    equilibrium    f + αf_L + Bᵀ(N, P, T) + Gx − M̄x = 0
    ends           u ∓ hφ − μ(λ₊ + λ₋) = ∂W*/∂N₁,₂ + Σ y ∂g/∂N₁,₂       W* = 0: rigid
    slip           λ₊ − λ₋ = v − v₀ + T/k_t
    products       g₁y₁ = g₂y₂ = (μN + T)λ₊ = (μN − T)λ₋ = τ → 0        g₁,₂ = N₁,₂ − κN², κ = 1/(4hσ)
    work           f_L·x = γ

with σ the strength per length, and G what the forces of an earlier solution change as the geometry does. All but x and
α are eliminated joint by joint (joint_elimination), which leaves BᵀDB + M̄ − G, three rows a block. Predictor and
corrector after Mehrotra, one more corrector after Gondzio; the forces that follow from stiff joints are refined until
equilibrium holds to rounding.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mechanics.kernels.jit import compiler, larger
from mechanics.kernels.joint import H
from mechanics.kernels.joint_elimination import (
    BM,
    BP,
    C1,
    C2,
    CG1,
    CG2,
    CHANGES,
    CLM,
    CLP,
    CN1,
    CN2,
    CT,
    CY1,
    CY2,
    CZM,
    CZP,
    DPP,
    DPV,
    DUP,
    DUU,
    DUV,
    DVV,
    FN,
    FP,
    FT,
    G1,
    G2,
    KAPPA,
    KNOWN,
    LANES,
    LM,
    LP,
    MPHI,
    MU,
    MV,
    N1,
    N2,
    OFF,
    RN,
    RP,
    RT,
    Y1,
    Y2,
    ZM,
    ZP,
    agree,
    aim,
    change,
    follow,
    missing,
    read,
    stiffness,
)
from mechanics.kernels.law import BED
from mechanics.kernels.linalg.cholesky import factorise, substitute
from mechanics.kernels.linalg.pattern import unpacked
from mechanics.kernels.linalg.signed_factors import factorise_signed, substitute_signed
from mechanics.kernels.matrix import bend, diagonal, motion, push, stiffen, turn
from mechanics.types import Array

compiled = compiler("contract", "reassoc")
looped = compiler("contract", "reassoc", allocates=False)
inlined = compiler("contract", "reassoc", allocates=False, inline=True)

STIFFEST = 1e-11  # compliance, per step and weight, that bounds the stiffness of closed and of stuck joints
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
CENTRED = 0.3  # of the mean product is the least target while gaps are missed by more,
BEHIND = 0.01  # and all of it where the products are smaller than this share of what is missed
HOLDING = 1e-8  # stiffness, per weight and step, that holds blocks
FIRMER = 10.0  # by which it grows where there is no factor
FIRM = 1.0  # the most of it
REFINEMENTS = 3  # of the forces of an iteration
ROUNDING = 1e-3  # share of the unbalanced force, or of what is accepted, that a refinement may leave
ROUNDED = 3e-15  # an imbalance, per weight, that is none
WIDE = 1e-4  # gaps count for so much less than forces and products in what is accepted
LEAST = 0.1  # of the target: smaller products stray
MOST = 10.0  # of the target: larger products stray
FARTHER = 1.5  # times as far as a step leads, products are looked at
IDLE = 10  # iterations without progress after which the method ends


class Joints(NamedTuple):
    """What does not change: `row` (j, 2), `places` (j, PLACE), `law` (j, LAW), `curved` (j, 7) or empty.

    `which` (j,): their places among the joints of the pattern.
    """

    row: Any
    places: Array
    law: Array
    curved: Array
    which: Any


@looped
def _lanes(joints: Any, r: int) -> int:
    """How many joints row r of what is known of them has."""
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


@compiled
def _back(stored: Array, pattern: Any, signed: bool, x: Array) -> None:
    if signed:
        substitute_signed(stored, pattern.places, pattern.last, x)
    else:
        substitute(stored, pattern, x)


@looped
def evaluate(
    joints: Any, x: Array, f: Array, y: Array, least: float, known: Array, residual: Array
) -> tuple[float, float]:
    """What all joints miss, into `known`; their forces onto `residual`; the most that gaps miss, the mean product."""
    row, places = joints.row, joints.places
    off, total = 0.0, 0.0
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
    for j in range(len(row)):
        n1, n2 = f[j, 0], f[j, 1]
        push(places[j], row[j, 0], row[j, 1], n1 + n2, places[j, H] * (n2 - n1), f[j, 2], residual)
        if len(joints.curved):
            turn(joints.curved[j], row[j, 0], row[j, 1], x, residual)
    return off, total / max(4.0 * len(row), 1.0)


@looped
def assemble(joints: Any, known: Array, held: Array, stored: Array, pattern: Any) -> None:
    """BᵀDB − G and the diagonal `held` (m,)."""
    row, places, which = joints.row, joints.places, joints.which
    diagonal(held, stored, pattern)
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            stiffness(s, k)
        for k in range(lanes):
            j = r * LANES + k
            d = (s[DUU + k], s[DUP + k], s[DUV + k], s[DPP + k], s[DPV + k], s[DVV + k])
            stiffen(which[j], places[j], row[j, 0], row[j, 1], d, stored, pattern)
    for j in range(len(joints.curved)):
        bend(which[j], row[j, 0], row[j, 1], joints.curved[j], stored, pattern)


@compiled
def _factorised(joints: Any, known: Array, held: Array, tied: bool, stored: Array, pattern: Any) -> bool:
    """Whether the matrix has a factor, then in its place. `tied`: a multiplier, whose work holds one motion.

    With curvature the matrix may then have one negative pivot, beyond the peak.
    """
    assemble(joints, known, held, stored, pattern)
    if len(joints.curved):
        negative = factorise_signed(stored, pattern.places, pattern.last)
        return bool(negative == 0 or (negative == 1 and tied))
    return bool(factorise(stored, pattern))


@looped
def _aim(joints: Any, known: Array, target: float, dx: Array) -> None:
    """Forces that bear what all joints miss, which are added to the right-hand side `dx` (m,)."""
    row, places = joints.row, joints.places
    for r in range(len(known)):
        s, lanes = known[r], _lanes(joints, r)
        for k in range(lanes):
            aim(s, k, target)
        for k in range(lanes):
            j = r * LANES + k
            push(places[j], row[j, 0], row[j, 1], s[RN + k], s[RP + k], s[RT + k], dx)


@looped
def _follow(joints: Any, known: Array, dx: Array, target: float, stiff: float, agreed: bool) -> None:
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
def _push_all(joints: Any, known: Array, dx: Array, total: Array) -> None:
    """Add to `total` (m,) the changes of forces N, P, T, and of those whose direction dx changes."""
    row, places = joints.row, joints.places
    for r in range(len(known)):
        s = known[r]
        for k in range(_lanes(joints, r)):
            j = r * LANES + k
            push(places[j], row[j, 0], row[j, 1], s[FN + k], s[FP + k], s[FT + k], total)
    for j in range(len(joints.curved)):
        turn(joints.curved[j], row[j, 0], row[j, 1], dx, total)


@looped
def _change(joints: Any, known: Array, target: float, stiff: float) -> tuple[float, float]:
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
def _predicted(joints: Any, known: Array, reach_f: float, reach_g: float) -> float:
    """The sum of products after a predictor so long; its terms of the second order become their corrections."""
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
def _correct_stray(joints: Any, known: Array, reach_f: float, reach_g: float, target: float) -> None:
    """Correct the products that would stray from their target (Gondzio)."""
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
    """What is added to the correction of a product that would become this."""
    wanted = -larger(-larger(product, LEAST * target), -MOST * target)
    return -larger(wanted - product, -MOST * target)


@looped
def _uncorrected(known: Array) -> None:
    for r in range(len(known)):
        known[r, C1 : BM + LANES] = 0.0


@looped
def _within_all(joints: Any, known: Array, reach: float) -> float:
    for r in range(len(known)):
        for k in range(_lanes(joints, r)):
            reach = _within(known[r], k, reach)
    return reach


@looped
def _within(s: Array, k: int, reach: float) -> float:
    """A reach at which crushing, which is curved, leaves both ends a share of what they had."""
    if s[KAPPA + k] == 0.0:
        return reach
    while True:
        n1, n2 = s[N1 + k] + reach * s[CN1 + k], s[N2 + k] + reach * s[CN2 + k]
        least, keeps = s[KAPPA + k] * (n1 + n2) ** 2, 1.0 - TO_THE_BOUND
        if n1 - least > keeps * s[G1 + k] and n2 - least > keeps * s[G2 + k]:
            return reach
        reach *= 0.7


@looped
def _advance(joints: Any, known: Array, reach_f: float, reach_g: float, f: Array, y: Array) -> None:
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


@compiled
def _refine(
    joints: Any, known: Array, load: Array, lateral: Array, mass: Array, swayed: Array, gives: float, dalpha: float,
    dx: Array, enough: float, size: float, target: float, stiff: float, fine: Array, stored: Array, pattern: Any,
) -> float:  # fmt: skip
    """Refine displacements dx and changes of forces until they balance the residual `load` (m,); the new Δα.

    Closed and stuck joints are stiff: forces that follow from motions lose their digits there.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    for _ in range(REFINEMENTS):
        fine[:] = load
        if len(lateral):
            fine += dalpha * lateral
        if len(mass):
            fine -= mass * dx
        _push_all(joints, known, dx, fine)
        if unbalanced(fine, size) <= enough:
            break
        _back(stored, pattern, len(joints.curved) > 0, fine)
        if len(lateral):
            more = -dot(lateral, fine) / gives
            dalpha += more
            fine += more * swayed
        _follow(joints, known, fine, target, stiff, True)
        dx += fine
    return dalpha


@compiled
def iterate(
    row: Any, places: Array, law: Array, load: Array, lateral: Array, work: float, mass: Array, curved: Array,
    x: Array, alpha: float, f: Array, y: Array, scale: Any, most: int, stored: Array, packed: Any, which: Any,
) -> tuple[int, float, float, float, float]:  # fmt: skip
    """Iterate on x (m,), α, f (j, 3): N₁, N₂, T, and y (j, 4): y₁, y₂, λ₊, λ₋, in one geometry and in place.

    `places` (j, PLACE), `law` (j, LAW); `lateral`, `mass` (m,) and `curved` (j, 7: joint.curvature) may be empty;
    `scale`: weight, size and step; what is accepted of unbalanced forces per weight and of gaps, 1/WIDE times as much,
    per step; and of products per weight and step. `which` (j,): their places among the joints of the pattern, that of
    `packed`. Returns the number of iterations, negative if no iteration leads on (with curvature: if equilibrium is not
    stable), α, and the residuals of forces, gaps and products, scaled likewise.
    """
    # many arguments and lines: arrays one by one, and a loop whose stages share a dozen arrays, see mechanics.kernels
    pattern = unpacked(packed)
    weight, size, step, accepted, closed = scale
    count, c, unit = len(x), len(row), step / weight
    joints = Joints(row, places, law, curved, which)
    known = np.empty(((c + LANES - 1) // LANES, KNOWN))
    tied = len(mass) > 0 or (law[:, BED] < np.inf).any()  # forces and gaps, to each other
    pushed, signed, stiff, holding = len(lateral) > 0, len(curved) > 0, 1.0 / unit, HOLDING
    kept_dx, kept_change = np.empty(count), np.empty((len(known), KNOWN - CN1))
    residual, dx, swayed = np.empty(count), np.empty(count), np.empty(count)
    held, fine = np.empty(count), np.empty(count)
    best, since, iteration = np.inf, 0, 0
    best_x, best_f, best_y = x.copy(), f.copy(), y.copy()
    best_alpha, best_off = alpha, (np.inf, np.inf, np.inf)
    while True:
        residual[:] = load
        if pushed:
            residual += alpha * lateral
        if len(mass):
            residual -= mass * x
        gap_off, mean = evaluate(joints, x, f, y, unit * STIFFEST, known, residual)
        force_off = unbalanced(residual, size)
        lacking = work - dot(lateral, x) if pushed else 0.0
        force, gap, product = (
            max(force_off / weight, abs(lacking) / (weight * step)), gap_off / step, mean / (weight * step),
        )  # fmt: skip
        off = max(force, gap)
        if not (off < np.inf and product < np.inf):
            return -1, alpha, np.inf, np.inf, np.inf
        if max(force, WIDE * gap) <= accepted and product <= closed:
            return iteration, alpha, force, gap, product
        since += 1
        if max(off, product) < 0.5 * best:
            best, since = max(off, product), 0
            best_x[:], best_alpha, best_f[:], best_y[:], best_off = x, alpha, f, y, (force, gap, product)
        if iteration == most or since > IDLE:  # rounding may throw back what is near the end
            x[:], f[:], y[:] = best_x, best_f, best_y
            return iteration, best_alpha, best_off[0], best_off[1], best_off[2]
        iteration += 1
        while True:  # firmer where rounding outweighs the hold
            held[:] = holding * stiff
            held[2::3] *= size**2
            if len(mass):
                held += mass
            if _factorised(joints, known, held, pushed, stored, pattern):
                break
            if holding >= FIRM:
                return -iteration, alpha, force, gap, product
            holding *= FIRMER
        gives = 1.0
        if pushed:
            swayed[:] = lateral
            _back(stored, pattern, signed, swayed)
            gives = dot(lateral, swayed)
        _uncorrected(known)
        target, dalpha, most_f, most_g = 0.0, 0.0, 0.0, 0.0
        kept_f, kept_g, kept_alpha = 0.0, 0.0, 0.0
        for corrects in range(3):
            dx[:] = residual
            _aim(joints, known, target, dx)
            _back(stored, pattern, signed, dx)
            if pushed:
                dalpha = (lacking - dot(lateral, dx)) / gives
                dx += dalpha * swayed
            _follow(joints, known, dx, target, stiff, corrects > 0)
            if corrects:
                enough = max(ROUNDING * max(force_off, accepted * weight), ROUNDED * weight)
                dalpha = _refine(
                    joints, known, residual, lateral, mass, swayed, gives, dalpha, dx, enough, size, target, stiff,
                    fine, stored, pattern,
                )  # fmt: skip
            most_f, most_g = _change(joints, known, target, stiff)
            if tied:
                most_f = most_g = max(most_f, most_g)
            if corrects == 2:
                if max(most_f, most_g) > max(kept_f, kept_g):  # the earlier step leads farther
                    most_f, most_g, dalpha = kept_f, kept_g, kept_alpha
                    dx[:], known[:, CHANGES] = kept_dx, kept_change
                break
            reach_f, reach_g = 1.0 / max(most_f, 1.0), 1.0 / max(most_g, 1.0)
            if corrects == 1:
                if max(most_f, most_g) <= 1.0:
                    break
                kept_f, kept_g, kept_alpha = most_f, most_g, dalpha
                kept_dx[:], kept_change[:] = dx, known[:, CHANGES]
                to_f, to_g = min(1.0, FARTHER * reach_f + 0.1), min(1.0, FARTHER * reach_g + 0.1)
                _correct_stray(joints, known, to_f, to_g, target)
            else:
                ahead = _predicted(joints, known, reach_f, reach_g)
                centre = (ahead / (4.0 * c * mean)) ** 3 if mean > 0.0 else 0.0
                if off > product:
                    centre = max(centre, CENTRED if product > BEHIND * off else 1.0)
                target = centre * mean
        reach_f = 1.0 if most_f < TO_THE_BOUND else TO_THE_BOUND / most_f
        reach_g = 1.0 if most_g < TO_THE_BOUND else TO_THE_BOUND / most_g
        reach_f = _within_all(joints, known, reach_f)
        if tied:
            reach_f = reach_g = min(reach_f, reach_g)
        _advance(joints, known, reach_f, reach_g, f, y)
        x += reach_g * dx
        alpha += reach_f * dalpha
