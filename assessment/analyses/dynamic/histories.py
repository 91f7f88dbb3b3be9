"""Every time history that a project asks for: at which time steps, and by how many members of an ensemble.

a first pair of members at the time step given, and at a half and a quarter of it where the project has an accuracy
finer ones until the peak is as accurate, or scatters more than the time steps differ
all other members at the finest time step, where the pair is not the same motion
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.accuracy import LEVELS, NOISE, Accuracy, accuracy_of
from assessment.analyses.dynamic.ensemble import (
    PAIR,
    Course,
    Scatter,
    agree,
    enough,
    lowest_median_highest,
    scatter_of,
)
from assessment.analyses.dynamic.inputs import MotionInputs
from assessment.analyses.dynamic.refinement import Refinement
from assessment.analyses.dynamic.time_history import DynamicResult, Shaking, history, history_title
from assessment.results.quality import joined
from assessment.results.schema.dynamic import Band, History
from assessment.results.schema.part import known
from mechanics.messages import Message, headed, linked, message

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion
    from mechanics.types import Array


def histories(inputs: MotionInputs, motions: list[BaseMotion]) -> list[DynamicResult[History]]:
    """Return every time history that the project asks for, in the order of their tasks."""
    accuracy, scatter = accuracy_of(inputs.project), scatter_of(inputs.project)
    studies = [Study(task, accuracy, scatter) for task in history_tasks(inputs, motions)]
    for levels in rounds(accuracy):
        wanted = [study for study in studies if not study.finished]
        _run(inputs, [(study, level, n) for study in wanted for level in levels for n in study.pair])
    _run(inputs, [(study, study.finest, n) for study in studies for n in study.others])
    return [study.result() for study in studies]


def history_tasks(inputs: MotionInputs, motions: list[BaseMotion]) -> list[Shaking]:
    """Return the tasks of all time histories, state by state."""
    by_table = [
        inputs.tasks(table, [motion]) for table, motion in zip(inputs.project.history, motions, strict=True)
    ]
    states = inputs.project.states
    return sorted((task for tasks in by_table for task in tasks), key=lambda task: states.index(task.state))


def rounds(accuracy: Accuracy) -> list[list[int]]:
    """Return the halvings of the time step that are run together: three levels first, then one at a time."""
    if accuracy.tolerance is None:
        return [[0]]
    return [list(range(LEVELS)), *([level] for level in range(LEVELS, accuracy.halvings + 1))]


@dataclass
class Study:
    """One history: its members, by halvings of the time step, then by their place among the amplitudes."""

    task: Shaking
    accuracy: Accuracy
    scatter: Scatter
    members: dict[int, dict[int, DynamicResult[History]]] = field(default_factory=dict)

    @property
    def pair(self) -> range:
        """The members that are run first; one if the state at rest was not reached."""
        return range(min(PAIR, self.scatter.members)) if self._starts else range(1)

    @property
    def others(self) -> range:
        """The members that are still to be run at the finest time step."""
        first = self.members[self.finest]
        if (
            not self._starts
            or _failures(first)
            or enough(_courses(first), self.scatter, self.task.model.size)
        ):
            return range(0)
        return range(len(first), self.scatter.members)

    @property
    def finest(self) -> int:
        """The halvings of the finest time step before any that fails."""
        sound = 0
        while sound + 1 in self.members and not _failures(self.members[sound + 1]):
            sound += 1
        return sound

    @property
    def finished(self) -> bool:
        """Whether no finer time step is needed."""
        if not self.members:
            return False
        tolerance, deepest = self.accuracy.tolerance, max(self.members)
        if tolerance is None or not self._starts or self.finest < deepest:
            return True
        return self.refinement.finished(tolerance)

    @property
    def refinement(self) -> Refinement:
        """The error of the peak from its time steps; the scatter of members that are the same motion is 0."""
        values, apart = [], []
        for level in range(self.finest + 1):
            one, *more = (self.members[level][n] for n in self.pair)
            values.append(peak(one))
            courses = _courses(self.members[level])[:PAIR]
            same = len(courses) < PAIR or agree(
                courses[0], courses[1], self.scatter.tolerance, self.task.model.size
            )
            other = peak(more[0]) if more else None
            apart.append(0.0 if same or other is None or values[-1] is None else abs(other - values[-1]))
        return Refinement(tuple(values), tuple(apart), NOISE * self.task.model.size)

    def at(self, level: int, member: int) -> Shaking:
        """Return the task of a member at a halved time step; `level`: how often it is halved."""
        motion = self.task.motion
        for _ in range(level):
            motion = motion.at_half_step()
        return replace(self.task, motion=motion.at_amplitude(self.scatter.amplitudes[member]))

    def result(self) -> DynamicResult[History]:
        """Return the history of the members at the finest time step, with the error estimated from the other steps."""
        state, record = self.task.state, self.task.motion.name
        title = history_title(self.task)
        found = together(title, list(self.members[self.finest].values()))
        found.seconds = sum(each.seconds for level in self.members.values() for each in level.values())
        tolerance = self.accuracy.tolerance
        if tolerance is None or not self._starts or found.numbers.collapsed is None:
            return found
        if self.finest < max(self.members):
            reason = linked(_failures(self.members[self.finest + 1]))
            found.warnings.append(headed(title, message("a finer time step fails: {reason}", reason=reason)))
        found.convergence = self.refinement.row(state, record, tolerance).replace(halvings=self.finest)
        found.warnings += self.refinement.missed(title, tolerance)
        return found

    @property
    def _starts(self) -> bool:
        return not isinstance(self.task.start, str)


def _run(inputs: MotionInputs, wanted: Sequence[tuple[Study, int, int]]) -> None:
    """Run members of studies side by side."""
    tasks = [(study.at(level, member),) for study, level, member in wanted]
    for (study, level, member), found in zip(wanted, inputs.each("history", history, tasks, 1), strict=True):
        study.members.setdefault(level, {})[member] = found


def together(title: Message, members: Sequence[DynamicResult[History]]) -> DynamicResult[History]:
    """Return the members of a history as one result: the numbers of the worst member, and the range of all.

    A collapse is worse than any peak, an earlier collapse worse than a later one.
    """
    finished = [each for each in members if each.numbers.collapsed is not None]
    if not finished or len(members) == 1:
        return members[0]
    worst = max(finished, key=_suffering)
    low, middle, high = lowest_median_highest([peak(each) for each in finished])
    fallen = sum(bool(each.numbers.collapsed) for each in finished)
    found = worst.numbers.replace(
        members=len(finished),
        members_collapsed=fallen,
        peak_displacement_m_range=[low, high],
        peak_displacement_median_m=middle,
        seconds=sum(each.seconds for each in members),
    )
    rows = [row for each in members for row in each.quality]
    warnings = list(worst.warnings)
    if len(finished) > PAIR:
        found = found.replace(band=band(finished, np.array(known(found.curve).time_s)))
        warnings.append(headed(title, _scattered(len(finished), fallen, low, middle, high)))
    return DynamicResult(
        worst.state,
        worst.stage,
        found,
        [joined(worst.state, rows[0].stage, rows)],
        warnings,
        [text for each in members for text in each.failures],
    )


def band(members: Sequence[DynamicResult[History]], time: Array) -> Band:
    """Return the least and largest control displacement of all members, m, at times (k,) s.

    A member that collapsed keeps its last displacement.
    """
    each = [np.interp(time, one.time, one.displacement) for one in map(_course, members)]
    return Band(low_m=np.min(each, axis=0).tolist(), high_m=np.max(each, axis=0).tolist())


def peak(result: DynamicResult[History]) -> float | None:
    """Return the peak displacement of a history, m; None for a collapse."""
    return None if result.numbers.collapsed else result.numbers.peak_displacement_m


def _suffering(member: DynamicResult[History]) -> tuple[bool, float]:
    """Return what members are ordered by, the worst last: collapses after all peaks, the earliest last."""
    numbers = member.numbers
    if numbers.collapsed:
        return True, -known(numbers.time_of_collapse_s)
    return False, known(numbers.peak_displacement_m)


def _scattered(
    count: int, fallen: int, low: float | None, middle: float | None, high: float | None
) -> Message:
    if fallen:
        return message(
            "{fallen} of {count} records within 1 % of the one given end in collapse, which counts",
            fallen=fallen,
            count=count,
        )
    return message(
        "under {count} records within 1 % of the one given the peak is from {low:.4g} to {high:.4g} m, "
        "median {middle:.4g} m; the largest counts",
        count=count,
        low=known(low),
        high=known(high),
        middle=known(middle),
    )


def _course(member: DynamicResult[History]) -> Course:
    curve = known(member.numbers.curve)
    return Course(np.array(curve.time_s), np.array(curve.displacement_m), bool(member.numbers.collapsed))


def _courses(members: dict[int, DynamicResult[History]]) -> list[Course]:
    return [_course(each) for each in members.values() if each.numbers.collapsed is not None]


def _failures(members: dict[int, DynamicResult[History]]) -> list[Message]:
    return [text for each in members.values() for text in each.failures]
