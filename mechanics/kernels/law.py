"""What a joint obeys, as compiled loops take it: the columns of `law` (j, LAW)."""

from __future__ import annotations

import numpy as np

from mechanics.kernels.jit import looped
from mechanics.types import Array

# friction (inf: no sliding); share ψ of μ|slip| by which sliding lifts (0: Coulomb's law, 1: the associative one);
# compliance in shear, m/kN; stiffness of the bed, kN/m² (inf: rigid); slip from which the slide counts, m;
# strength, kN/m (inf: none); segments of a bed of points (0: exact); lines, m, above which a bed begins, two values
# each: three that a bed of finite strength remembers of having been crushed (crushing), and that of the dashpots of a
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
