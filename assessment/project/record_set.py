"""Checks of records before any analysis: names, duplicates, units and lengths."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from assessment.runtime.errors import ProjectError
from mechanics.faults import visible
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from mechanics.records import Record

STRONGEST, WEAKEST = 2.0, 0.005  # g: beyond them the unit is probably another one
COARSEST = 0.05  # s: frequencies above 10 Hz, which records have, would be lost
SHORTEST = 5.0  # s
CUT = 0.2  # of the PGA: a record that begins or ends with more was cut off
SAME = 1e-4  # of the PGA: closer than this two records are one


def check_record_set(project: Project, motions: Sequence[BaseMotion]) -> None:
    """Raise ProjectError where two records of [campaign] have one name, or are one motion."""
    for one, other in combinations(motions, 2):
        if one.name == other.name:
            text = (
                f'two records are called "{one.name}"; rename a file, tables tell them apart by their names'
            )
            raise ProjectError(f"{project.source}: campaign.records: {text}")
        if _alike(one.original, other.original):
            text = f"{one.name} and {other.name} are the same motion; keep one, or both count as two records"
            raise ProjectError(f"{project.source}: campaign.records: {text}")


def doubtful_records(motions: Sequence[BaseMotion]) -> list[Message]:
    """Return a warning for each record whose unit or length is implausible."""
    return [
        message("campaign, {record}: {text}", record=motion.name, text=doubt)
        for motion in motions
        for doubt in _doubts(motion.original)
    ]


def doubtful_units(records: Sequence[Record]) -> list[Message]:
    """Return a warning for each unit, of accelerations or times, in which a record is implausible."""
    return [headed(visible(record.name), doubt) for record in records for doubt in _doubtful_units(record)]


def _doubtful_units(record: Record) -> Iterator[Message]:
    if not WEAKEST < record.pga < STRONGEST:
        yield message(
            "a PGA of {pga:.3g} g, read in {unit}; check the unit of the file, and name it in its heading",
            pga=record.pga,
            unit=record.unit,
        )
    if record.time_step > COARSEST:
        yield message(
            "a time step of {step:.3g} s; check the unit of the times, and name it in the heading",
            step=record.time_step,
        )


def _doubts(record: Record) -> Iterator[Message]:
    yield from _doubtful_units(record)
    if record.duration < SHORTEST:
        yield message("lasts {duration:.3g} s; check that the record is whole", duration=record.duration)
    elif max(abs(record.acceleration[[0, -1]])) > CUT * record.pga:
        yield message("begins or ends with strong motion; check that the record is whole")


def _alike(one: Record, other: Record) -> bool:
    """Whether two records are the same samples but for a factor, of either sign."""
    if one.acceleration.size != other.acceleration.size or one.time_step != other.time_step:
        return False
    a, b = (each.acceleration / each.pga for each in (one, other))
    return bool(min(np.abs(a - b).max(), np.abs(a + b).max()) < SAME)
