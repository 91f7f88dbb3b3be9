"""A path of equilibria, followed: its steps, their length, and what is tried where one finds no equilibrium.

The same follower serves pushdown and pushover, rigid and elastic:

    until the path ends:
        predict       the last rate, carried on by a length          advance of the path
        solve         program and geometry in turns                  find_equilibrium
        or go on      along the flow, where it leads to another      along_flow
        or let move   the shortest step, until it rests or falls     motion_to_rest
        accept        and lengthen the next step, or halve it        Bisection
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError
from mechanics.messages import Message, message
from mechanics.procedures.model_check import sound
from mechanics.progress import tell
from mechanics.steps.flow_step import along_flow, begins, flows
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.rest import motion_to_rest, way
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.tolerances import REST
from mechanics.types import Array


@dataclass(frozen=True, slots=True)
class PathTolerances:
    """Tolerances of the length of steps.

    `halvings`: of an increment, to which the end of a path is located; `growth`: factor from one step to the next,
    after halvings or a small first step; `rise`: share of its multiplier by which that of a step along a flow may rise,
    and by which another flow that begins has less.
    """

    halvings: int = 5
    growth: float = 1.5
    rise: float = 1e-4

    def shortest(self, increment: float) -> float:
        """Return the shortest step (m): the increment after all halvings."""
        return increment * 0.5**self.halvings


PATH = PathTolerances()


@dataclass(slots=True)
class Bisection:
    """The `length` of the next step of a path: halved if a step fails, down to 1/32 of the `increment`, and back up."""

    increment: float
    length: float = 0.0

    def __post_init__(self) -> None:
        self.length = self.length or self.increment

    @property
    def shortest(self) -> bool:
        """Whether the length may not be halved any more."""
        return self.length <= PATH.shortest(self.increment) * (1.0 + 1e-9)

    def take(self, step: Callable[[float, bool], bool]) -> NoEquilibriumError | ConvergenceError | None:
        """Take a step of that length, see Path.advance; return why the shortest one has failed, None if none has.

        A step that fails is followed by one of half its length, others by longer ones, up to the increment; at once if
        the blocks have jumped: the difficult part is behind.
        """
        try:
            jumped = step(self.length, self.shortest)
        except (NoEquilibriumError, ConvergenceError) as error:
            if self.shortest:
                return error
            self.length *= 0.5
            return None
        self.length = self.increment if jumped else min(self.increment, PATH.growth * self.length)
        return None


class Reached(NamedTuple):
    """The equilibrium of a `step`: whether blocks were `released` to find it, and whether they `jumped` to it."""

    step: Equilibrium
    released: bool = False
    jumped: bool = False


class Path(Protocol):
    """A path as far as it has been followed; `end`: why it ends, None while it goes on."""

    end: Message | None

    @property
    def share(self) -> float:
        """Share of the path that is done, about."""

    def advance(self, length: float, shortest: bool) -> bool:
        """Add the next point, at most a length (m) further on, or set `end`; return whether the blocks have jumped.

        `shortest`: whether no shorter step is tried after this one. Raises RunawayError where the structure falls,
        NoEquilibriumError or ConvergenceError where no point is found.
        """

    def stop(self, error: NoEquilibriumError | ConvergenceError) -> None:
        """Set `end` where the shortest step has failed, or raise the error."""


def follow(path: Path, steps: Bisection) -> None:
    """Follow a path to its end. Raises what its `stop` raises."""
    while not path.end:
        if error := steps.take(path.advance):
            path.stop(error)
        tell(path.share)


def reach(problem: StepProblem, guess: Array, last: Equilibrium | None, shortest: bool) -> Reached:
    """Return the equilibrium of a step.

    A failed step is not yet a collapse. If no equilibrium is found near the `guess` (b, 3), it is to be halved; at the
    `shortest` the blocks are released, and their motion decides. If blocks penetrate that were too far apart to touch,
    the step is repeated with their faces in contact. Raises RunawayError if the motion does not come to rest,
    NoEquilibriumError or ConvergenceError if the step may still be halved, ConvergenceError if nothing is decided.
    """
    problem = replace(problem, system=problem.system.around(problem.start.positions, problem.size))
    while True:
        found = _reach(problem, guess, last, shortest)
        at = found.step.state.positions
        system = problem.system.around(at, 0.0)
        if system is problem.system or not system.met_inside(problem.system, at):
            return found
        problem = replace(problem, system=system)


def _reach(problem: StepProblem, guess: Array, last: Equilibrium | None, shortest: bool) -> Reached:
    flow, other = last if last is not None and flows(problem, last) else None, None
    try:
        found = sound(find_equilibrium(problem, guess, last))
        if flow is None:
            return Reached(found)
        rise = -PATH.rise if begins(found, flow, problem.size) else PATH.rise
        if found.alpha <= flow.alpha * (1.0 + rise):
            return Reached(found)
        other = found  # the flow of the last step goes on if it can, and its end is located
    except (NoEquilibriumError, ConvergenceError) as error:
        stop: NoEquilibriumError | ConvergenceError = error
    if flow is not None:
        try:
            return Reached(sound(along_flow(problem, guess, flow)))
        except (NoEquilibriumError, ConvergenceError) as error:
            stop = error
        if other is not None and shortest:
            return Reached(other)
    if not shortest:
        raise stop
    # a push alone: what falls as a support moves is not held by a law that lifts what slides
    if problem.system.rigid and problem.system.dilation < 1.0 and problem.lateral is not None:
        with suppress(NoEquilibriumError, ConvergenceError):  # by the associative law: its lift is small here
            return Reached(sound(find_equilibrium(replace(problem, lifts=True), guess, last)))
    begun = np.where(problem.system.model.movable[:, None], problem.start.positions, guess)
    try:
        rested = sound(motion_to_rest(problem, begun))
    except RunawayError as fall:
        same = fall.message == stop.message  # motion and step ended for the same reason
        raise RunawayError(
            fall.message if same else message("{reason} ({stop})", reason=fall.message, stop=stop.message)
        ) from stop
    jumped = way(begun, rested.state.positions, problem.system.model.size) > REST.jump * problem.size
    return Reached(rested, released=True, jumped=jumped)
