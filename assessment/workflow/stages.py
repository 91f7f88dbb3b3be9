"""Which stages a project needs, in what order, and what they leave behind."""

import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from assessment.analyses import demand
from assessment.analyses.capacity import Assessed, assess
from assessment.analyses.chosen_mechanism import assess_chosen
from assessment.analyses.found import Found, as_part, joined, quality_of, refined
from assessment.analyses.governing import Run, governed, members
from assessment.analyses.histories import histories
from assessment.analyses.lateral import rests_or_moves, second_solver
from assessment.analyses.paths import pressed_in, stand
from assessment.analyses.states import Request, StateResult, analyse_states
from assessment.analyses.time_history import MotionInputs, motion_part, starts_of
from assessment.ntc.tables import confidence_factor
from assessment.project.model import ProjectModel, StateModel
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL
from assessment.report.chapters.judgement import told
from assessment.results.schema import (
    Direction,
    Knowledge,
    Pushovers,
    QualityRow,
    Results,
    StateResults,
    present,
)
from assessment.results.schema.studies import ConvergenceRow
from assessment.results.summary import summary_of, without
from assessment.results.table import comparison
from assessment.runtime.cache import Store
from assessment.runtime.progress import Show
from assessment.runtime.tasks import Outcome, Workers
from assessment.studies.campaign import campaign
from assessment.studies.convergence import Converged, converge
from assessment.studies.identification import identification
from assessment.studies.scans import Scans
from assessment.studies.searches import incremental
from assessment.studies.variants import Statics, Study, asks_for_scenarios, scenarios, sensitivity
from assessment.workflow.checking import Checked, read_inputs
from mechanics import Assembly, State
from mechanics.messages import Message, message

PERIODS = np.linspace(0.0, 4.0, 201)  # s, of the spectra of motions
Ensembles = Mapping[str, Sequence[Run]]
FEW = 3  # warnings of a study that are repeated among those of the run


def run(
    project: Project, model: ProjectModel, jobs: int = 0, store: Store | None = None, fresh: bool = False,
    show: Show | None = None, scheduler: str | None = None,
) -> Outcome:  # fmt: skip
    """Carry out every stage that the project asks for; for the other arguments see Workers.

    Raises ProjectError or ValueError for records and hazard that cannot be read, KilledError for a killed process,
    and pydantic's ValidationError for results that are not as the schema says (a fault of the program).
    """
    with Workers(jobs, store, fresh, show or Show(), scheduler=scheduler) as workers:
        read = read_inputs(project, model)
        draft = Draft(read, workers, read.results, [*read.notes])
        _carry_out(draft)
        results = draft.finished()
    if store:
        store.prune()
    return Outcome(results, draft.complete, workers.computed, workers.taken, told(results))


@dataclass
class Draft:
    """The results of a run while its stages add to them; `finished` returns them."""

    read: Checked
    workers: Workers
    results: Results
    warnings: list[Message]
    quality: list[QualityRow] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)  # by stage
    errors: list[ConvergenceRow] = field(default_factory=list)  # estimated, of paths
    search_errors: list[ConvergenceRow] = field(default_factory=list)  # estimated, of searches
    complete: bool = True  # whether all analyses asked for were

    @property
    def project(self) -> Project:
        """The project, its control points chosen."""
        return self.read.project

    @property
    def models(self) -> Mapping[str, StateModel]:
        """The assembly of every state."""
        return self.read.model.states

    @property
    def states(self) -> dict[str, StateResults]:
        """Every state of the project by name, as far as it was analysed."""
        return self.results.states

    def put(self, **parts: Any) -> None:
        """Set parts of the results by their keys. Raises pydantic's ValidationError for one that is not described."""
        self.results = self.results.replace(**parts)

    def put_state(self, name: str, **parts: Any) -> None:
        """Set parts of a state by their keys. Raises as `put`."""
        self.put(states=self.states | {name: self.states[name].replace(**parts)})

    def took(self, stage: str, seconds: float) -> None:
        """Add the computing time (s) of a stage."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds

    def add(self, stage: str, found: Found[Any]) -> None:
        """Add messages, certificates and time of an analysis of a stage."""
        self.warnings += [*found.warnings, *found.failures]
        self.quality += found.quality
        self.took(stage, found.seconds)
        self.complete = self.complete and not found.failures

    def finished(self) -> Results:
        """Return the results with warnings, certificates, estimated errors and computing times."""
        convergence = self.results.convergence.replace(rows=self.errors)
        if self.search_errors:
            convergence = convergence.replace(incremental=self.search_errors)
        summary, project = summary_of(self.results), self.project
        compared = comparison(summary.rows) if project.assessment or project.incremental else []
        return self.results.replace(
            summary=summary, comparison=compared, convergence=convergence, timing_s=self.seconds,
            quality=quality_of(self.quality, self.warnings),
        )  # fmt: skip


def _carry_out(draft: Draft) -> None:
    """Carry out every stage; a structure that does not stand is not analysed."""
    read, workers, assembly = draft.read, draft.workers, draft.read.model.assembly
    [unstable] = workers.each("self-weight", stand, [(assembly,)], ["self-weight"])
    if unstable:
        draft.put(model=draft.results.model.replace(self_weight_stable=False))
        draft.warnings.append(unstable)
        draft.complete = False
        return
    draft.warnings += pressed_in(assembly)
    project, models = draft.project, draft.models

    def analyse(finer: Project, names: Collection[str]) -> list[StateResult]:
        return analyse_states([each for each in _requests(finer, models) if each.state in names], workers)

    converged = converge(project, models, read.demands, analyse)
    requests = [
        request.within(refined(project, converged.halvings.get(request.state, 0)))
        for request in _requests(project, models)
    ]
    ensembles = members(requests, converged.stages, workers)
    _add_states(draft, converged)
    _add_second_solver(draft, _add_capacities(draft, converged, ensembles))
    scans = Scans(project, workers)
    _add_dynamics(draft, converged.stages, scans)
    beside = (read.demands, workers, draft.states, converged.stages, converged.halvings)
    _add_studies(draft, Statics(project, models, *beside), scans)


def _requests(project: Project, models: Mapping[str, StateModel]) -> list[Request]:
    """Return every state under every contact behaviour that a stage needs."""
    pushed = project.pushed_contacts
    settled = list(dict.fromkeys([*pushed, *project.dynamic_contacts, *project.moved_contacts])) or ["rigid"]
    return [
        Request(project, models[name], project.settlement_of(name), behaviour)
        for name in project.states
        for behaviour in (pushed if name == ORIGINAL else settled)
    ]


def _add_states(draft: Draft, converged: Converged) -> None:
    """Add configuration of every state, certificates, times, failures and estimated errors of its analyses."""
    draft.warnings += converged.warnings
    draft.errors += converged.rows
    reached: dict[str, dict[str, Any]] = {}
    for stage in converged.stages:
        draft.warnings += stage.failures
        draft.quality += stage.quality
        draft.complete = draft.complete and not stage.failures
        reached.setdefault(stage.state, {})[stage.behaviour] = stage.configuration
        for name, seconds in stage.seconds.items():
            draft.took(name, seconds)
    for name, by_behaviour in reached.items():
        found = present(by_behaviour)
        if configuration := found.get("rigid") or found.get("elastic"):
            draft.put_state(name, configuration=configuration)


def _add_capacities(draft: Draft, converged: Converged, ensembles: Ensembles) -> list[dict[Direction, Run]]:
    """Add what every state comes to: movement, curves, ranges and, where asked for, checks, demand, chosen mechanisms.

    `ensembles`: the further runs of a state. A state without capacity in a direction that was asked for has no index:
    the least of its directions is not known. Return the runs that the curves of each state are of.
    """
    began, project, demands = time.perf_counter(), draft.project, draft.read.demands
    reported = []
    for name in draft.states:
        if own := [stage for stage in converged.stages if stage.state == name]:
            assembly = draft.models[name].assembly

            def checked(
                pushovers: Mapping[Direction, Pushovers], assembly: Assembly = assembly
            ) -> Mapping[Direction, Found[Assessed]]:
                return assess(project, assembly, pushovers, demands) if project.assessment else {}

            runs = [own, *ensembles.get(name, ())]
            found, warnings, governing = governed(name, draft.states[name], runs, checked)
            reported.append(governing)
            draft.warnings += warnings
            parts = {key: getattr(found, key) for key in ("pushdown", "pushover", "capacity")}
            if project.assessment:
                asked = project.pushover.directions if project.pushover else ()
                known_ones = {} if without(found.capacity, asked) else found.capacity
                made = found.strengthening
                before = draft.states.get(made.of) if made else None
                parts["indices"] = demand.state_indices(project, known_ones, before)
            draft.put_state(name, **parts)
        state = draft.states[name]
        if project.assessment and without(state.capacity, state.pushover):
            draft.complete = False
    if project.assessment:
        if knowledge := project.assessment.knowledge:
            line = confidence_factor(knowledge.level, knowledge.components)
            draft.put(knowledge=as_part(Knowledge, knowledge, F_C=line.result, trace=[line]))
        draft.put(spectra=demand.demand_parts(project, demands))
        draft.took("assessment", time.perf_counter() - began)
    if project.mechanism:
        chosen = assess_chosen(project, draft.models, draft.states, demands, draft.warnings)
        draft.put(mechanisms=chosen)
        draft.complete = draft.complete and not any(given.refused for given in chosen)
    return reported


def _add_second_solver(draft: Draft, reported: Iterable[Mapping[Direction, Run]]) -> None:
    found = [
        (begun.model, stage.state, direction, pushed.activated, rigid.curve.multiplier[rigid.peak])
        for runs in reported
        for direction, run in runs.items()
        for stage in run
        if (begun := stage.begun) and direction in stage.pushed and (pushed := stage.pushed[direction].value)
        if pushed.activated is not None and (rigid := pushed.curves.rigid)
    ]
    titles = [f"{name}, limit analysis {direction}" for _, name, direction, *_ in found]
    compared = draft.workers.each("second solver", second_solver, found, titles)
    for (_, name, direction, *_), result in zip(found, compared, strict=True):
        curves = draft.states[name].pushover
        if rigid := curves[direction].rigid:
            with_second = curves[direction].replace(rigid=rigid.replace(second_solver=result.value))
            draft.put_state(name, pushover=curves | {direction: with_second})
        draft.add("second solver", result)


def _add_dynamics(draft: Draft, stages: Iterable[StateResult], scans: Scans) -> None:
    """Compute [[history]] and [incremental] from the states that `stages` reached, and add them to the results."""
    project, motions = draft.project, draft.read.motions
    starts = starts_of(project.dynamic_contacts, draft.models, stages)
    if "rigid" in project.dynamic_contacts and project.contacts.sliding == "coulomb":
        resting = {name: each for (name, kind), each in starts.items() if kind == "rigid"}
        at_rest = [(on, name, start) for name, (on, start) in resting.items() if isinstance(start, State)]
        for found in scans.workers.each("friction at rest", rests_or_moves, at_rest, [*resting]):
            draft.warnings += found.warnings
    pushovers = {name: state.pushover for name, state in draft.states.items()}
    inputs = MotionInputs(project, starts, pushovers, scans.workers)
    if project.history:
        draft.put(motions=[motion_part(motion, PERIODS) for motion in motions.history])
        for each in histories(inputs, motions.history):
            draft.add("history", each)
            draft.put_state(each.state, history=[*draft.states[each.state].history, each.numbers])
            draft.errors += [each.convergence] if each.convergence else []
    if project.incremental:
        study = Study()
        parts, draft.search_errors = incremental(inputs, motions.incremental, scans, study)
        draft.add("incremental", study)
        for state, part in parts.items():
            draft.put_state(state, incremental=part)


def _add_studies(draft: Draft, statics: Statics, scans: Scans) -> None:
    """Fit, compare, vary and run the campaign, each where asked for.

    Raises ProjectError for a property without a model.
    """
    project, workers, settling = draft.project, scans.workers, draft.models[ORIGINAL].settling
    made: tuple[tuple[str, object, Callable[[Study], Any]], ...] = (  # what asks for each
        ("identification", project.identification, partial(identification, project, settling, workers)),
        ("scenarios", asks_for_scenarios(project), partial(scenarios, statics)),
        ("sensitivity", project.sensitivity, partial(sensitivity, statics)),
        ("campaign", project.campaign, partial(campaign, statics, draft.read.motions.campaign, scans)),
    )
    for name, make in ((name, make) for name, asked, make in made if asked):
        study = Study()
        draft.put(**{name: make(study)})
        draft.took(name, study.seconds)
        draft.complete = draft.complete and not study.failures
        if study.quality:
            draft.quality.append(joined(None, name, study.quality))
        # single runs repeat the warnings of the states: of many only the number
        warnings, failures = study.warnings, study.failures
        if len(warnings) > FEW:
            warnings = [message(
                "{study}: {count} warnings of single runs, in results.json; the first: {text}",
                study=name, count=len(warnings), text=warnings[0],
            )]  # fmt: skip
        if len(failures) > FEW:
            failures = [message(
                "{study}: {count} failures of single runs, in results.json; the first: {text}",
                study=name, count=len(failures), text=failures[0],
            )]  # fmt: skip
        draft.warnings += [*warnings, *study.findings, *failures]
