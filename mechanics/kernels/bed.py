"""The no-tension bed of a joint, integrated in closed form.

The bed presses with k⟨−w⟩ along the overlap L = 2h, w = u + φs the gap. As complementary energy of the forces N₁ and N₂
at its two ends, N = N₁ + N₂ and P = h(N₂ − N₁):

    W* = (N² + 3 (N₂ − N₁)²)/(2kL)     where the whole bed is pressed, N₁ ≥ N₂/2 and N₂ ≥ N₁/2
    W* = 2N³/(9kL N₁)                  where it opens at the first end; likewise at the other

Its gradient are the closures of the ends, its Hessian their compliance; both are continuous. A bed of points at the
ends of n equal segments (the paper's) has no W* in closed form: there the displacements under two forces are found
first. Beds of finite strength: crushing. Which of them a joint has: law.
"""

from __future__ import annotations

from mechanics.kernels.jit import looped

MOST_SEGMENTS = 64  # of a bed of points


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
