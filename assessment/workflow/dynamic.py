"""The dynamic stages of a run: which motions start from which states, and their place in the results."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.dynamic.errors import Estimates, collapses_again
from assessment.analyses.dynamic.histories import histories
from assessment.analyses.dynamic.incremental import searches, summarise
from assessment.analyses.dynamic.inputs import Campaign, starts_of, ultimates
from assessment.analyses.dynamic.time_history import StageResult, motion_numbers
from assessment.project.motions import (
    BaseMotion,
    campaign_motions,
    history_motions,
    incremental_motions,
)
from assessment.project.record_set import check_record_set, doubtful_records

if TYPE_CHECKING:
    from assessment.analyses.static.states import StateResult
    from assessment.project.project import Project
    from assessment.results.schema.dynamic import History, Search
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly
    from mechanics.model import Behaviour

Results = dict[str, Any]
PERIODS = np.linspace(0.0, 4.0, 201)  # s


@dataclass(frozen=True)
class Motions:
    """The base motions of [[history]], [incremental] and the files of [campaign], read before anything is analysed."""

    history: list[BaseMotion]
    incremental: list[BaseMotion]
    campaign: list[BaseMotion]

    @property
    def notes(self) -> list[str]:
        """What the user should know about the records."""
        told = [
            note for motion in (*self.history, *self.incremental, *self.campaign) for note in motion.notes
        ]
        return [*told, *doubtful_records(self.campaign)]


def read_motions(project: Project) -> Motions:
    """Read every record that the project names.

    Raises ProjectError or ValueError naming file, line or key.
    """
    found = Motions(history_motions(project), incremental_motions(project), campaign_motions(project))
    check_record_set(project, found.campaign)
    return found


def dynamic_contacts(project: Project) -> list[Behaviour]:
    """Return the contact behaviours of the dynamic stages; each needs its own settled state."""
    tables = [*project.history, project.incremental, project.campaign]
    return list(dict.fromkeys(table.contacts for table in tables if table))


def add_dynamics(
    results: Results,
    project: Project,
    model: Assembly,
    motions: Motions,
    stages: Iterable[StateResult],
    workers: Workers,
) -> bool:
    """Compute [[history]] and [incremental] from the states that `stages` reached and add them to `results`.

    Return whether every analysis was completed.
    """
    starts = starts_of(dynamic_contacts(project), model, stages)
    campaign = Campaign(project, model, starts, ultimates(results["states"]), workers)
    warnings = results["quality"]["warnings"]
    complete = True

    def take(stage: StageResult[History] | StageResult[Search]) -> None:
        nonlocal complete
        warnings.extend([*stage.warnings, *stage.failures])
        results["quality"]["by_stage"] += stage.quality
        results["timing_s"][stage.stage] = results["timing_s"].get(stage.stage, 0.0) + stage.seconds
        complete = complete and not stage.failures

    if project.history:
        results["motions"] = [motion_numbers(motion, PERIODS) for motion in motions.history]
        for shaken in histories(campaign, motions.history):
            take(shaken)
            results["states"][shaken.state]["history"].append(shaken.numbers)
            if shaken.convergence is not None:
                results["convergence"]["rows"].append(shaken.convergence)
    if project.incremental:
        found: dict[str, list[Search]] = {}
        searched = searches(campaign, motions.incremental)
        for stage in searched:
            take(stage)
            found.setdefault(stage.state, []).append(stage.numbers)
        for state, records in found.items():
            results["states"][state]["incremental"] = summarise(records, warnings, state)
        _tell(results, "incremental", collapses_again(campaign, motions.incremental, searched))
    return complete


def _tell(results: Results, study: str, found: Estimates) -> None:
    """Add the rows of a study of errors to the results; nothing where there are none."""
    if found.rows:
        results["convergence"].setdefault(study, []).extend(found.rows)
        results["quality"]["warnings"] += found.warnings
        name = f"{study} error"
        results["timing_s"][name] = results["timing_s"].get(name, 0.0) + found.seconds
