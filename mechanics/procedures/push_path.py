"""The path of a push: equilibria under lateral loads, from its onset to α = 0 or to collapse (paper, §4, eqs 4, 5)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError, UnstableError
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.procedures.held_load import borne
from mechanics.procedures.limit_analysis import Limit, limit_in
from mechanics.procedures.model_check import departure, sound
from mechanics.procedures.path_start import PathStart, elastic_start, mechanism_start, onset
from mechanics.procedures.peaks import behind_closing, closes, may_peak
from mechanics.procedures.step_control import PATH, Reached, reach
from mechanics.steps.equilibrium import check_self_weight
from mechanics.steps.rest import motion_to_rest
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import StaticSystem
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array


@dataclass(frozen=True, slots=True)
class PushoverTolerances:
    """Tolerances of a capacity curve.

    `still`: displacement of a control point, as a share of the largest displacement, below which it takes no part;
    `largest`: increments that a block may move in a step in which the control point moves less. As shares of the
    largest multiplier: `spent`, from which on down it takes part with rigid joints; `zero`, what counts as zero
    (located to as much of a step: else it jumps); `flat`, a change that does not count; `closing`, to which the peak
    behind a joint that closes is located. `wedged`: multiplier beyond which the load only wedges the blocks, times that
    of limit analysis where this is above 1; `points`: most points of a curve; `bends`: slopes of an elastic curve by
    which α rises beyond a change that does not count, without another branch.
    """

    still: float = 1e-3
    spent: float = 0.5
    largest: float = 2.0
    zero: float = 1e-6
    flat: float = 1e-3
    closing: float = 2e-4
    wedged: float = 10.0
    points: int = 5000
    bends: float = 2.0


PUSHOVER = PushoverTolerances()
RISE = 0.15  # of the time of a curve, about, until its multiplier is largest


@dataclass(frozen=True, eq=False)
class PushInput:
    """Input of a push: the `control` point (2,) m, the direction, the step (`increment`, m) and where it ends."""

    control: Array
    direction: Direction
    increment: float
    until: float
    tolerances: PushoverTolerances


@dataclass(frozen=True, eq=False)
class PushPoint:
    """A point of a curve: an equilibrium, the displacement (m) of the control point, whether blocks `jumped` to it.

    `least`: whether the equilibrium is that of limit analysis in the state.
    """

    step: Equilibrium
    displacement: float
    jumped: bool = False
    least: bool = False


class PushPath:
    """A capacity curve as far as it has been followed; `end`: why it ends, None while it goes on.

    `points`: from the start on; `dropped`, `reached`, `lost`: see Pushover; `endless`: whether it leans or only slides.
    """

    def __init__(self, push: PushInput, system: StaticSystem, state: State | None) -> None:
        self.push, self.system, self.model, self.drawn = push, system, system.model, state is None
        self.tolerances = push.tolerances
        self.block = self.model.block_at(push.control)
        self.lateral = self.model.lateral_load(push.direction)
        if system.rigid:
            check_self_weight(self.model, self.model.starting(state))
        self.first = self._start(state)
        self.points, self.dropped = [PushPoint(self.first.step, 0.0)], list[tuple[float, float]]()
        # the next step is predicted from the displacements of blocks and control point per unit work in the last one
        self.rate = self.first.rate
        self.control_rate = self._control_rate()
        self.slope = np.inf  # what α has changed per unit work in the last step
        self.plateau = (0.0, self.alpha)  # displacement at which α last changed, and its value since
        self.limits: dict[tuple[State, Assembly], Limit | None] = {}
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
        """Return the start of a curve from a state at rest (None: as drawn)."""
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
        step, released, jumped = self._step(work, fastest, shortest)
        if not (self.system.rigid or jumped):
            work, step = self._on_branch(work, fastest, step, shortest)
        if step.alpha > self.tolerances.wedged * max(self.first.limit, 1.0):
            self._lean()
            return
        if jumped and self._falls_back(step.state.positions):
            raise RunawayError(message("the structure falls back to where it has jumped before"))
        if released and self.system.rigid and self._go_on_from(step, jumped):
            return  # rigid blocks rest under a range of multipliers: the curve takes the one that moves them again
        if step.alpha >= 0.0:
            self._append(work, step, jumped)
            return
        nearest = self._down_to_zero(work, fastest, step, shortest)
        if nearest is not None:
            self._append(*nearest)
        self.end = None
        zero = self.alpha <= self.tolerances.zero * self.largest
        spent, behind = zero and self._overturns(), self.far - self.push.increment
        held = None if spent else self._rest(0.0, step.state, behind)
        if held is not None and self._go_on_from(held):
            return
        self.reached, self.lost = zero, not zero
        if not zero:
            self.end = message("the structure falls: beyond, it stands only where a push holds it back")
        elif held is None:
            self.end = message("α = 0")
        else:
            self.end = message("α = 0, and no push moves the structure where it rests again")

    def _falls_back(self, positions: Array) -> bool:
        """Whether blocks jump to positions (b, 3) from or to where they have jumped from before: on and on."""
        far, last = self.model.farthest, self.last.positions  # of all blocks
        jumps = [
            (a.step.state.positions, b.step.state.positions) for a, b in pairwise(self.points) if b.jumped
        ]
        return any(
            far(x, positions) <= far(x, y) > 2.0 * min(far(x, positions), far(x, last)) for x, y in jumps
        )

    def _step(self, work: float, fastest: float, shortest: bool) -> Reached:
        """Return the equilibrium after `work` (kNm) of the lateral loads."""
        here, size = self.points[-1].step, work * fastest
        problem = StepProblem(here.system, here.state, self.model.dead_load, size, self.lateral, work)
        return reach(problem, here.state.positions + work * self.rate, here, shortest)

    def _on_branch(
        self, work: float, fastest: float, step: Equilibrium, shortest: bool
    ) -> tuple[float, Equilibrium]:
        """Return an elastic step on the branch of the last ones, of the given `work` (kNm) or a part of it.

        α that rises by more than its slope leads to is that of a joint that closes, or of another branch: where blocks
        rock, that on which they slide. Shorter steps tell them apart: raises ConvergenceError if there are any.
        """
        part, found, rise = work, step, self.tolerances.bends * max(self.slope, 0.0)
        while found.alpha > self.alpha + rise * part + self.tolerances.flat * self.largest:
            if not shortest:
                raise ConvergenceError(message("the multiplier rises by more than its slope leads to"))
            part *= 0.5
            if part < PATH.shortest(work):
                return work, step
            try:
                found = self._step(part, fastest, False).step
            except (NoEquilibriumError, ConvergenceError):
                return work, step
        return part, found

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
                step, _, jumped = self._step(chord, fastest, shortest)
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
        """Whether α = 0 is a fall, wherever it rests: as drawn, if the control point moves, not a loose block alone."""
        return self.drawn and self.takes_part(-1, self.far)

    def takes_part(self, point: int, displacement: float, since: int = 0) -> bool:
        """Whether a control point that goes so far (m) takes part in what moves between two points of the path."""
        one, two = (self.points[k].step.state.positions for k in (since, point))
        return displacement >= self.tolerances.still * float(abs(two - one)[:, :2].max())

    @property
    def descent(self) -> int:
        """Index of the point from which a rigid curve comes down to its end; 0: elastic, or it does not come down."""
        above = np.flatnonzero(self.multiplier >= self.tolerances.spent * self.largest)[-1]
        return int(above) if self.system.rigid and above < len(self.points) - 1 else 0

    def goes_over(self, along: bool) -> bool:
        """Whether the control point takes part in the path and in what goes over; `along`: in the push's direction."""
        since, way = self.descent, self.displacement - self.displacement[self.descent]
        over = way[-1] if along else abs(way[since:]).max()
        return self.takes_part(-1, self.displacement.max()) and self.takes_part(-1, over, since)

    def _snap_through(self) -> None:
        """Go on where the largest load, held beyond the peak, moves the structure to a rest: an arch snaps through."""
        held = self._rest(self.largest, self.last, self.far)
        if held is not None:
            self.end, self.reached, self.lost = None, False, False
            self._append(1.0, replace(held, alpha=self.largest), jumped=True)

    def _rest(self, alpha: float, start: State, farthest_back: float) -> Equilibrium | None:
        """Return the rest, under a held multiplier, of what is released in a state.

        None if it falls, or rests not beyond a displacement (m) of the control point. Raises ConvergenceError if that
        is not decided.
        """
        size = max(self.push.increment, 1e-3 * self.model.size)
        load = self.model.dead_load + alpha * self.lateral
        problem = StepProblem(self.points[-1].step.system, start, load, size)
        try:
            rested = motion_to_rest(problem, start.positions)
        except RunawayError:
            return None
        return rested if self.along(rested.state.positions) > farthest_back else None

    def _go_on_from(self, held: Equilibrium, jumped: bool = True) -> bool:
        """Add the onset of a push where released blocks rest; `jumped`: or fell there. False if no push moves them."""
        try:
            start = self._start(held.state)
            sound(start.step)
        except (UnstableError, NoEquilibriumError, ConvergenceError):
            return False
        if start.step.alpha < 0.0:  # it stands only where a push holds it back
            return False
        self._append(1.0, replace(start.step, solves=held.solves), jumped)
        self.rate = start.rate
        self.control_rate = self._control_rate()
        return True

    def _append(self, work: float, step: Equilibrium, jumped: bool) -> None:
        """Add a point, the rate of the next step, and why the curve ends if it does."""
        then, before = self.far, self.last.positions
        self.slope = np.inf if jumped else (step.alpha - self.alpha) / work
        self.points.append(PushPoint(step, self.along(step.state.positions), jumped))
        now, alpha, largest = self.far, step.alpha, self.largest
        if not jumped:
            self.rate, self.control_rate = (step.state.positions - before) / work, (now - then) / work
        if abs(alpha - self.plateau[1]) > self.tolerances.flat * largest:
            self.plateau = (now, alpha)
        if now - self.plateau[0] > self.model.size:
            self.endless = True
            self.end = message(
                "the structure slides: α stays {alpha:.4g} over {distance:.3g} m, and nothing ends that",
                alpha=alpha, distance=self.model.size,
            )  # fmt: skip
        elif now > 0.5 * self.push.increment and alpha <= self.push.until * largest:
            self.end = message("α has come down to {until:g} of its peak", until=self.push.until)
        elif len(self.points) == self.tolerances.points:
            self.end = message(
                "a curve has {count} points at most; write a larger {key}",
                count=self.tolerances.points, key="increment_m",
            )  # fmt: skip

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
            self.points.insert(point, PushPoint(added[point], self.along(added[point].state.positions)))

    def take_least_flow(self) -> bool:
        """Put the flow of limit analysis in place of points of another one about the peak; return if there are any.

        Each point that is looked at is twice as far as the last one: a flow may go on for hundreds of points.
        """
        end, peak = len(self.points) - 1, peak_of(self.multiplier)
        others: dict[int, PushPoint | None] = {}
        for way in (-1, 1):
            at, reach = peak, way
            while self.system.rigid and 0 < at < end and (flow := self._flow(at)) is not self.points[at]:
                others[at], at, reach = flow, peak + reach, 2 * reach
        if not others:
            return False
        first, after = min(others), max(others) + 1
        kept = [*(k for k in sorted(others) if others[k]), after]
        self.dropped += [(point.displacement, point.step.alpha) for point in self.points[first:after]]
        jumped = [any(p.jumped for p in self.points[a + 1 : b + 1]) for a, b in pairwise([first - 1, *kept])]
        flows = [others.get(k) or self.points[k] for k in kept]
        self.points[first : after + 1] = [replace(p, jumped=j) for p, j in zip(flows, jumped, strict=True)]
        return True

    def _flow(self, point: int) -> PushPoint | None:
        """Return a point if its flow is that of limit analysis in its state, else the point with that flow.

        None if that lifts what slides or presses across a gap, or joints that crush have none. A slide leaves forces
        open: the path may balance more than any flow of its state. Joints that crush bear no more than joints that do
        not.
        """
        own, closed = self.points[point], LIMIT.closed * self.model.size
        if own.least or (self.model.crushes and own.step.penetration > closed):
            return own  # without crushing such a joint is not closed
        bound = self.limit_at(point, self.model.uncrushed)
        if bound is None:
            return own
        if bound.dilation > max(self.system.dilation, *LIMIT.slight):
            return None
        if own.step.alpha <= (1.0 + self.tolerances.flat) * bound.alpha:
            return own
        if (least := self.limit_at(point, self.model)) is None:
            return None
        flow = onset(least, self.push.increment)
        flow = replace(flow, lifting=flow.lifting or own.step.lifting)
        return None if departure(flow) else replace(own, step=flow, least=True)

    def limit_at(self, point: int, model: Assembly) -> Limit | None:
        """Return the limit of rigid joints in the state of a point; None where the load meets no mechanism there.

        `model`: that of the curve, or the one whose joints cannot be crushed.
        """
        state = self.points[point].step.state
        if (state, model) not in self.limits:
            self.limits[state, model] = None
            with suppress(NoEquilibriumError, ConvergenceError):
                self.limits[state, model] = limit_in(model, self.push.direction, state, self.system.sliding)
        return self.limits[state, model]

    def peak_that_counts(self) -> tuple[int, float]:
        """Return the point of α_0, and α_0: the largest multiplier that, held, does not fell the structure.

        What exceeds it behind a trough is reached by a push that is taken back alone: the curve has it, α_0 does not
        count it. Where α vanishes in that trough the curve ends, if the control point has moved: without it hinges of a
        settlement close. Before, limit analysis replaces points of other flows.
        """
        while self.take_least_flow():
            pass
        alpha = self.multiplier
        discontinuous = np.array([point.jumped or point.least for point in self.points])
        flat, zero = self.tolerances.flat * float(alpha.max()), self.tolerances.zero * float(alpha.max())
        behaviour: Behaviour = "rigid" if self.system.rigid else "elastic"
        held = borne(
            alpha, discontinuous, flat, self.model, self.push.direction, behaviour, self.system.sliding,
            self.points[0].step.state,
        )  # fmt: skip
        peak = int(np.argmax(alpha >= held)) if held < np.inf else peak_of(alpha)
        alpha_0 = min(float(alpha[peak]), held)
        above = np.flatnonzero(alpha[peak:] > alpha[peak] + flat)
        last = peak + int(above[0]) - 1 if above.size else len(alpha) - 1
        spent = peak + int(np.argmax(alpha[peak : last + 1] <= zero))
        if peak < spent < len(alpha) - 1 and self.takes_part(spent, self.displacement[spent]):
            self.reached, self.lost = True, False
            self.end = message("the structure falls under more than α = {alpha:.4g} held", alpha=alpha_0)
            self.points = self.points[: spent + 1]
        return peak, alpha_0


def peak_of(multiplier: Array) -> int:
    """Return the index of the largest multiplier (k,), the first of those that differ by rounding alone."""
    largest = float(multiplier.max())
    return int(np.argmax(multiplier >= largest - PUSHOVER.zero * abs(largest)))
