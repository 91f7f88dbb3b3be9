"""The studies of a run, scenarios and sensitivity, and their place in the results."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from assessment.scenarios import asks_for_scenarios, scenarios
from assessment.sensitivity import sensitivity
from assessment.stages import StateResult
from assessment.study import Demands, Numbers, Study

if TYPE_CHECKING:
    from assessment.hazard import HazardCurve
    from assessment.project import Project
    from assessment.spectrum import Spectrum
    from mechanics import Assembly

FEW = 3  # warnings of a study that are repeated among those of the run
WORST = ("worst_equilibrium_residual", "worst_penetration_m", "worst_complementarity", "worst_cone_violation")


def add_studies(
    results: Numbers,
    project: Project,
    model: Assembly,
    stages: Sequence[StateResult],
    halvings: Mapping[str, int],
    spectra: Mapping[str, Spectrum],
    hazard: HazardCurve | None,
    jobs: int,
    progress: Callable[[str], None],
) -> bool:
    """Set the scenarios side by side and vary the properties, where asked for; return whether all was completed.

    `halvings`: of each state's increments behind `stages`; the studies of a state take the same.
    """
    demands = Demands(spectra, hazard)
    made: dict[str, Callable[[Study], Numbers]] = {}
    if asks_for_scenarios(project):
        made["scenarios"] = lambda study: scenarios(
            project, model, results["states"], stages, halvings, demands, jobs, progress, study
        )
    if project.sensitivity:
        made["sensitivity"] = lambda study: sensitivity(project, halvings, demands, jobs, progress, study)
    complete = True
    for name, make in made.items():
        began, study = time.perf_counter(), Study()
        results[name] = make(study)
        results["timing_s"][name] = time.perf_counter() - began
        results[name]["warnings"] = study.warnings
        results["quality"]["warnings"] += [*_in_short(name, study.warnings), *study.findings, *study.failures]
        if study.quality:
            results["quality"]["by_stage"].append(_worst(name, study.quality))
        complete = complete and not study.failures
    return complete


def _in_short(name: str, warnings: Sequence[str]) -> list[str]:
    """Return warnings one by one if they are few; the runs of a study repeat those of the states they vary."""
    if len(warnings) <= FEW:
        return list(warnings)
    return [f"{name}: {len(warnings)} warnings of single runs, in results.json; the first: {warnings[0]}"]


def _worst(stage: str, rows: Sequence[Mapping[str, Any]]) -> Numbers:
    """Return one row of quality for all programs of a study."""
    numbers = {key: max(row[key] for row in rows) for key in WORST}
    return {"state": None, "stage": stage, "solves": sum(row["solves"] for row in rows)} | numbers
