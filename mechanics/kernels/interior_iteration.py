"""The program over joints by a primal-dual interior-point method: static or dynamic, rigid or elastic.

Unknown are the displacements x, the multiplier α and per joint the forces N₁, N₂ > 0 at the ends of the overlap and T,
with |T| < μN, their gaps y₁, y₂ > 0 and the slips λ₊, λ₋ > 0:

    equilibrium    f + αf_L + Bᵀ(N, P, T) + Gx − M̄x = 0
    ends           u ∓ hφ − μ(λ₊ + λ₋) = ∂W*/∂N₁,₂ + Σ y ∂g/∂N₁,₂       W* = 0: rigid
    slip           λ₊ − λ₋ = v − v₀ + T/k_t
    products       g₁y₁ = g₂y₂ = (μN + T)λ₊ = (μN − T)λ₋ = τ → 0        g₁,₂ = N₁,₂ − κN², κ = 1/(4hσ)
    work           f_L·x = γ

with σ the strength per length, and G what the forces of an earlier solution change as the geometry does. All but x and
α are eliminated joint by joint, which leaves BᵀDB + M̄ − G, three rows a block; D is written in sums of positive terms,
since differences lose all digits once stick or slip is decided. Predictor and corrector after Mehrotra; the forces that
follow from stiff joints are refined until equilibrium holds to rounding.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.bed import (
    bent_linearised,
    bent_under,
    closures,
    linearised,
    points_under,
    softness,
    under,
)
from mechanics.kernels.cholesky import factorise, substitute
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.matrix import bend, diagonal, motion, push, stiffen, turn
from mechanics.kernels.pattern import unpacked
from mechanics.kernels.signed_factors import factorise_signed, substitute_signed
from mechanics.types import Array

compiled = compiler("contract", "reassoc")

# columns of the law of a joint (j, LAW): friction; compliance in shear, m/kN; stiffness of the bed, kN/m² (inf: rigid);
# slip from which the slide counts, m; strength, kN/m; segments of a bed of points (0: exact)
FRICTION, SHEAR, BED, SLID, STRENGTH, SEGMENTS = range(6)
# and of a bed whose gap is bent, in time stepping: place of the bend, from the middle of the overlap; u and φ of the
# gaps at the start; factors of these below and above the bend (equal: no bend)
KINK, U0, PHI0, BELOW, ABOVE = range(6, 11)
LAW = 11

STIFFEST = 1e-11  # compliance, per step and weight, that bounds the stiffness of closed and of stuck joints
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
CENTRED, BEHIND = (
    0.3,
    0.01,
)  # products left while gaps are missed by more than those; all of them, where by far more
HOLDING = 1e-8  # stiffness, per weight and step, that holds blocks; its growth; its most
FIRMER = 10.0
FIRM = 1.0
REFINEMENTS, ROUNDING = (
    3,
    1e-3,
)  # of the forces of an iteration, and the share of their imbalance that is left
ROUNDED = 3e-15  # an imbalance, per weight, that is none
WIDE = 1e-4  # gaps count for so much less than forces and products in what is accepted
LEAST = 0.1  # of the target: products below, and above the next one, stray
MOST = 10.0
FARTHER = 1.5  # times as far as a step leads, products are looked at
IDLE = 10  # iterations without progress after which the method ends

# what an iteration knows of a joint, columns of (j, KNOWN): forces and gaps; what the laws miss; bounds of T; λ/z; D
# of the
# ends; a, b/a, and the sums of the elimination; forces aimed at; λ aimed at; corrections of the products; compliance of
# the bed; motion
(N1, N2, T, Y1, Y2, LP, LM, G1, G2, BETA, E1, E2, SLIP, OFF, ZP, ZM, PP, PM, D11, D12, D22, A, LEVER, SUM, Q, RN, RP,
RT, KP,
 KM, C1, C2, BP, BM, S11, S12, S22, DU, DPHI, DV) = range(40)  # fmt: skip
KNOWN = 40


@compiled
def missing(
    p: Array, law: Array, i: int, j: int, x: Array, f: Array, y: Array, unit: float, know: Array
) -> None:  # fmt: skip
    """What an iterate misses of the laws of a joint, and the terms of its elimination, into `know` (KNOWN,)."""
    du, dphi, dv = motion(p, i, j, x)
    n1, n2, t, h, mu = f[0], f[1], f[2], p[H], law[FRICTION]
    n = n1 + n2
    w, tilt = p[U] + du - mu * (y[2] + y[3]), h * (p[PHI] + dphi)
    first, second = w - tilt, w + tilt
    kappa = 0.25 / (h * law[STRENGTH])
    beta = 2.0 * kappa * n
    c11, c12, c22, w1, w2, off = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if law[BED] < np.inf:
        soft = 1.0 / (2.0 * h * law[BED])
        if law[BELOW] != law[ABOVE]:
            w1, w2, _, _, _ = bent_under(
                n1, n2, h, law[BED], law[KINK], law[U0], law[PHI0], law[BELOW], law[ABOVE]
            )
            y[0], y[1] = _taken(first - w1, y[0]), _taken(second - w2, y[1])
            off = max(abs(w1 + y[0] - first), abs(w2 + y[1] - second))
            w1, w2, c11, c12, c22 = bent_linearised(
                n1,
                n2,
                first - second - y[0] + y[1],
                h,
                law[BED],
                law[KINK],
                law[U0],
                law[PHI0],
                law[BELOW],
                law[ABOVE],
            )
        elif law[STRENGTH] < np.inf:
            w1, w2 = under(n1, n2, h, law[BED], law[STRENGTH])
            c11, c12, c22 = softness(w1, w2, h, law[BED], law[STRENGTH])
        elif law[SEGMENTS] > 0.0:
            w1, w2, c11, c12, c22 = points_under(n1, n2, int(law[SEGMENTS]), soft)
        else:
            w1, w2 = closures(n1, n2, soft)
            # an open end's gap may be the bed's as well as y: where it can, y takes what is missing
            y[0], y[1] = _taken(first - w1, y[0]), _taken(second - w2, y[1])
            off = max(abs(w1 + y[0] - first), abs(w2 + y[1] - second))
            w1, w2, c11, c12, c22 = linearised(n1, n2, first - second - y[0] + y[1], soft)
    both = y[0] + y[1]
    know[N1], know[N2], know[T] = n1, n2, t
    know[Y1], know[Y2], know[LP], know[LM] = y[0], y[1], y[2], y[3]
    know[G1], know[G2], know[BETA] = n1 - kappa * n * n, n2 - kappa * n * n, beta
    know[E1], know[E2] = w1 + y[0] - beta * both - first, w2 + y[1] - beta * both - second
    if off == 0.0:
        off = max(abs(know[E1]), abs(know[E2]))
    know[SLIP] = y[2] - y[3] - (p[V] + dv - law[SLID]) - law[SHEAR] * t
    know[OFF] = max(off, abs(know[SLIP]))
    know[ZP], know[ZM] = mu * n + t, mu * n - t
    know[PP], know[PM] = y[2] / know[ZP], y[3] / know[ZM]
    know[S11], know[S12], know[S22] = c11, c12, c22
    first, second, cross = y[0] / know[G1], y[1] / know[G2], 2.0 * kappa * both
    rest = 1.0 - beta
    c11 += first * rest * rest + second * beta * beta + cross + unit
    c22 += second * rest * rest + first * beta * beta + cross + unit
    c12 += (first + second) * beta * rest - cross
    det = c11 * c22 - c12 * c12
    know[D11], know[D12], know[D22] = c22 / det, c12 / det, c11 / det
    a = know[D11] + know[D22] + 2.0 * know[D12]
    know[A], know[LEVER] = a, h * (know[D22] - know[D11]) / a
    shear = law[SHEAR] + unit
    know[SUM] = know[PP] + know[PM] + shear
    know[Q] = know[SUM] + a * mu * mu * (4.0 * know[PP] * know[PM] + shear * (know[PP] + know[PM]))


@compiled
def _taken(missed: float, y: float) -> float:
    return missed if 0.1 * y < missed < 10.0 * y else y


@compiled
def stiffness(know: Array, h: float, mu: float, d: Array) -> None:
    """D (6,) of a joint: −∂(N, P, T)/∂(u, φ, v) at the iterate, its entries uu, uφ, uv, φφ, φv, vv."""
    a, lever, q = know[A], know[LEVER], know[Q]
    skew = -a * mu * (know[PP] - know[PM]) / q
    d[0] = a * know[SUM] / q
    d[1] = lever * d[0]
    d[2] = skew
    # with N held, P = h(N₂ − N₁) resists the turn by 4h²/(det C a)
    d[3] = 4.0 * h * h * (know[D11] * know[D22] - know[D12] * know[D12]) / a + lever * d[1]
    d[4] = lever * skew
    d[5] = (1.0 + a * mu * mu * (know[PP] + know[PM])) / q


@compiled
def aim(know: Array, h: float, mu: float, target: float) -> None:
    """Forces RN, RP, RT of a joint that bear what it misses, its products becoming `target` less the corrections."""
    know[KP] = (target - know[LP] * know[ZP] - know[BP]) / know[ZP]
    know[KM] = (target - know[LM] * know[ZM] - know[BM]) / know[ZM]
    both, apart = know[KP] + know[KM], know[KP] - know[KM] + know[SLIP]
    first = (target - know[G1] * know[Y1] - know[C1]) / know[G1]
    second = (target - know[G2] * know[Y2] - know[C2]) / know[G2]
    b1 = know[E1] + first - know[BETA] * (first + second)
    b2 = know[E2] + second - know[BETA] * (first + second)
    a, skew = know[A], know[PP] - know[PM]
    n = (know[D11] + know[D12]) * b1 + (know[D22] + know[D12]) * b2
    tilt = 2.0 * h * (know[D11] * know[D22] - know[D12] * know[D12]) * (b2 - b1) / a
    lifted = a * mu
    know[RN] = (know[SUM] * n + lifted * (know[SUM] * both - skew * apart)) / know[Q]
    know[RP] = tilt + know[LEVER] * know[RN]
    know[RT] = (apart * (1.0 + lifted * mu * (know[PP] + know[PM])) - skew * mu * (n + lifted * both)) / know[
        Q
    ]


@compiled
def follow(d: Array, u: float, phi: float, v: float, df: Array) -> None:
    """Take D(u, φ, v) off the changes of N, P and T, df (3,)."""
    df[0] -= d[0] * u + d[1] * phi + d[2] * v
    df[1] -= d[1] * u + d[3] * phi + d[4] * v
    df[2] -= d[2] * u + d[4] * phi + d[5] * v


@compiled
def agree(know: Array, h: float, law: Array, df: Array, target: float, stiff: float) -> None:
    """Let forces that are nearly nothing be those that their wide gaps and slips ask for: changes of N, P, T, df (3,).

    As differences of large forces they would have lost their digits. `stiff`: weight per step.
    """
    u, phi, v, mu = know[DU], know[DPHI], know[DV], law[FRICTION]
    one, other = know[LP] * stiff > know[ZP], know[LM] * stiff > know[ZM]
    if one == other or know[BETA] > 0.0:
        return
    slip = v + law[SHEAR] * df[2] - know[SLIP]
    bound = mu * df[0]
    if one:
        lm = know[KM] - know[PM] * (bound - df[2])
        lp = lm + slip
    else:
        lp = know[KP] - know[PP] * (bound + df[2])
        lm = lp - slip
    couple = df[1] / h
    d1, d2 = 0.5 * (df[0] - couple), 0.5 * (df[0] + couple)
    w = u - mu * (lp + lm)
    if know[Y1] > know[N1] * (1.0 / stiff + know[S11]):
        y1 = w - h * phi - know[E1] + know[S11] * d1 - know[S12] * d2
        d1 = (target - know[G1] * know[Y1] - know[C1] - know[G1] * y1) / know[Y1]
    if know[Y2] > know[N2] * (1.0 / stiff + know[S22]):
        y2 = w + h * phi - know[E2] + know[S22] * d2 - know[S12] * d1
        d2 = (target - know[G2] * know[Y2] - know[C2] - know[G2] * y2) / know[Y2]
    df[0], df[1] = d1 + d2, h * (d2 - d1)
    bound = mu * df[0]
    if one:
        df[2] = (target - know[LP] * know[ZP] - know[BP] - know[ZP] * lp) / know[LP] - bound
    else:
        df[2] = bound - (target - know[LM] * know[ZM] - know[BM] - know[ZM] * lm) / know[LM]


@compiled
def change(know: Array, h: float, law: Array, df: Array, target: float, stiff: float, out: Array) -> None:
    """Changes of N₁, N₂, T; y₁, y₂, λ₊, λ₋; g₁, g₂, μN ± T that go with motions and forces, into `out` (11,).

    Of a wide gap or slip the change is that of the motion, of one that is narrow beside the bed's own compliance, and
    where joints crush, that which the product asks for.
    """
    u, phi, v, beta = know[DU], know[DPHI], know[DV], know[BETA]
    couple, mu = df[1] / h, law[FRICTION]
    d1, d2 = 0.5 * (df[0] - couple), 0.5 * (df[0] + couple)
    g1, g2 = d1 - beta * df[0], d2 - beta * df[0]
    bound = mu * df[0]
    zp, zm = bound + df[2], bound - df[2]
    lp, lm = know[KP] - know[PP] * zp, know[KM] - know[PM] * zm
    slip = v + law[SHEAR] * df[2] - know[SLIP]
    if know[PP] > know[PM]:
        lp = lm + slip
    else:
        lm = lp - slip
    y1 = (target - know[G1] * know[Y1] - know[C1] - know[Y1] * g1) / know[G1]
    y2 = (target - know[G2] * know[Y2] - know[C2] - know[Y2] * g2) / know[G2]
    w = u - mu * (lp + lm)
    if know[Y1] > know[N1] * (1.0 / stiff + know[S11]) and beta == 0.0:
        y1 = w - h * phi - know[E1] + know[S11] * d1 - know[S12] * d2
    if know[Y2] > know[N2] * (1.0 / stiff + know[S22]) and beta == 0.0:
        y2 = w + h * phi - know[E2] + know[S22] * d2 - know[S12] * d1
    out[0], out[1], out[2], out[3], out[4], out[5], out[6] = d1, d2, df[2], y1, y2, lp, lm
    out[7], out[8], out[9], out[10] = g1, g2, zp, zm


@compiled
def _stray(product: float, target: float) -> float:
    """What is added to the correction of a product that would become this."""
    wanted = min(max(product, LEAST * target), MOST * target)
    return -max(wanted - product, -MOST * target)


@compiled
def unbalanced(residual: Array, size: float) -> float:
    """The largest force of a residual (m,), moments by the size of a block."""
    largest = 0.0
    for i in range(len(residual)):
        largest = max(largest, abs(residual[i]) / (size if i % 3 == 2 else 1.0))
    return largest


@compiled
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


@compiled
def iterate(
    row: Any, places: Array, law: Array, load: Array, lateral: Array, work: float, mass: Array, curved: Array,
    x: Array, alpha: float, f: Array, y: Array, scale: Any, most: int, stored: Array, packed: Any, which: Any,
) -> tuple[int, float, float, float, float]:  # fmt: skip
    """Iterate on x (m,), α, f (j, 3): N₁, N₂, T, and y (j, 4): y₁, y₂, λ₊, λ₋, in one geometry and in place.

    `places` (j, PLACE), `law` (j, LAW); `lateral`, `mass` (m,) and `curved` (j, 7: joint.curvature) may be empty;
    `scale`: weight, size and step, and what is accepted of unbalanced forces per weight, of products per weight and
    step, and of gaps, WIDE times as much, per step; `which` (j,): their places among the joints of the pattern, that of
    `packed`. Returns the number of iterations, negative where none leads on
    (with curvature: where equilibrium is not stable), α, and these three.
    """
    pattern = unpacked(packed)
    weight, size, step, accepted = scale
    count, c, unit = len(x), len(row), step / weight
    tied = len(mass) > 0  # forces and gaps, to each other
    for k in range(c):
        tied |= law[k, BED] < np.inf
    know, d, df, out = np.zeros((c, KNOWN)), np.empty((c, 6)), np.empty((c, 3)), np.empty((c, 11))
    kept, kept_dx, kept_f, kept_g, kept_alpha = np.empty((c, 11)), np.empty(count), 0.0, 0.0, 0.0
    residual, dx, swayed, held, fine = (
        np.empty(count), np.empty(count), np.empty(count), np.empty(count), np.empty(count),
    )  # fmt: skip
    bent, pushed, holding = len(curved) > 0, len(lateral) > 0, HOLDING
    best, since, iteration = np.inf, 0, 0
    while True:
        residual[:] = load
        if pushed:
            residual += alpha * lateral
        if len(mass):
            residual -= mass * x
        gap_off, mean = 0.0, 0.0
        for k in range(c):
            i, j, s = row[k, 0], row[k, 1], know[k]
            missing(places[k], law[k], i, j, x, f[k], y[k], unit * STIFFEST, s)
            push(places[k], i, j, s[N1] + s[N2], places[k, H] * (s[N2] - s[N1]), s[T], residual)
            if bent:
                turn(curved[k], i, j, x, residual)
            gap_off = max(gap_off, s[OFF])
            mean += s[G1] * s[Y1] + s[G2] * s[Y2] + s[LP] * s[ZP] + s[LM] * s[ZM]
        mean /= max(4.0 * c, 1.0)
        force_off = unbalanced(residual, size)
        lacking = work - dot(lateral, x) if pushed else 0.0
        force, gap, product = (
            max(force_off / weight, abs(lacking) / (weight * step)), gap_off / step, mean / (weight * step),
        )  # fmt: skip
        off = max(force, gap)
        if not off < np.inf:
            return -1, alpha, np.inf, np.inf, np.inf
        if max(force, WIDE * gap, product) <= accepted:
            break
        progress = max(off, product)
        since += 1
        if progress < 0.5 * best:
            best, since = progress, 0
        if iteration == most or since > IDLE:
            break
        iteration += 1
        # the matrix, firmer where rounding outweighs the hold
        while True:
            held[:] = holding / unit
            held[2::3] *= size**2
            if len(mass):
                held += mass
            diagonal(held, stored, pattern)
            for k in range(c):
                i, j = row[k, 0], row[k, 1]
                stiffness(know[k], places[k, H], law[k, FRICTION], d[k])
                stiffen(which[k], places[k], i, j, d[k], stored, pattern)
                if bent:
                    bend(which[k], i, j, curved[k], stored, pattern)
            if bent:
                # with a multiplier the matrix may have one negative pivot, beyond the peak: the work holds that motion
                negative = factorise_signed(stored, pattern.places, pattern.last)
                definite = negative == 0 or (negative == 1 and pushed)
            else:
                definite = factorise(stored, pattern)
            if definite:
                break
            if holding >= FIRM:
                return -iteration, alpha, force, gap, product
            holding *= FIRMER
        gives = 1.0
        if pushed:
            swayed[:] = lateral
            _back(stored, pattern, bent, swayed)
            gives = dot(lateral, swayed)
        target, dalpha, most_f, most_g, reach_f, reach_g = 0.0, 0.0, 0.0, 0.0, 1.0, 1.0
        for k in range(c):
            know[k, C1], know[k, C2], know[k, BP], know[k, BM] = 0.0, 0.0, 0.0, 0.0
        for corrects in range(3):
            dx[:] = residual
            for k in range(c):
                s = know[k]
                aim(s, places[k, H], law[k, FRICTION], target)
                df[k, 0], df[k, 1], df[k, 2] = s[RN], s[RP], s[RT]
                push(places[k], row[k, 0], row[k, 1], s[RN], s[RP], s[RT], dx)
            _back(stored, pattern, bent, dx)
            if pushed:
                dalpha = (lacking - dot(lateral, dx)) / gives
                dx += dalpha * swayed
            for k in range(c):
                u, phi, v = motion(places[k], row[k, 0], row[k, 1], dx)
                know[k, DU], know[k, DPHI], know[k, DV] = u, phi, v
                follow(d[k], u, phi, v, df[k])
                if corrects:
                    agree(know[k], places[k, H], law[k], df[k], target, 1.0 / unit)
            for _ in range(REFINEMENTS if corrects else 0):
                # closed and stuck joints are stiff: forces that follow from motions lose their digits there
                fine[:] = residual
                if pushed:
                    fine += dalpha * lateral
                if len(mass):
                    fine -= mass * dx
                for k in range(c):
                    push(places[k], row[k, 0], row[k, 1], df[k, 0], df[k, 1], df[k, 2], fine)
                    if bent:
                        turn(curved[k], row[k, 0], row[k, 1], dx, fine)
                if unbalanced(fine, size) <= max(ROUNDING * force_off, ROUNDED * weight):
                    break
                _back(stored, pattern, bent, fine)
                if pushed:
                    more = -dot(lateral, fine) / gives
                    dalpha += more
                    fine += more * swayed
                for k in range(c):
                    u, phi, v = motion(places[k], row[k, 0], row[k, 1], fine)
                    s = know[k]
                    s[DU], s[DPHI], s[DV] = s[DU] + u, s[DPHI] + phi, s[DV] + v
                    follow(d[k], u, phi, v, df[k])
                    agree(s, places[k, H], law[k], df[k], target, 1.0 / unit)
                dx += fine
            most_f, most_g, ahead = 0.0, 0.0, 0.0
            for k in range(c):
                s, o = know[k], out[k]
                change(s, places[k, H], law[k], df[k], target, 1.0 / unit, o)
                most_f = max(most_f, -o[7] / s[G1], -o[8] / s[G2], -o[9] / s[ZP], -o[10] / s[ZM])
                most_g = max(most_g, -o[3] / s[Y1], -o[4] / s[Y2], -o[5] / s[LP], -o[6] / s[LM])
                if corrects == 0:
                    s[C1], s[C2], s[BP], s[BM] = o[7] * o[3], o[8] * o[4], o[9] * o[5], o[10] * o[6]
            if tied:
                most_f = most_g = max(most_f, most_g)
            if corrects == 2:
                if max(most_f, most_g) > max(kept_f, kept_g):  # the earlier step leads farther
                    most_f, most_g, dalpha = kept_f, kept_g, kept_alpha
                    dx[:], out[:] = kept_dx, kept
                break
            reach_f, reach_g = 1.0 / max(most_f, 1.0), 1.0 / max(most_g, 1.0)
            if corrects == 1:
                if max(most_f, most_g) <= 1.0:
                    break
                # products that would stray from their target are corrected once more (Gondzio)
                kept_f, kept_g, kept_alpha = most_f, most_g, dalpha
                kept_dx[:], kept[:] = dx, out
                to_f, to_g = min(1.0, FARTHER * reach_f + 0.1), min(1.0, FARTHER * reach_g + 0.1)
                for k in range(c):
                    s, o = know[k], out[k]
                    s[C1] += _stray((s[G1] + to_f * o[7]) * (s[Y1] + to_g * o[3]), target)
                    s[C2] += _stray((s[G2] + to_f * o[8]) * (s[Y2] + to_g * o[4]), target)
                    s[BP] += _stray((s[ZP] + to_f * o[9]) * (s[LP] + to_g * o[5]), target)
                    s[BM] += _stray((s[ZM] + to_f * o[10]) * (s[LM] + to_g * o[6]), target)
            if corrects == 0:
                for k in range(c):
                    s, o = know[k], out[k]
                    ahead += (s[G1] + reach_f * o[7]) * (s[Y1] + reach_g * o[3])
                    ahead += (s[G2] + reach_f * o[8]) * (s[Y2] + reach_g * o[4])
                    ahead += (s[ZP] + reach_f * o[9]) * (s[LP] + reach_g * o[5])
                    ahead += (s[ZM] + reach_f * o[10]) * (s[LM] + reach_g * o[6])
                centre = (ahead / (4.0 * c * mean)) ** 3 if mean > 0.0 else 0.0
                if off > product:
                    centre = max(centre, CENTRED if product > BEHIND * off else 1.0)
                target = centre * mean
        reach_f = 1.0 if most_f < TO_THE_BOUND else TO_THE_BOUND / most_f
        reach_g = 1.0 if most_g < TO_THE_BOUND else TO_THE_BOUND / most_g
        for k in range(c):
            reach_f = _within(law[k], places[k, H], know[k], out[k], reach_f)
        if tied:
            reach_f = reach_g = min(reach_f, reach_g)
        for k in range(c):
            for e in range(3):
                f[k, e] += reach_f * out[k, e]
            for e in range(4):
                y[k, e] += reach_g * out[k, 3 + e]
        x += reach_g * dx
        alpha += reach_f * dalpha
    return iteration, alpha, force, gap, product


@compiled
def _within(law: Array, h: float, know: Array, out: Array, reach: float) -> float:
    """A reach at which crushing, which is curved, leaves both ends a share of what they had."""
    if law[STRENGTH] == np.inf:
        return reach
    kappa = 0.25 / (h * law[STRENGTH])
    while True:
        n1, n2 = know[N1] + reach * out[0], know[N2] + reach * out[1]
        least = kappa * (n1 + n2) ** 2
        if n1 - least > (1.0 - TO_THE_BOUND) * know[G1] and n2 - least > (1.0 - TO_THE_BOUND) * know[G2]:
            return reach
        reach *= 0.7
