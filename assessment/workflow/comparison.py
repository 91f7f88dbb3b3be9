"""Capacities of each settled state beside those of the original one, static and dynamic."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from assessment.ntc.limit_states import SURFACE
from assessment.project.schema import ORIGINAL
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity, ComparisonRow, Direction
from assessment.results.table import brought_together, quoted_limit_state, reduction, static_pga


def comparison(states: Mapping[str, State]) -> list[ComparisonRow]:
    """Return a row for each settled state and direction; the dynamic capacity is the same in every direction.

    The static capacity is that of the farthest limit state checked, on rock with F_C; the dynamic one is at the surface
    without it, where `static_surface_pga_g` brings the static one before `dynamic_to_static` is taken.
    """
    original = states.get(ORIGINAL)
    if original is None:
        return []
    return [
        _row(name, original, state, direction)
        for name, state in states.items()
        if name != ORIGINAL
        for direction in _directions(original, state)
    ]


def _directions(original: State, state: State) -> Iterator[Direction | None]:
    """Yield the directions of the pushover; None if there is none and the state has a dynamic capacity."""
    if original.pushover:
        yield from original.pushover
    elif state.incremental.records:
        yield None


def _row(name: str, original: State, state: State, direction: Direction | None) -> ComparisonRow:
    was, now = (each.capacity.get(direction) if direction else None for each in (original, state))
    before, after = static_pga(was), static_pga(now)
    limit = _limit_state(was) or _limit_state(now)
    check = now.checks.get(limit) if now and limit else None
    dynamic = state.incremental.pga_collapse_g
    row = ComparisonRow(
        state=name,
        direction=direction,
        limit_state=limit,
        static_pga_g=after,
        static_reduction=reduction(before, after),
        dynamic_pga_g=dynamic,
        dynamic_reduction=reduction(original.incremental.pga_collapse_g, dynamic),
        static_reference=check.reference if check else None,
        dynamic_reference=None if dynamic is None else SURFACE,
    )
    if dynamic is None:
        return row
    return row.replace(**brought_together(now.nominal.pga_g if now and now.nominal else None, dynamic))


def _limit_state(capacity: Capacity | None) -> str | None:
    return quoted_limit_state(capacity.checks) if capacity else None
