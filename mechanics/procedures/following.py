"""A structure that follows a support wherever it is led: one equilibrium after another, from the last one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError, is_number, require
from mechanics.messages import Message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.procedures.step_control import Bisection
from mechanics.procedures.support_movement import FALLS, Led, checked_target, whole_movement
from mechanics.steps.equilibrium import check_self_weight, reaction
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import Sliding, static_system
from mechanics.steps.tolerances import STEP
from mechanics.types import Array

STRAIGHT = 0.999  # cosine between two steps, up to which the rate of the first predicts the second


class Following:
    """Follows a support: the equilibrium after each step of its movement, in any direction.

    On a straight way from the drawing they are those of `pushdown` with the same `increment` (m, of the largest
    component of the movement or of the arc at the support's farthest corner); `release` does what `pushdown` does in
    the end. `reached` (3,): movement x, z (m) and rotation (rad, about the support's drawn centroid) of the last
    `equilibrium`; `fallen`: whether the structure falls on the way beyond it, and `stopped`: why the way ends there
    (None: it does not). Raises UnstableError if the structure as drawn cannot stand, ArgumentError for an argument out
    of its range.
    """

    fallen: bool
    stopped: Message | None

    def __init__(
        self,
        model: Assembly,
        support: str,
        contacts: Behaviour = "rigid",
        sliding: Sliding = "coulomb",
        increment: float = 0.001,
    ) -> None:
        Assembly.check(model)
        require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
        self.model, self.support, self.increment = model, support, increment
        self.index = model.support(support)
        check_self_weight(model)
        self._led = Led(static_system(model, contacts, sliding), model.initial)
        self.reached, self._direction = np.zeros(3), np.zeros(3)
        self.aim((0.0, 0.0))

    @property
    def equilibrium(self) -> Equilibrium:
        """The last equilibrium."""
        return self._led.last

    @property
    def reaction(self) -> Array:
        """Force x and z of the support on the structure, kN, (2,)."""
        return reaction(self.equilibrium, self.index)[:2]

    def to(self, displacement: ArrayLike, rotation: float = 0.0) -> State:
        """Move the support straight to a `displacement` (2,) m from the drawing and a `rotation` (rad).

        Return the state at rest there, or at the last equilibrium on the way. What sliding has lifted comes down.
        """
        self.aim(displacement, rotation)
        while self.advance():
            pass
        if self.stopped is None:
            try:
                self._led.last = come_down(self.equilibrium, self._led.smallest)
            except (NoEquilibriumError, ConvergenceError) as error:
                self._stop(error)
        return self.equilibrium.state

    def release(self) -> None:
        """Release the structure, where joints have slid, with a kick along its way, after which it may be fallen."""
        led = self._led
        if self.stopped is None and led.slid and not led.stands(self.equilibrium.state, led.rate):
            self.fallen, self.stopped = True, FALLS

    def aim(self, displacement: ArrayLike, rotation: float = 0.0) -> None:
        """Set the target of the next steps; what has stopped them before counts no more."""
        self._target, self._steps = checked_target(displacement, rotation), Bisection(self.increment)
        self.fallen, self.stopped = False, None

    def advance(self) -> bool:
        """Take one step towards the target; return whether another one is to follow."""
        if self.stopped is None and self._left() > STEP.rounding * self.model.size:
            error = self._steps.take(self._step)
            if error is not None:
                self._stop(error)
            return self.stopped is None and self._left() > 0.0
        return False

    def _left(self) -> float:
        """Return the length (m) of the way to the target: its largest component, or the arc of the farthest corner."""
        way = self._target - self.reached
        arc = whole_movement(self.model, self.support, (0.0, 0.0), float(way[2]))
        return max(float(abs(way[:2]).max()), arc)

    def _step(self, length: float, shortest: bool) -> bool:
        """Move the support on by at most a length (m); return whether the blocks have jumped. Raises as `reach`."""
        way, left, led = self._target - self.reached, self._left(), self._led
        by = min(length, left)
        at = self._target.copy() if by == left else self.reached + by / left * way
        direction = way / np.linalg.norm(way)
        if self._direction @ direction <= STRAIGHT:
            led.rate = np.zeros_like(led.rate)
        guess = led.last.state.positions + by * led.rate
        jumped = led.step(
            self.model.moved_support(guess, self.support, at[:2], float(at[2])), by, 1.0, shortest
        )
        self.reached, self._direction = at, direction
        return jumped

    def _stop(self, error: NoEquilibriumError | ConvergenceError) -> None:
        self.fallen, self.stopped = isinstance(error, RunawayError), error.message
