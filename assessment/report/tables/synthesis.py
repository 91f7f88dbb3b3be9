"""What the first page prints, from `summary` of the results alone: the rows of its table, and which of them count."""

from __future__ import annotations

from assessment.ntc.limit_states import INDEXED
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction
from assessment.results.schema.summary import SummaryCheck, SummaryRow

ORIGINAL = "original"


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
