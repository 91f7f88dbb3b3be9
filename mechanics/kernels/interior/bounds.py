"""Infinite friction in the interior point: a joint that presses does not slide, one that is open bears nothing.

That set of forces, N > 0 with any T and N = T = 0, is not closed, and has no products of its own. By Coulomb's law |T|
is held below μN with a μ of the iterate: it grows wherever T comes near the bound of a joint that presses, so that in
the end no joint slides under N, and an open one, whose N vanishes, has no T. By the associative law, whose cone is
closed (N ≥ 0 with any T), a joint that touches has no slip at all.
"""

from __future__ import annotations

import numpy as np

from mechanics.kernels.jit import looped
from mechanics.kernels.joint import PHI, H, U
from mechanics.kernels.law import BED, DILATION, FRICTION, STEEP
from mechanics.types import Array

TOUCHES = 1e-6  # of the step: a gap that is none
CLOSED = 0.01  # of what a bed closes: a gap of faces that press
NEAR, GROWS = 0.5, 10.0  # share of its bound at which T raises it, and by how much


@looped
def begin(places: Array, law: Array, f: Array, step: float) -> bool:
    """Bound T in the `law` (j, LAW) of joints of infinite friction under forces f (j, 3): whether any is."""
    bounded = False
    for j in range(len(law)):
        touches = places[j, U] - places[j, H] * abs(places[j, PHI]) <= TOUCHES * step
        if law[j, FRICTION] < np.inf or (law[j, DILATION] == 1.0 and touches):
            continue
        law[j, FRICTION], law[j, DILATION] = max(STEEP, 2.0 * abs(f[j, 2]) / (f[j, 0] + f[j, 1])), 0.0
        bounded = True
    return bounded


@looped
def grow(places: Array, law: Array, given: Array, f: Array, y: Array, unit: float) -> None:
    """Raise the bounds near which T is, where the friction that is `given` (j, LAW) has none; products stay.

    `unit`: step per weight. A joint presses whose gap is small beside what N closes its bed by, of rigid ones beside a
    step per weight: of faces that only touch gap and force vanish alike.
    """
    for j in range(len(law)):
        mu, n, t = law[j, FRICTION], f[j, 0] + f[j, 1], f[j, 2]
        give = unit if law[j, BED] == np.inf else 0.5 / (places[j, H] * law[j, BED])
        presses = min(y[j, 0], y[j, 1]) < CLOSED * give * n
        if given[j, FRICTION] < np.inf or mu == np.inf or not presses or abs(t) < NEAR * mu * n:
            continue
        law[j, FRICTION] = GROWS * mu
        y[j, 2] *= (mu * n + t) / (GROWS * mu * n + t)
        y[j, 3] *= (mu * n - t) / (GROWS * mu * n - t)
