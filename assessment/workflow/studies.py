"""The studies of a run, scenarios, sensitivity and campaign, and their place in the results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from assessment.analyses.static.states import joined_quality
from assessment.studies.campaign.stage import campaign
from assessment.studies.scenarios import asks_for_scenarios, scenarios
from assessment.studies.sensitivity import sensitivity
from assessment.studies.variants import Numbers, Statics, Study

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly

FEW = 3  # warnings of a study that are repeated among those of the run


def add_studies(
    results: Numbers,
    project: Project,
    model: Assembly,
    statics: Statics,
    demands: Demands,
    records: Sequence[BaseMotion],
    workers: Workers,
) -> bool:
    """Set the scenarios side by side, vary the properties, run the campaign, where asked for.

    Returns whether all was completed. `records`: of the files that [campaign] names.
    """
    made: dict[str, Callable[[Study], Numbers]] = {}
    if asks_for_scenarios(project):
        made["scenarios"] = lambda study: scenarios(project, model, statics, demands, workers, study)
    if project.sensitivity:
        made["sensitivity"] = lambda study: sensitivity(project, statics.halvings, demands, workers, study)
    if project.campaign:
        made["campaign"] = lambda study: campaign(project, model, records, statics, demands, workers, study)
    complete = True
    for name, make in made.items():
        study = Study()
        results[name] = make(study)
        results["timing_s"][name] = study.seconds
        results[name]["warnings"] = study.warnings
        results["quality"]["warnings"] += [
            *_in_short(name, study.warnings),
            *study.findings,
            *_in_short(name, study.failures, "failures"),
        ]
        if study.quality:
            results["quality"]["by_stage"].append(joined_quality(None, name, study.quality))
        complete = complete and not study.failures
    return complete


def _in_short(name: str, told: Sequence[str], what: str = "warnings") -> list[str]:
    """Return messages one by one if they are few; the runs of a study repeat those of the states they vary."""
    if len(told) <= FEW:
        return list(told)
    return [f"{name}: {len(told)} {what} of single runs, in results.json; the first: {told[0]}"]
