"""Small ensembles: a motion is repeated under the same record, a little weaker and a little stronger.

A motion with many impacts or slides depends on the last digits of its record: single runs do not converge, their
distribution does. If the first two members agree, the motion is not of this kind and no other member is run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.accuracy import NOISE, PRESETS, accuracy_of
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.project import Project

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
class Course:
    """The control displacement (k,) m of a member at times (k,) s, and whether the motion ends in collapse."""

    time: Array
    displacement: Array
    collapsed: bool

    @property
    def last(self) -> int:
        """Index of the largest displacement from which the structure came back."""
        return sustained_peak(self.displacement, self.collapsed)


def sustained_peak(displacement: Array, collapsed: bool) -> int:
    """Return the index of the largest displacement (k,); at a collapse only those before the last way outward count."""
    if collapsed:
        turns = np.flatnonzero(np.diff(np.sign(np.diff(displacement)))) + 1
        displacement = displacement[: turns[-1] + 1] if turns.size else displacement[:1]
    return int(np.argmax(abs(displacement)))


def agree(one: Course, other: Course, tolerance: float, size: float) -> bool:
    """Whether two members are the same motion: both collapse or neither, and their courses agree up to the peak.

    `tolerance`: of their distance at any time, relative to the peak; `size` (m): of the model. Equal peaks alone might
    be a coincidence.
    """
    if one.collapsed != other.collapsed:
        return False
    until = min(max(one.time[one.last], other.time[other.last]), one.time[-1], other.time[-1])
    shared = one.time[one.time <= until]
    apart = np.interp(shared, one.time, one.displacement) - np.interp(shared, other.time, other.displacement)
    peak = max(abs(each.displacement[each.last]) for each in (one, other))
    return float(abs(apart).max()) <= max(tolerance * peak, NOISE * size)


def enough(courses: Sequence[Course], scatter: Scatter, size: float) -> bool:
    """Whether the members run so far suffice: their first pair agrees, or all are run."""
    if len(courses) >= scatter.members:
        return True
    return len(courses) == PAIR and agree(courses[0], courses[1], scatter.tolerance, size)


def lowest_median_highest(
    values: Sequence[float | None],
) -> tuple[float | None, float | None, float | None]:
    """Return lowest, median and highest of several values; None, a collapse, counts as higher than any value."""
    counted = [math.inf if value is None else value for value in values]
    low, middle, high = (None if math.isinf(f(counted)) else float(f(counted)) for f in (min, median, max))
    return low, middle, high
