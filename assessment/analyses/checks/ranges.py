"""The capacity of a state whose paths scatter: the least one of its ensemble, with the range."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, TypeVar

from assessment.analyses.checks.capacity import Assessed
from assessment.analyses.static.ensemble import QUANTITIES
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity, Direction
from assessment.results.schema.part import Part
from assessment.results.schema.static import Contacts, ElasticPush, PushdownPath, Pushovers, RigidPush
from assessment.results.table import static_pga

Assess = Callable[[Mapping[Direction, Pushovers]], Mapping[Direction, Assessed]]
Ranged = TypeVar("Ranged", bound=Part)
CHECKED = ("a_g_g", "zeta_E")


@dataclass(frozen=True)
class Paths:
    """What a member of an ensemble found: its settlement by behaviour, its curves by direction."""

    pushdown: Mapping[Contacts, PushdownPath]
    pushover: Mapping[Direction, Pushovers]


def with_ranges(state: State, members: Sequence[Paths], assess: Assess) -> State:
    """Return a state with the ranges of the ensemble of its paths, and with its capacity.

    `members`: paths of each further member. In each direction the state takes the curves of the member with the least
    a_g at the farthest limit state. The ultimate movement and every quantity of QUANTITIES and CHECKED become the least
    of all members, with their range; `members` of a curve: the curves of the others.
    """
    pushdown = {
        behaviour: _with_range(
            path,
            "ultimate_movement_m",
            [path, *(each.pushdown[behaviour] for each in members if behaviour in each.pushdown)],
        )
        for behaviour, path in state.pushdown.items()
    }
    pushover, capacity = {}, {}
    for direction, own in state.pushover.items():
        followed = [own, *(each.pushover[direction] for each in members if direction in each.pushover)]
        checked = [assess({direction: each}).get(direction) for each in followed]
        least = min(range(len(followed)), key=lambda number: _capacity(checked[number]))
        lowest = checked[least]
        pushover[direction] = _joined(
            own.control, lowest.curves if lowest else followed[least], least, followed
        )
        if lowest is not None:
            others = [each.capacity for each in checked if each is not None]
            capacity[direction] = _checks(lowest.capacity, others)
    return state.replace(pushdown=pushdown, pushover=pushover, capacity=capacity)


def _capacity(checked: Assessed | None) -> float:
    """Return the a_g at the farthest limit state that was checked, g; infinite if there is none."""
    found = static_pga(checked.capacity if checked else None)
    return float("inf") if found is None else found


def _joined(control: str, chosen: Pushovers, number: int, followed: Sequence[Pushovers]) -> Pushovers:
    """Return the curves of the member of that number with the ranges of all and the curves of the others."""
    curves: dict[Contacts, RigidPush | ElasticPush] = {}
    for behaviour, curve in chosen.by_contacts.items():
        numbered = [
            (place, each.by_contacts[behaviour])
            for place, each in enumerate(followed)
            if behaviour in each.by_contacts
        ]
        others = [each.curve for place, each in numbered if place != number]
        found = curve.replace(members=others)
        for name in QUANTITIES:
            if name in curve.model_fields_set:
                found = _with_range(found, name, [each for _, each in numbered])
        curves[behaviour] = found
    return Pushovers(control=control).replace(**curves)


def _checks(least: Capacity, members: Sequence[Capacity]) -> Capacity:
    """Return the capacity with, at each limit state, the check of the member that is least there.

    So also the linear check with the vertical component.
    """
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
        # of another capacity curve: its steps belong to the check
        steps = [] if lowest is least else lowest.trace
        ranged = check.replace(trace=[*steps, *check.trace])
        for quantity in CHECKED:
            ranged = _with_range(ranged, quantity, [each for _, each, _ in asked])
        found[name] = ranged
    lighter = [each.vertical for each in members if each.vertical]
    if lighter:
        least = least.replace(vertical=min(lighter, key=lambda check: check.ratio))
    return least.with_checks(found)


def _with_range(part: Ranged, name: str, members: Sequence[Part]) -> Ranged:
    """Return the part with the least value of a quantity, and its range; as it is where no member has a value.

    The upper end of the range is open if a member has none.
    """
    values: list[Any] = [getattr(each, name) for each in members if name in each.model_fields_set]
    found = [value for value in values if value is not None]
    if not found:
        return part
    highest = max(found) if len(found) == len(values) else None
    return part.replace(**{name: min(found), f"{name}_range": [min(found), highest]})
