"""Pushover: the multiplier of lateral loads against the displacement of a control point (paper, §4, eqs 4 and 5)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    RunawayError,
    UnstableError,
    array_of,
    is_number,
    require,
)
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.pictures import draw_curve, film
from mechanics.procedures.limit_analysis import limit_analysis, limit_in
from mechanics.procedures.mechanism import farthest_corner
from mechanics.procedures.model_check import check_path
from mechanics.procedures.path_start import (
    START,
    PathStart,
    elastic_start,
    mechanism_start,
    no_way_from_rest,
)
from mechanics.procedures.peaks import behind_closing, closes, may_peak, stands_until
from mechanics.procedures.step_control import Bisection, follow, reach
from mechanics.program import Certificate
from mechanics.steps.rest import motion_to_rest
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import Sliding, StaticSystem, static_system
from mechanics.types import Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True)
class PushoverTolerances:
    """Tolerances of a capacity curve.

    `still`: displacement of a control point, as a share of the largest displacement, below which it takes no part;
    `largest`: increments that a block may move in a step in which the control point moves less. As shares of the
    largest multiplier: `zero`, a multiplier that counts as zero (located to as much of a step: else it jumps); `flat`,
    a change that does not count; `closing`, to which the peak behind a joint that closes is located. `wedged`:
    multiplier beyond which the load only wedges the blocks, times that of limit analysis where this is above 1;
    `points`: most points of a curve.
    """

    still: float = 1e-3
    largest: float = 2.0
    zero: float = 1e-6
    flat: float = 1e-3
    closing: float = 2e-4
    wedged: float = 10.0
    points: int = 5000


PUSHOVER = PushoverTolerances()
RISE = 0.15  # of the time of a curve, about, until its multiplier is largest


@dataclass(frozen=True, eq=False, repr=False)
class Pushover:
    """A capacity curve from a state's own equilibrium.

    `displacement` (k,) m of the `control` point, a drawn point (2,) m of the `block` of that number, positive along the
    push; `multiplier` (k,); `states` of each point; `steps`: the equilibria of the points (rigid joints: none at the
    onset); `certificates` of every point.
    `reached_zero`: whether the last point has α = 0; `lost`: whether the curve ends because no equilibrium lies beyond
    its last point; `end`: why it ends; `crossed` (n, 2) m: displacements between which a part moves by itself, until
    other blocks hold it again. `formed`: index of the point of the mechanism, the first from the peak on in which the
    control point moves; `mechanism` (b, 3): its virtual displacements; `forces` (j, 3): N, P and T of the `contacts`
    there, kN and kNm. `sliding`: whether what slides lifts ("associative") or not ("coulomb"); `lifting`: number of
    points solved with a dilation where the latter was not. Of the `model`, pushed in a `direction`.
    """

    control: Array
    block: int
    displacement: Array
    multiplier: Array
    states: tuple[State, ...]
    steps: tuple[Equilibrium, ...]
    certificates: tuple[Certificate, ...]
    reached_zero: bool
    lost: bool
    end: Message
    crossed: Array
    mechanism: Array
    formed: int
    forces: Array
    contacts: Contacts
    sliding: Sliding
    lifting: int
    model: Assembly
    direction: Direction

    @property
    def peak(self) -> int:
        """Index of the largest multiplier, the first of equal ones.

        In a settled state the onset may be a local motion that closes a hinge of the settlement: the multiplier then
        rises before it falls.
        """
        return _peak(self.multiplier)

    @property
    def alpha_0(self) -> float:
        """The largest multiplier: α_0 of results and report with rigid joints, α_u with elastic ones."""
        return float(self.multiplier[self.peak])

    @property
    def alpha_onset(self) -> float:
        """The first multiplier: rigid joints begin to move by it, as `limit_analysis` of the state has it."""
        return float(self.multiplier[0])

    def __repr__(self) -> str:
        at = 1000.0 * self.displacement[[self.peak, -1]]
        end = 0.0 if self.reached_zero else self.multiplier[-1]
        return (
            f"Pushover({self.direction}, {len(self.multiplier)} points, α_onset = {self.alpha_onset:.4g}, "
            f"α_0 = {self.alpha_0:.4g} at {at[0]:.4g} mm, ends at {at[1]:.4g} mm with α = {end:.3g})"
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the curve with α_0, and d_0 where α vanishes or equilibrium ends; return the matplotlib axes."""
        d = 1000.0 * self.displacement
        marks = {"α_0": (float(d[self.peak]), self.alpha_0)}
        if self.reached_zero or self.lost:
            marks["d_0"] = (float(d[-1]), float(self.multiplier[-1]))
        labels = ("displacement of the control point [mm]", "multiplier α")
        return draw_curve(d, self.multiplier, marks, labels, self.direction, axes)

    def animate(self, interval: float = 0.05) -> FuncAnimation:
        """Return the points of the curve as a film, one each `interval`, s; `.save("push.gif")` writes it."""
        shapes = [self.model.shape.moved(self.model.displaced(state)) for state in self.states]
        points = zip(1000.0 * self.displacement, self.multiplier, strict=True)
        return film(shapes, self.model.shape, [f"d = {d:.4g} mm, α = {a:.4g}" for d, a in points], interval)

    def to_frame(self) -> pd.DataFrame:
        """Return the points of the curve as a table: displacement (m) and multiplier."""
        import pandas as pd  # late: only tables need it

        return pd.DataFrame({"displacement_m": self.displacement, "multiplier": self.multiplier})


def pushover(
    model: Assembly,
    control: ArrayLike | None = None,
    direction: Direction = "+x",
    contacts: Behaviour = "rigid",
    increment: float = 0.001,
    state: State | None = None,
    until: float = 0.0,
    sliding: Sliding = "coulomb",
    tolerances: PushoverTolerances = PUSHOVER,
) -> Pushover:
    """Push the assembly over, from the onset of its mechanism (rigid joints) or from rest (elastic) to α = 0.

    `control`: drawn point (2,) m in or on a block; default the corner that goes farthest along the push in the first
    mechanism; `increment`: step of its displacement along the push, m; `state`: where the push begins, default as
    drawn; `until`: share of the peak at which the curve ends.

    Every point is an equilibrium in its own displaced geometry: the multiplier is free, and the lateral loads do a
    given work (eq. 5; with elastic joints the same program follows the curve through its peak). If no equilibrium lies
    near, the blocks are released with that work held constant; at α = 0 they are released under gravity, but for a
    structure pushed as drawn whose control point moves: its capacity is spent, whatever it falls on. If they come
    to rest, the curve goes on (with rigid joints at the multiplier that moves them again; with elastic ones, past its
    peak, at the largest load so far). If they do not, or fall back behind an earlier jump, or α jumps below zero, the
    structure has collapsed: the last equilibrium before is located.

    Raises UnstableError if the state cannot stand, ArgumentError for a control point outside every block, ControlError
    for one that takes no part in the mechanism, NoEquilibriumError if the load meets no mechanism.
    """
    # nine arguments: the public function of the package, called with keywords
    Assembly.check(model)
    require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
    require(is_number(until) and 0.0 <= until < 1.0, "until", until, "a share of the peak")
    system = static_system(model, contacts, sliding)
    if control is not None:
        point = array_of("control", control, "a point (x, z) in m")
        return _followed(_Push(point, direction, increment, until, tolerances), system, state).finished()
    first = _Push(_first_to_move(system, direction, state), direction, increment, until, tolerances)
    curve = _followed(first, system, state)
    try:
        return curve.finished()
    except ControlError:  # another part moves farther on: the curve is of what goes farthest
        begun, moved = curve.points[0].step.state.positions, curve.last.positions
        point, _ = farthest_corner(model, begun, moved, direction)
        return _followed(replace(first, control=point), system, state).finished()


def _followed(push: _Push, system: StaticSystem, state: State | None) -> _Curve:
    """Return a curve followed to its end."""
    curve = _Curve(push, system, state)
    follow(curve, Bisection(push.increment, curve.first.share * push.increment))
    if curve.system.rigid:
        curve.locate_peak()
    return curve


def _first_to_move(system: StaticSystem, direction: Direction, state: State | None) -> Array:
    """Return the drawn corner (2,), m, that goes farthest along the push in the first mechanism of rigid joints.

    The highest one where the load meets no mechanism, or elastic joints hold a state that rigid ones would not. Raises
    UnstableError if a state of rigid joints cannot stand.
    """
    model, held = system.model, () if system.rigid else (UnstableError,)
    begun = model.starting(state).positions
    moved = begun + np.where(model.movable[:, None], [1.0, 0.0, 0.0], 0.0)
    with suppress(NoEquilibriumError, ConvergenceError, *held):
        moved = begun + 1e-6 * model.size * limit_analysis(model, direction, state, system.sliding).mechanism
    return farthest_corner(model, begun, moved, direction)[0]


@dataclass(frozen=True, eq=False)
class _Push:
    """Input of a push: the `control` point (2,) m, the direction, the step (`increment`, m) and where it ends."""

    control: Array
    direction: Direction
    increment: float
    until: float
    tolerances: PushoverTolerances


@dataclass(frozen=True, eq=False)
class _Point:
    """A point of a curve: an equilibrium, the displacement (m) of the control point, whether blocks `jumped` to it."""

    step: Equilibrium
    displacement: float
    jumped: bool = False


class _Curve:
    """A capacity curve as far as it has been followed; `end`: why it ends, None while it goes on.

    `points`: the first one is the start; `reached`, `lost`: see Pushover; `endless`: whether it leans or only slides.
    """

    def __init__(self, push: _Push, system: StaticSystem, state: State | None) -> None:
        self.push, self.system, self.model, self.drawn = push, system, system.model, state is None
        self.tolerances = push.tolerances
        self.block = self.model.block_at(push.control)
        self.lateral = self.model.lateral_load(push.direction)
        self.first = self._start(state)
        self.points = [_Point(self.first.step, 0.0)]
        # the next step is predicted from the displacements of blocks and control point per unit work in the last one
        self.rate = self.first.rate
        self.control_rate = self._control_rate()
        self.plateau = (0.0, self.alpha)  # displacement at which α last changed, and its value since
        self.end: Message | None = None
        self.reached, self.lost, self.endless = False, False, False

    @property
    def last(self) -> State:
        """The last state."""
        return self.points[-1].step.state

    @property
    def alpha(self) -> float:
        """The last multiplier."""
        return self.points[-1].step.alpha

    @property
    def far(self) -> float:
        """The last displacement (m) of the control point."""
        return self.points[-1].displacement

    @property
    def multiplier(self) -> Array:
        """The multipliers (k,) of the points."""
        return np.array([point.step.alpha for point in self.points])

    @property
    def displacement(self) -> Array:
        """The displacements (k,) m of the control point."""
        return np.array([point.displacement for point in self.points])

    @property
    def largest(self) -> float:
        """The largest multiplier."""
        return max(point.step.alpha for point in self.points)

    @property
    def crossed(self) -> list[tuple[float, float]]:
        """Displacements (m) between which blocks have jumped."""
        return [(one.displacement, two.displacement) for one, two in pairwise(self.points) if two.jumped]

    def _start(self, state: State | None) -> PathStart:
        """Return the start of a curve from a state (None: as drawn)."""
        start = mechanism_start if self.system.rigid else elastic_start
        return start(self.model, self.push.direction, state, self.push.increment, self.system.sliding)

    def _control_rate(self) -> float:
        """Return the displacement of the control point per unit work (m/kNm) at the last point."""
        little = 1e-6 * self.model.size / float(abs(self.rate[:, :2]).max())
        return (self.along(self.last.positions + little * self.rate) - self.far) / little

    def along(self, positions: Array) -> float:
        """Return the displacement (m) of the control point along the push, at positions (b, 3)."""
        now, begun = (
            self.model.point_displacement(self.push.control, self.block, at)[0]
            for at in (positions, self.points[0].step.state.positions)
        )
        return float(now - begun) if self.push.direction == "+x" else float(begun - now)

    def advance(self, length: float, shortest: bool) -> bool:
        """Add the next point, about a length (m) further on; return whether the blocks have jumped.

        `shortest`: whether no shorter step is tried after this one. Where an elastic curve ends, go on if the structure
        snaps through. Raises RunawayError where a part or the structure falls, NoEquilibriumError or ConvergenceError
        where no point is found.
        """
        before = len(self.points)
        self._next(length, shortest)
        spent = self.endless or (self.reached and self._overturns())
        if self.end and not self.system.rigid and not spent and len(self.points) < self.tolerances.points:
            self._snap_through()
        return any(point.jumped for point in self.points[before:])

    def stop(self, error: NoEquilibriumError | ConvergenceError) -> None:
        """End the curve at its last point, beyond which the shortest step has failed."""
        self.end, self.lost = error.message, isinstance(error, RunawayError)
        if self.system.rigid and not self.lost:
            try:
                limit_in(self.model, self.push.direction, self.last, self.system.sliding)
            except NoEquilibriumError:
                self._lean()
            except ConvergenceError:
                pass

    def _lean(self) -> None:
        """End the curve where α begins to rise without bound: the load presses the blocks on what does not move."""
        self.end = message(
            "the structure leans on what the push does not move: beyond, the multiplier has no bound"
        )
        self.endless, alpha = True, self.multiplier
        falls = np.flatnonzero(np.diff(alpha) <= 0.0)
        self.points = self.points[: int(falls[-1]) + 2 if falls.size else 1]

    def _next(self, length: float, shortest: bool) -> None:
        """Add the next point, or the last one before α = 0; the errors are those of `advance`."""
        fastest = float(abs(self.rate[:, :2]).max())
        work = length / max(self.control_rate, fastest / self.tolerances.largest)
        step, jumped = self._step(work, fastest, shortest)
        if step.alpha > self.tolerances.wedged * max(self.first.limit, 1.0):
            self._lean()
            return
        now = self.along(step.state.positions)
        if jumped and now <= max((then for then, _ in self.crossed), default=-np.inf):
            raise RunawayError(message("the structure falls back to where it has jumped before"))
        if jumped and self.system.rigid and self._go_on_from(step):
            return  # rigid blocks rest under a range of multipliers: the curve takes the one that moves them again
        if step.alpha >= 0.0:
            self._append(work, step, jumped)
            return
        nearest = self._down_to_zero(work, fastest, step, shortest)
        if nearest is not None:
            self._append(*nearest)
        self.end = None
        zero = self.alpha <= self.tolerances.zero * self.largest
        held = None if zero and self._overturns() else self._held_again(step)
        if held is not None and self._go_on_from(held):
            return
        self.reached, self.lost = zero, not zero
        if not zero:
            self.end = message("the structure falls: beyond, it stands only where a push holds it back")
        elif held is None:
            self.end = message("α = 0")
        else:
            self.end = message("α = 0, and no push moves the structure where it rests again")

    def _step(self, work: float, fastest: float, shortest: bool) -> tuple[Equilibrium, bool]:
        """Return the equilibrium after `work` (kNm) of the lateral loads, and whether blocks jumped to it."""
        here, size = self.points[-1].step, work * fastest
        problem = StepProblem(here.system, here.state, self.model.dead_load, size, self.lateral, work)
        return reach(problem, here.state.positions + work * self.rate, here, shortest)

    def _down_to_zero(
        self, work: float, fastest: float, beyond: Equilibrium, shortest: bool
    ) -> tuple[float, Equilibrium, bool] | None:
        """Return the step to α = 0 on the way to an equilibrium beyond it (false position, Illinois rule).

        The result has the arguments of `_append`. If the multiplier jumps below zero it is the last step found before
        the jump, or None; None too from a point at α = 0, as elastic joints go on from where they rest again.
        """
        if self.alpha <= 0.0:
            return None
        low, high = (0.0, self.alpha), (work, beyond.alpha)
        tolerance, least = self.tolerances.zero * self.largest, self.tolerances.zero * work
        last: tuple[float, Equilibrium, bool] | None = None
        while high[0] - low[0] >= least:
            chord = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
            try:
                step, jumped = self._step(chord, fastest, shortest)
            except (NoEquilibriumError, ConvergenceError):
                if not shortest:  # what lies beyond may be another branch: this one is followed to its end
                    raise
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

    def _overturns(self) -> bool:
        """Return whether the structure falls at α = 0, wherever it comes to rest: as drawn, if the control point moves.

        What falls without it may be a loose block, which lets elastic joints go back; in a settled state a hinge of the
        settlement may close.
        """
        return self.drawn and self._takes_part_by(self.far)

    def _takes_part_by(self, displacement: float) -> bool:
        """Return whether the control point takes part in what has moved if that is its displacement (m)."""
        moved = float(abs(self.last.positions - self.points[0].step.state.positions)[:, :2].max())
        return displacement >= self.tolerances.still * moved

    def _held_again(self, beyond: Equilibrium) -> Equilibrium | None:
        """Return the rest under gravity near an equilibrium beyond α = 0; None if there is none or it lies far back."""
        return self._rest(0.0, beyond.state, self.far - self.push.increment)

    def _snap_through(self) -> None:
        """Go on where the structure comes to rest farther on with its largest load held: no capacity ends there.

        Beyond a peak a load that stays moves the structure on, to a fall or, as an arch that snaps through, to a rest.
        """
        held = self._rest(self.largest, self.last, self.far)
        if held is not None:
            self.end, self.reached, self.lost = None, False, False
            self._append(1.0, replace(held, alpha=self.largest), jumped=True)

    def _rest(self, alpha: float, start: State, farthest_back: float) -> Equilibrium | None:
        """Return the rest, under a held multiplier, of what is released in a state.

        None if there is none, or not beyond a displacement (m) of the control point.
        """
        size = max(self.push.increment, 1e-3 * self.model.size)
        load = self.model.dead_load + alpha * self.lateral
        problem = StepProblem(self.points[-1].step.system, start, load, size)
        try:
            rested = motion_to_rest(problem, start.positions)
        except (NoEquilibriumError, ConvergenceError):
            return None
        return rested if self.along(rested.state.positions) > farthest_back else None

    def _go_on_from(self, held: Equilibrium) -> bool:
        """Add the onset of a new push where the structure rests again; return False if no push moves it there."""
        try:
            start = self._start(held.state)
        except (UnstableError, NoEquilibriumError, ConvergenceError):
            return False
        if start.step.alpha < 0.0:  # it stands only where a push holds it back
            return False
        self._append(1.0, replace(start.step, solves=held.solves), jumped=True)
        self.rate = start.rate
        self.control_rate = self._control_rate()
        return True

    def _append(self, work: float, step: Equilibrium, jumped: bool) -> None:
        """Add a point, the rate of the next step, and why the curve ends if it does."""
        then, before = self.far, self.last.positions
        self.points.append(_Point(step, self.along(step.state.positions), jumped))
        now, alpha, largest = self.far, step.alpha, self.largest
        if not jumped:
            self.rate, self.control_rate = (step.state.positions - before) / work, (now - then) / work
        if abs(alpha - self.plateau[1]) > self.tolerances.flat * largest:
            self.plateau = (now, alpha)
        if now - self.plateau[0] > self.model.size:
            self.endless = True
            self.end = message(
                "the structure slides: α stays {alpha:.4g} over {distance:.3g} m, and nothing ends that",
                alpha=alpha,
                distance=self.model.size,
            )
        elif now > 0.5 * self.push.increment and alpha <= self.push.until * largest:
            self.end = message("α has come down to {until:g} of its peak", until=self.push.until)
        elif len(self.points) == self.tolerances.points:
            self.end = message(
                "a curve has {count} points at most; write a larger {key}",
                count=self.tolerances.points,
                key="increment_m",
            )

    @property
    def share(self) -> float:
        """Share that is done, about: of the rise, then of the way from the peak down, or of the slide that ends it."""
        now, alpha, largest = self.far, self.alpha, self.largest
        fallen = (1.0 - alpha / largest) / (1.0 - self.push.until) if largest > 0.0 else 0.0
        down = max(fallen, (now - self.plateau[0]) / self.model.size)
        if largest <= self.first.step.alpha:
            return down
        risen = 0.5 * RISE * (1.0 + largest / max(self.first.limit, largest))
        return risen + (1.0 - risen) * min(down, 1.0)

    def locate_peak(self) -> None:
        """Add the points just behind joints that close, in the steps in which α may be largest."""
        best = self.largest
        tolerance = self.tolerances.closing * best
        added: dict[int, Equilibrium] = {}
        for most, point in may_peak(self.multiplier, self.displacement, self.tolerances.flat * best):
            before, end = self.points[point - 1].step, self.points[point].step
            if self.points[point].jumped or most < best or not closes(before.state, end):
                continue
            part = tolerance / max(most - end.alpha, tolerance)
            step = behind_closing(self.lateral, before, end, part)
            if step is not None and step.alpha > best:
                added[point], best = step, step.alpha
        for point in sorted(added, reverse=True):
            self.points.insert(point, _Point(added[point], self.along(added[point].state.positions)))

    def finished(self) -> Pushover:
        """Return the curve; raise ControlError if the control point takes no part in it."""
        assert self.end is not None
        alone = len(self.points) == 1
        if alone and self.endless:
            raise NoEquilibriumError(self.end)
        if not self.system.rigid and self.drawn and (alone or self._is_hidden_by_rounding):
            raise no_way_from_rest(self.model, self.end)
        if alone or not self._takes_part_by(max(self.displacement)):
            raise ControlError(
                message(
                    "control = {point} takes no part in the mechanism along {direction}, "
                    "or the increment is too large: {reason}",
                    point=str(tuple(self.push.control.tolist())),
                    direction=self.push.direction,
                    reason=self.end,
                )
            )
        self._end_where_it_falls()
        equilibria = [point.step for point in self.points]
        steps = equilibria[1:] if self.system.rigid else equilibria
        check_path(steps)
        formed, mechanism = self._mechanism()
        return Pushover(
            self.push.control,
            self.block,
            self.displacement,
            self.multiplier,
            tuple(step.state for step in equilibria),
            tuple(steps),
            tuple(step.certificate for step in equilibria),
            self.reached,
            self.lost,
            self.end,
            np.array(self.crossed).reshape(-1, 2),
            mechanism,
            formed,
            equilibria[formed].forces,
            equilibria[formed].contacts,
            self.system.sliding,
            sum(step.lifting for step in equilibria),
            self.model,
            self.push.direction,
        )

    @property
    def _is_hidden_by_rounding(self) -> bool:
        """Whether an elastic curve ends as it rises, and joints are compressed by hardly more than rounding."""
        return self.model.rounding > START.resolved and self.alpha >= self.largest

    def _end_where_it_falls(self) -> None:
        """End the curve at α = 0, or where α would exceed a multiplier under which, held, the structure falls."""
        moves = np.diff([point.step.state.positions for point in self.points], axis=0)
        jumps = np.array([point.jumped for point in self.points[1:]])
        alpha, flat, zero = self.multiplier, self.tolerances.flat, self.tolerances.zero
        last, held = stands_until(self.model, self.lateral, alpha, moves, jumps, flat, zero)
        if last < len(alpha) - 1:
            self.reached = bool(alpha[last] <= zero * alpha.max())
            self.lost = not self.reached
            self.end = message("the structure falls under α = {alpha:.4g} held", alpha=held)
            self.points = self.points[: last + 1]

    def _mechanism(self) -> tuple[int, Array]:
        """Return the point at which the mechanism forms, and its displacements (b, 3)."""
        peak = _peak(self.multiplier)
        for point in range(peak, len(self.points)):
            mechanism = self._mechanism_at(point)
            if self._takes_part(point, mechanism):
                return point, mechanism
        return peak, self._mechanism_at(peak)

    def _mechanism_at(self, point: int) -> Array:
        """Return virtual displacements (b, 3) at a point: with elastic joints those of the step from it."""
        if self.system.rigid and point == 0:
            return self.first.rate
        state = self.points[point].step.state
        if self.system.rigid:
            with suppress(NoEquilibriumError, ConvergenceError):
                return limit_in(self.model, self.push.direction, state, self.system.sliding).mechanism
        begin = min(point, len(self.points) - 2)
        one, two = (each.step.state.positions for each in self.points[begin : begin + 2])
        return two - one

    def _takes_part(self, point: int, mechanism: Array) -> bool:
        """Whether virtual displacements (b, 3) at a point move the control point along the push."""
        fastest = float(abs(mechanism[:, :2]).max())
        little, at = 1e-6 * self.model.size / fastest, self.points[point].step.state.positions
        moved = self.along(at + little * mechanism) - self.along(at)
        return moved >= self.tolerances.still * little * fastest


def _peak(multiplier: Array) -> int:
    """Return the index of the largest multiplier (k,), the first of those that differ by rounding alone."""
    largest = float(multiplier.max())
    return int(np.argmax(multiplier >= largest - PUSHOVER.zero * abs(largest)))
