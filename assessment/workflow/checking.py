"""What a run reads before anything is analysed: model, records, demand; for `assesto check` and the app its verdict."""

from __future__ import annotations

from dataclasses import dataclass, replace

from assessment.analyses.checks.chosen_mechanism import refused_as_drawn
from assessment.analyses.checks.demand import Demands, demand_spectra
from assessment.analyses.static.lateral import with_control
from assessment.analyses.static.paths import pressed_in, stand
from assessment.project import motions as base
from assessment.project.plausibility import implausible_hazard
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL
from assessment.project.structure.model import ProjectModel, build_model
from assessment.results.schema import Results
from assessment.workflow.description import describe
from mechanics.messages import Message
from mechanics.records import Record


@dataclass(frozen=True)
class Motions:
    """The base motions of [[history]], [incremental] and the files of [campaign]; `records`: every file, as it is."""

    history: list[base.BaseMotion]
    incremental: list[base.BaseMotion]
    campaign: list[base.BaseMotion]
    records: list[Record]

    @property
    def notes(self) -> list[Message]:
        """What the user should know about the records."""
        every = (*self.history, *self.incremental, *self.campaign)
        told = {motion.name for motion in self.campaign}
        others = [record for record in self.records if record.name not in told]
        notes = (note for motion in every for note in motion.notes)
        return [*notes, *base.doubtful_records(self.campaign), *base.doubtful_units(others)]


@dataclass(frozen=True, eq=False)
class Checked:
    """A project that a run would accept: its model, records and demand, and the results before any analysis.

    `results.model.self_weight_stable`: whether the structure as drawn stands; `notes`: what is to be told of the files;
    `warnings`: of all that was checked.
    """

    project: Project
    model: ProjectModel
    motions: Motions
    demands: Demands
    results: Results
    notes: tuple[Message, ...]
    warnings: tuple[str, ...] = ()


def read_motions(project: Project) -> Motions:
    """Read every record that the project names. Raises ProjectError or ValueError naming file, line or key."""
    found = Motions(
        base.history_motions(project),
        base.incremental_motions(project),
        base.campaign_motions(project),
        base.records_of(project),
    )
    base.check_record_set(project, found.campaign)
    return found


def read_inputs(project: Project, model: ProjectModel) -> Checked:
    """Read every file that a run reads, and choose the control points; self-weight is not looked at.

    Raises ProjectError, RecordError or ValueError naming file and key, OSError for a file that cannot be read.
    """
    project, chosen = with_control(project, model.assembly)
    motions = read_motions(project)
    demands = demand_spectra(project, motions.history) if project.assessment else Demands()
    notes = (*chosen, *motions.notes, *implausible_hazard(project, demands.spectra))
    return Checked(project, model, motions, demands, describe(project, model), notes)


def checked(project: Project, model: ProjectModel | None = None) -> Checked:
    """Read every file that a run of the project reads, and refuse what it would refuse.

    `model`: that of the project where it is built already. Raises as `read_inputs`, and FaultyDrawingError with all
    faults of a drawing that is no assembly.
    """
    found = read_inputs(project, model := model or build_model(project))
    results, refused = found.results, refused_as_drawn(project, model.states[ORIGINAL])
    if unstable := stand(model.assembly):
        results = results.replace(model=results.model.replace(self_weight_stable=False))
    more = [unstable] if unstable else pressed_in(model.assembly)
    warnings = (*results.model.warnings, *found.notes, *refused, *more)
    return replace(found, project=project, results=results, warnings=warnings)
