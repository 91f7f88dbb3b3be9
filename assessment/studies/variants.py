"""Variants of a project beside its states: sweeps of movements with the worst case, and properties lower and higher.

A point of a sweep is a scenario of its own: the structure as drawn settles by a part of the movement, comes to rest,
and is pushed over. A sensitivity varies one property in all blocks at once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import product
from math import inf, isfinite
from operator import itemgetter

from assessment.analyses.checks.capacity import assess, capacities, told
from assessment.analyses.checks.demand import Demands
from assessment.analyses.found import finest, refined
from assessment.analyses.static.states import Request, StateResult, analyse_states, curves
from assessment.ntc.tables import QUOTED
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, SettlementTable, Table
from assessment.project.structure.model import StateModel, build_model
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity
from assessment.results.schema.model import QualityRow
from assessment.results.schema.static import Pushovers
from assessment.results.schema.studies import (
    Capacities,
    ScenarioPoint,
    Scenarios,
    Sensitivity,
    SensitivityRun,
)
from assessment.results.table import compared, reduction
from assessment.runtime.tasks import Workers
from mechanics.messages import Message, headed, message
from mechanics.model import Direction
from mechanics.procedures import whole_movement


@dataclass(frozen=True)
class Variant:
    """A project and the model of a state after a settlement (None: as drawn); `what`: how it differs from the state."""

    what: str
    project: Project
    model: StateModel
    settlement: SettlementTable | None

    @property
    def title(self) -> Message:
        """The variant and its state, for messages."""
        return message("{what}: {state}", what=self.what, state=self.model.name)


@dataclass(frozen=True, eq=False)
class Statics:
    """What the static analyses gave: each state as results.json has it, and the results behind it.

    `halvings`: how often the increments of each state were halved; the studies of a state halve theirs as often.
    """

    states: Mapping[str, State]
    stages: Sequence[StateResult]
    halvings: Mapping[str, int]

    def stages_of(self, name: str) -> list[StateResult]:
        """Return the results of a state, one for each contact behaviour."""
        return [stage for stage in self.stages if stage.state == name]


@dataclass
class Study:
    """Rows of quality, warnings and failures of the runs of a study, findings about all of them, and their time (s)."""

    quality: list[QualityRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)
    findings: list[Message] = field(default_factory=list)
    failures: list[Message] = field(default_factory=list)
    seconds: float = 0.0

    def take(self, title: str, stages: Iterable[StateResult]) -> None:
        """Add quality, times and messages of the analyses of a variant; the messages get its title."""
        for stage in stages:
            self.quality += stage.quality
            self.seconds += sum(stage.seconds.values())
            self.warnings += [headed(title, text) for text in stage.warnings]
            self.failures += [headed(title, text) for text in stage.failures]


def analyse(
    variants: Sequence[Variant], demands: Demands, workers: Workers, study: Study, name: str
) -> Iterator[dict[Direction, Capacities]]:
    """Settle and push over every variant; yield the capacity of each by direction, in order; `name`: of the study.

    Messages, certificates and times go to `study`. Raises KilledError where a process was ended from outside.
    """
    requests = [
        Request(variant.project, variant.model, variant.settlement, behaviour, f"{variant.what}: ")
        for variant in variants
        for behaviour in variant.project.pushed_contacts
    ]
    each = len(requests) // max(1, len(variants))
    results = iter(analyse_states(requests, workers, name))
    for variant in variants:
        stages = [next(results) for _ in range(each)]
        study.take(variant.what, stages)
        pushovers = curves(stages)
        checked: dict[Direction, Capacity] = {}
        if variant.project.assessment:
            found = assess(variant.project, variant.model.assembly, pushovers, demands)
            checked = capacities(found)
            study.warnings += [headed(variant.title, note) for note in told(found)]
        yield capacities_of(variant.project, stages, pushovers, checked)


def directions(project: Project) -> tuple[Direction, ...]:
    """Return the directions of the pushover."""
    return project.pushover.directions if project.pushover else ()


def capacities_of(
    project: Project,
    stages: Collection[StateResult],
    pushovers: Mapping[Direction, Pushovers],
    checked: Mapping[Direction, Capacity],
) -> dict[Direction, Capacities]:
    """Return the capacity of one state for a study, by direction; null: asked for, but not reached.

    `collapses`: under one of the contact behaviours the structure falls before the whole movement is applied;
    a_g and ζ_E are of the farthest limit state.
    """
    fallen = any(stage.pushdown is not None and stage.reached is None for stage in stages)
    return {
        direction: _capacities(project, fallen, pushovers.get(direction), checked.get(direction))
        for direction in directions(project)
    }


def _capacities(
    project: Project, fallen: bool, pushed: Pushovers | None, capacity: Capacity | None
) -> Capacities:
    found = Capacities(collapses=fallen)
    if "rigid" in project.pushed_contacts:
        rigid = pushed.rigid if pushed else None
        found = found.replace(alpha_0=rigid.alpha_0 if rigid else None, d_0_m=rigid.d_0_m if rigid else None)
    if "elastic" in project.pushed_contacts:
        elastic = pushed.elastic if pushed else None
        found = found.replace(alpha_u=elastic.alpha_u if elastic else None)
    if project.assessment:
        check = capacity.checks.get(quoted_limit_state(project) or "") if capacity else None
        found = found.replace(a_g_g=check.a_g_g if check else None, zeta_E=check.zeta_E if check else None)
    return found


def quoted_limit_state(project: Project) -> str | None:
    """Return the limit state of the capacities a_g that are quoted: the farthest of those asked for."""
    asked = project.assessment.limit_states if project.assessment else ()
    return next((limit for limit in QUOTED if limit in asked), None)


def quantity(project: Project) -> str:
    """Return the key of the quantity that capacities are compared by: a_g with an assessment, else α0, else α_u."""
    return "a_g_g" if project.assessment else "alpha_0" if "rigid" in project.pushed_contacts else "alpha_u"


def asks_for_scenarios(project: Project) -> bool:
    """Whether there are scenarios to compare: several settlements, or a sweep of one."""
    several = len(project.settlements) > 1 or any(each.steps for each in project.settlements)
    return several and project.pushover is not None


def scenarios(
    project: Project,
    models: Mapping[str, StateModel],
    statics: Statics,
    demands: Demands,
    workers: Workers,
    study: Study,
) -> Scenarios:
    """Return the capacity of every state, and of each part of a movement with a sweep, in the order of the scenarios.

    With the quantity that they are compared by (see `quantity`) and the worst point. Parts have the increments of the
    whole movement, halved as often. Messages, certificates and times go to `study`. Raises KilledError where a process
    was ended from outside.
    """
    swept = [
        (finer, whole, k)
        for finer, whole in finest(project, statics.halvings)
        for k in range(1, whole.steps or 1)
    ]
    variants = [
        Variant(
            message("part {number} of {count}", number=k, count=whole.steps or 1),
            finer,
            models[whole.name],
            part(whole, k / (whole.steps or 1)),
        )
        for finer, whole, k in swept
    ]
    keys = [(whole.name, k) for _, whole, k in swept]
    parts = dict(zip(keys, analyse(variants, demands, workers, study, "scenarios"), strict=True))

    by, original = quantity(project), _of_state(project, statics, ORIGINAL)
    points = _points(ORIGINAL, 0.0, 0.0, original, original, by)
    for settlement in project.settlements:
        *earlier, movement = (
            whole_movement(models[ORIGINAL].settling, each.support, each.displacement_m, each.rotation_rad)
            for each in project.movements_to(settlement.name)
        )
        steps = settlement.steps or 1
        for k in range(1, steps + 1):
            last = k == steps
            numbers = _of_state(project, statics, settlement.name) if last else parts[settlement.name, k]
            length = sum(earlier) + k / steps * movement
            points += _points(settlement.name, k / steps, length, numbers, original, by)
    return Scenarios(
        quantity=by,
        limit_state=quoted_limit_state(project),
        points=points,
        worst=worst(points, by),
        warnings=list(study.warnings),
    )


def part(whole: SettlementTable, share: float) -> SettlementTable:
    """Return the settlement by a `share` (0 to 1) of the `whole` movement, without its search for collapse."""
    x, z = whole.displacement_m
    moved = {"displacement_m": (share * x, share * z), "rotation_rad": share * whole.rotation_rad}
    return whole.model_copy(update=moved | {"to_collapse": False, "steps": None})


def worst(points: Sequence[ScenarioPoint], by: str) -> ScenarioPoint | None:
    """Return the settled point with the lowest capacity; if some collapse, the one with the shortest movement.

    `by`: the quantity that capacities are compared by. None where no settled point has a capacity.
    """
    settled = [point for point in points if point.state != ORIGINAL]
    fallen = [point for point in settled if point.collapses]
    if fallen:
        return min(fallen, key=lambda point: point.movement_m)
    reached = [(value, point) for point in settled if (value := compared(point, by)) is not None]
    return min(reached, key=itemgetter(0))[1] if reached else None


def _of_state(project: Project, statics: Statics, name: str) -> dict[Direction, Capacities]:
    """Return the capacity of a state of the project, by direction."""
    own = [stage for stage in statics.stages_of(name) if stage.behaviour in project.pushed_contacts]
    state = statics.states[name]
    return capacities_of(project, own, state.pushover, state.capacity)


def _points(
    state: str,
    share: float,
    movement: float,
    found: Mapping[Direction, Capacities],
    original: Mapping[Direction, Capacities],
    by: str,
) -> list[ScenarioPoint]:
    """Return the point of a part of a movement (its largest component `movement`, m) in each direction."""
    return [
        ScenarioPoint(
            state=state,
            share=share,
            movement_m=movement,
            direction=direction,
            **capacities.model_dump(exclude_unset=True),
            reduction=reduction(compared(original[direction], by), compared(capacities, by)),
        )
        for direction, capacities in found.items()
    ]


SCATTER = 0.005  # relative difference of a_g from which scatter is reported: the third digit
KEYS = {  # property: the keys of [material], [geometry] and [layers] that it stands for
    "friction": ("friction",),
    "stiffness": ("normal_stiffness_kN_m3", "tangential_stiffness_kN_m3"),
    "unit_weight": ("unit_weight_kN_m3",),
    "depth": ("depth_m",),
}
NAMES = {
    "friction": message("friction"),
    "stiffness": message("stiffness"),
    "unit_weight": message("unit weight"),
    "depth": message("depth"),
}


def sensitivity(
    project: Project, halvings: Mapping[str, int], demands: Demands, workers: Workers, study: Study
) -> Sensitivity:
    """Analyse every state with each property lower and higher; return two runs for each property, state and direction.

    `halvings`: how often the increments of each state were halved; the runs halve theirs as often, so that only the
    property differs. Messages, certificates and times go to `study`. Raises ProjectError or DrawingError where a model
    cannot be built, KilledError where a process was ended from outside.
    """
    assert project.sensitivity is not None
    factors = [(key, factor) for key, pair in project.sensitivity.factors.items() for factor in pair]
    varied = {each: with_factor(project, *each) for each in factors}
    models = {each: build_model(changed).states for each, changed in varied.items()}
    cases = list(product(factors, _states(project, halvings).items()))
    variants = [
        Variant(
            message("{property} × {factor:g}", property=NAMES[key], factor=factor),
            refined(varied[key, factor], halvings.get(state, 0)),
            models[key, factor][state],
            settlement,
        )
        for (key, factor), (state, settlement) in cases
    ]
    runs = [
        SensitivityRun(
            state=state,
            property=key,
            factor=factor,
            direction=direction,
            **capacities.model_dump(exclude_unset=True),
        )
        for ((key, factor), (state, _)), found in zip(
            cases, analyse(variants, demands, workers, study, "sensitivity"), strict=True
        )
        for direction, capacities in found.items()
    ]
    study.findings += scatter(runs, without_effect(project))
    return Sensitivity(limit_state=quoted_limit_state(project), runs=runs, warnings=list(study.warnings))


def without_effect(project: Project) -> set[str]:
    """Return the properties to which all forces are proportional, so that no capacity depends on them.

    The depth is one unless loads, or ties, are given in kN; the unit weight is one if joints neither are elastic nor
    crush.
    """
    loads = any(part.vertical_load_kN or part.variable_load_kN for part in project.parts.values())
    if loads or project.tie:
        return set()
    strengths = [part.compressive_strength_kN_m2 for part in project.parts.values()]
    crushes = any(
        isfinite(strength or inf) for strength in (project.material.compressive_strength_kN_m2, *strengths)
    )
    rigid = project.pushover is not None and project.pushover.contacts == ("rigid",) and not crushes
    return {"depth", "unit_weight"} if rigid else {"depth"}


def scatter(runs: Sequence[SensitivityRun], properties: Set[str]) -> list[Message]:
    """Return a finding for each state and direction whose a_g changes with `properties` that it cannot depend on."""
    found = []
    varied = properties & {run.property for run in runs}
    for state, direction in dict.fromkeys((run.state, run.direction) for run in runs):
        same = [
            run.a_g_g
            for run in runs
            if (run.state, run.direction) == (state, direction) and run.property in properties
        ]
        known = [value for value in same if value is not None]
        spread = (
            (max(known) - min(known)) / max(known)
            if known and len(known) == len(same)
            else float(bool(known))
        )
        if spread > SCATTER:
            found.append(
                message(
                    "sensitivity, {state}, {direction}: a_g scatters by {spread:.3g} % with {names}, on which it "
                    "cannot depend: bars of this size mean nothing; take smaller increments, and see where paths end",
                    state=state,
                    direction=direction,
                    spread=100.0 * spread,
                    names=_named(varied),
                )
            )
    return found


def _named(properties: Set[str]) -> Message:
    """Return the names of one or both of depth and unit weight."""
    return message("unit weight and depth") if len(properties) > 1 else NAMES[min(properties)]


def with_factor(project: Project, key: str, factor: float) -> Project:
    """Return the project with a property (see KEYS) times a `factor` wherever it is given; loads stay as they are."""

    def scaled(table: Table) -> Table:
        values = {name: getattr(table, name, None) for name in KEYS[key]}
        return table.model_copy(
            update={name: factor * value for name, value in values.items() if value is not None}
        )

    return project.model_copy(
        update={
            "geometry": scaled(project.geometry),
            "material": scaled(project.material),
            "layers": {name: scaled(layer) for name, layer in project.layers.items()},
            "region": tuple(map(scaled, project.region)),
            "strengthening": tuple(
                made.model_copy(
                    update={"layers": {name: scaled(layer) for name, layer in made.layers.items()}}
                )
                for made in project.strengthening
            ),
        }
    )


def _states(project: Project, halvings: Mapping[str, int]) -> dict[str, SettlementTable | None]:
    """Return the states to vary with their movements, without the search for collapse; None: as drawn."""
    assert project.sensitivity is not None
    wanted = project.sensitivity.states or project.states
    found: dict[str, SettlementTable | None] = {}
    for name in (each for each in project.states if each in wanted):
        whole = refined(project, halvings.get(name, 0)).settlement_of(name)
        found[name] = whole and whole.model_copy(update={"to_collapse": False})
    return found
