"""A structure that follows a support wherever it is led: one equilibrium after another, from the last one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    ConvergenceError,
    NoEquilibriumError,
    RunawayError,
    array_of,
    is_number,
    require,
)
from mechanics.messages import Message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.procedures.pushdown import AHEAD, whole_movement
from mechanics.procedures.step_control import PATH, Bisection, reach
from mechanics.steps.equilibrium import check_self_weight, reaction, rest, rest_size
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import Sliding, static_system
from mechanics.steps.tolerances import STEP
from mechanics.types import Array

STRAIGHT = 0.999  # cosine between two steps, up to which the rate of the first predicts the second


class Following:
    """Follows a support: the equilibrium after each step of its movement, in any direction.

    On a straight way from the drawing they are those of `pushdown` with the same `increment` (m, of the largest
    component of the movement or of the arc at the support's farthest corner). `reached` (3,): movement x, z (m) and
    rotation (rad, about the support's drawn centroid) of the last `equilibrium`; `fallen`: whether the structure falls
    on the way beyond it, and `stopped`: why the way ends there (None: it does not). Raises UnstableError if the
    structure as drawn cannot stand, ArgumentError for an argument out of its range.
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
        self.system = static_system(model, contacts, sliding)
        self.smallest = 0.0 if self.system.rigid else rest_size(model, contacts)
        self.equilibrium: Equilibrium = rest(self.system, model.initial)
        self.reached, self._direction = np.zeros(3), np.zeros(3)
        self._rate = np.zeros_like(model.initial.positions)
        self.aim((0.0, 0.0))

    @property
    def reaction(self) -> Array:
        """Force x and z of the support on the structure, kN, (2,)."""
        return reaction(self.model, self.equilibrium, self.index)[:2]

    def to(self, displacement: ArrayLike, rotation: float = 0.0) -> State:
        """Move the support straight to a `displacement` (2,) m from the drawing and a `rotation` (rad).

        Return the state at rest there, or at the last equilibrium on the way. What sliding has lifted comes down.
        """
        self.aim(displacement, rotation)
        while self.advance():
            pass
        if self.stopped is None:
            try:
                self.equilibrium = come_down(self.equilibrium, self.smallest)
            except (NoEquilibriumError, ConvergenceError) as error:
                self._stop(error)
        return self.equilibrium.state

    def aim(self, displacement: ArrayLike, rotation: float = 0.0) -> None:
        """Set the target of the next steps; what has stopped them before counts no more."""
        shift = array_of("displacement", displacement, "(x, z) in m")
        fits = shift.shape == (2,) and bool(np.isfinite(shift).all())
        require(fits, "displacement", displacement, "(x, z) in m")
        require(is_number(rotation) and abs(rotation) < np.inf, "rotation", rotation, "finite, in rad")
        self._target, self._steps = np.array([*shift, rotation]), Bisection(self.increment)
        self.fallen, self.stopped = False, None

    def advance(self) -> bool:
        """Take one step towards the target; return whether another one is to follow."""
        way, last = self._target - self.reached, self.equilibrium
        # its largest component, or the arc of the support's farthest corner
        arc = whole_movement(self.model, self.support, (0.0, 0.0), float(way[2]))
        length = max(float(abs(way[:2]).max()), arc)
        if self.stopped is not None or length <= STEP.rounding * self.model.size:
            return False
        by = min(self._steps.length, length)
        at = self.reached + by / length * way
        straight = float(self._direction @ way) > STRAIGHT * np.linalg.norm(way)
        past = self._rate if straight else np.zeros_like(self._rate)
        guess = self.model.moved_support(last.state.positions + past * by, self.support, at[:2], float(at[2]))
        expected = max(by, self.smallest)
        self.system = self.system.around(last.state.positions, AHEAD * expected)
        problem = StepProblem(self.system, last.state, self.model.dead_load, expected)
        try:
            found, jumped = reach(problem, guess, last if past.any() else None, self._steps.shortest)
        except (NoEquilibriumError, ConvergenceError) as error:
            if not self._steps.shorter():
                self._stop(error)
            return self.stopped is None
        self._steps.longer(jumped)
        if by > PATH.shortest(self.increment):  # the rate of a shorter step is mostly rounding
            rate = (found.state.positions - last.state.positions) / by
            self._rate = np.zeros_like(rate) if jumped else rate
        self._direction = way / np.linalg.norm(way)
        self.equilibrium, self.reached = found, self._target.copy() if by == length else at
        return by < length

    def _stop(self, error: NoEquilibriumError | ConvergenceError) -> None:
        self.fallen, self.stopped = isinstance(error, RunawayError), error.message
