"""Which stages a project needs, in what order, and what they leave behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from assessment.analyses.checks.capacity import (
    Assessed,
    assess,
    capacities,
    governing,
    safety_index,
)
from assessment.analyses.checks.chosen_mechanism import assess_chosen
from assessment.analyses.checks.demand import Demands, demand_parts, demand_spectra
from assessment.analyses.checks.governing import Paths, governed
from assessment.analyses.checks.indices import knowledge_of, state_indices
from assessment.analyses.checks.refusals import joined
from assessment.analyses.static.ensemble import members
from assessment.analyses.static.lateral import second_solver, with_control
from assessment.analyses.static.paths import stand
from assessment.analyses.static.states import Request, StateResult, analyse_states, curves
from assessment.project.plausibility import implausible_hazard
from assessment.project.schema import ORIGINAL
from assessment.results.schema.part import known, present
from assessment.results.undetermined import without
from assessment.runtime.show import SILENCE, Show
from assessment.runtime.tasks import Outcome, Workers, large
from assessment.studies.campaign.scans import Scans
from assessment.studies.convergence import Convergence, converge
from assessment.studies.increments import refined
from assessment.studies.variants import Statics
from assessment.workflow.comparison import comparison, strengthened
from assessment.workflow.draft import Draft
from assessment.workflow.dynamic import add_dynamics, read_motions
from assessment.workflow.skeleton import describe
from assessment.workflow.studies import add_studies
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.structure.model import ProjectModel
    from assessment.project.structure.state_models import StateModel
    from assessment.results.schema import Results
    from assessment.results.schema.checks import Direction
    from assessment.results.schema.part import Configuration
    from assessment.results.schema.static import Pushovers
    from assessment.runtime.cache import Store
    from mechanics import Assembly

    States = Mapping[str, StateModel]

Ensemble = Sequence[Sequence[StateResult]]
"""The further runs of a state: of each member, the results of its contact behaviours."""


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
    assessed = _add_capacities(draft, project, states, demands, ensembles)
    _add_second_solver(draft, converged, ensembles, workers)

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
    """Add settlement, curves and configuration of every state, their certificates, times and estimated errors."""
    draft.warnings += converged.warnings
    draft.errors += converged.rows
    for stage in converged.stages:
        draft.take(stage.warnings, stage.failures, stage.quality)
        for name, seconds in stage.seconds.items():
            draft.took(name, seconds)
    for name in dict.fromkeys(stage.state for stage in converged.stages):
        own = [stage for stage in converged.stages if stage.state == name]
        paths = _paths(own)
        draft.put_state(name, pushdown=paths.pushdown, pushover=paths.pushover)
        if (reached := _configuration(own)) is not None:
            draft.put_state(name, configuration=reached)


def _paths(stages: Sequence[StateResult]) -> Paths:
    """Return the paths of a state: its settlement by behaviour, its curves by direction."""
    return Paths(present({stage.behaviour: stage.pushdown for stage in stages}), curves(stages))


def _configuration(stages: Sequence[StateResult]) -> Configuration | None:
    """Return the configuration that a state reached, that under rigid contacts before that under elastic ones."""
    reached = present({stage.behaviour: stage.configuration for stage in stages})
    return reached.get("rigid") or reached.get("elastic")


def _add_capacities(
    draft: Draft,
    project: Project,
    states: States,
    demands: Demands,
    ensembles: Mapping[str, Ensemble],
) -> bool:
    """Add the ranges of every state and, where asked for, its checks, the demand and the chosen mechanisms.

    Return whether every capacity was found: each pushover has one, and no mechanism of the project was refused.
    """
    began = time.perf_counter()
    complete = True
    for name in draft.states:
        found = _add_capacity(draft, name, project, states[name].assembly, demands, ensembles.get(name))
        complete = complete and found
    if project.assessment:
        if project.assessment.knowledge:
            draft.put(knowledge=knowledge_of(project.assessment.knowledge))
        draft.put(spectra=demand_parts(project, demands))
        draft.took("assessment", time.perf_counter() - began)
    if project.mechanism:
        chosen = assess_chosen(project, states, draft.states, demands, draft.warnings)
        draft.put(mechanisms=chosen)
        complete = complete and not any(given.refused for given in chosen)
    return complete


def _add_capacity(
    draft: Draft,
    name: str,
    project: Project,
    assembly: Assembly,
    demands: Demands,
    ensemble: Ensemble | None,
) -> bool:
    """Add ranges and checks of one state, and the indices that follow from them; return whether all were found.

    A state without capacity in a direction that was asked for has no index: the least of its directions is not known.
    """
    notes: list[Message] = []

    def checked(pushovers: Mapping[Direction, Pushovers]) -> Mapping[Direction, Assessed]:
        return assess(project, assembly, pushovers, demands, notes) if project.assessment else {}

    state = draft.states[name]
    if ensemble is not None:
        state = governed(state, [_paths(member) for member in ensemble], checked)
    else:
        found = checked(state.pushover)
        curves_of = {direction: each.curves for direction, each in found.items()}
        state = state.replace(pushover=state.pushover | curves_of, capacity=capacities(found))
    runs = 1 if ensemble is None else len(ensemble) + 1
    draft.warnings += [message("{state}: {text}", state=name, text=note) for note in joined(notes, runs)]
    if ensemble is not None:
        draft.warnings += [headed(message("{state}", state=name), note) for note in told_of(ensemble)]
    draft.put_state(name, pushdown=state.pushdown, pushover=state.pushover, capacity=state.capacity)
    if not project.assessment:
        return True
    asked = project.pushover.directions if project.pushover else ()
    determined = {} if without(state.capacity, asked) else state.capacity
    made = state.strengthening
    draft.put_state(
        name,
        governing=governing(determined),
        safety_index=safety_index(determined),
        indices=state_indices(project, determined, draft.states.get(made.of) if made else None),
    )
    return not without(state.capacity, state.pushover)


def _add_second_solver(
    draft: Draft, converged: Convergence, ensembles: Mapping[str, Ensemble], workers: Workers
) -> None:
    """Add to every rigid curve that is reported the multiplier of limit analysis by a second program."""
    runs = [
        *converged.stages,
        *(each for members in ensembles.values() for member in members for each in member),
    ]
    found = [
        (known(stage.model), stage.state, direction, activated, rigid.alpha_0)
        for stage in runs
        for direction, activated in stage.activated.items()
        if (reported := draft.states[stage.state].pushover.get(direction))
        and (rigid := reported.rigid)
        and reported.run == stage.pushover[direction].run
    ]
    compared = workers.each(
        "second solver",
        second_solver,
        found,
        [f"{name}, limit analysis {direction}" for _, name, direction, *_ in found],
        large(*(model for model, *_ in found)),
    )
    for (_, name, direction, *_), result in zip(found, compared, strict=True):
        pushed = draft.states[name].pushover
        if rigid := pushed[direction].rigid:
            reported = pushed[direction].replace(rigid=rigid.replace(second_solver=result.found))
            draft.put_state(name, pushover=pushed | {direction: reported})
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


def told_of(ensemble: Ensemble) -> Iterator[Message]:
    """Yield warnings about an ensemble: how large it is, and which members have no result."""
    yield message(
        "joints slide, or a part moves by itself: {count} runs with other increments and corners moved by a "
        "ten-millionth of their block give the ranges; all numbers are those of the run with the least capacity",
        count=len(ensemble) + 1,
    )
    failed = [each for member in ensemble for each in member if each.failures]
    if failed:
        yield message(
            "in {count} of the runs of the ensemble: {text}", count=len(failed), text=failed[0].failures[0]
        )
