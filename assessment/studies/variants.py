"""Variants of a project beside its states: sweeps of movements with the worst case, properties lower and higher.

A point of a sweep is a scenario: the drawn structure settles by a part of the movement, rests, and is pushed over.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import product
from math import inf, isfinite
from operator import itemgetter
from typing import Any

from assessment.analyses.capacity import assess, capacities, told
from assessment.analyses.demand import Demands
from assessment.analyses.found import Found, finest, refined
from assessment.analyses.states import Request, StateResult, analyse_states, curves
from assessment.ntc.tables import farthest
from assessment.project.model import StateModel, build_model
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, ProjectTable, SettlementTable
from assessment.results.schema import Capacity, Pushovers, StateResults, known, studies
from assessment.results.table import compared, reduction
from assessment.runtime.tasks import Workers
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.model import Direction
from mechanics.procedures import whole_movement


@dataclass(frozen=True, eq=False)
class Statics:
    """What studies start from: the project, and each state as results.json has it, with the results behind it.

    `halvings`: how often the increments of each state were halved; the studies of a state halve theirs as often.
    """

    project: Project
    models: Mapping[str, StateModel]
    demands: Demands
    workers: Workers
    states: Mapping[str, StateResults]
    stages: Sequence[StateResult]
    halvings: Mapping[str, int]

    def stages_of(self, name: str) -> list[StateResult]:
        """Return the results of a state, one for each contact behaviour."""
        return [stage for stage in self.stages if stage.state == name]

    def capacities_of(self, name: str) -> dict[Direction, studies.Capacities]:
        """Return the capacity of a state of the project, by direction."""
        own = [stage for stage in self.stages_of(name) if stage.behaviour in self.project.pushed_contacts]
        return capacities_of(self.project, own, self.states[name].pushover, self.states[name].capacity)


@dataclass
class Study(Found[Any]):
    """What the runs of a study leave beside its part of the results; `findings`: about all of them."""

    findings: list[Message] = field(default_factory=list)

    def take(self, title: str, stages: Iterable[StateResult]) -> None:
        """Add quality, times and messages of the analyses of a variant; the messages get its title."""
        for stage in stages:
            self.quality += stage.quality
            self.seconds += sum(stage.seconds.values())
            self.warnings += [headed(title, text) for text in stage.warnings]
            self.failures += [headed(title, text) for text in stage.failures]


def variant(
    what: Message, project: Project, model: StateModel, settlement: SettlementTable | None
) -> list[Request]:
    """Return the requests for a state of a varied project, one for each contact behaviour that is pushed."""
    return [Request(project, model, settlement, behaviour, what) for behaviour in project.pushed_contacts]


def analyse(
    variants: Sequence[list[Request]], statics: Statics, study: Study, name: str
) -> Iterator[dict[Direction, studies.Capacities]]:
    """Settle and push over every variant; yield its capacity by direction, in order; tell the `study` of that name."""
    requests = [request for each in variants for request in each]
    results = iter(analyse_states(requests, statics.workers, name))
    for first, *others in variants:
        stages = [next(results) for _ in (first, *others)]
        study.take(first.what, stages)
        found, notes = of_stages(first.project, first.model.assembly, stages, statics.demands)
        title = message("{what}: {state}", what=first.what, state=first.state)
        study.warnings += [headed(title, note) for note in notes]
        yield found


def directions(project: Project) -> tuple[Direction, ...]:
    """Return the directions of the pushover."""
    return project.pushover.directions if project.pushover else ()


def of_stages(
    project: Project, model: Assembly, stages: Collection[StateResult], demands: Demands
) -> tuple[dict[Direction, studies.Capacities], list[Message]]:
    """Return the capacity of one state, `model`, from the results under every behaviour, and what to know of it."""
    pushovers = curves(stages)
    assessed = assess(project, model, pushovers, demands) if project.assessment else {}
    return capacities_of(project, stages, pushovers, capacities(assessed)), told(assessed)


def capacities_of(
    project: Project, stages: Collection[StateResult], pushovers: Mapping[Direction, Pushovers],
    checked: Mapping[Direction, Capacity],
) -> dict[Direction, studies.Capacities]:  # fmt: skip
    """Return the capacity of one state for a study, by direction; null: asked for, but not reached.

    `collapses`: under one of the contact behaviours the structure falls before the whole movement is applied;
    a_g and ζ_E are of the farthest limit state.
    """
    contacts, limit = project.pushed_contacts, quoted_limit_state(project) or ""
    found: dict[Direction, studies.Capacities] = {}
    for direction in directions(project):
        pushed, capacity = pushovers.get(direction), checked.get(direction)
        made: dict[str, float | None] = {}
        if "rigid" in contacts:
            rigid = pushed.rigid if pushed else None
            made |= {"alpha_0": rigid.alpha_0 if rigid else None, "d_0_m": rigid.d_0_m if rigid else None}
        if "elastic" in contacts:
            made["alpha_u"] = pushed.elastic.alpha_u if pushed and pushed.elastic else None
        if project.assessment:
            check = capacity.checks.get(limit) if capacity else None
            made |= {"a_g_g": check.a_g_g if check else None, "zeta_E": check.zeta_E if check else None}
        # under one of the behaviours, before the whole movement is applied
        fallen = any(stage.pushdown is not None and stage.reached is None for stage in stages)
        found[direction] = studies.Capacities(collapses=fallen, **made)
    return found


def quoted_limit_state(project: Project) -> str | None:
    """Return the limit state of the capacities a_g that are quoted: the farthest of those asked for."""
    return farthest(project.assessment.limit_states) if project.assessment else None


def quantity(project: Project) -> str:
    """Return the key of the quantity that capacities are compared by: a_g with an assessment, else α0, else α_u."""
    return "a_g_g" if project.assessment else "alpha_0" if "rigid" in project.pushed_contacts else "alpha_u"


def asks_for_scenarios(project: Project) -> bool:
    """Whether there are scenarios to compare: several settlements, or a sweep of one."""
    several = len(project.settlements) > 1 or any(each.steps for each in project.settlements)
    return several and project.pushover is not None


def scenarios(statics: Statics, study: Study) -> studies.Scenarios:
    """Return the capacity of every state, and of each part of a movement with a sweep, in the order of the scenarios.

    With the quantity that they are compared by and the worst point. Parts have the increments of the whole movement.
    """
    project, models = statics.project, statics.models
    variants = {
        (whole.name, k): variant(
            message("part {number} of {count}", number=k, count=whole.steps or 1), finer, models[whole.name],
            part(whole, k / (whole.steps or 1)),
        )
        for finer, whole in finest(project, statics.halvings)
        for k in range(1, whole.steps or 1)
    }  # fmt: skip
    found = analyse(list(variants.values()), statics, study, "scenarios")
    parts = dict(zip(variants, found, strict=True))
    by, original = quantity(project), statics.capacities_of(ORIGINAL)
    sweep = [(ORIGINAL, 0.0, 0.0, original)]
    for settlement in project.settlements:
        *earlier, movement = (
            whole_movement(models[ORIGINAL].settling, each.support, each.displacement_m, each.rotation_rad)
            for each in project.movements_to(settlement.name)
        )
        name, steps = settlement.name, settlement.steps or 1
        for k in range(1, steps + 1):
            numbers = statics.capacities_of(name) if k == steps else parts[name, k]
            sweep.append((name, k / steps, sum(earlier) + k / steps * movement, numbers))
    points = [
        studies.ScenarioPoint(
            state=state, share=share, movement_m=movement, direction=direction,
            reduction=reduction(compared(original[direction], by), compared(capacities, by)),
            **capacities.model_dump(exclude_unset=True),
        )
        for state, share, movement, found_there in sweep
        for direction, capacities in found_there.items()
    ]  # fmt: skip
    return studies.Scenarios(
        quantity=by, limit_state=quoted_limit_state(project), points=points, worst=worst(points, by),
        warnings=list(study.warnings),
    )  # fmt: skip


def part(whole: SettlementTable, share: float) -> SettlementTable:
    """Return the settlement by a `share` (0 to 1) of the `whole` movement, without its search for collapse."""
    x, z = whole.displacement_m
    moved = {"displacement_m": (share * x, share * z), "rotation_rad": share * whole.rotation_rad}
    return whole.model_copy(update=moved | {"to_collapse": False, "steps": None})


def worst(points: Sequence[studies.ScenarioPoint], by: str) -> studies.ScenarioPoint | None:
    """Return the settled point with the lowest capacity; if some collapse, the one with the shortest movement.

    `by`: the quantity that capacities are compared by. None where no settled point has a capacity.
    """
    settled = [point for point in points if point.state != ORIGINAL]
    fallen = [point for point in settled if point.collapses]
    if fallen:
        return min(fallen, key=lambda point: point.movement_m)
    reached = [(value, point) for point in settled if (value := compared(point, by)) is not None]
    return min(reached, key=itemgetter(0))[1] if reached else None


SCATTER = 0.005  # relative difference of a_g from which scatter is reported: the third digit
PROPERTIES = {  # how each is called, and the keys of [material], [geometry] and [layers] that it stands for
    "friction": (message("friction"), "friction"),
    "stiffness": (message("stiffness"), "normal_stiffness_kN_m3", "tangential_stiffness_kN_m3"),
    "unit_weight": (message("unit weight"), "unit_weight_kN_m3"),
    "depth": (message("depth"), "depth_m"),
}


def sensitivity(statics: Statics, study: Study) -> studies.Sensitivity:
    """Analyse every state with each property lower and higher, in its increments, without a search for collapse.

    Raises ProjectError or DrawingError where a model cannot be built.
    """
    project, halvings = statics.project, statics.halvings
    asked = known(project.sensitivity)
    factors = [(key, factor) for key, pair in asked.factors.items() for factor in pair]
    varied = {each: with_factor(project, *each) for each in factors}
    models = {each: build_model(changed).states for each, changed in varied.items()}
    wanted = [name for name in project.states if name in (asked.states or project.states)]
    cases, variants = list(product(factors, wanted)), []
    for (key, factor), name in cases:
        whole = refined(project, halvings.get(name, 0)).settlement_of(name)
        title = message("{property} × {factor:g}", property=PROPERTIES[key][0], factor=factor)
        finer = refined(varied[key, factor], halvings.get(name, 0))
        movement = whole and whole.model_copy(update={"to_collapse": False})
        variants.append(variant(title, finer, models[key, factor][name], movement))
    found = analyse(variants, statics, study, "sensitivity")
    runs = [
        studies.SensitivityRun(
            state=state, property=key, factor=factor, direction=direction, **capacities.model_dump(exclude_unset=True)
        )
        for ((key, factor), state), ways in zip(cases, found, strict=True)
        for direction, capacities in ways.items()
    ]  # fmt: skip
    study.findings += scatter(runs, without_effect(project))
    limit = quoted_limit_state(project)
    return studies.Sensitivity(limit_state=limit, runs=runs, warnings=list(study.warnings))


def without_effect(project: Project) -> set[str]:
    """Return the properties to which all forces are proportional, so that no capacity depends on them.

    The depth is one unless loads, or ties, are given in kN; the unit weight is one if joints neither are elastic nor
    crush.
    """
    loads = any(part.vertical_load_kN or part.variable_load_kN for part in project.parts.values())
    if loads or project.tie:
        return set()
    strengths = [part.compressive_strength_kN_m2 for part in project.parts.values()]
    crushes = any(isfinite(each or inf) for each in (project.material.compressive_strength_kN_m2, *strengths))
    rigid = project.pushover is not None and project.pushover.contacts == ("rigid",) and not crushes
    return {"depth", "unit_weight"} if rigid else {"depth"}


def scatter(runs: Sequence[studies.SensitivityRun], properties: Set[str]) -> list[Message]:
    """Return a finding for each state and direction whose a_g changes with `properties` that it cannot depend on."""
    found, varied = [], properties & {run.property for run in runs}
    for state, direction in dict.fromkeys((run.state, run.direction) for run in runs):
        own = [run for run in runs if (run.state, run.direction) == (state, direction)]
        same = [run.a_g_g for run in own if run.property in properties]
        known = [value for value in same if value is not None]
        spread = float(bool(known))
        if known and len(known) == len(same):
            spread = (max(known) - min(known)) / max(known)
        if spread > SCATTER:
            found.append(message(
                "sensitivity, {state}, {direction}: a_g scatters by {spread:.3g} % with {names}, on which it "
                "cannot depend: bars of this size mean nothing; take smaller increments, and see where paths end",
                state=state, direction=direction, spread=100.0 * spread,
                names=message("unit weight and depth") if len(varied) > 1 else PROPERTIES[min(varied)][0],
            ))  # fmt: skip
    return found


def with_factor(project: Project, key: str, factor: float) -> Project:
    """Return the project with one of PROPERTIES times a `factor` wherever it is given; loads stay as they are."""

    def scaled(table: ProjectTable) -> ProjectTable:
        values = ((name, getattr(table, name, None)) for name in PROPERTIES[key][1:])
        return table.model_copy(update={name: factor * each for name, each in values if each is not None})

    def layered(layers: Mapping[str, ProjectTable]) -> dict[str, ProjectTable]:
        return {name: scaled(layer) for name, layer in layers.items()}

    made = (each.model_copy(update={"layers": layered(each.layers)}) for each in project.strengthening)
    changed: dict[str, Any] = {"geometry": scaled(project.geometry), "material": scaled(project.material)}
    changed |= {"layers": layered(project.layers), "region": tuple(map(scaled, project.region))}
    return project.model_copy(update=changed | {"strengthening": tuple(made)})
