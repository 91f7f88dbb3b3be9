"""The governing run of a state whose paths scatter: of its ensemble the one with the least capacity, by direction.

Everything that is told of a state and direction comes from that run; the range over all runs stands beside a quantity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, TypeVar

from assessment.analyses.checks.capacity import Assessed
from assessment.analyses.static.ensemble import ENSEMBLE, QUANTITIES
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity, Direction
from assessment.results.schema.part import Part
from assessment.results.schema.static import Contacts, ElasticPush, PushdownPath, Pushovers, RigidPush
from assessment.results.table import indices

Assess = Callable[[Mapping[Direction, Pushovers]], Mapping[Direction, Assessed]]
Ranged = TypeVar("Ranged", bound=Part)
CHECKED = ("a_g_g", "zeta_E")


@dataclass(frozen=True)
class Paths:
    """What a run of a state found: its settlement by behaviour, its curves by direction."""

    pushdown: Mapping[Contacts, PushdownPath]
    pushover: Mapping[Direction, Pushovers]


def governed(state: State, members: Sequence[Paths], assess: Assess) -> State:
    """Return a state with, in each direction, curves, mechanism and capacity of its governing run, and their ranges.

    `members`: paths of each further run. `members` of a curve: the curves of the other runs. A movement is that of the
    run with the least ultimate one.
    """
    pushdown = {
        behaviour: _least_movement(
            [path, *(each.pushdown[behaviour] for each in members if behaviour in each.pushdown)]
        )
        for behaviour, path in state.pushdown.items()
    }
    pushover, capacity = {}, {}
    for direction, own in state.pushover.items():
        runs = [own, *(each.pushover[direction] for each in members if direction in each.pushover)]
        checked = [assess({direction: each}).get(direction) for each in runs]
        number = _least_capacity(runs, [each.capacity if each else None for each in checked])
        governing = checked[number]
        curves = governing.curves if governing else runs[number]
        pushover[direction] = _with_curves(curves, number, runs)
        if governing is not None:
            capacity[direction] = _with_ranges(
                governing.capacity, [each.capacity for each in checked if each is not None]
            )
    return state.replace(pushdown=pushdown, pushover=pushover, capacity=capacity)


def _least_capacity(runs: Sequence[Pushovers], capacities: Sequence[Capacity | None]) -> int:
    """Return the number of the run with the least index ζ_E at SLV and SLC, or ratio where neither was checked.

    Without any, that with the least α0 (of elastic joints alone α_u); where several agree in it, the least d_0 of them.
    """
    ratios = [each.ratios if each else {} for each in capacities]
    least = [min((indices(each) or each).values(), default=inf) for each in ratios]
    if min(least) < inf:
        return least.index(min(least))
    alpha, d_0 = [], []
    for each in runs:
        told = each.rigid.alpha_0 if each.rigid else each.elastic.alpha_u if each.elastic else inf
        end = each.rigid.d_0_m if each.rigid else None
        alpha.append(told)
        d_0.append(inf if end is None else end)
    agreeing = [k for k, each in enumerate(alpha) if each <= min(alpha) * (1.0 + ENSEMBLE.agree)]
    return min(agreeing, key=lambda k: d_0[k])


def _least_movement(runs: Sequence[PushdownPath]) -> PushdownPath:
    """Return the path of the run with the least ultimate movement, and its range; the first where none has one."""
    ultimate = [each.ultimate_movement_m for each in runs]
    known = [each for each in ultimate if each is not None]
    least = runs[ultimate.index(min(known))] if known else runs[0]
    return _ranged(least, ("ultimate_movement_m",), runs)


def _with_curves(chosen: Pushovers, number: int, runs: Sequence[Pushovers]) -> Pushovers:
    """Return the curves of the run of that number, with the ranges of all and the curves of the others."""
    found: dict[Contacts, RigidPush | ElasticPush] = {}
    for behaviour, curve in chosen.by_contacts.items():
        numbered = [
            (k, each.by_contacts[behaviour]) for k, each in enumerate(runs) if behaviour in each.by_contacts
        ]
        others = [each.curve for k, each in numbered if k != number]
        found[behaviour] = _ranged(curve.replace(members=others), QUANTITIES, [each for _, each in numbered])
    return chosen.replace(**found)


def _with_ranges(governing: Capacity, runs: Sequence[Capacity]) -> Capacity:
    """Return the capacity of the governing run with the range of each of its checks over the runs."""
    return governing.with_checks(
        {
            name: _ranged(check, CHECKED, [each.checks[name] for each in runs if name in each.checks])
            for name, check in governing.checks.items()
        }
    )


def _ranged(part: Ranged, names: Sequence[str], runs: Sequence[Part]) -> Ranged:
    """Return the part with the range of each of its quantities, in which another choice of increments is expected.

    It is wider than the span of the runs, not below zero, and open above where a run has no value.
    """
    ranges: dict[str, Any] = {}
    for name in names:
        values = [getattr(each, name) for each in runs if name in each.model_fields_set]
        known = [value for value in values if value is not None]
        if name in part.model_fields_set and known:
            more = ENSEMBLE.wider * (max(known) - min(known))
            above = max(known) + more if len(known) == len(values) else None
            ranges[f"{name}_range"] = [max(0.0, min(known) - more), above]
    return part.replace(**ranges)
