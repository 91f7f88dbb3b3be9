"""The studies of a run, scenarios, sensitivity, identification and campaign, and their place in the results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from assessment.project.schema import ORIGINAL
from assessment.results.quality import joined
from assessment.studies.campaign.scans import Scans
from assessment.studies.campaign.stage import campaign
from assessment.studies.identification.stage import identification
from assessment.studies.scenarios import asks_for_scenarios, scenarios
from assessment.studies.sensitivity import sensitivity
from assessment.studies.variants import Statics, Study
from mechanics.messages import Message, message

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.structure.state_models import StateModel
    from assessment.results.schema.campaign import Campaign
    from assessment.results.schema.identification import Identification
    from assessment.results.schema.studies import Scenarios, Sensitivity
    from assessment.workflow.draft import Draft

FEW = 3  # warnings of a study that are repeated among those of the run


def add_studies(
    draft: Draft,
    project: Project,
    states: Mapping[str, StateModel],
    statics: Statics,
    demands: Demands,
    records: Sequence[BaseMotion],
    scans: Scans,
) -> bool:
    """Fit movements, compare scenarios, vary properties and run the campaign, each where asked for; add the results.

    `records`: of the files that [campaign] names. Return whether all was completed. Raises KilledError where a process
    was ended from outside, ProjectError for a property that gives no model.
    """
    workers = scans.workers
    made: dict[str, Callable[[Study], Scenarios | Sensitivity | Identification | Campaign]] = {}
    if project.identification:
        made["identification"] = lambda study: identification(
            project, states[ORIGINAL].settling, workers, study
        )
    if asks_for_scenarios(project):
        made["scenarios"] = lambda study: scenarios(project, states, statics, demands, workers, study)
    if project.sensitivity:
        made["sensitivity"] = lambda study: sensitivity(project, statics.halvings, demands, workers, study)
    if project.campaign:
        made["campaign"] = lambda study: campaign(project, states, records, statics, demands, scans, study)
    complete = True
    for name, make in made.items():
        study = Study()
        draft.put(**{name: make(study)})
        draft.took(name, study.seconds)
        draft.warnings += _in_short(name, study)
        if study.quality:
            draft.quality.append(joined(None, name, study.quality))
        complete = complete and not study.failures
    return complete


def _in_short(name: str, study: Study) -> list[Message]:
    """Return up to FEW warnings and failures as they are, more as their number: they repeat those of the states."""
    warnings, failures = study.warnings, study.failures
    if len(warnings) > FEW:
        warnings = [
            message(
                "{study}: {count} warnings of single runs, in results.json; the first: {text}",
                study=name,
                count=len(warnings),
                text=warnings[0],
            )
        ]
    if len(failures) > FEW:
        failures = [
            message(
                "{study}: {count} failures of single runs, in results.json; the first: {text}",
                study=name,
                count=len(failures),
                text=failures[0],
            )
        ]
    return [*warnings, *study.findings, *failures]
