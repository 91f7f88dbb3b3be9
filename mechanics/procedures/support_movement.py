"""Supports that move in proportion to each other, and a structure that they lead from one equilibrium to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, RunawayError, array_of, is_number, require
from mechanics.messages import message
from mechanics.model.assembly import Assembly, State
from mechanics.procedures.held_load import KICKS, stands_kicked
from mechanics.procedures.step_control import Reached, reach
from mechanics.steps.equilibrium import rest, rest_size
from mechanics.steps.flow_step import slides
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import StaticSystem
from mechanics.steps.tolerances import REST, STEP
from mechanics.types import Array

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
