"""Every time history that a project asks for: at which time steps, and by how many members of an ensemble.

a first pair of members at the time step given, and at a half and a quarter of it where the project has an accuracy
finer ones until the peak is as accurate, or scatters more than the time steps differ
all other members at the finest time step, where the pair is not the same motion

Members have the same record, a little weaker and a little stronger: a motion with many impacts or slides depends on the
last digits of its record; single runs do not converge, their distribution does.

Error of a peak from three or more levels of the time step v₀, v₁, v₂… at h, h/2, h/4…; two may agree by chance:
the pair is farther apart than the levels    the quantity scatters: no time step makes it surer
differences shrink as those of a method      Richardson's extrapolation, of first order at most
else                                         the levels converge to nothing that is known: all they differ by
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from statistics import median

import numpy as np

from assessment.analyses import time_history
from assessment.analyses.found import FIRST_ORDER, LEVELS, NOISE, PRESETS, accuracy_of, joined, observed_order
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.results.schema import Band, ConvergenceRow, known
from mechanics.messages import Message, headed, linked, message
from mechanics.types import Array

SPREAD = 0.01  # of the amplitude, to either side
PAIR = 2  # members that are run first


@dataclass(frozen=True)
class Scatter:
    """The most `members` of an ensemble, and the `tolerance` within which a first pair agrees."""

    members: int
    tolerance: float

    @property
    def amplitudes(self) -> tuple[float, ...]:
        """Factors on the record, evenly spread over 1 ± SPREAD: first 1, then the weakest, then the others."""
        half = self.members // 2
        shares = [k / half for k in range(-half, self.members - half) if k]
        return (1.0, *(1.0 + SPREAD * share for share in shares))

    @property
    def strongest_first(self) -> tuple[float, ...]:
        """The same factors for a search: first 1, then the strongest, which decide and end soonest."""
        return (1.0, *sorted(self.amplitudes[1:], reverse=True))


def scatter_of(project: Project) -> Scatter:
    """Return the ensemble that the project's keys `scatter` and `accuracy` ask for."""
    tolerance = accuracy_of(project).tolerance or PRESETS["standard"].tolerance
    assert tolerance is not None
    return Scatter(project.scatter, tolerance)


@dataclass(frozen=True, eq=False)
class Track:
    """The control displacement (k,) m of a member at times (k,) s, and whether the motion ends in collapse."""

    time: Array
    displacement: Array
    collapsed: bool

    @property
    def last(self) -> int:
        """Index of the largest displacement from which the structure came back."""
        return time_history.sustained_peak(self.displacement, self.collapsed)


def agree(one: Track, other: Track, tolerance: float, size: float) -> bool:
    """Whether two members are one motion: both collapse or neither, courses up to the peak within `tolerance` of it."""
    if one.collapsed != other.collapsed:
        return False
    until = min(max(one.time[one.last], other.time[other.last]), one.time[-1], other.time[-1])
    shared = one.time[one.time <= until]
    apart = np.interp(shared, one.time, one.displacement) - np.interp(shared, other.time, other.displacement)
    peak = max(abs(each.displacement[each.last]) for each in (one, other))
    return float(abs(apart).max()) <= max(tolerance * peak, NOISE * size)


def enough(courses: Sequence[Track], scatter: Scatter, size: float) -> bool:
    """Whether the members run so far suffice: their first pair agrees, or all are run."""
    if len(courses) >= scatter.members:
        return True
    return len(courses) == PAIR and agree(courses[0], courses[1], scatter.tolerance, size)


def lowest_median_highest(values: Sequence[float | None]) -> tuple[float | None, float | None, float | None]:
    """Return lowest, median and highest of several values; None, a collapse, counts as higher than any value."""
    counted = [math.inf if value is None else value for value in values]
    low, middle, high = (None if math.isinf(f(counted)) else float(f(counted)) for f in (min, median, max))
    return low, middle, high


PEAK = "peak_displacement_m"


def histories(inputs: time_history.MotionInputs, asked: list[BaseMotion]) -> list[time_history.FoundHistory]:
    """Return every time history that the project asks for, state by state; `asked`: the motions of its tables."""
    accuracy, scatter, states = accuracy_of(inputs.project), scatter_of(inputs.project), inputs.project.states
    tables = zip(inputs.project.history, asked, strict=True)
    tasks = [task for table, motion in tables for task in inputs.tasks(table, motion)]
    tasks.sort(key=lambda task: states.index(task.state))
    studies = [HistoryStudy(task, accuracy.tolerance, scatter) for task in tasks]
    rounds = [[0]]  # halvings of the time step that are run together
    if accuracy.tolerance is not None:
        rounds = [list(range(LEVELS)), *([level] for level in range(LEVELS, accuracy.halvings + 1))]
    for levels in rounds:
        wanted = [study for study in studies if not study.finished]
        _run(inputs, [(study, level, n) for study in wanted for level in levels for n in study.pair])
    _run(inputs, [(study, study.finest, n) for study in studies for n in study.others])
    return [study.result() for study in studies]


def _run(inputs: time_history.MotionInputs, wanted: Sequence[tuple["HistoryStudy", int, int]]) -> None:
    done = inputs.histories([(study.at(level, member),) for study, level, member in wanted])
    for (study, level, member), found in zip(wanted, done, strict=True):
        study.members.setdefault(level, {})[member] = found


@dataclass(frozen=True)
class Refinement:
    """The peak displacement at time steps h, h/2, h/4…: `values` (m), None for a collapse, and `scatter` of each level.

    `least`: a value that is none.
    """

    values: tuple[float | None, ...]
    scatter: tuple[float, ...]
    least: float

    @property
    def collapsed(self) -> bool:
        """Whether the last levels all collapse: there is neither a value nor an error."""
        return all(value is None for value in self.values[-LEVELS:])

    @property
    def scatters(self) -> float | None:
        """Distance of a perturbed pair if it exceeds that of the levels; else None."""
        known, apart = self._known, max(self.scatter[-LEVELS:])
        return apart if known and apart > max(known) - min(known) else None

    @property
    def order(self) -> float | None:
        """The order observed in the last three levels; None if their differences do not shrink as with a method."""
        return observed_order(self.values)

    @property
    def error(self) -> float | None:
        """Estimated error of the finest level; None if not known."""
        if not self._known:
            return None
        _, b, c = self._known
        if self.order is None:
            return max(self._known) - min(self._known)
        return abs(c - b) / (min(2.0**self.order, FIRST_ORDER) - 1.0)

    @property
    def unsure(self) -> float | None:
        """Scatter or error, relative to the value of the finest level."""
        amount = self.error if self.scatters is None else self.scatters
        return None if amount is None else amount / max(abs(self.values[-1] or 0.0), self.least)

    @property
    def _known(self) -> list[float]:
        """The values of the last levels, if there are enough."""
        known = [value for value in self.values[-LEVELS:] if value is not None]
        return known if len(known) == LEVELS else []

    def within(self, tolerance: float) -> bool:
        """Whether scatter or error is within the tolerance."""
        if len(self.values) < LEVELS:
            return False
        return self.collapsed or (self.unsure is not None and self.unsure <= tolerance)

    def finished(self, tolerance: float) -> bool:
        """Whether no finer level is needed."""
        return len(self.values) >= LEVELS and (self.within(tolerance) or self.scatters is not None)

    def row(self, state: str, record: str, tolerance: float) -> ConvergenceRow:
        """Return the row of the results: order, error or scatter, the same relative to the value, and the levels."""
        levels = {PEAK: list(self.values)}
        found = ConvergenceRow(state=state, record=record, met=self.within(tolerance), levels=levels)
        if self.scatters is not None:
            return found.replace(relative_scatter=self.unsure, peak_displacement_scatter_m=self.scatters)
        if self.collapsed:
            return found
        told = {"relative_error": self.unsure, "peak_displacement_error_m": self.error}
        return found.replace(order=self.order, **told)

    def missed(self, title: Message, tolerance: float) -> list[Message]:
        """Return a warning if the tolerance is not met."""
        if self.within(tolerance):
            return []
        if len(self.values) < LEVELS:
            text = message("discretisation error not known")
        elif self.unsure is None:
            text = message("error of {key} not known: not every time step reaches it", key=PEAK)
        elif self.scatters is not None:
            text = message(
                "{key} scatters by {error:.2g} % between records that differ by 1 %, more than between time steps, "
                "tolerance {tolerance:.2g} %; the range tells how sure it is", key=PEAK, error=100.0 * self.unsure,
                tolerance=100.0 * tolerance,
            )  # fmt: skip
        else:
            text = message(
                "estimated error of {key} {error:.2g} % by time steps down to 1/{times} of those given, "
                "tolerance {tolerance:.2g} %; take a smaller {keys}", key=PEAK, error=100.0 * self.unsure,
                times=2 ** (len(self.values) - 1), tolerance=100.0 * tolerance, keys="time_step_s",
            )  # fmt: skip
        return [headed(title, text)]


@dataclass
class HistoryStudy:
    """One history: its members, by halvings of the time step, then by their place among the amplitudes."""

    task: time_history.Shaking
    tolerance: float | None
    scatter: Scatter
    members: dict[int, dict[int, time_history.FoundHistory]] = field(default_factory=dict)

    @property
    def pair(self) -> range:
        """The members that are run first; one if the state at rest was not reached."""
        return range(min(PAIR, self.scatter.members)) if self.task.starts else range(1)

    @property
    def others(self) -> range:
        """The members that are still to be run at the finest time step."""
        first = self.members[self.finest]
        same = enough(_courses(first), self.scatter, self.task.model.size)
        done = not self.task.starts or _failures(first.values()) or same
        return range(0) if done else range(len(first), self.scatter.members)

    @property
    def finest(self) -> int:
        """The halvings of the finest time step before any that fails."""
        sound = 0
        while sound + 1 in self.members and not _failures(self.members[sound + 1].values()):
            sound += 1
        return sound

    @property
    def finished(self) -> bool:
        """Whether no finer time step is needed."""
        if not self.members:
            return False
        if self.tolerance is None or not self.task.starts or self.finest < max(self.members):
            return True
        return self.refinement.finished(self.tolerance)

    @property
    def refinement(self) -> Refinement:
        """The error of the peak from its time steps; the scatter of members that are the same motion is 0."""
        values, apart, size = [], [], self.task.model.size
        for level in range(self.finest + 1):
            one, *more = (self.members[level][n] for n in self.pair)
            values.append(peak(one))
            courses = _courses(self.members[level])[:PAIR]
            same = len(courses) < PAIR or agree(courses[0], courses[1], self.scatter.tolerance, size)
            other = peak(more[0]) if more else None
            apart.append(0.0 if same or other is None or values[-1] is None else abs(other - values[-1]))
        return Refinement(tuple(values), tuple(apart), NOISE * size)

    def at(self, level: int, member: int) -> time_history.Shaking:
        """Return the task of a member at a halved time step; `level`: how often it is halved."""
        amplitude = self.scatter.amplitudes[member]
        return replace(self.task, motion=self.task.motion.halved(level).at_amplitude(amplitude))

    def result(self) -> time_history.FoundHistory:
        """Return the history of the members at the finest time step, with the error estimated from the other steps."""
        title, tolerance = time_history.history_title(self.task), self.tolerance
        found = together(title, list(self.members[self.finest].values()))
        found.seconds = sum(each.seconds for level in self.members.values() for each in level.values())
        if tolerance is None or not self.task.starts or found.numbers.collapsed is None:
            return found
        if self.finest < max(self.members):
            reason = linked(_failures(self.members[self.finest + 1].values()))
            found.warn(title, message("a finer time step fails: {reason}", reason=reason))
        row = self.refinement.row(self.task.state, self.task.motion.name, tolerance)
        found.convergence = row.replace(halvings=self.finest)
        found.warnings += self.refinement.missed(title, tolerance)
        return found


def together(title: Message, members: Sequence[time_history.FoundHistory]) -> time_history.FoundHistory:
    """Return the members of a history as one: the numbers of the worst (a collapse, the earliest), the range of all."""
    finished = [each for each in members if each.numbers.collapsed is not None]
    if not finished or len(members) == 1:
        return members[0]

    def badness(each: time_history.FoundHistory) -> tuple[float, float]:
        found = peak(each)
        return inf if found is None else found, -(each.numbers.time_of_collapse_s or 0.0)

    worst = max(finished, key=badness)
    low, middle, high = lowest_median_highest([peak(each) for each in finished])
    fallen = sum(bool(each.numbers.collapsed) for each in finished)
    value = worst.numbers.replace(
        members=len(finished), members_collapsed=fallen, peak_displacement_m_range=[low, high],
        peak_displacement_median_m=middle, seconds=sum(each.seconds for each in members),
    )  # fmt: skip
    rows = [row for each in members for row in each.quality]
    warnings = list(worst.warnings)
    if len(finished) > PAIR:
        time_s = known(value.curve).time_s
        curves = [np.interp(time_s, one.time, one.displacement) for one in map(_course, finished)]
        value = value.replace(  # one that collapsed keeps its last displacement
            band=Band(low_m=np.min(curves, axis=0).tolist(), high_m=np.max(curves, axis=0).tolist())
        )
        if fallen:
            text = message("{fallen} of {count} records within 1 % of the one given end in collapse, which counts",
                           fallen=fallen, count=len(finished))  # fmt: skip
        else:
            text = message(
                "under {count} records within 1 % of the one given the peak is from {low:.4g} to {high:.4g} m, "
                "median {middle:.4g} m; the largest counts", count=len(finished), low=known(low), high=known(high),
                middle=known(middle),
            )  # fmt: skip
        warnings.append(headed(title, text))
    quality = [joined(worst.state, rows[0].stage, rows)]
    return time_history.FoundHistory(value, warnings, _failures(members), quality, state=worst.state)


def peak(result: time_history.FoundHistory) -> float | None:
    """Return the peak displacement of a history, m; None for a collapse."""
    return None if result.numbers.collapsed else result.numbers.peak_displacement_m


def _course(member: time_history.FoundHistory) -> Track:
    curve = known(member.numbers.curve)
    return Track(np.array(curve.time_s), np.array(curve.displacement_m), bool(member.numbers.collapsed))


def _courses(members: dict[int, time_history.FoundHistory]) -> list[Track]:
    return [_course(each) for each in members.values() if each.numbers.collapsed is not None]


def _failures(members: Iterable[time_history.FoundHistory]) -> list[Message]:
    return [text for each in members for text in each.failures]
