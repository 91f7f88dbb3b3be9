"""All movements side by side: capacity against settlement along each of them, and the worst case.

A point of a sweep is what a scenario of that movement would be: the structure as drawn is settled by that part of
the movement, comes to rest, and is pushed over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from assessment.analyses.static.states import StateResult
from assessment.project.schema import ORIGINAL
from assessment.results.table import reduction
from assessment.studies.increments import refined
from assessment.studies.variants import (
    Demands,
    Numbers,
    Study,
    Variant,
    analyse,
    behaviours,
    capacity_numbers,
    directions,
    quantity,
    quoted_limit_state,
)
from mechanics.procedures import whole_movement

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly


def asks_for_scenarios(project: Project) -> bool:
    """Whether there is something to set side by side: two settlements, or a sweep of one."""
    several = len(project.settlements) > 1 or any(each.steps for each in project.settlements)
    return several and project.pushover is not None


def scenarios(
    project: Project,
    model: Assembly,
    states: Mapping[str, Any],
    stages: Sequence[StateResult],
    halvings: Mapping[str, int],
    demands: Demands,
    workers: Workers,
    study: Study,
) -> Numbers:
    """Review the states that there are, and the parts of each movement that is swept.

    The parts are reviewed with the increments of the whole, halved as often (`halvings` of each state).
    Returns the points in the order of the scenarios, what they are judged by, and the worst of them.
    """
    finest = [
        (refined(project, halvings.get(whole.name, 0)), number)
        for number, whole in enumerate(project.settlements)
    ]
    swept = [
        (finer, finer.settlements[number], k)
        for finer, number in finest
        for k in range(1, finer.settlements[number].steps or 1)
    ]
    variants = [
        Variant(f"part {k} of {whole.steps}", finer, model, part(whole, k / (whole.steps or 1)))
        for finer, whole, k in swept
    ]
    keys = [(whole.name, k) for _, whole, k in swept]
    parts = dict(zip(keys, analyse(variants, demands, workers, study, "scenarios"), strict=True))

    by, original = quantity(project), _of_state(project, states, stages, ORIGINAL)
    points = _points(ORIGINAL, 0.0, 0.0, original, original, by)
    for settlement in project.settlements:
        movement = whole_movement(
            model, settlement.support, settlement.displacement_m, settlement.rotation_rad
        )
        steps = settlement.steps or 1
        for k in range(1, steps + 1):
            last = k == steps
            numbers = (
                _of_state(project, states, stages, settlement.name) if last else parts[settlement.name, k]
            )
            points += _points(settlement.name, k / steps, k / steps * movement, numbers, original, by)
    return {
        "quantity": by,
        "limit_state": quoted_limit_state(project),
        "points": points,
        "worst": worst(points, by),
    }


def part(whole: SettlementTable, share: float) -> SettlementTable:
    """Return the settlement by a share of a movement, not taken on to collapse."""
    x, z = whole.displacement_m
    moved = {"displacement_m": (share * x, share * z), "rotation_rad": share * whole.rotation_rad}
    return whole.model_copy(update=moved | {"to_collapse": False, "steps": None})


def worst(points: Sequence[Numbers], by: str) -> Numbers | None:
    """Return the point of a settlement with the lowest capacity; the shortest movement where some collapse."""
    settled = [point for point in points if point["state"] != ORIGINAL]
    fallen = [point for point in settled if point["collapses"]]
    if fallen:
        return min(fallen, key=lambda point: point["movement_m"])
    known = [point for point in settled if point[by] is not None]
    return min(known, key=lambda point: point[by], default=None)


def _of_state(
    project: Project, states: Mapping[str, Any], stages: Sequence[StateResult], name: str
) -> dict[str, Numbers]:
    """Return what was found of a state of the project, by direction."""
    own = [stage for stage in stages if stage.state == name and stage.behaviour in behaviours(project)]
    curves, checks = states[name]["pushover"], states[name]["capacity"]
    return {
        direction: capacity_numbers(project, own, curves.get(direction, {}), checks.get(direction))
        for direction in directions(project)
    }


def _points(
    state: str,
    share: float,
    movement: float,
    numbers: Mapping[str, Numbers],
    original: Mapping[str, Numbers],
    by: str,
) -> list[Numbers]:
    return [
        {"state": state, "share": share, "movement_m": movement, "direction": direction}
        | found
        | {"reduction": reduction(original[direction][by], found[by])}
        for direction, found in numbers.items()
    ]
