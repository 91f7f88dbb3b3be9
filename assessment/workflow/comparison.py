"""Capacities of each settled state beside the original one, and of each strengthened one beside that before."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from assessment.ntc.tables import SURFACE
from assessment.project.schema import ORIGINAL
from assessment.results.schema import State
from assessment.results.schema.checks import ComparisonRow, Direction, StrengtheningRow
from assessment.results.table import brought_together, quoted_limit_state, reduction, static_pga

COMPARED = ("a_g_g", "alpha_0", "alpha_u", "dynamic_pga_g")  # of which the first that is known gives the gain


def comparison(states: Mapping[str, State]) -> list[ComparisonRow]:
    """Return a row for each settled state and direction; the dynamic capacity is the same in every direction.

    The static capacity is that of the farthest limit state checked, with F_C; the dynamic one has none, and
    `dynamic_to_static` is over `static_surface_pga_g`, which has none either. All are PGA at the surface.
    """
    if ORIGINAL not in states:
        return []
    original, rows = states[ORIGINAL], []
    for name, state in states.items():
        dynamic = state.incremental.pga_collapse_g
        for direction in _directions(original, state) if name != ORIGINAL else ():
            was, now = (each.capacity.get(direction) if direction else None for each in (original, state))
            before, after = static_pga(was), static_pga(now)
            limits = [quoted_limit_state(each.checks) for each in (was, now) if each]
            row = ComparisonRow(
                state=name, direction=direction, limit_state=next(filter(None, limits), None),
                static_pga_g=after, static_reduction=reduction(before, after), dynamic_pga_g=dynamic,
                dynamic_reduction=reduction(original.incremental.pga_collapse_g, dynamic),
                static_reference=None if after is None else SURFACE,
                dynamic_reference=None if dynamic is None else SURFACE,
            )  # fmt: skip
            nominal = now.nominal.pga_g if now and now.nominal else None
            rows.append(row if dynamic is None else row.replace(**brought_together(nominal, dynamic)))
    return rows


def _directions(original: State, state: State) -> Iterable[Direction | None]:
    """Return the directions of the pushover; None if there is none and the state has a dynamic capacity."""
    return original.pushover or ([None] if state.incremental.records else [])


def strengthened(states: Mapping[str, State]) -> list[StrengtheningRow]:
    """Return a row for each strengthened state and direction: its capacities beside those of the state before.

    The limit state of ζ_E is SLV (NTC 2018, §8.3), the farthest one where it was not checked. A quantity before the
    strengthening has its unit last: a_g_before_g.
    """
    rows = []
    for name, state in states.items():
        made = state.strengthening
        for direction in _directions(states[made.of], state) if made and made.of in states else ():
            of = made.of if made else ""
            (was, limit_was), (now, limit) = (_measured(states[each], direction) for each in (of, name))
            row: dict[str, Any] = {}
            for key in {**was, **now}:
                stem, _, unit = key.rpartition("_")
                row[f"{stem}_before_{unit}" if unit in {"m", "g"} else f"{key}_before"] = was.get(key)
                row[key] = now.get(key)
            by = next((key for key in COMPARED if was.get(key) is not None), "")
            if was.get(by) and now.get(by) is not None:
                row["gain"] = now[by] / was[by] - 1.0
            if limit_was or limit:
                row["limit_state"] = limit_was or limit
            rows.append(StrengtheningRow(state=name, of=of, direction=direction, **({"gain": None} | row)))
    return rows


def _measured(state: State, direction: Direction | None) -> tuple[dict[str, Any], str | None]:
    """Return the capacities of a state in a direction, those that were asked for, and the limit state checked."""
    found: dict[str, Any] = {}
    pushed = state.pushover.get(direction) if direction else None
    capacity = state.capacity.get(direction) if direction else None
    if pushed and pushed.rigid:
        found |= {"alpha_0": pushed.rigid.alpha_0, "d_0_m": pushed.rigid.d_0_m}
    if pushed and pushed.elastic:
        found["alpha_u"] = pushed.elastic.alpha_u
    limit = ("SLV" if "SLV" in capacity.checks else quoted_limit_state(capacity.checks)) if capacity else None
    if capacity and limit:
        check = capacity.checks[limit]
        found |= {"a_g_g": check.a_g_g, "zeta_E": check.zeta_E}
    if state.incremental.records is not None:
        found["dynamic_pga_g"] = state.incremental.pga_collapse_g
    return found, limit
