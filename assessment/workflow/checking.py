"""What a project holds, read and validated without any analysis beyond self-weight: for `assesto check` and the app."""

from __future__ import annotations

from dataclasses import dataclass

from assessment.analyses.checks.chosen_mechanism import refused_as_drawn
from assessment.analyses.checks.demand import Demands, demand_spectra
from assessment.analyses.static.lateral import with_control
from assessment.analyses.static.paths import pressed_in, stand
from assessment.project.plausibility import implausible_hazard
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL
from assessment.project.structure.model import ProjectModel, build_model
from assessment.results.schema import Results
from assessment.workflow.description import describe
from assessment.workflow.motions import Motions, read_motions


@dataclass(frozen=True, eq=False)
class Checked:
    """A project that a run would accept: its model, records and demand, and the results before any analysis.

    `results.model.self_weight_stable`: whether the structure as drawn stands; `warnings`: everything to be told.
    """

    project: Project
    model: ProjectModel
    motions: Motions
    demands: Demands
    results: Results
    warnings: tuple[str, ...]


def checked(project: Project, model: ProjectModel | None = None) -> Checked:
    """Read every file that a run of the project reads, and refuse what it would refuse.

    `model`: that of the project where it is built already.

    Raises FaultyDrawingError with all faults of a drawing that is no assembly, ProjectError, DrawingError, RecordError
    or ValueError naming file and key for everything else, OSError for a file that cannot be read.
    """
    model = model or build_model(project)
    followed, chosen = with_control(project, model.assembly)
    results, motions = describe(followed, model), read_motions(project)
    demands = demand_spectra(project, motions.history) if project.assessment else Demands()
    warnings: list[str] = [
        *results.model.warnings,
        *chosen,
        *motions.notes,
        *implausible_hazard(project, demands.spectra),
        *refused_as_drawn(project, model.states[ORIGINAL]),
    ]
    if unstable := stand(model.assembly):
        results = results.replace(model=results.model.replace(self_weight_stable=False))
        warnings.append(unstable)
    else:
        warnings += pressed_in(model.assembly)
    return Checked(project, model, motions, demands, results, tuple(warnings))
