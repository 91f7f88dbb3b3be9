"""Pushdown: reaction and configuration against the movement of a support (paper, §4, eqs 6 and 7)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    CollapseError,
    ConvergenceError,
    NoEquilibriumError,
    RunawayError,
    array_of,
    is_number,
    require,
)
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.pictures import film, magnification
from mechanics.procedures.held_load import stands
from mechanics.procedures.model_check import check_path, sound
from mechanics.procedures.step_control import Bisection, Reached, follow, reach
from mechanics.program import Certificate
from mechanics.solvers import USABLE
from mechanics.steps.equilibrium import check_self_weight, reaction, rest, rest_size
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import Sliding, StaticSystem, static_system
from mechanics.steps.tolerances import LIMIT, REST, STEP
from mechanics.types import GRAVITY, Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

POINTS = 20_000  # most of a path that goes on to collapse
KICKS = (1e-3, 5e-3)  # √(size·g): speeds along its jump with which what jumps is released


@dataclass(frozen=True)
class SupportMovement:
    """A support displaced by `displacement` (x, z), m, and turned by `rotation` (rad) about its drawn centroid."""

    support: str
    displacement: tuple[float, float]
    rotation: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Pushdown:
    """The path of a moving support of the `model`.

    `movement` (k,) m: its largest component, from zero (a pure rotation: the arc at the support's farthest corner);
    `reaction` (k, 2) kN: x and z force of the support on the structure (rigid joints: the first one is taken as the
    movement begins); `states`: of each point; `final`: at rest after the whole movement. `ultimate` (m): movement
    beyond which no equilibrium is found, located to 1/32 of an increment (None: not sought or not reached); `end`: why
    the path ends. `crossed` (n, 2) m: movements between which a part moves by itself, until other blocks hold it again.
    `steps`: the equilibria. `sliding`: whether what slides lifts ("associative") or not ("coulomb").
    """

    movement: Array
    reaction: Array
    states: tuple[State, ...]
    final: State
    ultimate: float | None
    end: Message
    crossed: Array
    steps: tuple[Equilibrium, ...]
    certificates: tuple[Certificate, ...]
    sliding: Sliding
    model: Assembly

    @property
    def lifting(self) -> int:
        """Number of points solved with a dilation, where Coulomb's law was not."""
        return sum(step.lifting for step in self.steps)

    def __repr__(self) -> str:
        ends = f"{1000.0 * self.movement[-1]:.4g} mm"
        last = "" if self.ultimate is None else f", ultimate movement {1000.0 * self.ultimate:.4g} mm"
        return f"Pushdown({len(self.movement)} points, to {ends}{last})"

    def plot(self, magnified: float | None = None, axes: Axes | None = None) -> Axes:
        """Draw the structure after the whole movement over its outlines as drawn; return the matplotlib axes.

        `magnified`: factor of displacements, by default one that lets them be seen.
        """
        times = magnified or magnification(self.model.shape, self.model.displaced(self.final))
        return self.model.plot(self.final, times, axes)

    def animate(self, interval: float = 0.1) -> FuncAnimation:
        """Return the points of the path as a film, one each `interval`, s; `.save("path.gif")` writes it."""
        shapes = [self.model.shape.moved(self.model.displaced(state)) for state in self.states]
        return film(shapes, self.model.shape, [f"{1000.0 * each:.4g} mm" for each in self.movement], interval)

    def to_frame(self) -> pd.DataFrame:
        """Return the points of the path as a table: movement (m), reactions (kN)."""
        import pandas as pd  # late: only tables need it

        x, z = self.reaction.T
        return pd.DataFrame({"movement_m": self.movement, "reaction_x_kN": x, "reaction_z_kN": z})


def pushdown(
    model: Assembly,
    support: str,
    displacement: ArrayLike = (0.0, 0.0),
    rotation: float = 0.0,
    increment: float = 0.001,
    contacts: Behaviour = "rigid",
    to_collapse: bool = False,
    sliding: Sliding = "coulomb",
    state: State | None = None,
) -> Pushdown:
    """Move a support by `displacement` (2,) m and `rotation` (rad, about its drawn centroid), in increments.

    `increment` (m): of the largest component. The movement begins in `state` and counts from there, by default as
    drawn. With `to_collapse` it continues in the same direction, after `final` is taken, up to the last equilibrium. If
    no equilibrium lies near, the blocks are released until they rest; if they do not come to rest, without inertia or
    with it, the structure has collapsed.

    Raises UnstableError if the structure as drawn cannot stand, CollapseError if it collapses before the whole movement
    is applied, NoEquilibriumError or ConvergenceError if that cannot be decided (these carry the path so far),
    ArgumentError for an argument out of its range.
    """
    # nine arguments: the public function of the package, called with keywords
    Assembly.check(model)
    movement = _checked(model, support, displacement, rotation)
    require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
    check_self_weight(model)
    moving = _Moving(static_system(model, contacts, sliding), (movement,), model.starting(state))
    return _followed(moving, increment, to_collapse)


def pushdown_together(
    model: Assembly,
    movements: Sequence[SupportMovement],
    increment: float,
    sliding: Sliding = "coulomb",
) -> Pushdown:
    """Move several supports of rigid blocks in proportion to each other; `reaction` is that of the first one.

    `increment` (m): of the largest component of all movements. Raises as `pushdown`.
    """
    Assembly.check(model)
    checked = tuple(_checked(model, each.support, each.displacement, each.rotation) for each in movements)
    require(len(checked) > 0, "movements", 0, "the movement of one support or more")
    require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
    check_self_weight(model)
    return _followed(
        _Moving(static_system(model, "rigid", sliding), checked, model.initial), increment, False
    )


def _followed(moving: _Moving, increment: float, to_collapse: bool) -> Pushdown:
    """Follow the path of moving supports. Raises as `pushdown`."""
    path = _Path(moving, increment, to_collapse)
    try:
        follow(path, Bisection(increment))
        if path.undecided is not None:
            raise path.undecided
        check_path(path.steps)
    except (NoEquilibriumError, ConvergenceError) as error:
        path.end = error.message
        error.path = path.result()
        raise
    if path.final is None:
        raise CollapseError(path.collapse(), path.result())
    return path.result()


def _checked(model: Assembly, support: str, displacement: ArrayLike, rotation: float) -> SupportMovement:
    """Return the whole movement of a support; ArgumentError if it is none."""
    target = array_of("displacement", displacement, "(x, z) in m")
    require(
        target.shape == (2,) and bool(np.isfinite(target).all()), "displacement", displacement, "(x, z) in m"
    )
    require(is_number(rotation) and abs(rotation) < np.inf, "rotation", rotation, "finite, in rad")
    full = whole_movement(model, support, target, rotation)
    arc = whole_movement(model, support, np.zeros(2), rotation)
    least = STEP.rounding * model.size
    require(
        max(full, arc) > least, "displacement", displacement, f"with the rotation, more than {least:.1g} m"
    )
    return SupportMovement(support, (float(target[0]), float(target[1])), rotation)


@dataclass(frozen=True, eq=False)
class _Moving:
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

    def translation(self, by: float) -> Array | None:
        """Return how far (2,) a movement of `by` (m) takes the support; None where several move, or one turns."""
        one = self.movements[0]
        if len(self.movements) > 1 or one.rotation:
            return None
        return by / self.full * np.array(one.displacement)

    @property
    def lever(self) -> float:
        """Ratio, 1 or more, of the longest way of the supports' corners to the movement: a rotation may exceed it."""
        model = self.system.model
        turned = [whole_movement(model, each.support, (0.0, 0.0), each.rotation) for each in self.movements]
        return max(1.0, max(turned) / self.full)


class Led:
    """A structure whose supports are led: its `last` equilibrium, and its `rate` (b, 3) per metre of their movement."""

    def __init__(self, system: StaticSystem, begun: State) -> None:
        self.smallest = 0.0 if system.rigid else rest_size(system.model, system.behaviour)
        self.last = rest(system, begun)
        self.rate = np.zeros_like(begun.positions)

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
            way = np.where(still, 0.0, jump / abs(jump).max()) * np.sqrt(GRAVITY * system.model.size)
            at = np.where(still, guess, before.positions)
            releases = [replace(before, positions=at, velocities=kick * way, carrying=None) for kick in KICKS]
            if not all(stands(system.model, system.behaviour, system.sliding, each) for each in releases):
                raise RunawayError(
                    message("the structure falls: a part moves by itself, and is not held again")
                )
        self.last = found
        self.rate = 0.0 * guess if jumped else (found.state.positions - before.positions) / by
        return jumped


class _Path:
    """The path as far as it has been followed; `end`: why it ends, None while it goes on.

    `final`: the state at rest after the whole movement, None before; `undecided`: why it is not known whether there is
    one; `ultimate` (m): see Pushdown.
    """

    def __init__(self, moving: _Moving, increment: float, to_collapse: bool) -> None:
        self.moving, self.model, self.to_collapse = moving, moving.system.model, to_collapse
        larger_side = float(np.ptp(drawn_extent(self.model), axis=0).max())  # of the drawing
        self.limit = max(moving.full, larger_side) if to_collapse else moving.full
        self.final: State | None = None
        self.undecided: ConvergenceError | None = None
        self.ultimate: float | None = None
        self.end: Message | None = None
        self.index = self.model.support(moving.movements[0].support)
        self.led = Led(moving.system, moving.begun)
        self.steps, self.movement = [self.led.last], [0.0]
        begun = self.led.last
        if moving.system.rigid:
            onset = LIMIT.onset * min(increment, self.model.size)
            guess = moving.moved(begun.state.positions, onset)
            with suppress(RunawayError):  # whether the path ends there the first step decides
                begun = self.led.reach(guess, moving.lever * onset, True).step
        self.reactions = [reaction(begun, self.index)[:2]]
        self.certificates = [self.led.last.certificate, begun.certificate]
        self.crossed: list[tuple[float, float]] = []

    def advance(self, length: float, shortest: bool) -> bool:
        """Add the next point, at most a length (m) further on; return whether the blocks have jumped to it.

        The whole movement is not passed before the blocks have come to rest there. `shortest`: whether no shorter step
        is tried after this one. The errors are those of `reach`.
        """
        target = self.moving.full if self.final is None else self.limit
        here = self.movement[-1]
        by, led = min(length, target - here), self.led
        guess = self.moving.moved(led.last.state.positions + by * led.rate, here + by)
        jumped = led.step(guess, by, self.moving.lever, shortest)
        self.steps.append(led.last)
        self.movement.append(here + by)
        self.certificates.append(led.last.certificate)
        self.reactions.append(reaction(led.last, self.index)[:2])
        if jumped:
            self.crossed.append((here, here + by))
        if self.final is None and self.applied:
            self._settle()
        elif self.final is not None and self._moves_as_a_whole(by):
            self.end = message("the structure moves with its support as a whole")
        if self.end is None and self.movement[-1] >= self.limit * (1.0 - 1e-9):
            self.end = message("the whole movement is applied")
        elif self.end is None and self.final is not None and len(self.steps) >= POINTS:
            key = "increment_m" if self.moving.shifts else "increment_rad"
            self.end = message(
                "a path has {count} points at most; write a larger {key}", count=POINTS, key=key
            )
        return jumped

    def stop(self, error: NoEquilibriumError | ConvergenceError) -> None:
        """End the path at its last point, beyond which the shortest step has failed.

        Raises the error if the whole movement is not applied, and the structure does not fall.
        """
        falls = isinstance(error, RunawayError)
        if self.final is None and not falls:
            raise error
        self.ultimate, self.end = self.movement[-1] if falls else None, error.message

    @property
    def share(self) -> float:
        """Share of the path that is done: of the whole movement; how far away collapse is is not known."""
        applied = min(self.movement[-1] / self.moving.full, 1.0)
        return 0.5 * applied if self.to_collapse else applied

    @property
    def applied(self) -> bool:
        """Whether the whole movement is applied."""
        return self.movement[-1] >= self.moving.full * (1.0 - 1e-9)

    def _settle(self) -> None:
        """Let the blocks that sliding has lifted come down after the whole movement; the path ends if they fall."""
        step = self.steps[-1]
        try:
            rested = sound(come_down(step, self.led.smallest))
        except RunawayError as fall:
            self.ultimate, self.end = self.movement[-2], fall.message
            return
        except ConvergenceError as error:
            self.undecided, self.end = error, error.message
            return
        if rested is not step:
            self.certificates.append(rested.certificate)
        self.final = rested.state

    def _moves_as_a_whole(self, by: float) -> bool:
        """Whether in the last step, of `by` (m), every block went along with the support and rests on no other."""
        moved, last = self.moving.translation(by), self.steps[-1]
        elsewhere = ~self.model.movable
        elsewhere[self.index] = False
        beside = elsewhere[last.contacts.a] | elsewhere[last.contacts.b]
        if moved is None or (beside & (last.forces[:, 0] > last.system.least_force)).any():
            return False
        before, after = (step.state.positions for step in self.steps[-2:])
        apart = abs((after - before)[self.model.movable] - [*moved, 0.0]).max()
        return bool(apart < USABLE * float(abs(moved).max()))

    def result(self) -> Pushdown:
        """Return the path as a result, once it has ended."""
        assert self.end is not None
        states = tuple(step.state for step in self.steps)
        return Pushdown(
            np.array(self.movement),
            np.array(self.reactions),
            states,
            self.final or states[-1],
            self.ultimate,
            self.end,
            np.array(self.crossed).reshape(-1, 2),
            tuple(self.steps),
            tuple(self.certificates),
            self.moving.system.sliding,
            self.model,
        )

    def collapse(self) -> Message:
        """Return that the structure collapses before it rests after the whole movement, and why."""
        whole, reason = self.moving.full, self.end
        assert reason is not None
        if self.applied:
            return message(
                "the structure collapses after the whole movement of {whole:.4g} m: {reason}",
                whole=whole,
                reason=reason,
            )
        return message(
            "the structure collapses at a movement of {reached:.4g} m, before the whole of {whole:.4g} m: {reason}",
            reached=self.movement[-1],
            whole=whole,
            reason=reason,
        )


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
