"""Pushover: the multiplier of lateral loads against the displacement of a control point (paper, §4, eqs 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    RunawayError,
    UnstableError,
    require,
)
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.procedures.limit_analysis import limit_in
from mechanics.procedures.path_start import elastic_start, mechanism_start, no_way_from_rest
from mechanics.procedures.step_control import HALVINGS, Bisection, reach
from mechanics.program import Certificate
from mechanics.steps.contact_values import moved_over
from mechanics.steps.rest import motion_to_rest
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import Sliding, static_system
from mechanics.types import Array


@dataclass(frozen=True, slots=True)
class PushoverTolerances:
    """Of a capacity curve.

    `still`: of the largest displacement, a control point that takes no part; `largest`: increments that a block may
    move where the control point moves less; of the largest multiplier, `zero`: one that is none, found by at most
    `chords`, `nearly`: one from which a path that comes down may jump below zero, `flat`: a change that is none;
    `back`: of its displacement, to where a control point goes back as a part falls; `points`: the most.
    """

    still: float = 1e-3
    largest: float = 2.0
    zero: float = 1e-6
    chords: int = 8
    nearly: float = 1e-2
    flat: float = 1e-3
    back: float = 0.5
    points: int = 5000


PUSHOVER = PushoverTolerances()


@dataclass(frozen=True, eq=False)
class Pushover:
    """A capacity curve from a state's own equilibrium.

    `displacement` (k,) m of the control point, positive along the push; `multiplier` (k,); `states` of each point;
    `steps`: the equilibria behind the points (rigid: none at the onset). `reached_zero`: whether the curve was
    followed to α = 0, at its last point; `lost`: whether it ends because no equilibrium lies beyond that point; `end`:
    why it ends; `crossed` (n, 2) m: between which displacements a part moves by itself, until others hold it again.
    `certificates` of every step. `mechanism` (b, 3): virtual displacements at the point `formed`, the first with the
    largest multiplier in which the control point moves; `forces` (j, 3): N, P and T of the `contacts` there.
    """

    displacement: Array
    multiplier: Array
    states: tuple[State, ...]
    steps: tuple[Equilibrium, ...]
    certificates: tuple[Certificate, ...]
    reached_zero: bool
    lost: bool
    end: str
    crossed: Array
    mechanism: Array
    formed: int
    forces: Array
    contacts: Contacts

    @property
    def peak(self) -> int:
        """Index of the largest multiplier, the first of equal ones.

        In a settled state the onset may be a local motion that closes a hinge of the settlement: the multiplier then
        rises before it falls.
        """
        return _peak(self.multiplier)


def pushover(
    model: Assembly,
    control: ArrayLike,
    direction: Direction = "+x",
    contacts: Behaviour = "rigid",
    increment: float = 0.001,
    state: State | None = None,
    until: float = 0.0,
    sliding: Sliding = "associative",
    tolerances: PushoverTolerances = PUSHOVER,
) -> Pushover:
    """Push the assembly over, from onset (rigid) or rest (elastic) until the multiplier has come down to zero.

    `control`: drawn point (m) in or on a block; `increment` (m) of its displacement along the push; `until`: the share
    of its peak at which the multiplier has come down far enough. Every point is an equilibrium in its own displaced
    geometry, under a free multiplier whose loads do a given work (eq. 5; with elastic joints the same program traces
    the curve through its peak). Where no equilibrium lies near, the blocks are released with that work held, until they
    rest; where the multiplier comes down to zero, under gravity. Where they rest again the curve goes on (with rigid
    joints at the multiplier that moves them again); where they run away, or the control point goes back, or α jumps
    below zero, the structure has collapsed, and the last equilibrium before is located. Raises
    UnstableError, ValueError for a control point outside every block, ControlError for one that takes no part in the
    mechanism, NoEquilibriumError where the load meets no mechanism.
    """
    require(0.0 < increment < np.inf, "increment", increment, "positive, in m")
    require(0.0 <= until < 1.0, "until", until, "a share of the peak")
    curve = _Curve(model, control, direction, contacts, increment, state, until, sliding, tolerances)
    bisection = Bisection(increment, curve.first.share * increment)
    while not curve.end:
        try:
            curve.advance(bisection.length, bisection.shortest)
        except (NoEquilibriumError, ConvergenceError) as stop:
            if not bisection.shorter():
                curve.end, curve.lost = str(stop), isinstance(stop, RunawayError)
            continue
        bisection.longer()
    return curve.finished()


class _Curve:
    """A capacity curve as far as it has been followed; `end`: why it goes no farther."""

    def __init__(
        self,
        model: Assembly,
        control: ArrayLike,
        direction: Direction,
        contacts: Behaviour,
        increment: float,
        state: State | None,
        until: float,
        sliding: Sliding,
        tolerances: PushoverTolerances,
    ) -> None:
        self.tolerances = tolerances
        self.model, self.increment, self.until, self.drawn = model, increment, until, state is None
        self.control, self.direction = np.asarray(control, dtype=float), direction
        self.block = model.block_at(control)
        self.lateral = model.lateral_load(direction)
        self.system = static_system(model, contacts, sliding)
        self.first = (
            mechanism_start(model, direction, state, sliding)
            if contacts == "rigid"
            else elastic_start(model, direction, state, increment, sliding)
        )
        self.states, self.multiplier, self.displacement = [self.first.state], [self.first.alpha], [0.0]
        self.steps = [self.first.step] if self.first.step else []
        self.certificates = [self.first.certificate]
        # the next step from the rate of the last one: per unit work, how far the blocks and the control point move
        self.rate = self.first.rate
        little = 1e-6 * model.size / float(abs(self.rate[:, :2]).max())
        self.control_rate = self.along(self.first.state.positions + little * self.rate) / little
        self.plateau = (0.0, self.first.alpha)  # where α last changed, and to what
        self.crossed: list[tuple[float, float]] = []
        self.end, self.reached, self.lost = "", False, False

    def along(self, positions: Array) -> float:
        """Displacement (m) of the control point along the push."""
        now, begun = (
            self.model.point_displacement(self.control, self.block, at)[0]
            for at in (positions, self.states[0].positions)
        )
        return float(now - begun) if self.direction == "+x" else float(begun - now)

    def advance(self, length: float, shortest: bool) -> None:
        """The next point, about a length (m) further on: whether it is the `shortest` that is tried."""
        fastest = float(abs(self.rate[:, :2]).max())
        work = length / max(self.control_rate, fastest / self.tolerances.largest)
        step, jumped = self._step(work, fastest, shortest)
        gone_back = self.displacement[-1] - self.along(step.state.positions)
        if gone_back > max(
            self.tolerances.back * self.displacement[-1], self.tolerances.still * self.model.size
        ):
            raise RunawayError("a part falls, and the control point goes back")
        if jumped and self.system.rigid and self._go_on_from(step):
            return  # rigid blocks rest under many multipliers: the one that moves them again is theirs
        if step.alpha >= 0.0:
            self._append(work, step, jumped)
            return
        nearest = self._down_to_zero(work, fastest, step)
        if nearest is not None:
            self._append(*nearest)
        zero = self.multiplier[-1] <= self.tolerances.nearly * max(self.multiplier)
        self.multiplier[-1], self.end = 0.0 if zero else self.multiplier[-1], ""
        held = self._held_again(step)
        if held is not None and self._go_on_from(held):
            return
        self.reached, self.lost = zero, not zero
        if not zero:
            self.end = "the structure falls: beyond, it stands only where a push holds it back"
        elif held is None:
            self.end = "α = 0"
        else:
            self.end = "α = 0, and no push moves the structure where it rests again"

    def _step(self, work: float, fastest: float, shortest: bool = True) -> tuple[Equilibrium, bool]:
        """The equilibrium after so much work (kNm), and whether blocks jumped to it."""
        now = self.states[-1]
        self.system = self.system.around(now.positions, 2.0 * work * fastest)
        problem = StepProblem(self.system, now, self.model.dead_load, work * fastest, self.lateral, work)
        last = self.steps[-1] if self.steps else None
        return reach(problem, now.positions + work * self.rate, last, shortest)

    def _down_to_zero(
        self, work: float, fastest: float, beyond: Equilibrium
    ) -> tuple[float, Equilibrium, bool] | None:
        """The step that brings the multiplier down to zero on the way to one beyond (false position, Illinois rule).

        As `_append` takes it. Where the multiplier jumps below zero: the last one found before the jump, or None.
        """
        low, high = (0.0, self.multiplier[-1]), (work, beyond.alpha)
        tolerance, least = self.tolerances.zero * max(self.multiplier), work / 2.0**HALVINGS
        last: tuple[float, Equilibrium, bool] | None = None
        for count in range(self.tolerances.chords):
            chord = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
            if count and chord < least:
                break
            try:
                step, jumped = self._step(chord, fastest)
            except (NoEquilibriumError, ConvergenceError):
                break
            if step.alpha >= -tolerance:
                last = (chord, step, jumped)
            if abs(step.alpha) <= tolerance:
                break
            if step.alpha < 0.0:
                low, high = (low[0], 0.5 * low[1]), (chord, step.alpha)
            else:
                low, high = (chord, step.alpha), (high[0], 0.5 * high[1])
        return last

    def _held_again(self, beyond: Equilibrium) -> Equilibrium | None:
        """The rest under gravity near a point beyond zero, where a part that has moved by itself is held again."""
        size = max(self.increment, 1e-3 * self.model.size)
        problem = StepProblem(self.system, beyond.state, self.model.dead_load, size)
        try:
            held = motion_to_rest(problem, beyond.state.positions)
        except (NoEquilibriumError, ConvergenceError):
            return None
        return held if self.along(held.state.positions) >= self.displacement[-1] - self.increment else None

    def _go_on_from(self, held: Equilibrium) -> bool:
        """Whether the curve goes on where the structure rests again, or nothing can be pushed there."""
        try:
            start = (
                mechanism_start(self.model, self.direction, held.state, self.system.sliding)
                if self.system.rigid
                else elastic_start(
                    self.model, self.direction, held.state, self.increment, self.system.sliding
                )
            )
        except (UnstableError, NoEquilibriumError, ConvergenceError):
            return False
        # the point is the onset there: its forces are those under α, not those of the rest under gravity
        forces = moved_over(start.forces, start.contacts, held.contacts)
        onset = replace(held, alpha=start.alpha, forces=forces, certificate=start.certificate)
        self._append(1.0, onset, jumped=True)
        self.rate = start.rate
        little = 1e-6 * self.model.size / float(abs(self.rate[:, :2]).max())
        self.control_rate = (
            self.along(held.state.positions + little * self.rate) - self.displacement[-1]
        ) / little
        return True

    def _append(self, work: float, step: Equilibrium, jumped: bool) -> None:
        """The next point."""
        before = self.states[-1].positions
        self.states.append(step.state)
        self.steps.append(step)
        self.certificates.append(step.certificate)
        self.multiplier.append(step.alpha)
        self.displacement.append(self.along(step.state.positions))
        then, now = self.displacement[-2:]
        if jumped:
            self.crossed.append((then, now))
        else:
            self.rate, self.control_rate = (step.state.positions - before) / work, (now - then) / work
        if abs(self.multiplier[-1] - self.plateau[1]) > self.tolerances.flat * max(self.multiplier):
            self.plateau = (now, self.multiplier[-1])
        size, alpha = self.model.size, self.multiplier[-1]
        if now - self.plateau[0] > size:
            self.end = f"the structure slides: α stays {alpha:.4g} over {size:.3g} m, and nothing ends that"
        if not self.end and now > 0.5 * self.increment and alpha <= self.until * max(self.multiplier):
            self.end = f"α has come down to {self.until:g} of its peak"
        if len(self.states) == self.tolerances.points and not self.end:
            self.end = f"{self.tolerances.points} points"

    def finished(self) -> Pushover:
        """The curve; ControlError where the control point takes no part in it."""
        if len(self.states) == 1 and not self.system.rigid and self.drawn:
            raise no_way_from_rest(self.end)
        moved = float(abs(self.states[-1].positions - self.states[0].positions)[:, :2].max())
        if len(self.states) == 1 or max(self.displacement) < self.tolerances.still * moved:
            raise ControlError(
                f"control = {tuple(self.control.tolist())} takes no part in the mechanism along {self.direction}, "
                f"or the increment is too large: {self.end}"
            )
        formed, mechanism, forces, contacts = self._mechanism()
        return Pushover(
            np.array(self.displacement),
            np.array(self.multiplier),
            tuple(self.states),
            tuple(self.steps),
            tuple(self.certificates),
            self.reached,
            self.lost,
            self.end,
            np.array(self.crossed).reshape(-1, 2),
            mechanism,
            formed,
            forces,
            contacts,
        )

    def _mechanism(self) -> tuple[int, Array, Array, Contacts]:
        """The point at which the mechanism is activated, its virtual displacements (b, 3), and the forces there."""
        peak = _peak(np.array(self.multiplier))
        for point in range(peak, len(self.states)):
            mechanism, forces, contacts = self._mechanism_at(point)
            if self._takes_part(point, mechanism):
                return point, mechanism, forces, contacts
        return peak, *self._mechanism_at(peak)

    def _mechanism_at(self, point: int) -> tuple[Array, Array, Contacts]:
        """Virtual displacements (b, 3), forces (j, 3) and contacts at a point; elastic: the next motion."""
        rigid = self.system.rigid
        if rigid and point == 0:
            return self.first.rate, self.first.forces, self.first.contacts
        step = self.steps[point - rigid]
        forces, contacts = step.forces, step.contacts
        if rigid:
            try:
                found = limit_in(self.model, self.direction, self.states[point], self.system.sliding)
                return found.mechanism, forces, contacts
            except (NoEquilibriumError, ConvergenceError):
                pass
        begin = min(point, len(self.states) - 2)
        return self.states[begin + 1].positions - self.states[begin].positions, forces, contacts

    def _takes_part(self, point: int, mechanism: Array) -> bool:
        """Whether the control point moves along the push in virtual displacements (b, 3) of a point."""
        fastest = float(abs(mechanism[:, :2]).max())
        little, at = 1e-6 * self.model.size / fastest, self.states[point].positions
        moved = self.along(at + little * mechanism) - self.along(at)
        return moved >= self.tolerances.still * little * fastest


def _peak(multiplier: Array) -> int:
    """Index of the largest multiplier (k,), the first of those that differ by no more than rounding."""
    largest = float(multiplier.max())
    return int(np.argmax(multiplier >= largest - PUSHOVER.zero * abs(largest)))
