"""The dynamic stages of a run: which motions shake which states, and their place in the results."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.dynamic.histories import histories
from assessment.analyses.dynamic.inputs import MotionInputs, starts_of, ultimates
from assessment.analyses.dynamic.time_history import DynamicResult, motion_part
from assessment.project.motions import (
    BaseMotion,
    campaign_motions,
    history_motions,
    incremental_motions,
    records_of,
)
from assessment.project.record_set import check_record_set, doubtful_records, doubtful_units
from assessment.studies.campaign.incremental import incremental
from assessment.studies.campaign.scans import Scans
from mechanics.messages import Message

if TYPE_CHECKING:
    from assessment.analyses.static.states import StateResult
    from assessment.project.project import Project
    from assessment.project.structure.state_models import StateModel
    from assessment.results.schema.dynamic import History
    from assessment.workflow.draft import Draft
    from mechanics.records import Record

PERIODS = np.linspace(0.0, 4.0, 201)  # s


@dataclass(frozen=True)
class Motions:
    """The base motions of [[history]], [incremental] and the files of [campaign], read before anything is analysed.

    `records`: every file that was read, once and as it is.
    """

    history: list[BaseMotion]
    incremental: list[BaseMotion]
    campaign: list[BaseMotion]
    records: list[Record]

    @property
    def notes(self) -> list[Message]:
        """What the user should know about the records."""
        notes = [
            note for motion in (*self.history, *self.incremental, *self.campaign) for note in motion.notes
        ]
        doubted = doubtful_records(self.campaign)
        told = {motion.name for motion in self.campaign}
        return [
            *notes,
            *doubted,
            *doubtful_units([record for record in self.records if record.name not in told]),
        ]


def read_motions(project: Project) -> Motions:
    """Read every record that the project names.

    Raises ProjectError or ValueError naming file, line or key.
    """
    found = Motions(
        history_motions(project), incremental_motions(project), campaign_motions(project), records_of(project)
    )
    check_record_set(project, found.campaign)
    return found


def add_dynamics(
    draft: Draft,
    project: Project,
    models: Mapping[str, StateModel],
    motions: Motions,
    stages: Iterable[StateResult],
    scans: Scans,
) -> bool:
    """Compute [[history]] and [incremental] from the states that `stages` reached, and add them to the results.

    Return whether every analysis was completed. Raises KilledError where a process was ended from outside.
    """
    starts = starts_of(project.dynamic_contacts, models, stages)
    pushovers = {name: state.pushover for name, state in draft.states.items()}
    inputs = MotionInputs(project, starts, ultimates(pushovers), scans.workers)
    complete = True
    if project.history:
        draft.put(motions=[motion_part(motion, PERIODS) for motion in motions.history])
        complete = _add_histories(draft, histories(inputs, motions.history))
    if project.incremental:
        found = incremental(inputs, motions.incremental, scans)
        draft.take(found.warnings, found.failures, found.quality)
        draft.took("incremental", found.seconds)
        draft.search_errors += found.errors
        for state, part in found.states.items():
            draft.put_state(state, incremental=part)
        complete = complete and not found.failures
    return complete


def _add_histories(draft: Draft, found: Iterable[DynamicResult[History]]) -> bool:
    """Add time histories to their states; return whether all were completed."""
    complete = True
    for each in found:
        complete = _take(draft, each) and complete
        draft.put_state(each.state, history=[*draft.states[each.state].history, each.numbers])
        if each.convergence is not None:
            draft.errors.append(each.convergence)
    return complete


def _take(draft: Draft, stage: DynamicResult[Any]) -> bool:
    """Add messages, certificates and time of a dynamic analysis; return whether it was completed."""
    draft.take(stage.warnings, stage.failures, stage.quality)
    draft.took(stage.stage, stage.seconds)
    return not stage.failures
