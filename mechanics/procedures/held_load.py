"""Loads that grow and are held: which peaks of a capacity curve a structure bears.

Up to its first peak a curve is what a growing load does. Beyond, its equilibria are held by a push that is taken back
as the structure moves; what a load does that is not taken back, a motion decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.errors import ConvergenceError
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.procedures.motion_start import first_frequency
from mechanics.procedures.time_history import time_history
from mechanics.steps.static_system import Sliding
from mechanics.types import GRAVITY, Array, Mask

GROWS = 10.0  # √(L/g), L the extent of the structure: time in which a load grows
HOLDS = 5  # times as many √(L/g): what has neither fallen nor come to rest then rocks where it is
STEP = 0.01  # √(L/g): time step
DAMPED = 0.1  # of critical: elastic joints, which lose nothing at impacts
BORNE = 0.95  # of a peak: what a structure bears that bears the peak


@dataclass
class HeldLoad:
    """The load of a direction, held on a structure from a state on; each motion narrows what is known.

    `borne`: the largest multiplier under which it is known to stand; `fatal`: the least one that is known to fell it.
    """

    model: Assembly
    direction: Direction
    contacts: Behaviour
    sliding: Sliding
    state: State
    borne: float = 0.0
    fatal: float = np.inf

    def bears(self, alpha: float) -> bool:
        """Whether the structure stands under a multiplier that grows from zero and stays.

        A motion that is not solved shows nothing: what it is of counts as fallen.
        """
        if self.borne < alpha < self.fatal:
            if self._stands(alpha):
                self.borne = alpha
            else:
                self.fatal = alpha
        return alpha <= self.borne

    def _stands(self, alpha: float) -> bool:
        model = self.model.uncrushed if self.contacts == "rigid" else self.model
        step = STEP * np.sqrt(np.ptp(model.initial.positions[:, :2], axis=0).max() / GRAVITY)
        # the base is accelerated to the left: what stands on it is pushed to the right
        held = -alpha if self.direction == "+x" else alpha
        grows, stays = np.linspace(0.0, held, round(GROWS / STEP) + 1), np.full(round(HOLDS / STEP) + 1, held)
        damping = DAMPED if self.contacts == "elastic" and first_frequency(model) else 0.0
        state = self.state
        for load in (grows, *HOLDS * (stays,)):
            try:
                motion = time_history(
                    model, load, step, self.contacts, state, damping_ratio=damping, sliding=self.sliding
                )
            except ConvergenceError:
                return False
            if motion.collapsed:
                return False
            if load is stays and not motion.speed_at_end:
                break
            state = motion.final
        return True


def borne_peak(alpha: Array, jumps: Mask, flat: float, load: HeldLoad) -> int:
    """Return the point of the largest multiplier that, held, does not fell the structure.

    `alpha` (k,) of the points of a curve, and whether blocks have jumped to them, `jumps` (k,). The points that exceed
    all before them are searched by bisection: what bears a load bears a smaller one. Up to where α has first come down
    by more than `flat`, or blocks have jumped, no motion is needed.
    """
    largest = np.maximum.accumulate(alpha)
    left = jumps | (alpha < largest - flat)
    first = int(np.argmax(left)) if left.any() else len(alpha)
    peaks = [int(np.argmax(alpha[:first]))]
    higher = np.flatnonzero(alpha[1:] > largest[:-1]) + 1
    peaks += [int(k) for k in higher if k >= first and alpha[k] > alpha[peaks[0]] + flat]
    low, high = 0, len(peaks)
    tried = high - 1  # the highest first: most structures bear it
    while high - low > 1:
        if load.bears(BORNE * float(alpha[peaks[tried]])):
            low = tried
        else:
            high = tried
        tried = (low + high) // 2
    return peaks[low]
