"""The law of a joint about an iterate of the interior point, linearised and eliminated.

Unknown are N₁, N₂, T, the gaps y₁, y₂ and the slips λ₊, λ₋ (see iteration). Their changes follow from that of
the joint's motion (u, φ, v): forces by D, which is written in sums of positive terms, then gaps and slips. With
p± = λ±/(μN ± T), S = p₊ + p₋, s the compliance in shear, a = ΣD of the bed and ℓ = P/N of a push of it

    q = S + s + ψμ²a(4p₊p₋ + sS)        D_uu = a(S + s)/q        D_uv = −ψμa(p₊ − p₋)/q
                                        D_vu = −μa(p₊ − p₋)/q    D_vv = (1 + ψμ²aS)/q

and ℓ times the terms of u those of φ. D is symmetric for ψ = 1 alone.
A joint that does not slide at all (infinite friction, see iteration) has no slips.

What is known of a joint is in lane k of a row `s` of LANES joints (joints): quantity C is s[C + k].
"""

from __future__ import annotations

import numpy as np

from mechanics.kernels.bed import closures, linearised
from mechanics.kernels.jit import inlined, larger, looped
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import BED, DILATION, FRICTION, SHEAR, SLID, STRENGTH, gaps_under, is_whole
from mechanics.kernels.matrix import motion
from mechanics.types import Array

LANES = 8  # joints side by side
NO_SLIP = 1e-300  # m: of a joint that does not slide at all
# what is known of a joint: forces, gaps and slips; g₁, g₂ and 2κN; what the laws of the ends and of the slip miss, and
# the most of it; bounds of T; λ±/(μN ± T); D of the ends; its sum a, b/a, and the sums of the elimination; forces aimed
# at; λ± aimed at; corrections of the products; compliance of the bed; half-length, friction (0 where it is infinite),
# ψμ, 1 where the joint may slide, compliance in shear and κ; motion in an iteration, and the part of it that is new; D;
# changes of N, P, T; changes of all unknowns
(N1, N2, T, Y1, Y2, LP, LM, G1, G2, BETA, E1, E2, SLIP, OFF, ZP, ZM, PP, PM, D11, D12, D22, A, LEVER, SUM, Q, RN, RP,
 RT, KP, KM, C1, C2, BP, BM, S11, S12, S22, HALF, COULOMB, LIFT, FREE, SPRING, KAPPA, DU, DPHI, DV, MU, MPHI, MV, DUU,
 DUP, DUV, DPP, DPV, DVV, DVU, DVP, FN, FP, FT, CN1, CN2, CT, CY1, CY2, CLP, CLM, CG1, CG2, CZP,
 CZM) = range(0, 71 * LANES, LANES)  # fmt: skip
KNOWN = 71 * LANES
CHANGES = slice(CN1, KNOWN)  # all unknowns' changes


@looped
def read(p: Array, law: Array, i: int, j: int, x: Array, f: Array, y: Array, s: Array, k: int) -> None:
    """The iterate of a joint, its law and the residuals of its bed and its slip, into lane k of s.

    Gaps y (4,) of the ends change where the bed's own can be told from them.
    """
    du, dphi, dv = motion(p, i, j, x)
    n1, n2, h, mu = f[0], f[1], p[H], law[FRICTION]
    s[FREE + k] = 1.0
    if mu == np.inf:
        mu, s[FREE + k], y[2], y[3] = 0.0, 0.0, NO_SLIP, NO_SLIP
    lift = law[DILATION] * mu
    w, tilt = p[U] + du - lift * (y[2] + y[3]), h * (p[PHI] + dphi)
    first, second = w - tilt, w + tilt
    w1, w2, s[S11 + k], s[S12 + k], s[S22 + k], s[OFF + k] = _bed(law, h, n1, n2, first, second, y)
    s[E1 + k], s[E2 + k] = w1 - first, w2 - second
    s[N1 + k], s[N2 + k], s[T + k] = n1, n2, f[2]
    s[Y1 + k], s[Y2 + k], s[LP + k], s[LM + k] = y[0], y[1], y[2], y[3]
    s[SLIP + k] = y[2] - y[3] - (p[V] + dv - law[SLID]) - law[SHEAR] * f[2]
    s[HALF + k], s[COULOMB + k], s[LIFT + k], s[SPRING + k] = h, mu, lift, law[SHEAR]
    s[KAPPA + k] = 0.25 / (h * law[STRENGTH])


@inlined
def missing(s: Array, k: int, least: float) -> None:
    """The residuals of the laws of a joint, and the terms of its elimination.

    `least` (m/kN): added to compliances, bounds the stiffness.
    """
    n1, n2, t, y1, y2, lp, lm = (
        s[N1 + k], s[N2 + k], s[T + k], s[Y1 + k], s[Y2 + k], s[LP + k], s[LM + k],
    )  # fmt: skip
    h, mu, kappa = s[HALF + k], s[COULOMB + k], s[KAPPA + k]
    n = n1 + n2
    beta, crushed = 2.0 * kappa * n, kappa * n * n
    g1, g2 = n1 - crushed, n2 - crushed
    e1, e2 = s[E1 + k] + y1 - beta * (y1 + y2), s[E2 + k] + y2 - beta * (y1 + y2)
    off = s[OFF + k] if s[OFF + k] >= 0.0 else larger(abs(e1), abs(e2))
    free = s[FREE + k]
    zp, zm = 1.0 - free + free * (mu * n + t), 1.0 - free + free * (mu * n - t)
    pp, pm = lp / zp, lm / zm
    s[G1 + k], s[G2 + k], s[BETA + k], s[E1 + k], s[E2 + k] = g1, g2, beta, e1, e2
    s[OFF + k] = larger(off, abs(s[SLIP + k]))
    s[ZP + k], s[ZM + k], s[PP + k], s[PM + k] = zp, zm, pp, pm
    # D of the ends, and the sums that resultants follow from
    first, second, shear = y1 / g1, y2 / g2, s[SPRING + k] + least
    cross, rest = 2.0 * kappa * (y1 + y2), 1.0 - beta
    c11 = s[S11 + k] + first * rest * rest + second * beta * beta + cross + least
    c22 = s[S22 + k] + second * rest * rest + first * beta * beta + cross + least
    c12 = s[S12 + k] + (first + second) * beta * rest - cross
    det = c11 * c22 - c12 * c12
    d11, d12, d22 = c22 / det, c12 / det, c11 / det
    a = d11 + d22 + 2.0 * d12
    slides = pp + pm
    s[D11 + k], s[D12 + k], s[D22 + k] = d11, d12, d22
    s[A + k], s[LEVER + k], s[SUM + k] = a, h * (d22 - d11) / a, slides + shear
    s[Q + k] = slides + shear + a * mu * s[LIFT + k] * (4.0 * pp * pm + shear * slides)


@looped
def _bed(
    law: Array, h: float, n1: float, n2: float, first: float, second: float, y: Array
) -> tuple[float, float, float, float, float, float]:
    """Gaps of a bed's ends under N₁ and N₂, its compliance C₁₁, −C₁₂, C₂₂, and its residual beside `first`, `second`.

    The last is negative where it is the distance of the ends from the gaps returned. An open end's gap may be the
    bed's as well as y (4,): where it can, y takes what is missing.
    """
    if law[BED] == np.inf:
        return 0.0, 0.0, 0.0, 0.0, 0.0, -1.0
    soft = 1.0 / (2.0 * h * law[BED])
    w1, w2 = closures(n1, n2, soft)
    if not is_whole(law, max(-w1, -w2)):
        w1, w2, c11, c12, c22 = gaps_under(law, h, n1, n2)
        return w1, w2, c11, c12, c22, -1.0
    beta = soft * law[BED] * (n1 + n2) / law[STRENGTH]
    y[0] = _taken(first - w1 + beta * (y[0] + y[1]), y[0])
    y[1] = _taken(second - w2 + beta * (y[0] + y[1]), y[1])
    w1, w2 = w1 - beta * (y[0] + y[1]), w2 - beta * (y[0] + y[1])
    off = max(abs(w1 + y[0] - first), abs(w2 + y[1] - second))
    turn = first - second - y[0] + y[1]
    w1, w2, c11, c12, c22 = linearised(n1, n2, turn, soft)
    return w1, w2, c11, c12, c22, off


@looped
def _taken(missed: float, y: float) -> float:
    return missed if 0.1 * y < missed < 10.0 * y else y


@inlined
def stiffness(s: Array, k: int) -> None:
    """D of a joint: −∂(N, P, T)/∂(u, φ, v) at the iterate."""
    a, lever, q, h, mu, lift = s[A + k], s[LEVER + k], s[Q + k], s[HALF + k], s[COULOMB + k], s[LIFT + k]
    d11, d12, d22, pp, pm = s[D11 + k], s[D12 + k], s[D22 + k], s[PP + k], s[PM + k]
    uu, uv, vu = a * s[SUM + k] / q, -a * lift * (pp - pm) / q, -a * mu * (pp - pm) / q
    s[DUU + k], s[DUP + k], s[DUV + k], s[DVU + k], s[DVP + k] = uu, lever * uu, uv, vu, lever * vu
    # with N held, P = h(N₂ − N₁) resists the turn by 4h²/(det C a)
    s[DPP + k] = 4.0 * h * h * (d11 * d22 - d12 * d12) / a + lever * lever * uu
    s[DPV + k], s[DVV + k] = lever * uv, (1.0 + a * mu * lift * (pp + pm)) / q


@inlined
def aim(s: Array, k: int, target: float) -> None:
    """Changes of N, P, T of a joint that cancel its residuals; its products become `target` less the corrections."""
    h, mu, a, q = s[HALF + k], s[COULOMB + k], s[A + k], s[Q + k]
    kp = s[FREE + k] * (target - s[LP + k] * s[ZP + k] - s[BP + k]) / s[ZP + k]
    km = s[FREE + k] * (target - s[LM + k] * s[ZM + k] - s[BM + k]) / s[ZM + k]
    both, apart = kp + km, kp - km + s[SLIP + k]
    first = (target - s[G1 + k] * s[Y1 + k] - s[C1 + k]) / s[G1 + k]
    second = (target - s[G2 + k] * s[Y2 + k] - s[C2 + k]) / s[G2 + k]
    b1 = s[E1 + k] + first - s[BETA + k] * (first + second)
    b2 = s[E2 + k] + second - s[BETA + k] * (first + second)
    skew, d11, d12, d22 = s[PP + k] - s[PM + k], s[D11 + k], s[D12 + k], s[D22 + k]
    n = (d11 + d12) * b1 + (d22 + d12) * b2
    tilt = 2.0 * h * (d11 * d22 - d12 * d12) * (b2 - b1) / a
    lifted = a * s[LIFT + k]
    rn = (s[SUM + k] * n + lifted * (s[SUM + k] * both - skew * apart)) / q
    rp = tilt + s[LEVER + k] * rn
    rt = (apart * (1.0 + lifted * mu * (s[PP + k] + s[PM + k])) - skew * mu * (n + lifted * both)) / q
    s[KP + k], s[KM + k] = kp, km
    s[RN + k], s[RP + k], s[RT + k] = rn, rp, rt
    s[FN + k], s[FP + k], s[FT + k] = rn, rp, rt
    s[DU + k], s[DPHI + k], s[DV + k] = 0.0, 0.0, 0.0


@inlined
def follow(s: Array, k: int) -> None:
    """Add the new part of a joint's motion to it, and take D(u, φ, v) off the changes of N, P and T."""
    u, phi, v = s[MU + k], s[MPHI + k], s[MV + k]
    s[DU + k] += u
    s[DPHI + k] += phi
    s[DV + k] += v
    s[FN + k] -= s[DUU + k] * u + s[DUP + k] * phi + s[DUV + k] * v
    s[FP + k] -= s[DUP + k] * u + s[DPP + k] * phi + s[DPV + k] * v
    s[FT + k] -= s[DVU + k] * u + s[DVP + k] * phi + s[DVV + k] * v


@inlined
def agree(s: Array, k: int, target: float, stiff: float) -> None:
    """Take forces that nearly vanish from the products with their wide gaps and slips: changes of N, P and T.

    As differences of large forces they would have lost their digits. `stiff`: weight per step.
    """
    u, phi, v, mu, h = s[DU + k], s[DPHI + k], s[DV + k], s[COULOMB + k], s[HALF + k]
    fn, fp, ft, give = s[FN + k], s[FP + k], s[FT + k], 1.0 / stiff
    one, other = s[LP + k] * stiff > s[ZP + k], s[LM + k] * stiff > s[ZM + k]
    wide = (one != other) & (s[BETA + k] <= 0.0)
    slip = v + s[SPRING + k] * ft - s[SLIP + k]
    bound = mu * fn
    lp, lm = s[KP + k] - s[PP + k] * (bound + ft), s[KM + k] - s[PM + k] * (bound - ft)
    lp, lm = (lm + slip if one else lp), (lm if one else lp - slip)
    d1, d2 = 0.5 * (fn - fp / h), 0.5 * (fn + fp / h)
    w = u - s[LIFT + k] * (lp + lm)
    y1 = w - h * phi - s[E1 + k] + s[S11 + k] * d1 - s[S12 + k] * d2
    asked = (target - s[G1 + k] * s[Y1 + k] - s[C1 + k] - s[G1 + k] * y1) / s[Y1 + k]
    d1 = asked if s[Y1 + k] > s[N1 + k] * (give + s[S11 + k]) else d1
    y2 = w + h * phi - s[E2 + k] + s[S22 + k] * d2 - s[S12 + k] * d1
    asked = (target - s[G2 + k] * s[Y2 + k] - s[C2 + k] - s[G2 + k] * y2) / s[Y2 + k]
    d2 = asked if s[Y2 + k] > s[N2 + k] * (give + s[S22 + k]) else d2
    bound = mu * (d1 + d2)
    forth = (target - s[LP + k] * s[ZP + k] - s[BP + k] - s[ZP + k] * lp) / s[LP + k] - bound
    back = bound - (target - s[LM + k] * s[ZM + k] - s[BM + k] - s[ZM + k] * lm) / s[LM + k]
    t = forth if one else back
    s[FN + k] = d1 + d2 if wide else fn
    s[FP + k] = h * (d2 - d1) if wide else fp
    s[FT + k] = t if wide else ft


@inlined
def change(s: Array, k: int, target: float, stiff: float) -> None:
    """Changes of N₁, N₂, T; y₁, y₂, λ₊, λ₋; g₁, g₂, μN ± T that go with the motion and with those of N, P, T.

    Of a wide gap or slip the change is that of the motion, of one that is narrow beside the bed's own compliance, and
    where joints crush, that which the product asks for.
    """
    u, phi, v, beta, mu, h = s[DU + k], s[DPHI + k], s[DV + k], s[BETA + k], s[COULOMB + k], s[HALF + k]
    fn, fp, ft, give = s[FN + k], s[FP + k], s[FT + k], 1.0 / stiff
    d1, d2 = 0.5 * (fn - fp / h), 0.5 * (fn + fp / h)
    g1, g2 = d1 - beta * fn, d2 - beta * fn
    bound, free = mu * fn, s[FREE + k]
    zp, zm = free * (bound + ft), free * (bound - ft)
    lp, lm = s[KP + k] - s[PP + k] * zp, s[KM + k] - s[PM + k] * zm
    slip, forth = v + s[SPRING + k] * ft - s[SLIP + k], s[PP + k] > s[PM + k]
    lp, lm = free * (lm + slip if forth else lp), free * (lm if forth else lp - slip)
    y1 = (target - s[G1 + k] * s[Y1 + k] - s[C1 + k] - s[Y1 + k] * g1) / s[G1 + k]
    y2 = (target - s[G2 + k] * s[Y2 + k] - s[C2 + k] - s[Y2 + k] * g2) / s[G2 + k]
    w = u - s[LIFT + k] * (lp + lm)
    moved1 = w - h * phi - s[E1 + k] + s[S11 + k] * d1 - s[S12 + k] * d2
    moved2 = w + h * phi - s[E2 + k] + s[S22 + k] * d2 - s[S12 + k] * d1
    y1 = moved1 if (s[Y1 + k] > s[N1 + k] * (give + s[S11 + k])) & (beta == 0.0) else y1
    y2 = moved2 if (s[Y2 + k] > s[N2 + k] * (give + s[S22 + k])) & (beta == 0.0) else y2
    s[CN1 + k], s[CN2 + k], s[CT + k] = d1, d2, ft
    s[CY1 + k], s[CY2 + k], s[CLP + k], s[CLM + k] = y1, y2, lp, lm
    s[CG1 + k], s[CG2 + k], s[CZP + k], s[CZM + k] = g1, g2, zp, zm
