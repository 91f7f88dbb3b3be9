"""Supports that move, and a structure that they lead from one equilibrium to the next: along a path, or anywhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError, array_of, is_number, require
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.procedures.held_load import KICKS, stands_kicked
from mechanics.procedures.step_control import Bisection, Reached, reach
from mechanics.steps.equilibrium import check_self_weight, reaction, rest, rest_size
from mechanics.steps.flow_step import slides
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import Sliding, StaticSystem, static_system
from mechanics.steps.tolerances import REST, STEP
from mechanics.types import Array

STRAIGHT = 0.999  # cosine between two steps, up to which the rate of the first predicts the second
FALLS = message("released where it rests, the structure falls after a kick along its way")


@dataclass(frozen=True)
class SupportMovement:
    """A support displaced by `displacement` (x, z), m, and turned by `rotation` (rad) about its drawn centroid."""

    support: str
    displacement: tuple[float, float]
    rotation: float = 0.0


def checked_movement(
    model: Assembly, support: str, displacement: ArrayLike, rotation: float
) -> SupportMovement:
    """Return the whole movement of a support. Raises ArgumentError if it is none."""
    target = checked_target(displacement, rotation)[:2]
    full = whole_movement(model, support, target, rotation)
    arc = whole_movement(model, support, np.zeros(2), rotation)
    least = STEP.rounding * model.size
    require(
        max(full, arc) > least, "displacement", displacement, f"with the rotation, more than {least:.1g} m"
    )
    return SupportMovement(support, (float(target[0]), float(target[1])), rotation)


def checked_target(displacement: ArrayLike, rotation: float) -> Array:
    """Return where a support moves to: x, z (m) and rotation (rad), (3,). Raises ArgumentError for no numbers."""
    shift = array_of("displacement", displacement, "(x, z) in m")
    fits = shift.shape == (2,) and bool(np.isfinite(shift).all())
    require(fits, "displacement", displacement, "(x, z) in m")
    require(is_number(rotation) and abs(rotation) < np.inf, "rotation", rotation, "finite, in rad")
    return np.array([*shift, rotation])


@dataclass(frozen=True, eq=False)
class Movements:
    """Supports that move in proportion to each other; the largest component of their movements is `full` (m).

    `begun`: the state in which their movements begin.
    """

    system: StaticSystem
    movements: tuple[SupportMovement, ...]
    begun: State

    @cached_property
    def before(self) -> list[tuple[Array, float]]:
        """Displacement (2,) m and rotation (rad) of each support where the movements begin."""
        return [
            self.system.model.support_movement(self.begun.positions, each.support) for each in self.movements
        ]

    @cached_property
    def full(self) -> float:
        """Largest component of the whole movements, m."""
        model = self.system.model
        return max(
            whole_movement(model, each.support, each.displacement, each.rotation) for each in self.movements
        )

    @property
    def shifts(self) -> bool:
        """Whether a support moves other than by turning."""
        return any(any(each.displacement) for each in self.movements)

    def moved(self, positions: Array, movement: float) -> Array:
        """Return the positions (b, 3) with the supports displaced by a movement (m)."""
        share = movement / self.full
        for each, (shift, turn) in zip(self.movements, self.before, strict=True):
            to = shift + share * np.array(each.displacement)
            positions = self.system.model.moved_support(
                positions, each.support, to, turn + share * each.rotation
            )
        return positions

    @property
    def lever(self) -> float:
        """Ratio, 1 or more, of the longest way of the supports' corners to the movement: a rotation may exceed it."""
        model = self.system.model
        turned = [whole_movement(model, each.support, (0.0, 0.0), each.rotation) for each in self.movements]
        return max(1.0, max(turned) / self.full)


class Led:
    """A structure whose supports are led: its `last` equilibrium, and its `rate` (b, 3) per metre of their movement.

    `slid`: whether a joint has: what turns alone has one set of forces, and stands up to its last equilibrium.
    """

    def __init__(self, system: StaticSystem, begun: State) -> None:
        self.smallest = 0.0 if system.rigid else rest_size(system.model, system.behaviour)
        self.last = rest(system, begun)
        self.rate, self.slid = np.zeros_like(begun.positions), False

    def reach(self, guess: Array, by: float, shortest: bool) -> Reached:
        """Return the equilibrium near a `guess` (b, 3), `by` (m) on."""
        here, system = self.last.state, self.last.system
        problem = StepProblem(system, here, system.model.dead_load, max(by, self.smallest))
        # the forces at rest do not show which hinges will open: the first step has a cold start
        return reach(problem, guess, self.last if self.rate.any() else None, shortest)

    def step(self, guess: Array, by: float, lever: float, shortest: bool) -> bool:
        """Take a step of the supports, `by` (m) times a lever; return whether the blocks have jumped.

        Raises RunawayError where a motion with inertia, released along a jump, does not come to rest; ConvergenceError
        where blocks go farther than the last step leads to and may have snapped: in the shortest step the same motion
        decides. Other errors are those of `reach`.
        """
        before, system, far = self.last.state, self.last.system, self.last.system.model.farthest
        found, _, jumped = self.reach(guess, lever * by, shortest)
        x = before.positions
        snaps = self.rate.any() and far(x, found.state.positions) > REST.faster * far(x, x + by * self.rate)
        if snaps and not shortest:
            raise ConvergenceError(message("the blocks move farther than the last step leads to"))
        if jumped or snaps:
            still, jump = ~system.model.movable[:, None], found.state.positions - before.positions
            at = replace(before, positions=np.where(still, guess, before.positions), carrying=None)
            if not stands_kicked(system.model, system.behaviour, system.sliding, at, jump, KICKS):
                raise RunawayError(
                    message("the structure falls: a part moves by itself, and is not held again")
                )
        self.last = found
        self.rate = 0.0 * guess if jumped else (found.state.positions - before.positions) / by
        self.slid |= slides(found, by)
        return jumped

    def stands(self, state: State, way: Array) -> bool:
        """Whether the structure, released in a state with a kick along the `way` (b, 3) to it, stands."""
        system = self.last.system
        return stands_kicked(system.model, system.behaviour, system.sliding, state, way, KICKS[:1])


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
        """Kick the structure along its last step, where joints have slid; it is `fallen` if it does not stand that."""
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


def whole_movement(model: Assembly, support: str, displacement: ArrayLike, rotation: float) -> float:
    """Return the largest component of a support's movement, m; of a pure rotation, the arc at its farthest corner.

    `displacement` (2,) m; `rotation` (rad), about the support's drawn centroid. Raises ArgumentError for an unknown
    support.
    """
    corners = np.concatenate([model.blocks[i].polygon for i in model.support(support)])
    far = float(np.hypot(*(model.from_origin(corners) - model.support_centre(support)).T).max())
    return float(abs(np.asarray(displacement, dtype=float)).max()) or abs(rotation) * far


def drawn_extent(model: Assembly) -> Array:
    """Return the lower left and the upper right corner (2, 2) of the drawing's bounding box, m."""
    points = np.concatenate([b.polygon for b in model.blocks])
    return np.stack([points.min(axis=0), points.max(axis=0)])
