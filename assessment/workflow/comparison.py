"""Capacities of each settled state beside the original one, and of each strengthened one beside that before."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from assessment.ntc.tables import SURFACE
from assessment.project.schema import ORIGINAL
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity, ComparisonRow, Direction, StrengtheningRow
from assessment.results.table import brought_together, quoted_limit_state, reduction, static_pga

COMPARED = ("a_g_g", "alpha_0", "alpha_u", "dynamic_pga_g")  # of which the first that is known gives the gain


def comparison(states: Mapping[str, State]) -> list[ComparisonRow]:
    """Return a row for each settled state and direction; the dynamic capacity is the same in every direction.

    The static capacity is that of the farthest limit state checked, with F_C; the dynamic one has none, and
    `dynamic_to_static` is over `static_surface_pga_g`, which has none either. All are PGA at the surface.
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
    dynamic = state.incremental.pga_collapse_g
    row = ComparisonRow(
        state=name,
        direction=direction,
        limit_state=limit,
        static_pga_g=after,
        static_reduction=reduction(before, after),
        dynamic_pga_g=dynamic,
        dynamic_reduction=reduction(original.incremental.pga_collapse_g, dynamic),
        static_reference=None if after is None else SURFACE,
        dynamic_reference=None if dynamic is None else SURFACE,
    )
    if dynamic is None:
        return row
    return row.replace(**brought_together(now.nominal.pga_g if now and now.nominal else None, dynamic))


def _limit_state(capacity: Capacity | None) -> str | None:
    return quoted_limit_state(capacity.checks) if capacity else None


def strengthened(states: Mapping[str, State]) -> list[StrengtheningRow]:
    """Return a row for each strengthened state and direction: its capacities beside those of the state before."""
    return [
        _strengthened(name, made.of, states, direction)
        for name, state in states.items()
        if (made := state.strengthening) is not None and made.of in states
        for direction in _directions(states[made.of], state)
    ]


def _strengthened(
    name: str, of: str, states: Mapping[str, State], direction: Direction | None
) -> StrengtheningRow:
    before, after = (_measured(states[each], direction) for each in (of, name))
    found = {_before(key): before.get(key) for key in {**before, **after}} | {
        key: after.get(key) for key in {**before, **after}
    }
    by = next((key for key in COMPARED if before.get(key) is not None), None)
    gain = None
    if by is not None and before[by] and after.get(by) is not None:
        gain = after[by] / before[by] - 1.0
    limits = [_checked(states[each].capacity.get(direction)) for each in (of, name) if direction]
    if limit := next((limit for limit in limits if limit), None):
        found["limit_state"] = limit
    return StrengtheningRow(state=name, of=of, direction=direction, gain=gain, **found)


def _measured(state: State, direction: Direction | None) -> dict[str, Any]:
    """Return the capacities of a state in a direction, those that were asked for."""
    found: dict[str, Any] = {}
    pushed = state.pushover.get(direction) if direction else None
    if pushed and pushed.rigid:
        found |= {"alpha_0": pushed.rigid.alpha_0, "d_0_m": pushed.rigid.d_0_m}
    if pushed and pushed.elastic:
        found["alpha_u"] = pushed.elastic.alpha_u
    capacity = state.capacity.get(direction) if direction else None
    limit = _checked(capacity)
    if capacity and limit:
        check = capacity.checks[limit]
        found |= {"a_g_g": check.a_g_g, "zeta_E": check.zeta_E}
    if state.incremental.records is not None:
        found["dynamic_pga_g"] = state.incremental.pga_collapse_g
    return found


def _checked(capacity: Capacity | None) -> str | None:
    """Return the limit state of ζ_E: SLV (NTC 2018, §8.3), the farthest one where it was not checked."""
    if capacity is None:
        return None
    return "SLV" if "SLV" in capacity.checks else quoted_limit_state(capacity.checks)


def _before(key: str) -> str:
    """Name a quantity before the strengthening, its unit last: a_g_before_g."""
    stem, _, unit = key.rpartition("_")
    return f"{stem}_before_{unit}" if unit in {"m", "g"} else f"{key}_before"
