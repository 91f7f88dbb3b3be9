"""Which stages a project needs, in what order, and what they leave behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.checks.capacity import Assessed, assess
from assessment.analyses.checks.chosen_mechanism import assess_chosen
from assessment.analyses.checks.demand import (
    Demands,
    demand_parts,
    governing,
    knowledge_of,
    safety_index,
    state_indices,
)
from assessment.analyses.checks.governing import Governed, Run, governed, members
from assessment.analyses.dynamic.histories import histories
from assessment.analyses.dynamic.time_history import MotionInputs, motion_part, starts_of, ultimates
from assessment.analyses.found import Found, refined
from assessment.analyses.static.lateral import second_solver
from assessment.analyses.static.paths import pressed_in, stand
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.project.schema import ORIGINAL
from assessment.results.asked import without
from assessment.results.quality import joined, quality_of
from assessment.results.schema import Results, State
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import known, present
from assessment.results.schema.studies import ConvergenceRow
from assessment.results.summary import summary_of
from assessment.runtime.progress import SILENCE, Show
from assessment.runtime.tasks import Outcome, Workers, large
from assessment.studies.campaign import summary as searches
from assessment.studies.campaign.scans import Scans
from assessment.studies.campaign.stage import campaign
from assessment.studies.convergence import Convergence, converge
from assessment.studies.identification.stage import identification
from assessment.studies.variants import Statics, Study, asks_for_scenarios, scenarios, sensitivity
from assessment.workflow.checking import Motions, read_inputs
from assessment.workflow.comparison import comparison, strengthened
from mechanics.messages import Message, message

if TYPE_CHECKING:
    from assessment.analyses.dynamic.time_history import DynamicResult
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.structure.model import ProjectModel, StateModel
    from assessment.results.schema.checks import Direction
    from assessment.results.schema.dynamic import Campaign
    from assessment.results.schema.static import Pushovers
    from assessment.results.schema.studies import Identification, Scenarios, Sensitivity
    from assessment.runtime.cache import Store
    from mechanics import Assembly

    States = Mapping[str, StateModel]


@dataclass
class Draft:
    """The results of a run while its stages add to them; `finished` returns them.

    `results`: what needs no analysis, then the parts that were found; `warnings`: what the reader has to know;
    `quality`: certificates of the analyses; `seconds`: their computing time by stage; `errors` and `search_errors`:
    estimated errors of pushovers and histories, and of the PGA at collapse.
    """

    results: Results
    warnings: list[Message] = field(default_factory=list)
    quality: list[QualityRow] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    errors: list[ConvergenceRow] = field(default_factory=list)
    search_errors: list[ConvergenceRow] = field(default_factory=list)

    @property
    def states(self) -> dict[str, State]:
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

    def add(self, stage: str, found: DynamicResult | searches.Found) -> bool:
        """Add messages, certificates and time of an analysis of a stage; return whether it was completed."""
        self.warnings += [*found.warnings, *found.failures]
        self.quality += found.quality
        self.took(stage, found.seconds)
        return not found.failures

    def finished(self) -> Results:
        """Return the results with warnings, certificates, estimated errors and computing times."""
        convergence = self.results.convergence.replace(rows=self.errors)
        if self.search_errors:
            convergence = convergence.replace(incremental=self.search_errors)
        return self.results.replace(
            summary=summary_of(self.results),
            convergence=convergence,
            quality=quality_of(self.quality, self.warnings),
            timing_s=self.seconds,
        )


PERIODS = np.linspace(0.0, 4.0, 201)  # s, of the spectra of motions
FEW = 3  # warnings of a study that are repeated among those of the run
Ensemble = Sequence[Run]
"""The further runs of a state."""


def run(
    project: Project,
    model: ProjectModel,
    jobs: int = 0,
    store: Store | None = None,
    fresh: bool = False,
    show: Show = SILENCE,
    meanwhile: Callable[[], object] | None = None,
    scheduler: str | None = None,
) -> Outcome:
    """Carry out every stage that the project asks for.

    `jobs`: number of processes, 0: as many as help; `scheduler`: address of a Dask cluster used in their place;
    `store`: where finished analyses are kept, and taken from unless `fresh`; `show`: receives the progress;
    `meanwhile`: what this process does, once, while others compute.

    Raises ProjectError or ValueError for records and hazard that cannot be read, KilledError where a process was ended
    from outside, and pydantic's ValidationError for results that are not as the schema says (a fault of the program).
    """
    with Workers(jobs, store, fresh, show, meanwhile=meanwhile, scheduler=scheduler) as workers:
        results, complete = _stages(project, model, workers)
    if store:
        store.prune()
    return Outcome(results, complete, workers.computed, workers.taken)


def _stages(project: Project, model: ProjectModel, workers: Workers) -> tuple[Results, bool]:
    """Return the results, and whether every requested analysis was completed."""
    states = model.states
    read = read_inputs(project, model)
    project, motions, demands = read.project, read.motions, read.demands
    draft = Draft(read.results, [*read.notes])
    [unstable] = workers.each(
        "self-weight", stand, [(model.assembly,)], ["self-weight"], large(model.assembly)
    )
    if unstable:
        draft.put(model=draft.results.model.replace(self_weight_stable=False))
        draft.warnings.append(unstable)
        return draft.finished(), False
    draft.warnings += pressed_in(model.assembly)

    def analyse(finer: Project, names: Collection[str]) -> list[StateResult]:
        requests = _requests(finer, states)
        return analyse_states([request for request in requests if request.state in names], workers)

    converged = converge(project, states, demands, analyse)
    requests = [
        request.within(refined(project, converged.halvings.get(request.state, 0)))
        for request in _requests(project, states)
    ]
    ensembles = members(requests, converged.stages, workers)
    settled = _add_states(draft, converged)
    assessed, reported = _add_capacities(draft, project, states, demands, converged, ensembles)
    _add_second_solver(draft, reported, workers)

    scans = Scans(project, workers)
    shaken = _add_dynamics(draft, project, states, motions, converged.stages, scans)
    statics = Statics(draft.states, converged.stages, converged.halvings)
    studied = _add_studies(draft, project, states, statics, demands, motions.campaign, scans)
    if project.assessment or project.incremental:
        draft.put(comparison=comparison(draft.states))
    if project.strengthening:
        draft.put(strengthening=strengthened(draft.states))
    return draft.finished(), settled and assessed and shaken and studied


def _add_states(draft: Draft, converged: Convergence) -> bool:
    """Add configuration of every state, certificates, times, failures and estimated errors of its analyses.

    Return whether all were completed.
    """
    draft.warnings += converged.warnings
    draft.errors += converged.rows
    for stage in converged.stages:
        draft.warnings += stage.failures
        draft.quality += stage.quality
        for name, seconds in stage.seconds.items():
            draft.took(name, seconds)
    for name in dict.fromkeys(stage.state for stage in converged.stages):
        own = [stage for stage in converged.stages if stage.state == name]
        reached = present({stage.behaviour: stage.configuration for stage in own})
        if configuration := reached.get("rigid") or reached.get("elastic"):
            draft.put_state(name, configuration=configuration)
    return not any(stage.failures for stage in converged.stages)


def _add_capacities(
    draft: Draft,
    project: Project,
    states: States,
    demands: Demands,
    converged: Convergence,
    ensembles: Mapping[str, Ensemble],
) -> tuple[bool, list[Governed]]:
    """Add what every state comes to: movement, curves, ranges and, where asked for, checks, demand, chosen mechanisms.

    Return whether every capacity was found, each pushover having one and no mechanism of the project being refused, and
    the runs that the curves of each state are of.
    """
    began = time.perf_counter()
    complete, reported = True, []
    for name in draft.states:
        own = [stage for stage in converged.stages if stage.state == name]
        if own:
            runs = [own, *ensembles.get(name, ())]
            reported.append(_add_capacity(draft, name, project, states[name].assembly, demands, runs))
        state = draft.states[name]
        complete = complete and not (project.assessment and without(state.capacity, state.pushover))
    if project.assessment:
        if project.assessment.knowledge:
            draft.put(knowledge=knowledge_of(project.assessment.knowledge))
        draft.put(spectra=demand_parts(project, demands))
        draft.took("assessment", time.perf_counter() - began)
    if project.mechanism:
        chosen = assess_chosen(project, states, draft.states, demands, draft.warnings)
        draft.put(mechanisms=chosen)
        complete = complete and not any(given.refused for given in chosen)
    return complete, reported


def _add_capacity(
    draft: Draft, name: str, project: Project, assembly: Assembly, demands: Demands, runs: Sequence[Run]
) -> Governed:
    """Add curves and checks of one state, and the indices that follow from them; return the runs that they are of.

    A state without capacity in a direction that was asked for has no index: the least of its directions is not known.
    """

    def checked(pushovers: Mapping[Direction, Pushovers]) -> Mapping[Direction, Found[Assessed]]:
        return assess(project, assembly, pushovers, demands) if project.assessment else {}

    found = governed(name, draft.states[name], runs, checked)
    state = found.state
    draft.warnings += found.warnings
    draft.put_state(name, pushdown=state.pushdown, pushover=state.pushover, capacity=state.capacity)
    if project.assessment:
        asked = project.pushover.directions if project.pushover else ()
        determined = {} if without(state.capacity, asked) else state.capacity
        made = state.strengthening
        draft.put_state(
            name,
            governing=governing(determined),
            safety_index=safety_index(determined),
            indices=state_indices(project, determined, draft.states.get(made.of) if made else None),
        )
    return found


def _add_second_solver(draft: Draft, reported: Iterable[Governed], workers: Workers) -> None:
    """Add to every rigid curve the multiplier of limit analysis by a second program."""
    found = [
        (known(stage.model), stage.state, direction, pushed.activated, rigid.alpha_0)
        for each in reported
        for direction, run in each.runs.items()
        for stage in run
        if direction in stage.pushed and (pushed := stage.pushed[direction].value)
        if pushed.activated is not None and (rigid := pushed.curves.rigid)
    ]
    compared = workers.each(
        "second solver",
        second_solver,
        found,
        [f"{name}, limit analysis {direction}" for _, name, direction, *_ in found],
        large(*(model for model, *_ in found)),
    )
    for (_, name, direction, *_), result in zip(found, compared, strict=True):
        curves = draft.states[name].pushover
        if rigid := curves[direction].rigid:
            with_second = curves[direction].replace(rigid=rigid.replace(second_solver=result.value))
            draft.put_state(name, pushover=curves | {direction: with_second})
        draft.warnings += result.warnings
    if compared:
        draft.took("second solver", sum(result.seconds for result in compared))


def _requests(project: Project, states: States) -> list[Request]:
    """Return every state under every contact behaviour that a stage needs."""
    pushed = project.pushed_contacts
    settled = list(dict.fromkeys([*pushed, *project.dynamic_contacts, *project.moved_contacts])) or ["rigid"]
    return [
        Request(project, states[name], project.settlement_of(name), behaviour)
        for name in project.states
        for behaviour in (pushed if name == ORIGINAL else settled)
    ]


def _add_dynamics(
    draft: Draft,
    project: Project,
    models: States,
    motions: Motions,
    stages: Iterable[StateResult],
    scans: Scans,
) -> bool:
    """Compute [[history]] and [incremental] from the states that `stages` reached, and add them to the results.

    Return whether every analysis was completed. Raises KilledError where a process was ended from outside.
    """
    ends = ultimates({name: state.pushover for name, state in draft.states.items()})
    inputs = MotionInputs(project, starts_of(project.dynamic_contacts, models, stages), ends, scans.workers)
    complete = True
    if project.history:
        draft.put(motions=[motion_part(motion, PERIODS) for motion in motions.history])
        for each in histories(inputs, motions.history):
            complete = draft.add("history", each) and complete
            draft.put_state(each.state, history=[*draft.states[each.state].history, each.numbers])
            draft.errors += [each.convergence] if each.convergence else []
    if project.incremental:
        found = searches.incremental(inputs, motions.incremental, scans)
        complete = draft.add("incremental", found) and complete
        draft.search_errors += found.errors
        for state, part in found.states.items():
            draft.put_state(state, incremental=part)
    return complete


def _add_studies(
    draft: Draft,
    project: Project,
    states: States,
    statics: Statics,
    demands: Demands,
    records: Sequence[BaseMotion],
    scans: Scans,
) -> bool:
    """Fit movements, compare scenarios, vary properties and run the campaign, each where asked for; add the results.

    `records`: of the files that [campaign] names. Return whether all was completed. Raises KilledError where a process
    was ended from outside, ProjectError for a property that gives no model.
    """
    workers, settling = scans.workers, states[ORIGINAL].settling
    made: dict[str, Callable[[Study], Scenarios | Sensitivity | Identification | Campaign]] = {}
    if project.identification:
        made["identification"] = lambda study: identification(project, settling, workers, study)
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
        complete = complete and not study.failures
        if study.quality:
            draft.quality.append(joined(None, name, study.quality))
        # what is told of single runs repeats what is told of the states: of many the number
        warnings, failures = study.warnings, study.failures
        if len(warnings) > FEW:
            several = message(
                "{study}: {count} warnings of single runs, in results.json; the first: {text}",
                study=name,
                count=len(warnings),
                text=warnings[0],
            )
            warnings = [several]
        if len(failures) > FEW:
            several = message(
                "{study}: {count} failures of single runs, in results.json; the first: {text}",
                study=name,
                count=len(failures),
                text=failures[0],
            )
            failures = [several]
        draft.warnings += [*warnings, *study.findings, *failures]
    return complete
