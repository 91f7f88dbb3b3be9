"""Scenarios: the capacity against settlement along every movement, and the worst case.

A point of a sweep is a scenario of its own: the structure as drawn settles by a part of the movement, comes to rest,
and is pushed over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import TYPE_CHECKING

from assessment.analyses.static.increments import finest
from assessment.project.schema import ORIGINAL
from assessment.results.schema.studies import Capacities, ScenarioPoint, Scenarios
from assessment.results.table import compared, reduction
from assessment.studies.variants import (
    Statics,
    Study,
    Variant,
    analyse,
    capacities_of,
    quantity,
    quoted_limit_state,
)
from mechanics.messages import message
from mechanics.procedures import whole_movement

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.project.structure.model import StateModel
    from assessment.runtime.tasks import Workers
    from mechanics.model import Direction


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
