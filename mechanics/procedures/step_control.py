"""How long a step of a path is, and what is done where none leads on."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mechanics.errors import ConvergenceError, NoEquilibriumError, UnsettledError
from mechanics.steps.rest import motion_to_rest
from mechanics.steps.static_step import Equilibrium, StepProblem, find_equilibrium, in_short_steps
from mechanics.types import Array

HALVINGS = 5  # down to which the end of a path is located
GROWTH = 1.5  # of steps that have been halved, or begin small


@dataclass(slots=True)
class Bisection:
    """The `length` of the next step of a path: halved where one fails, down to 1/32 of the `increment`, and back up."""

    increment: float
    length: float = 0.0

    def __post_init__(self) -> None:
        self.length = self.length or self.increment

    @property
    def shortest(self) -> bool:
        """Whether it is not halved any more."""
        return self.length <= self.increment * 0.5**HALVINGS * (1.0 + 1e-9)

    def shorter(self) -> bool:
        """Half of it, where that is long enough."""
        if self.shortest:
            return False
        self.length *= 0.5
        return True

    def longer(self) -> None:
        """Towards the increment again."""
        self.length = min(self.increment, GROWTH * self.length)


def reach(
    problem: StepProblem, guess: Array, last: Equilibrium | None, shortest: bool
) -> tuple[Equilibrium, bool]:
    """The equilibrium of a step, and whether blocks were let go to find it.

    Collapse is a fact and not a failed step: where there is no equilibrium nearby, the motion that follows decides. A
    step in which blocks came into each other that were too far apart to touch is repeated with their faces in contact.
    Raises NoEquilibriumError where it runs away, UnsettledError of an elastic step that may be halved: whether it is
    the
    `shortest`.
    """
    while True:
        found, jumped = _reach(problem, guess, last, shortest)
        system = problem.system.around(found.state.positions, 0.0)
        if system is problem.system or not system.met_inside(problem.system, found.state.positions):
            return found, jumped
        problem = replace(problem, system=system)


def _reach(
    problem: StepProblem, guess: Array, last: Equilibrium | None, shortest: bool
) -> tuple[Equilibrium, bool]:
    stop: Exception
    try:
        return find_equilibrium(problem, guess, last), False
    except UnsettledError as unsettled:
        # rigid joints that slide settle in shorter steps as little
        if not problem.system.rigid and not shortest:
            raise
        try:
            return in_short_steps(problem, guess), False
        except (NoEquilibriumError, ConvergenceError) as error:
            stop = error
        stop.__cause__ = unsettled
    except (NoEquilibriumError, ConvergenceError) as error:
        stop = error
    begun = problem.start.positions.copy()
    fixed = ~problem.system.model.movable
    begun[fixed] = guess[fixed]
    try:
        return motion_to_rest(problem, begun), True
    except NoEquilibriumError as fall:
        same = str(fall) == str(stop)  # the motion was stopped by what had stopped the step
        raise NoEquilibriumError(str(fall) if same else f"{fall} ({stop})") from stop
