"""The capacity of a state whose paths scatter: the least one of its ensemble, with the range."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import Any

from assessment.analyses.static.ensemble import QUANTITIES
from assessment.results.schema.checks import Capacity, Direction
from assessment.results.table import static_pga

Curves = Mapping[Direction, Mapping[str, Any]]  # of a state: numbers by direction and behaviour
Assess = Callable[[Curves], Mapping[Direction, Capacity]]
CHECKED = ("a_g_g", "zeta_E")


def with_ranges(
    state: dict[str, Any], members: Sequence[tuple[Mapping[str, Any], Curves]], assess: Assess
) -> dict[Direction, Capacity]:
    """Return the capacity of a state from the ensemble of its paths; the curves in `state` become those of it.

    `members`: settlements by behaviour, and curves, of each further member. In each direction the state takes the
    curves of the member with the least a_g at the farthest limit state. The ultimate movement and every quantity of
    QUANTITIES and CHECKED become the least of all members, with their range; `members` of a curve: the curves of the
    others.
    """
    for behaviour, numbers in state["pushdown"].items():
        others = [pushdown.get(behaviour) or {} for pushdown, _ in members]
        _with_range(numbers, "ultimate_movement_m", [numbers, *others])
    capacity = {}
    for direction, own in state["pushover"].items():
        followed = [own, *(curves[direction] for _, curves in members if direction in curves)]
        checked = [assess({direction: each}).get(direction) for each in followed]
        least = min(range(len(followed)), key=lambda number: _capacity(checked[number]))
        state["pushover"][direction] = {"control": own["control"]} | {
            behaviour: _joined(numbers, [each[behaviour] for each in followed if behaviour in each])
            for behaviour, numbers in followed[least].items()
            if behaviour != "control"
        }
        lowest = checked[least]
        if lowest is not None:
            capacity[direction] = _checks(lowest, [each for each in checked if each is not None])
    return capacity


def _capacity(checked: Capacity | None) -> float:
    """Return the a_g at the farthest limit state that was checked, g; infinite if there is none."""
    found = static_pga(checked)
    return float("inf") if found is None else found


def _joined(numbers: Mapping[str, Any], followed: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the numbers of a curve with the ranges of all and the curves of the others."""
    found = {
        key: value for key, value in numbers.items() if key != "control"
    }  # the state has it once for both behaviours
    for name in QUANTITIES:
        if name in found:
            _with_range(found, name, followed)
    found["members"] = [each["curve"] for each in followed if each is not numbers]
    return found


def _checks(least: Capacity, members: Sequence[Capacity]) -> Capacity:
    """Return the capacity with, at each limit state, the check of the member that is least there."""
    found = {}
    for name in least.checks:
        asked = [
            (check.a_g_g, check, each)
            for each in members
            if (check := each.checks.get(name)) is not None and check.a_g_g is not None
        ]
        if not asked:
            continue
        _, check, lowest = min(asked, key=itemgetter(0))
        ranges: dict[str, Any] = {}
        for quantity in CHECKED:
            ranges |= _range(quantity, [getattr(each, quantity) for _, each, _ in asked])
        # of another capacity curve: its steps belong to the check
        steps = [] if lowest is least else lowest.trace
        found[name.replace(" ", "_")] = check.model_copy(update=ranges | {"trace": [*steps, *check.trace]})
    return least.model_copy(update=found)


def _with_range(numbers: dict[str, Any], name: str, members: Sequence[Mapping[str, Any]]) -> None:
    """Set a quantity to the least of the members, and add its range."""
    numbers |= _range(name, [each[name] for each in members if name in each])


def _range(name: str, values: Sequence[float | None]) -> dict[str, Any]:
    """Return the least value of a quantity and its range; its upper end is open if a member has no value.

    Nothing where no member has one.
    """
    found = [value for value in values if value is not None]
    if not found:
        return {}
    highest = max(found) if len(found) == len(values) else None
    return {name: min(found), f"{name}_range": [min(found), highest]}
