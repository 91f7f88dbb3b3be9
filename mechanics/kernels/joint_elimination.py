"""The laws of a joint about an iterate of the interior point: linearised, and eliminated one joint at a time.

Unknown are N₁, N₂, T, the gaps y₁, y₂ and the slips λ₊, λ₋ (see interior_iteration). Their changes follow from that of
the joint's motion (u, φ, v): forces by D, which is written in sums of positive terms, then gaps and slips.
"""

from __future__ import annotations

import numpy as np

from mechanics.kernels.bed import (
    closures,
    linearised,
    points_under,
    softness,
    under,
)
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import (
    BED,
    FRICTION,
    SEGMENTS,
    SHEAR,
    SLID,
    STRENGTH,
)
from mechanics.kernels.matrix import motion
from mechanics.types import Array

compiled = compiler("contract", "reassoc", allocates=False)

# columns of (j, KNOWN), what is known of a joint: forces, gaps and slips; g₁, g₂ and 2κN; what the laws of the ends and
# of the slip miss, and the most of it; bounds of T; λ±/(μN ± T); D of the ends; its sum a, b/a, and the sums of the
# elimination; forces aimed at; λ± aimed at; corrections of the products; compliance of the bed; motion
(N1, N2, T, Y1, Y2, LP, LM, G1, G2, BETA, E1, E2, SLIP, OFF, ZP, ZM, PP, PM, D11, D12, D22, A, LEVER, SUM, Q, RN, RP,
 RT, KP, KM, C1, C2, BP, BM, S11, S12, S22, DU, DPHI, DV) = range(40)  # fmt: skip
KNOWN = 40


@compiled
def missing(
    p: Array, law: Array, i: int, j: int, x: Array, f: Array, y: Array, least: float, know: Array
) -> None:  # fmt: skip
    """What an iterate misses of the laws of a joint, and the terms of its elimination, into `know` (KNOWN,).

    `least` (m/kN): added to compliances, bounds the stiffness. Gaps y (4,) of the ends change where the bed's own can
    be told from them.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    du, dphi, dv = motion(p, i, j, x)
    n1, n2, t, h, mu = f[0], f[1], f[2], p[H], law[FRICTION]
    n = n1 + n2
    w, tilt = p[U] + du - mu * (y[2] + y[3]), h * (p[PHI] + dphi)
    first, second = w - tilt, w + tilt
    w1, w2, c11, c12, c22, off = _bed(law, h, n1, n2, first, second, y)
    kappa = 0.25 / (h * law[STRENGTH])
    beta, both = 2.0 * kappa * n, y[0] + y[1]
    know[N1], know[N2], know[T] = n1, n2, t
    know[Y1], know[Y2], know[LP], know[LM] = y[0], y[1], y[2], y[3]
    know[G1], know[G2], know[BETA] = n1 - kappa * n * n, n2 - kappa * n * n, beta
    know[E1], know[E2] = w1 + y[0] - beta * both - first, w2 + y[1] - beta * both - second
    if off < 0.0:
        off = max(abs(know[E1]), abs(know[E2]))
    know[SLIP] = y[2] - y[3] - (p[V] + dv - law[SLID]) - law[SHEAR] * t
    know[OFF] = max(off, abs(know[SLIP]))
    know[ZP], know[ZM] = mu * n + t, mu * n - t
    know[PP], know[PM] = y[2] / know[ZP], y[3] / know[ZM]
    know[S11], know[S12], know[S22] = c11, c12, c22
    _eliminate(h, mu, law[SHEAR] + least, kappa, least, know)


@compiled
def _eliminate(h: float, mu: float, shear: float, kappa: float, least: float, know: Array) -> None:
    """D of the ends and the sums that resultants follow from, into `know`."""
    beta, first, second = know[BETA], know[Y1] / know[G1], know[Y2] / know[G2]
    cross, rest = 2.0 * kappa * (know[Y1] + know[Y2]), 1.0 - beta
    c11 = know[S11] + first * rest * rest + second * beta * beta + cross + least
    c22 = know[S22] + second * rest * rest + first * beta * beta + cross + least
    c12 = know[S12] + (first + second) * beta * rest - cross
    det = c11 * c22 - c12 * c12
    know[D11], know[D12], know[D22] = c22 / det, c12 / det, c11 / det
    a = know[D11] + know[D22] + 2.0 * know[D12]
    know[A], know[LEVER] = a, h * (know[D22] - know[D11]) / a
    slides = know[PP] + know[PM]
    know[SUM] = slides + shear
    know[Q] = know[SUM] + a * mu * mu * (4.0 * know[PP] * know[PM] + shear * slides)


@compiled
def _bed(
    law: Array, h: float, n1: float, n2: float, first: float, second: float, y: Array
) -> tuple[float, float, float, float, float, float]:
    """Gaps of a bed's ends under N₁ and N₂, its compliance C₁₁, −C₁₂, C₂₂, and by how much it misses `first`, `second`.

    The last is negative where it is what the ends miss of the gaps returned. An open end's gap may be the bed's as well
    as y (4,): where it can, y takes what is missing.
    """
    if law[BED] == np.inf:
        return 0.0, 0.0, 0.0, 0.0, 0.0, -1.0
    soft = 1.0 / (2.0 * h * law[BED])
    if law[STRENGTH] < np.inf:
        w1, w2 = under(n1, n2, h, law[BED], law[STRENGTH])
        c11, c12, c22 = softness(w1, w2, h, law[BED], law[STRENGTH])
        return w1, w2, c11, c12, c22, -1.0
    if law[SEGMENTS] > 0.0:
        w1, w2, c11, c12, c22 = points_under(n1, n2, int(law[SEGMENTS]), soft)
        return w1, w2, c11, c12, c22, -1.0
    w1, w2 = closures(n1, n2, soft)
    y[0], y[1] = _taken(first - w1, y[0]), _taken(second - w2, y[1])
    off = max(abs(w1 + y[0] - first), abs(w2 + y[1] - second))
    turn = first - second - y[0] + y[1]
    w1, w2, c11, c12, c22 = linearised(n1, n2, turn, soft)
    return w1, w2, c11, c12, c22, off


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
