"""Whether a structure stands that is released, or under a load that grows and is held: a motion with inertia decides.

Up to its first peak a curve is what a growing load does. Beyond, its equilibria are held by a push that is taken back
as the structure moves; of a curve that rises behind a trough the motion tells what the structure bears.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.errors import ConvergenceError
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.procedures.motion_start import first_frequency
from mechanics.procedures.time_history import time_history
from mechanics.progress import stretch
from mechanics.steps.static_system import Sliding
from mechanics.types import GRAVITY, Array, Mask

GROWS = 10.0  # √(L/g), L the extent of the structure: time in which a load grows
HOLDS = 5  # √(L/g): time that it stays then, and up to so many times as long until all rests
STEP = 0.01  # √(L/g): time step
DAMPED = 0.1  # of critical: elastic joints, which lose nothing at impacts
RESOLVED = 0.95  # ratio of multipliers that are not told apart
# √(size·g): speeds along its way with which what jumps or moves with a support is released
KICKS = (1e-3, 5e-3)


def stands(
    model: Assembly, contacts: Behaviour, sliding: Sliding, state: State, acceleration: float = 0.0
) -> bool:
    """Whether a structure released in a state stands, under a base `acceleration` (g) that grows from zero and stays.

    What still moves in the end stands if no corner is farther than a block's size from where it was: it rocks, it does
    not slide. A motion that is not solved counts as a fall. Rigid joints do not crush here. Raises ArgumentError as
    time_history.
    """
    model = model.uncrushed if contacts == "rigid" else model
    step = STEP * np.sqrt(np.ptp(model.initial.positions[:, :2], axis=0).max() / GRAVITY)
    grows = np.linspace(0.0, acceleration, round(GROWS / STEP) + 1)
    stays = np.full(round(1.0 / STEP) + 1, acceleration)
    damping = DAMPED if contacts == "elastic" and first_frequency(model) else 0.0
    begun = state.positions
    for held in range(0 if acceleration else 1, HOLDS**2 + 1):
        load = stays if held else grows
        try:
            with stretch(1.0, 1.0):  # the path is there
                motion = time_history(
                    model, load, step, contacts, state, damping_ratio=damping, sliding=sliding
                )
        except ConvergenceError:
            return False
        if motion.collapsed:
            return False
        early, late = (float(part.max()) for part in np.array_split(motion.energy.kinetic, 2))
        falls = late > early  # a fall from a balance is slow at first, and gains speed
        if held >= HOLDS and not falls and not motion.speed_at_end:
            return True
        state = motion.final
    return model.farthest(begun, state.positions) <= model.size


def stands_kicked(
    model: Assembly, contacts: Behaviour, sliding: Sliding, state: State, way: Array, kicks: tuple[float, ...]
) -> bool:
    """Whether a structure released in a state stands with each of the `kicks` along the `way` (b, 3) of its blocks.

    Without a kick an unstable equilibrium stays. Raises ArgumentError as time_history.
    """
    free = np.where(model.movable[:, None], way, 0.0)
    speed = free * np.sqrt(GRAVITY * model.size) / max(float(abs(free).max()), np.finfo(float).tiny)
    released = (replace(state, velocities=kick * speed) for kick in kicks)
    return all(stands(model, contacts, sliding, each) for each in released)


def borne(
    alpha: Array, discontinuous: Mask, flat: float, model: Assembly, direction: Direction, contacts: Behaviour,
    sliding: Sliding, state: State,
) -> float:  # fmt: skip
    """Return the largest multiplier that, held, does not fell a structure pushed from a state; ∞: all of its curve.

    `alpha` (k,) of the points of the curve; `discontinuous` (k,): to which blocks have jumped, or that limit analysis
    has placed. Up to these, or where α has come down by more than `flat`, no motion is needed. What exceeds that is
    searched by bisection, as if what bears a load bore any smaller one, down to RESOLVED times what fells it.
    """
    left = discontinuous | (alpha < np.maximum.accumulate(alpha) - flat)
    low = float(alpha[: int(np.argmax(left)) if left.any() else len(alpha)].max())
    if alpha.max() <= low + flat:
        return np.inf
    sign = -1.0 if direction == "+x" else 1.0  # the base is accelerated against the push
    high = RESOLVED * float(alpha.max())
    if high <= low or stands(model, contacts, sliding, state, sign * high):
        return np.inf
    while low < RESOLVED * high and high > flat:
        middle = max(float(np.sqrt(low * high)), 0.2 * high)
        if stands(model, contacts, sliding, state, sign * middle):
            low = middle
        else:
            high = middle
    return low
