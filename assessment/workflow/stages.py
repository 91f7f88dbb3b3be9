"""Which stages a project needs, in what order, and what they leave behind."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from assessment.analyses.checks.capacity import assess, assess_chosen, governing, safety_index
from assessment.analyses.checks.demand import Demands, demand_parts, demand_spectra
from assessment.analyses.checks.indices import knowledge_of, state_indices
from assessment.analyses.checks.ranges import Assess, with_ranges
from assessment.analyses.static.ensemble import members
from assessment.analyses.static.paths import stand
from assessment.analyses.static.second_solver import second_solver
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.ntc.limit_states import SURFACE
from assessment.project.plausibility import implausible_hazard
from assessment.project.schema import ORIGINAL
from assessment.results.plain import plain
from assessment.results.table import brought_together, quoted_limit_state, reduction, static_pga
from assessment.runtime.outcome import Outcome
from assessment.runtime.tasks import SILENCE, Show, Workers, large
from assessment.studies.convergence import Convergence, converge
from assessment.studies.increments import refined
from assessment.studies.variants import Statics, behaviours, curves
from assessment.workflow.dynamic import add_dynamics, dynamic_contacts, read_motions
from assessment.workflow.skeleton import describe
from assessment.workflow.studies import add_studies

if TYPE_CHECKING:
    from assessment.project.model import Model
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.results.schema.checks import Capacity, Direction
    from assessment.runtime.cache import Store
    from mechanics import Assembly
    from mechanics.model import Behaviour

Results = dict[str, Any]
Ensemble = Sequence[Sequence[StateResult]]
"""The further runs of a state: of each member, the results of its contact behaviours."""


def run(
    project: Project,
    model: Model,
    jobs: int = 0,
    store: Store | None = None,
    fresh: bool = False,
    show: Show = SILENCE,
    meanwhile: Callable[[], object] | None = None,
    scheduler: str | None = None,
) -> Outcome:
    """Carry out every stage that the project asks for.

    `jobs`: processes, 0: as many as help; `scheduler`: of a Dask cluster in their place; `store`: where finished
    analyses are kept, and taken from unless `fresh`;
    `meanwhile`: what this process does, once, while others compute.
    """
    with Workers(jobs, store, fresh, show, meanwhile=meanwhile, scheduler=scheduler) as workers:
        results, complete = _stages(project, model, workers)
    if store:
        store.prune()
    return Outcome(plain(results), complete, workers.computed, workers.taken)


def _stages(project: Project, model: Model, workers: Workers) -> tuple[Results, bool]:
    """Return the results and whether every analysis asked for was completed."""
    assembly = model.assembly
    motions = read_motions(project)
    demands = demand_spectra(project, motions.history) if project.assessment else Demands()
    results = describe(project, model)
    results["quality"]["warnings"] += [*motions.notes, *implausible_hazard(project, demands.spectra)]
    if _falls_by_itself(results, assembly, workers):
        _sum_up(results["quality"])
        return results, False

    converged = _converged(project, assembly, demands, workers)
    ensembles = _ensembles(project, assembly, converged, workers)
    _add_states(results, converged)
    _add_capacities(results, project, assembly, demands, ensembles)
    _add_second_solver(results, assembly, converged, workers)

    statics = Statics(results["states"], converged.stages, converged.halvings)
    studied = add_studies(results, project, assembly, statics, demands, motions.campaign, workers)
    shaken = add_dynamics(results, project, assembly, motions, converged.stages, workers)
    if project.assessment or project.incremental:
        results["comparison"] = _comparison(results["states"])
    _sum_up(results["quality"])
    return results, shaken and studied and not any(stage.failures for stage in converged.stages)


def _falls_by_itself(results: Results, assembly: Assembly, workers: Workers) -> bool:
    """Return whether the structure as drawn cannot carry its own weight, and say so in the results."""
    [unstable] = workers.each("self-weight", stand, [(assembly,)], ["self-weight"], large(assembly))
    if unstable:
        results["model"]["self_weight_stable"] = False
        results["quality"]["warnings"].append(unstable)
    return bool(unstable)


def _converged(project: Project, assembly: Assembly, demands: Demands, workers: Workers) -> Convergence:
    """Settle and push over every state, in increments halved until its capacity is within the tolerance."""

    def analyse(finer: Project, names: Collection[str]) -> list[StateResult]:
        requests = _requests(finer, assembly)
        return analyse_states([request for request in requests if request.state in names], workers)

    return converge(project, assembly, demands, analyse)


def _ensembles(
    project: Project, assembly: Assembly, converged: Convergence, workers: Workers
) -> Mapping[str, Ensemble]:
    """Repeat the states whose paths scatter, in the increments at which they converged; by state, by member."""
    requests = [
        replace(request, project=refined(project, converged.halvings.get(request.state, 0)))
        for request in _requests(project, assembly)
    ]
    return members(requests, converged.stages, workers)


def _add_states(results: Results, converged: Convergence) -> None:
    """Add the curves of every state, the certificates and times behind them, and how far they are from converged."""
    results["quality"]["warnings"] += converged.warnings
    results["convergence"]["rows"] += converged.rows
    for stage in converged.stages:
        _merge(results["states"][stage.state], stage)
        results["quality"]["warnings"] += stage.warnings + stage.failures
        results["quality"]["by_stage"] += stage.quality
        for name, seconds in stage.seconds.items():
            results["timing_s"][name] = results["timing_s"].get(name, 0.0) + seconds


def _add_second_solver(
    results: Results, assembly: Assembly, converged: Convergence, workers: Workers
) -> None:
    """Add to every rigid curve that is reported the multiplier of limit analysis by a second program.

    Of a state with an ensemble it is that of its own run, as drawn, whichever member's curve is reported.
    """
    found = [
        (stage.state, direction, activated, float(stage.pushover[direction]["alpha_0"]))
        for stage in converged.stages
        for direction, activated in stage.activated.items()
    ]
    parts = workers.each(
        "second solver",
        second_solver,
        [(assembly, *each) for each in found],
        [f"{name}, limit analysis {direction}" for name, direction, *_ in found],
        large(assembly),
    )
    for (name, direction, *_), part in zip(found, parts, strict=True):
        if rigid := results["states"][name]["pushover"][direction].get("rigid"):
            rigid["second_solver"] = part.numbers
        results["quality"]["warnings"] += part.warnings
    if parts:
        results["timing_s"]["second solver"] = sum(part.seconds for part in parts)


def _add_capacities(
    results: Results,
    project: Project,
    assembly: Assembly,
    demands: Demands,
    ensembles: Mapping[str, Ensemble],
) -> None:
    """Add the ranges of every state and, where asked for, its checks, the demand and the chosen mechanisms."""
    began = time.perf_counter()
    warnings, states = results["quality"]["warnings"], results["states"]
    for name, state in states.items():
        notes: list[str] = []
        checked: Assess = (
            partial(assess, project, assembly, demands=demands, warnings=notes)
            if project.assessment
            else lambda _: {}
        )
        capacity: Mapping[Direction, Capacity]
        if name in ensembles:
            capacity = with_ranges(state, [settled_and_pushed(each) for each in ensembles[name]], checked)
            notes += [*told_of(ensembles[name]), *notes]
        else:
            capacity = checked(state["pushover"])
        warnings += [f"{name}: {note}" for note in dict.fromkeys(notes)]
        if project.assessment:
            state["capacity"] = capacity
            state["governing"], state["safety_index"] = governing(capacity), safety_index(capacity)
            state["indices"] = state_indices(project, capacity)
    if project.assessment:
        if project.assessment.knowledge:
            results["knowledge"] = knowledge_of(project.assessment.knowledge)
        results["spectra"] = demand_parts(project, demands)
        results["timing_s"]["assessment"] = time.perf_counter() - began
    if project.mechanism:
        results["mechanisms"] = assess_chosen(project, assembly, states, demands, warnings)


def _requests(project: Project, model: Assembly) -> list[Request]:
    """Every state under every contact behaviour that a stage needs it under."""
    pushed = behaviours(project)
    settled = list(dict.fromkeys([*pushed, *dynamic_contacts(project)])) or ["rigid"]
    states: list[tuple[SettlementTable | None, Behaviour]] = [(None, behaviour) for behaviour in pushed]
    states += [(settlement, behaviour) for settlement in project.settlements for behaviour in settled]
    return [Request(project, model, *state) for state in states]


def _merge(state: Results, stage: StateResult) -> None:
    if stage.pushdown is not None:
        state["pushdown"][stage.behaviour] = stage.pushdown
    if stage.configuration is not None and (
        stage.behaviour == "rigid" or not any(map(any, state["configuration"]))
    ):
        state["configuration"] = stage.configuration
    for direction, numbers in stage.pushover.items():
        control = numbers.pop("control")
        state["pushover"].setdefault(direction, {"control": control})[stage.behaviour] = numbers


def settled_and_pushed(member: Sequence[StateResult]) -> tuple[Results, dict[Direction, Results]]:
    """Return what a member of an ensemble found: its settlement by behaviour, its curves by direction and behaviour."""
    settled: Results = {each.behaviour: each.pushdown for each in member if each.pushdown is not None}
    return settled, curves(member)


def told_of(ensemble: Ensemble) -> Iterator[str]:
    """Yield what a reader has to know of an ensemble: how large it is, and which members found no result."""
    yield (
        f"joints slide, or a part moves by itself: {len(ensemble) + 1} runs with other increments and corners moved "
        "by a ten-millionth of their block give the ranges; of a capacity the lower end is used"
    )
    failed = [each for member in ensemble for each in member if each.failures]
    if failed:
        yield f"in {len(failed)} of the runs of the ensemble: {failed[0].failures[0]}"


def _comparison(states: Mapping[str, Any]) -> list[Results]:
    """Capacities of each settled state beside the original one's; the dynamic one is the same in every direction.

    `limit_state`: the farthest one checked, of which the static capacity is, on rock with F_C; the dynamic one is at
    the surface without it, where `static_surface_pga_g` brings the static one before `dynamic_to_static` is taken.
    """
    rows: list[Results] = []
    original = states.get(ORIGINAL)
    if original is None:
        return rows
    for name, state in states.items():
        if name == ORIGINAL:
            continue
        dynamic = state["incremental"].pga_collapse_g
        for direction in original["pushover"] or ([None] if state["incremental"].records else []):
            was, now = (each["capacity"].get(direction) for each in (original, state))
            before, after = static_pga(was), static_pga(now)
            limit = next(filter(None, (quoted_limit_state(each.checks) for each in (was, now) if each)), None)
            check = now.checks.get(limit or "") if now else None
            nominal = now.nominal if now else None
            rows.append(
                {
                    "state": name,
                    "direction": direction,
                    "limit_state": limit,
                    "static_pga_g": after,
                    "static_reduction": reduction(before, after),
                    "dynamic_pga_g": dynamic,
                    "dynamic_reduction": reduction(original["incremental"].pga_collapse_g, dynamic),
                    "static_reference": check.reference if check else None,
                    "dynamic_reference": None if dynamic is None else SURFACE,
                }
                | (
                    brought_together(nominal.pga_g if nominal else None, dynamic)
                    if dynamic is not None
                    else {}
                )
            )
    return rows


def _sum_up(quality: Results) -> None:
    rows = quality["by_stage"]
    quality["solves"] = sum(row["solves"] for row in rows)
    for key in (
        "worst_equilibrium_residual",
        "worst_penetration_m",
        "worst_complementarity",
        "worst_cone_violation",
    ):
        quality[key] = max((row[key] for row in rows if key in row), default=None)
