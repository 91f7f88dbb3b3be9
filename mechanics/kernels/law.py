"""What a joint obeys, as compiled loops take it: the columns of `law` (j, LAW), friction, and which bed it has.

The bed is exact, of points or of finite strength (bed), above the lines `left` (8,) m. The `strength`,
kN/m, is the law's, or infinite for ties in a motion, which yield as a whole (dynamics.motion). A bed of finite strength
has no points.
"""

from __future__ import annotations

import numpy as np

from mechanics.kernels.bed import (  # isort: skip
    closures, compliance, crushed, points, points_stored, points_under, softness, stiffened, stored, under, worked,
)  # fmt: skip
from mechanics.kernels.jit import looped
from mechanics.types import Array

# friction (inf: no sliding); share ψ of μ|slip| by which sliding lifts (0: Coulomb's law, 1: the associative one);
# compliance in shear, m/kN; stiffness of the bed, kN/m² (inf: rigid); slip from which the slide counts, m;
# strength, kN/m (inf: none); segments of a bed of points (0: exact); lines, m, above which a bed begins, two values
# each: three that a bed of finite strength remembers of having been crushed (bed), and that of the dashpots of a
# step (dynamics.motion)
FRICTION, DILATION, SHEAR, BED, SLID, STRENGTH, SEGMENTS, LEFT = range(8)
DASHPOTS = LEFT + 6
LAW = 15
# friction beyond which programs do not tell from infinite, and that with which they begin in its place
STEEPEST, STEEP = 1e4, 1e2
CRUSHED = 0.99  # of the strength: the force of a joint that is crushed, of a tie that yields


@looped
def most_shear(friction: float, normal: float) -> float:
    """The most of |T| under a normal force, kN: μN; without bound where nothing slides, but for an open joint."""
    if friction == np.inf:
        return np.inf if normal > 0.0 else 0.0
    return friction * normal


@looped
def lift(law: Array, slip: float) -> float:
    """By how much a slip λ₊ + λ₋ (m) lifts a joint of a law (LAW,): ψμ times that; nothing where nothing slides."""
    if law[FRICTION] == np.inf:
        return 0.0
    return float(law[DILATION] * law[FRICTION] * slip)


EXACT, POINTS, CRUSHING = range(3)


@looped
def kind(law: Array, strength: float) -> int:
    """EXACT, POINTS or CRUSHING; the last also where a bed without strength begins above the line of its dashpots."""
    if strength < np.inf or law[DASHPOTS] > 0.0 or law[DASHPOTS + 1] > 0.0:
        return CRUSHING
    return POINTS if law[SEGMENTS] > 0.0 else EXACT


@looped
def is_whole(law: Array, pressed: float) -> bool:
    """Whether a bed obeys the exact law, its ends pressed in by at most `pressed`, m: no fibre has been crushed."""
    exact = law[SEGMENTS] == 0.0 or law[STRENGTH] < np.inf
    return bool(exact and law[BED] * pressed <= law[STRENGTH] and not law[LEFT:].any())


@looped
def bed_forces(
    law: Array, strength: float, left: Array, h: float, u: float, phi: float
) -> tuple[float, float, float, float, float]:
    """N, P and −∂N/∂u, −∂N/∂φ, −∂P/∂φ of a bed under the gap u + φs, |s| ≤ h."""
    which = kind(law, strength)
    if which == CRUSHING:
        return crushed(u, phi, h, law[BED], strength, left)
    if which == POINTS:
        return points(u, phi, h, law[BED], int(law[SEGMENTS]))
    return stiffened(u, phi, h, law[BED])


@looped
def bed_work(law: Array, strength: float, left: Array, h: float, u: float, phi: float) -> float:
    """The work (kNm) that presses a bed to the gap u + φs, |s| ≤ h: −∂/∂u = N, −∂/∂φ = P. Stored but for crushing."""
    which = kind(law, strength)
    if which == CRUSHING:
        return worked(u, phi, h, law[BED], strength, left)
    if which == POINTS:
        return points_stored(u, phi, h, law[BED], int(law[SEGMENTS]))
    return stored(u, phi, h, law[BED])


@looped
def gaps_under(law: Array, h: float, n1: float, n2: float) -> tuple[float, float, float, float, float]:
    """Gaps of the two ends of a bed under forces N₁, N₂ > 0, and its compliance C₁₁, −C₁₂, C₂₂."""
    which, soft = kind(law, law[STRENGTH]), 1.0 / (2.0 * h * law[BED])
    if which == CRUSHING:
        w1, w2 = under(n1, n2, h, law[BED], law[STRENGTH], law[LEFT:])
        c11, c12, c22 = softness(w1, w2, h, law[BED], law[STRENGTH], law[LEFT:])
        return w1, w2, c11, c12, c22
    if which == POINTS:
        return points_under(n1, n2, int(law[SEGMENTS]), soft)
    w1, w2 = closures(n1, n2, soft)
    c11, c12, c22 = compliance(n1, n2, soft)
    return w1, w2, c11, c12, c22


@looped
def ends_under(ends: Array, half: Array, law: Array, gaps: Array) -> None:
    """Gaps (j, 2), m, of the ends of elastic joints under end forces (j, 2) > 0, kN; `half` (j,) m, `law` (j, LAW)."""
    for k in range(len(ends)):
        gaps[k, 0], gaps[k, 1], _, _, _ = gaps_under(law[k], half[k], ends[k, 0], ends[k, 1])
