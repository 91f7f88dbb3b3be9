"""The capacity of a state whose paths scatter: the least one of its ensemble, with the range."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from assessment.analyses.static.ensemble import QUANTITIES
from assessment.ntc.limit_states import CHECKS
from assessment.results.table import quoted_limit_state

Curves = Mapping[str, Mapping[str, Any]]  # of a state: numbers by direction and behaviour
Assess = Callable[[Curves], dict[str, Any]]
CHECKED = ("a_g_g", "zeta_E")


def with_ranges(
    state: dict[str, Any], members: Sequence[tuple[Mapping[str, Any], Curves]], assess: Assess
) -> dict[str, Any]:
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


def _capacity(checked: Mapping[str, Any] | None) -> float:
    """Return the a_g at the farthest limit state that was checked; infinite if there is none."""
    limit_state = quoted_limit_state(checked or {})
    found = checked[limit_state]["a_g_g"] if checked and limit_state else None
    return float("inf") if found is None else float(found)


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


def _checks(least: Mapping[str, Any], known: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the checks of the least member; at each limit state the check of the member that is least there."""
    found = dict(least)
    for limit_state in CHECKS:
        asked = [each for each in known if each.get(limit_state) and each[limit_state]["a_g_g"] is not None]
        if not asked or not found.get(limit_state):
            continue
        lowest = min(asked, key=lambda each: each[limit_state]["a_g_g"])
        check = dict(lowest[limit_state])
        if lowest is not least:  # of another capacity curve: its steps belong to the check
            check["trace"] = [*lowest["trace"], *check["trace"]]
        for name in CHECKED:
            _with_range(check, name, [each[limit_state] for each in asked])
        found[limit_state] = check
    return found


def _with_range(numbers: dict[str, Any], name: str, members: Sequence[Mapping[str, Any]]) -> None:
    """Set a quantity to the least of the members, and add its range; its upper end is open if a member has no value."""
    values = [each[name] for each in members if name in each]
    known = [value for value in values if value is not None]
    if known:
        highest = max(known) if len(known) == len(values) else None
        numbers[name], numbers[f"{name}_range"] = min(known), [min(known), highest]
