"""How long a step of a path is, and what is done where none leads on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError, UnsettledError
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.rest import motion_to_rest, way
from mechanics.steps.short_steps import in_short_steps
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.tolerances import STEP
from mechanics.types import Array

HALVINGS = 5  # down to which the end of a path is located
JUMP = 2.0  # of a step: a motion that it does not account for
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
    """The equilibrium of a step, and whether blocks that were released to find it jumped.

    Collapse is a fact and not a failed step. Where no equilibrium is found the step is taken in short ones; where
    blocks fall in these, the motion that follows decides. A step in which blocks came into each other that were too far
    apart to touch is repeated with their faces in contact. Raises RunawayError where the motion runs away,
    UnsettledError of an elastic step that may be halved (it is not the `shortest`), ConvergenceError or
    NoEquilibriumError where nothing is decided.
    """
    while True:
        found, jumped = _reach(problem, guess, last, shortest)
        system = problem.system.around(found.state.positions, 0.0)
        if system is problem.system or not system.met_inside(problem.system, found.state.positions):
            return found, jumped
        problem = replace(problem, system=system)


def slides(found: Equilibrium, size: float) -> bool:
    """Whether joints slide in the program that led to an equilibrium, by a share of its step's size (m)."""
    if found.iterate is None:
        return False
    slip = abs(found.iterate.gaps[:, 2] - found.iterate.gaps[:, 3]).max(initial=0.0)
    return bool(slip > STEP.slip_gap * size)


def _reach(
    problem: StepProblem, guess: Array, last: Equilibrium | None, shortest: bool
) -> tuple[Equilibrium, bool]:
    rigid = problem.system.rigid
    try:
        return find_equilibrium(problem, guess, last), False
    except (NoEquilibriumError, ConvergenceError) as error:
        stop: Exception = error
    unsettled = isinstance(stop, UnsettledError)
    if unsettled and not rigid and not shortest:
        raise stop  # rigid joints that slide settle in shorter steps as little
    if unsettled or rigid:
        try:
            found = in_short_steps(problem, guess)
            if unsettled or slides(found, problem.size):
                return found, False  # what only turns is followed exactly, or not at all
        except (NoEquilibriumError, ConvergenceError) as error:
            error.__cause__ = stop
            stop = error
    begun = np.where(problem.system.model.movable[:, None], problem.start.positions, guess)
    try:
        rested = motion_to_rest(problem, begun)
    except RunawayError as fall:
        same = str(fall) == str(stop)  # the motion was stopped by what had stopped the step
        raise RunawayError(str(fall) if same else f"{fall} ({stop})") from stop
    jumped = way(begun, rested.state.positions, problem.system.model.size) > JUMP * problem.size
    return rested, jumped
