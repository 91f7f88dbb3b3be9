"""Pushdown: reaction and configuration against the movement of a support (paper, §4, eqs 6 and 7)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    CollapseError,
    ConvergenceError,
    NoEquilibriumError,
    RunawayError,
    is_number,
    require,
)
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.pictures import film, magnification
from mechanics.procedures.model_check import check_path, sound
from mechanics.procedures.step_control import Bisection, follow
from mechanics.procedures.support_movement import (
    FALLS,
    Led,
    Movements,
    SupportMovement,
    checked_movement,
    drawn_extent,
)
from mechanics.program import Certificate
from mechanics.solvers import USABLE
from mechanics.steps.equilibrium import check_self_weight, reaction
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import Sliding, static_system
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

POINTS = 20_000  # most of a path that goes on to collapse
# shares of a path to collapse at which it is released with a kick
KICKED = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)


@dataclass(frozen=True, eq=False, repr=False)
class Pushdown:
    """The path of a moving support of the `model`.

    `movement` (k,) m: its largest component, from zero (a pure rotation: the arc at the support's farthest corner);
    `reaction` (k, 2) kN: x and z force of the support on the structure (rigid joints: the first one is taken as the
    movement begins); `states`: of each point; `final`: at rest after the whole movement. `ultimate` (m): movement
    beyond which no equilibrium is found, located to 1/32 of an increment, or where joints slide the last one at
    which the structure stands after a kick (None: not sought or not reached); `end`: why the path ends. `crossed`
    (n, 2) m: movements between which a part moves by itself, until other blocks hold it again. `steps`: the
    equilibria. `sliding`: whether what slides lifts ("associative") or not ("coulomb").
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
    movement = (support, displacement, rotation)
    return _followed(model, [movement], increment, contacts, to_collapse, sliding, state)


def pushdown_together(
    model: Assembly,
    movements: Sequence[SupportMovement],
    increment: float,
    sliding: Sliding = "coulomb",
) -> Pushdown:
    """Move several supports of rigid blocks in proportion to each other; `reaction` is that of the first one.

    `increment` (m): of the largest component of all movements. Raises as `pushdown`.
    """
    whole = [(each.support, each.displacement, each.rotation) for each in movements]
    return _followed(model, whole, increment, "rigid", False, sliding, None)


def _followed(
    model: Assembly, movements: Sequence[tuple[str, ArrayLike, float]], increment: float, contacts: Behaviour,
    to_collapse: bool, sliding: Sliding, state: State | None,
) -> Pushdown:  # fmt: skip
    """Follow the path of supports that move by a displacement and a rotation each. Raises as `pushdown`."""
    Assembly.check(model)
    checked = tuple(checked_movement(model, *each) for each in movements)
    require(len(checked) > 0, "movements", 0, "the movement of one support or more")
    require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
    check_self_weight(model)
    moving = Movements(static_system(model, contacts, sliding), checked, model.starting(state))
    path = _Path(moving, increment, to_collapse)
    try:
        follow(path, Bisection(increment))
        if path.undecided is not None:
            raise path.undecided
        check_path(path.steps)
        path.release()
    except (NoEquilibriumError, ConvergenceError) as error:
        path.end = error.message
        error.path = path.result()
        raise
    if path.final is None:
        raise CollapseError(path.collapse(), path.result())
    return path.result()


class _Path:
    """The path as far as it has been followed; `end`: why it ends, None while it goes on.

    `final`: the state at rest after the whole movement, None before; `undecided`: why it is not known whether there is
    one; `ultimate` (m): see Pushdown.
    """

    def __init__(self, moving: Movements, increment: float, to_collapse: bool) -> None:
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
        self.others = [begun.certificate]  # certificates of what is no point of the path
        self.crossed: list[tuple[float, float]] = []

    def advance(self, length: float, shortest: bool) -> bool:
        """Add the next point, at most a length (m) further on; return whether the blocks have jumped to it.

        The whole movement is not passed before the blocks have come to rest there. `shortest`: whether no shorter step
        is tried after this one. The errors are those of `reach`.
        """
        target = self.moving.full if self.final is None else self.limit
        here = self.movement[-1]
        at, led = here + length, self.led
        at = at if at < target * (1.0 - 1e-9) else target  # no step is left of a length of rounding
        by = at - here
        guess = self.moving.moved(led.last.state.positions + by * led.rate, at)
        jumped = led.step(guess, by, self.moving.lever, shortest)
        self.steps.append(led.last)
        self.movement.append(at)
        self.reactions.append(reaction(led.last, self.index)[:2])
        if jumped:
            self.crossed.append((here, at))
        if self.final is None and self.applied:
            self._settle()
        elif self.final is not None and self._moves_as_a_whole():
            self.end = message("the structure moves with its support as a whole")
        if self.end is None and at == self.limit:
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

    def release(self) -> None:
        """End a path on which joints slide at its last point from which the structure, kicked, does not fall.

        Of a path to collapse, beyond the whole movement; of one that falls before or after it, from its start.
        """
        if not self.led.slid or (self.final is not None and not self.to_collapse):
            return
        movement, last = np.array(self.movement), len(self.movement) - 1
        stood = 0 if self.final is None else int(np.searchsorted(movement, self.moving.full))
        points = [k for k in np.searchsorted(movement, np.array(KICKED) * movement[-1]).tolist() if k > stood]
        fell = next((k for k in points if not self._stands(k)), last if self.end is FALLS else None)
        if fell is None:
            return
        stood = max([stood, *(k for k in points if k < fell)])
        while fell - stood > 1:
            middle = (stood + fell) // 2
            stood, fell = (middle, fell) if self._stands(middle) else (stood, middle)
        del self.steps[stood + 1 :], self.movement[stood + 1 :], self.reactions[stood + 1 :]
        self.crossed = [(begun, end) for begun, end in self.crossed if end <= self.movement[-1]]
        self.ultimate, self.end = self.movement[-1], FALLS

    def _stands(self, point: int) -> bool:
        """Whether the structure, released at a point with a kick along the way to it, stands."""
        before, state = (step.state for step in self.steps[point - 1 : point + 1])
        return self.led.stands(state, state.positions - before.positions)

    @property
    def share(self) -> float:
        """Share of the path that is done: of the whole movement; how far away collapse is is not known."""
        applied = min(self.movement[-1] / self.moving.full, 1.0)
        return 0.5 * applied if self.to_collapse else applied

    @property
    def applied(self) -> bool:
        """Whether the whole movement is applied."""
        return self.movement[-1] >= self.moving.full

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
            self.others.append(rested.certificate)
        way = rested.state.positions - self.steps[-2].state.positions
        if self.led.slid and not self.led.stands(rested.state, way):
            self.end = FALLS
            return
        self.final = rested.state

    def _moves_as_a_whole(self) -> bool:
        """Whether in the last step every block went along with the (first) support and rests on no other."""
        before, last = self.steps[-2:]
        elsewhere = ~self.model.movable
        elsewhere[self.index] = False
        beside = elsewhere[last.contacts.a] | elsewhere[last.contacts.b]
        if (beside & (last.forces[:, 0] > last.system.least_force)).any():
            return False
        moved = last.state.positions - before.state.positions
        apart = abs(moved[self.model.movable] - moved[self.index[0]]).max()
        return bool(apart < USABLE * float(abs(moved).max()))

    def result(self) -> Pushdown:
        """Return the path as a result, once it has ended."""
        assert self.end is not None
        states = tuple(step.state for step in self.steps)
        certificates = (*(step.certificate for step in self.steps), *self.others)
        return Pushdown(
            np.array(self.movement), np.array(self.reactions), states, self.final or states[-1], self.ultimate,
            self.end, np.array(self.crossed).reshape(-1, 2), tuple(self.steps), certificates,
            self.moving.system.sliding, self.model,
        )  # fmt: skip

    def collapse(self) -> Message:
        """Return that the structure collapses before it rests after the whole movement, and why."""
        whole, reason = self.moving.full, self.end
        assert reason is not None
        if self.applied:
            return message(
                "the structure collapses after the whole movement of {whole:.4g} m: {reason}",
                whole=whole, reason=reason,
            )  # fmt: skip
        return message(
            "the structure collapses at a movement of {reached:.4g} m, before the whole of {whole:.4g} m: {reason}",
            reached=self.movement[-1], whole=whole, reason=reason,
        )  # fmt: skip
