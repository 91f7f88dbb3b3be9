"""The summary of results, and what is read off it: indices by state and direction, their loss, the rows that govern."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from assessment.ntc.tables import INDEXED, SURFACE
from assessment.results.asked import directions_asked, limit_states
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Capacity, Direction
from assessment.results.schema.static import Mechanism, OtherLaw, Pushovers
from assessment.results.schema.summary import (
    Summary,
    SummaryCheck,
    SummaryGoverning,
    SummaryMechanism,
    SummaryRow,
)
from assessment.results.table import quoted_limit_state, reduction, static_pga

ORIGINAL = "original"
EMPTY = Summary(reference=SURFACE, governing=None, verified=None, rows=[])
"""Of results without any analysis."""


def summary_of(results: Results) -> Summary:
    """Return the summary of every state and direction asked for, and where ζ_E is least."""
    asked: list[Direction | None] = [*directions_asked(results)]
    shaken = any(state.incremental.records is not None for state in results.states.values())
    if not asked and shaken:
        asked = [None]
    limits = limit_states(results.echo)
    rows = [_row(results.states, name, way, limits) for name in results.states for way in asked]
    index = next((limit for limit in INDEXED if limit in limits), None)
    found = [
        SummaryGoverning(state=row.state, direction=row.direction, limit_state=limit, zeta_E=ratio)
        for row in rows
        for limit, check in row.checks.items()
        if (ratio := check.zeta_E) is not None and row.direction is not None and limit == (index or limit)
    ]
    least = min(found, key=lambda each: each.zeta_E, default=None)
    return Summary(reference=SURFACE, governing=least, verified=_all(row.verified for row in rows), rows=rows)


def _row(
    states: dict[str, State], name: str, direction: Direction | None, limits: Iterable[str]
) -> SummaryRow:
    """Return the row of a state in a direction, its losses from the original state in the same direction."""

    def there(of: State | None) -> tuple[Capacity | None, Pushovers | None]:
        return (of.capacity.get(direction), of.pushover.get(direction)) if of and direction else (None, None)

    state, original = states[name], states.get(ORIGINAL) if name != ORIGINAL else None
    (capacity, pushed), (was, before) = there(state), there(original)
    checks = {limit: _counting(capacity, limit) for limit in limits}
    for limit, check in checks.items() if original else ():
        checks[limit] = check.replace(loss=reduction(_counting(was, limit).zeta_E, check.zeta_E))
    if (made := state.strengthening) is not None and made.of in states:
        for limit, check in checks.items():
            change = reduction(_counting(there(states[made.of])[0], limit).zeta_E, check.zeta_E)
            checks[limit] = check.replace(gain=None if change is None else -change)
    ratios = {limit: ratio for limit, check in checks.items() if (ratio := check.zeta_E) is not None}
    indexed = [limit for limit in INDEXED if limit in checks] or list(checks)
    row: dict[str, Any] = {"state": name, "direction": direction, "checks": checks}
    before_it = (
        states.get(made.of) if made else state
    )  # not reached: its configuration is that of the drawing
    row["reached"] = before_it is None or before_it.settlement is None or any(map(any, state.configuration))
    row["governing"] = min(ratios, key=lambda limit: ratios[limit], default=None)
    row["verified"] = _all(checks[limit].verified for limit in indexed)
    row["limit_state"] = quoted_limit_state(capacity.checks) if capacity else None
    row["static_pga_g"] = static_pga(capacity)
    if pushed is not None:
        rigid, elastic = pushed.rigid, pushed.elastic
        row |= {"control": pushed.control, "run": pushed.run}
        row |= {"alpha_u": elastic.alpha_u} if elastic else {}
        if rigid is not None:
            row |= {"alpha_0": rigid.alpha_0, "d_0_m": rigid.d_0_m, "mechanism": _mechanism(rigid.mechanism)}
            if (law := rigid.other_law) is not None:
                row["other_law"] = OtherLaw(sliding=law.sliding, alpha_0=law.alpha_0)
        if before and rigid and before.rigid:
            row["alpha_loss"] = reduction(before.rigid.alpha_0, rigid.alpha_0)
        elif before and elastic and before.elastic:
            row["alpha_loss"] = reduction(before.elastic.alpha_u, elastic.alpha_u)
    if capacity and capacity.alpha_0 is not None and capacity.other_law:
        row |= {"alpha_0": capacity.alpha_0, "other_law": capacity.other_law}
    if state.incremental.records is not None:
        dynamic, loss = state.incremental.pga_collapse_g, state.incremental.loss
        nominal = capacity.nominal.pga_g if capacity and capacity.nominal else None
        row |= {"dynamic_pga_g": dynamic, "static_nominal_pga_g": nominal}
        row["dynamic_to_static"] = dynamic / nominal if dynamic is not None and nominal else None
        if original is not None:
            lost = reduction(original.incremental.pga_collapse_g, dynamic)
            row["dynamic_loss"] = loss.dynamic if loss else lost
    return SummaryRow(**row)


def _mechanism(found: Mechanism) -> SummaryMechanism:
    slides, turns = len(found.sliding_joints), found.hinges
    alone = "overturning" if turns == 1 else "hinges"
    kind: Any = ("mixed" if turns else "sliding") if slides else alone
    weight = found.moving_weight_kN
    return SummaryMechanism(kind=kind, hinges=turns, sliding_joints=slides, moving_weight_kN=weight)


def _counting(capacity: Capacity | None, limit: str) -> SummaryCheck:
    """Return the check that counts at a limit state; without numbers where none has a ratio."""
    made = capacity.checks if capacity else {}
    names = [name for name in (limit, f"{limit} linear", f"{limit} elastic") if name in made]  # its own first
    known = [(ratio, name) for name in names if (ratio := made[name].zeta_E) is not None]
    if not known:
        return SummaryCheck(check=limit, zeta_E=None, verified=None)
    # at SLV the linear check stands in for the nonlinear one
    ratio, name = known[0] if limit in INDEXED else min(known, key=lambda each: each[0])
    found = SummaryCheck(check=name, zeta_E=ratio, verified=made[name].verified)
    return found.replace(zeta_E_range=each) if (each := made[name].zeta_E_range) else found


def _all(verified: Iterable[bool | None]) -> bool | None:
    """Whether all are true; None where none is false and one is not known, or there is none."""
    found = list(verified)
    if not found or (None in found and False not in found):
        return None
    return all(found)


def index_limit(results: Results) -> str | None:
    """Return the limit state whose ratio is ζ_E: SLV, else SLC; without both the farthest one checked, None: none."""
    checked = list(dict.fromkeys(limit for row in results.summary.rows for limit in row.checks))
    return next((limit for limit in INDEXED if limit in checked), checked[-1] if checked else None)


def index_of(row: SummaryRow, limit: str | None) -> SummaryCheck | None:
    """Return the check of a row that is its index, None where it has no number."""
    check = row.checks.get(limit) if limit else None
    return check if check is not None and check.zeta_E is not None else None


def rows_of(results: Results, state: str) -> list[SummaryRow]:
    """Return the rows of a state."""
    return [row for row in results.summary.rows if row.state == state]


def least_row(results: Results, state: str) -> SummaryRow | None:
    """Return the row of a state with the least index, without any with the least multiplier; None: nothing is known."""
    limit = index_limit(results)
    known = [(check.zeta_E, row) for row in rows_of(results, state) if (check := index_of(row, limit))]
    known = known or [(row.alpha_0, row) for row in rows_of(results, state) if row.alpha_0 is not None]
    known = known or [(row.alpha_u, row) for row in rows_of(results, state) if row.alpha_u is not None]
    return min(known, key=lambda each: each[0] or 0.0)[1] if known else None


def settled(results: Results) -> list[str]:
    """Return the states that a movement leads to, strengthened ones aside."""
    return [name for name, state in results.states.items() if state.settlement and not state.strengthening]


def worst_settled(results: Results) -> str | None:
    """Return the settled state that bears least: one that was not reached, else of the least index or multiplier."""
    names = settled(results)
    fallen = [name for name in names if any(not row.reached for row in rows_of(results, name))]
    limit = index_limit(results)

    def borne(name: str) -> tuple[bool, float]:
        row = least_row(results, name)
        check = index_of(row, limit) if row else None
        value = check.zeta_E if check else row.alpha_0 if row else None
        return value is None, value or 0.0

    return fallen[0] if fallen else min(names, key=borne, default=None)


def governing_view(results: Results) -> tuple[str, Direction] | None:
    """Return state and direction of the rigid mechanism that governs; None where there is none."""
    pushed = {
        (name, way): push.rigid
        for name, state in results.states.items()
        for way, push in state.pushover.items()
        if push.rigid
    }
    least = results.summary.governing
    if least and (least.state, least.direction) in pushed:
        return least.state, least.direction
    return min(pushed, key=lambda view: pushed[view].alpha_0, default=None)
