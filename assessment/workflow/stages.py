"""Which stages a project needs, in what order, and what they leave behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from assessment.analyses.checks.capacity import Assessed, assess
from assessment.analyses.checks.chosen_mechanism import assess_chosen
from assessment.analyses.checks.demand import Demands, demand_parts, demand_spectra
from assessment.analyses.checks.governing import Governed, Run, governed
from assessment.analyses.checks.indices import governing, knowledge_of, safety_index, state_indices
from assessment.analyses.found import Found
from assessment.analyses.static.ensemble import members
from assessment.analyses.static.increments import refined
from assessment.analyses.static.lateral import second_solver, with_control
from assessment.analyses.static.paths import stand
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.project.plausibility import implausible_hazard
from assessment.project.schema import ORIGINAL
from assessment.results.schema.part import known, present
from assessment.results.undetermined import without
from assessment.runtime.progress import SILENCE, Show
from assessment.runtime.tasks import Outcome, Workers, large
from assessment.studies.campaign.scans import Scans
from assessment.studies.convergence import Convergence, converge
from assessment.studies.variants import Statics
from assessment.workflow.comparison import comparison, strengthened
from assessment.workflow.description import describe
from assessment.workflow.draft import Draft
from assessment.workflow.dynamic import add_dynamics, read_motions
from assessment.workflow.studies import add_studies

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.structure.model import ProjectModel
    from assessment.project.structure.state_models import StateModel
    from assessment.results.schema import Results
    from assessment.results.schema.checks import Direction
    from assessment.results.schema.static import Pushovers
    from assessment.runtime.cache import Store
    from mechanics import Assembly

    States = Mapping[str, StateModel]

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
    project, chosen = with_control(project, states[ORIGINAL].assembly)
    motions = read_motions(project)
    demands = demand_spectra(project, motions.history) if project.assessment else Demands()
    draft = Draft(describe(project, model))
    draft.warnings += [*chosen, *motions.notes, *implausible_hazard(project, demands.spectra)]
    if _falls_by_itself(draft, states[ORIGINAL].assembly, workers):
        return draft.finished(), False

    converged = _converged(project, states, demands, workers)
    ensembles = _ensembles(project, states, converged, workers)
    _add_states(draft, converged)
    assessed, reported = _add_capacities(draft, project, states, demands, converged, ensembles)
    _add_second_solver(draft, reported, workers)

    statics = Statics(draft.states, converged.stages, converged.halvings)
    scans = Scans(project, workers)
    shaken = add_dynamics(draft, project, states, motions, converged.stages, scans)
    studied = add_studies(draft, project, states, statics, demands, motions.campaign, scans)
    if project.assessment or project.incremental:
        draft.put(comparison=comparison(draft.states))
    if project.strengthening:
        draft.put(strengthening=strengthened(draft.states))
    settled = not any(stage.failures for stage in converged.stages)
    return draft.finished(), assessed and studied and shaken and settled


def _falls_by_itself(draft: Draft, assembly: Assembly, workers: Workers) -> bool:
    """Return whether the structure as drawn cannot carry its own weight; the results then hold the reason."""
    [unstable] = workers.each("self-weight", stand, [(assembly,)], ["self-weight"], large(assembly))
    if unstable:
        draft.put(model=draft.results.model.replace(self_weight_stable=False))
        draft.warnings.append(unstable)
    return bool(unstable)


def _converged(project: Project, states: States, demands: Demands, workers: Workers) -> Convergence:
    """Analyse the settlement and pushover of every state, in increments halved until its capacity has converged."""

    def analyse(finer: Project, names: Collection[str]) -> list[StateResult]:
        requests = _requests(finer, states)
        return analyse_states([request for request in requests if request.state in names], workers)

    return converge(project, states, demands, analyse)


def _ensembles(
    project: Project, states: States, converged: Convergence, workers: Workers
) -> Mapping[str, Ensemble]:
    """Repeat the states whose paths scatter, in the increments at which they converged; by state, by member."""
    requests = [
        request.within(refined(project, converged.halvings.get(request.state, 0)))
        for request in _requests(project, states)
    ]
    return members(requests, converged.stages, workers)


def _add_states(draft: Draft, converged: Convergence) -> None:
    """Add configuration of every state, certificates, times, failures and estimated errors of its analyses."""
    draft.warnings += converged.warnings
    draft.errors += converged.rows
    for stage in converged.stages:
        draft.take([], stage.failures, stage.quality)
        for name, seconds in stage.seconds.items():
            draft.took(name, seconds)
    for name in dict.fromkeys(stage.state for stage in converged.stages):
        own = [stage for stage in converged.stages if stage.state == name]
        reached = present({stage.behaviour: stage.configuration for stage in own})
        if configuration := reached.get("rigid") or reached.get("elastic"):
            draft.put_state(name, configuration=configuration)


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
