"""The no-tension bed of a joint, integrated in closed form.

The bed presses with k⟨−w⟩ along the overlap L = 2h, w = u + φs the gap. As complementary energy of the forces N₁ and N₂
at its two ends, N = N₁ + N₂ and P = h(N₂ − N₁):

    W* = (N² + 3 (N₂ − N₁)²)/(2kL)     where the whole bed is pressed, N₁ ≥ N₂/2 and N₂ ≥ N₁/2
    W* = 2N³/(9kL N₁)                  where it opens at the first end; likewise at the other

Its gradient are the closures of the ends, its Hessian their compliance; both are continuous. A bed of points at the
ends of n equal segments (the paper's) has no W* in closed form: there the displacements under two forces are found
first. Which bed a joint has: law.

A fibre of a bed of finite strength σ, at s, is pressed in by p = −w. What it is pressed in beyond σ/k stays:

    f = min(σ, k⟨p − r⟩)      r(s) = max(0, q₁(s), q₂(s), q₃(s))      q = p − σ/k when a place was pressed in the most

A line q is remembered for either end and for the middle: that of the moment at which it was pressed in the farthest.
A fourth one is that of the dashpots of a step (dynamics.motion), of beds without strength (σ = ∞) too.
Loads that grow find the bed that they left, and one that has been let go touches where it is left. Where r has a kink
the bed is divided; on each part f is the difference of two beds without strength, k⟨p − r⟩ − k⟨p − r − σ/k⟩.
"""

from __future__ import annotations

from mechanics.kernels.jit import looped
from mechanics.types import Array

MOST_SEGMENTS = 64  # of a bed of points
LINES = 4  # of both ends and of the middle, and that of dashpots
NEWTON, HALVINGS = 60, 30  # iterations for the displacements under given forces, and halvings of one
EXACT = 1e-13  # of the force: an imbalance of the bed that is none


@looped
def closures(n1: float, n2: float, soft: float) -> tuple[float, float]:
    """Gaps of the two ends under forces N₁, N₂ > 0; `soft` = 1/(kL), m/kN."""
    if 2.0 * n1 < n2:
        n, x = n1 + n2, 1.0 + n2 / n1
        b = 2.0 / 9.0 * soft * n * x
        return b * (x - 3.0), -3.0 * b
    if 2.0 * n2 < n1:
        n, x = n1 + n2, 1.0 + n1 / n2
        b = 2.0 / 9.0 * soft * n * x
        return -3.0 * b, b * (x - 3.0)
    return soft * (2.0 * n2 - 4.0 * n1), soft * (2.0 * n1 - 4.0 * n2)


@looped
def compliance(n1: float, n2: float, soft: float) -> tuple[float, float, float]:
    """Hessian of W*: C₁₁, −C₁₂ and C₂₂, all positive, m/kN."""
    b = 2.0 / 9.0 * soft
    if 2.0 * n1 < n2:
        x = 1.0 + n2 / n1
        return 2.0 * b * x * (x * (x - 3.0) + 3.0), 3.0 * b * x * (x - 2.0), 6.0 * b * x
    if 2.0 * n2 < n1:
        x = 1.0 + n1 / n2
        return 6.0 * b * x, 3.0 * b * x * (x - 2.0), 2.0 * b * x * (x * (x - 3.0) + 3.0)
    return 4.0 * soft, 2.0 * soft, 4.0 * soft


@looped
def linearised(n1: float, n2: float, turn: float, soft: float) -> tuple[float, float, float, float, float]:
    """Gaps of the ends and C₁₁, −C₁₂, C₂₂ of the law's stiffer tangent: at the forces or at the turn.

    `turn`: the gap at the first end less that at the other. Where a bed opens, forces far behind the turn would follow
    it by half of themselves in an iteration, as a turn far behind the forces would overshoot.
    """
    first = n1 < n2
    low, n = min(n1, n2), n1 + n2
    b = 2.0 / 9.0 * soft * n
    opened = turn if first else -turn
    x = n / low
    if x <= 3.0 or opened >= b * x * x:
        g1, g2 = closures(n1, n2, soft)
        c11, c12, c22 = compliance(n1, n2, soft)
        return g1, g2, c11, c12, c22
    if opened <= 9.0 * b:  # so little turned the whole bed is pressed: the law is linear there
        return soft * (2.0 * n2 - 4.0 * n1), soft * (2.0 * n1 - 4.0 * n2), 4.0 * soft, 2.0 * soft, 4.0 * soft
    at = n / (opened / b) ** 0.5
    other = n - at
    g1, g2 = closures(at, other, soft) if first else closures(other, at, soft)
    c11, c12, c22 = compliance(at, other, soft) if first else compliance(other, at, soft)
    shift = n1 - at if first else n1 - other
    return g1 - (c11 + c12) * shift, g2 + (c12 + c22) * shift, c11, c12, c22


@looped
def pressed(u: float, phi: float, half: float, stiffness: float) -> tuple[float, float, float]:
    """N, P and the contact length l of a gap u + φs, |s| ≤ h: the same law from the displacements."""
    first, second = u - half * phi, u + half * phi
    low, high = min(first, second), max(first, second)
    if low >= 0.0:
        return 0.0, 0.0, 0.0
    length = 2.0 * half
    if high > 0.0:
        length *= low / (low - high)  # φ is never divided by
    at_open = max(-high, 0.0)
    n = 0.5 * stiffness * length * (at_open - low)
    # from the middle of the overlap to that of the contact, and within it
    moment = n * (half - 0.5 * length) + stiffness * length * length / 12.0 * (-low - at_open)
    return n, moment if second < first else -moment, length


@looped
def stiffened(
    u: float, phi: float, half: float, stiffness: float
) -> tuple[float, float, float, float, float]:
    """N, P and −∂N/∂u, −∂N/∂φ, −∂P/∂φ of a gap u + φs, |s| ≤ h."""
    n, m, length = pressed(u, phi, half, stiffness)
    middle = half - 0.5 * length
    if phi > 0.0:
        middle = -middle
    c0 = stiffness * length
    return n, m, c0, c0 * middle, c0 * (middle * middle + length * length / 12.0)


@looped
def stored(u: float, phi: float, half: float, stiffness: float) -> float:
    """Energy of a bed under gaps u + φs: ½k ∫⟨−w⟩² ds."""
    first, second = u - half * phi, u + half * phi
    low, high = min(first, second), max(first, second)
    if low >= 0.0:
        return 0.0
    length = 2.0 * half
    if high > 0.0:
        length *= low / (low - high)
    pressed_less = max(-high, 0.0)
    mean, spread = 0.5 * (pressed_less - low), -low - pressed_less
    return 0.5 * stiffness * length * (mean * mean + spread * spread / 12.0)


@looped
def points_under(
    n1: float, n2: float, segments: int, soft: float
) -> tuple[float, float, float, float, float]:
    """Gaps of the ends and C₁₁, −C₁₂, C₂₂ of a bed of points at the ends of equal segments; `soft` = 1/(kL).

    The points in contact are those of one side; those that open leave, until none does.
    """
    if n1 > n2:
        g2, g1, c22, c12, c11 = points_under(n2, n1, segments, soft)
        return g1, g2, c11, c12, c22
    first = 0
    while True:
        # stiffness of the points from `first` on against the gaps of the two ends
        a, b, c = 0.0, 0.0, 0.0
        for i in range(first, segments + 1):
            share = i / segments
            weight = (0.5 if i in (0, segments) else 1.0) / (segments * soft)
            a += weight * (1.0 - share) ** 2
            b += weight * share * (1.0 - share)
            c += weight * share**2
        det = a * c - b * b
        g1, g2 = -(c * n1 - b * n2) / det, -(a * n2 - b * n1) / det
        if first == segments - 1 or g1 + (g2 - g1) * first / segments <= 0.0:
            return g1, g2, c / det, b / det, a / det
        first += 1


@looped
def points(
    u: float, phi: float, half: float, stiffness: float, segments: int
) -> tuple[float, float, float, float, float]:
    """As stiffened, of a bed of points at the ends of equal segments."""
    n, m, c0, c1, c2 = 0.0, 0.0, 0.0, 0.0, 0.0
    each = 2.0 * half * stiffness / segments
    for i in range(segments + 1):
        s = half * (2.0 * i / segments - 1.0)
        gap = u + phi * s
        if gap < 0.0:
            k = 0.5 * each if i in (0, segments) else each
            n, m = n - k * gap, m - k * gap * s
            c0, c1, c2 = c0 + k, c1 + k * s, c2 + k * s * s
    return n, m, c0, c1, c2


@looped
def points_stored(u: float, phi: float, half: float, stiffness: float, segments: int) -> float:
    """Energy of a bed of points at the ends of equal segments: Σ ½kᵢ⟨−wᵢ⟩²."""
    total = 0.0
    for i in range(segments + 1):
        gap = min(u + phi * half * (2.0 * i / segments - 1.0), 0.0)
        total += (0.5 if i in (0, segments) else 1.0) * gap * gap
    return half * stiffness / segments * total


@looped
def _line(number: int, half: float, left: Array) -> tuple[float, float]:
    """A line q in the middle of a bed, m, and its slope; behind those that are remembered, zero."""
    if number == LINES:
        return 0.0, 0.0
    first, second = left[2 * number], left[2 * number + 1]
    return 0.5 * (first + second), 0.5 * (second - first) / half


@looped
def highest(s: float, half: float, left: Array) -> int:
    """Which line is r at s; the steepest one of several."""
    found, most, steepest = LINES, 0.0, 0.0
    for number in range(LINES):
        middle, slope = _line(number, half, left)
        there = middle + slope * s
        if there > most or (there == most and slope > steepest):
            found, most, steepest = number, there, slope
    return found


@looped
def following(line: int, half: float, left: Array) -> tuple[float, int]:
    """Where a line ceases to be r, m, and the line that is r from there on; the end of the bed if none is."""
    middle, slope = _line(line, half, left)
    end, found, steepest = half, line, slope
    for number in range(LINES + 1):
        other, along = _line(number, half, left)
        if along > slope:
            s = (middle - other) / (along - slope)
            if s < end or (s == end and found != line and along > steepest):
                end, found, steepest = s, number, along
    return max(end, -half), found


@looped
def crushed(
    u: float, phi: float, half: float, stiffness: float, strength: float, left: Array
) -> tuple[float, float, float, float, float]:
    """N, P and −∂N/∂u, −∂N/∂φ, −∂P/∂φ of a bed that bears at most the `strength`, kN/m.

    `left` (8,) m: each line q at both ends of the bed.
    """
    yields, low, line = strength / stiffness, -half, highest(-half, half, left)
    n, m, c0, c1, c2 = 0.0, 0.0, 0.0, 0.0, 0.0
    while low < half:
        middle, slope = _line(line, half, left)
        high, line = following(line, half, left)
        s, h = 0.5 * (low + high), 0.5 * (high - low)
        low = high
        if h <= 0.0:
            continue
        w, turn = u + phi * s + middle + slope * s, phi + slope
        less, more = stiffened(w, turn, h, stiffness), stiffened(w + yields, turn, h, stiffness)
        pn, pm, p0, p1, p2 = (
            less[0] - more[0], less[1] - more[1], less[2] - more[2], less[3] - more[3], less[4] - more[4],
        )  # fmt: skip
        n, m = n + pn, m + pm + s * pn
        c0, c1, c2 = c0 + p0, c1 + p1 + s * p0, c2 + p2 + 2.0 * s * p1 + s * s * p0
    return n, m, c0, c1, c2


@looped
def worked(u: float, phi: float, half: float, stiffness: float, strength: float, left: Array) -> float:
    """The work ψ = ½k∫(⟨p − r⟩² − ⟨p − r − σ/k⟩²) ds that presses a bed in; −∂ψ/∂u = N, −∂ψ/∂φ = P.

    Where no fibre is pressed in beyond r + σ/k it is stored.
    """
    yields, low, line, total = strength / stiffness, -half, highest(-half, half, left), 0.0
    while low < half:
        middle, slope = _line(line, half, left)
        high, line = following(line, half, left)
        s, h = 0.5 * (low + high), 0.5 * (high - low)
        low = high
        if h > 0.0:
            w, turn = u + phi * s + middle + slope * s, phi + slope
            total += stored(w, turn, h, stiffness) - stored(w + yields, turn, h, stiffness)
    return total


@looped
def leave(u: float, phi: float, half: float, stiffness: float, strength: float, left: Array) -> None:
    """Remember in `left` (8,) that the bed has been pressed to gaps u + φs, for places that never were so far."""
    q1, q2 = half * phi - u - strength / stiffness, -half * phi - u - strength / stiffness
    if q1 > left[0]:
        left[0], left[1] = q1, q2
    if q2 > left[3]:
        left[2], left[3] = q1, q2
    if q1 + q2 > max(left[4] + left[5], 0.0):
        left[4], left[5] = q1, q2


@looped
def under(
    n1: float, n2: float, half: float, stiffness: float, strength: float, left: Array
) -> tuple[float, float]:
    """Gaps of the two ends of a bed of finite strength under forces within it (Newton, on the energy ψ + Nu + Pφ)."""
    n, m = n1 + n2, half * (n2 - n1)
    w1, w2 = closures(n1, n2, 1.0 / (2.0 * half * stiffness))
    u, phi = 0.5 * (w1 + w2), 0.5 * (w2 - w1) / half
    middle, slope = _line(highest(m / n, half, left), half, left)  # as if that were r everywhere
    u, phi = u - middle, phi - slope
    for _ in range(NEWTON):
        f, p, c0, c1, c2 = crushed(u, phi, half, stiffness, strength, left)
        rn, rp = f - n, (p - m) / half
        if abs(rn) + abs(rp) <= EXACT * n:
            break
        c1, c2 = c1 / half, c2 / (half * half)
        det = c0 * c2 - c1 * c1
        if not det > 1e-14 * c0 * c0:  # all that is in contact is crushed: back towards what is not
            du, dphi = rn / (stiffness * half), rp / (stiffness * half)
        else:
            du, dphi = (c2 * rn - c1 * rp) / det, (c0 * rp - c1 * rn) / det
        share, slope = 1.0, rn * du + rp * dphi
        # it must keep in touch, and the slope of the convex energy along the step not turn by more than half
        for _ in range(HALVINGS):
            f, p, c0, c1, c2 = crushed(
                u + share * du, phi + share * dphi / half, half, stiffness, strength, left
            )
            if f > 0.0 and (f - n) * du + (p - m) / half * dphi >= -0.5 * slope:
                break
            share *= 0.5
        u, phi = u + share * du, phi + share * dphi / half
    return u - half * phi, u + half * phi


@looped
def softness(
    w1: float, w2: float, half: float, stiffness: float, strength: float, left: Array
) -> tuple[float, float, float]:
    """C₁₁, −C₁₂ and C₂₂ of a bed of finite strength with these gaps of its ends."""
    u, phi = 0.5 * (w1 + w2), 0.5 * (w2 - w1) / half
    _, _, c0, c1, c2 = crushed(u, phi, half, stiffness, strength, left)
    c1, c2 = c1 / half, c2 / (half * half)
    # of N₁, N₂ = (N ∓ P/h)/2 against u ∓ hφ
    d11, d22, d12 = 0.25 * (c0 - 2.0 * c1 + c2), 0.25 * (c0 + 2.0 * c1 + c2), 0.25 * (c0 - c2)
    det = d11 * d22 - d12 * d12
    return d22 / det, d12 / det, d11 / det
