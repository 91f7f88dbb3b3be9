"""The vertical loads of each layer as the seismic combination has them, and what is said of the vertical component."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.ntc.vertical import THRUSTING_A_G
from assessment.report.tables.capacity import capacities
from assessment.report.text.language import Words
from assessment.results.table import Results, Row, Table

LOADS = (
    "layer",
    "blocks",
    "own_weight_kN",
    "permanent_load_kN",
    "variable_load_kN",
    "use_category",
    "psi_2",
    "combined_kN",
    "seismic_weight_kN",
)
VARIABLE = {"variable_load_kN", "use_category", "psi_2"}
VERTICAL = (
    "state",
    "direction",
    "a_v_g",
    "alpha_0",
    "a_0_star_g",
    "demand_a_star_g",
    "ratio",
    "verified",
)


def loads(results: Results) -> Table:
    """List own weight, permanent and variable loads of each layer, ψ₂, and their combination; all blocks together."""
    return Table("loads", list(results.get("loads") or []), LOADS)


def reported_loads(results: Results, words: Words) -> Table:
    """Return the loads with their sums, without what no layer has."""
    rows = loads(results).rows
    varies = any(row["variable_load_kN"] for row in rows)
    columns = tuple(column for column in LOADS if varies or column not in VARIABLE)
    sums: Row = {"layer": words.plain("value.sum")}
    sums |= {key: sum(row[key] for row in rows) for key in columns if key == "blocks" or key.endswith("_kN")}
    kept = [
        {key: row[key] for key in columns if row.get(key) is not None}
        for row in ([*rows, sums] if len(rows) > 1 else rows)
    ]
    return Table("loads", kept, columns)


def vertical(results: Results) -> Table:
    """List the linear checks at SLV with the vertical component of the seismic action."""
    rows = [
        {"state": name, "direction": direction} | {key: capacity["vertical"][key] for key in VERTICAL[2:]}
        for name, direction, capacity in capacities(results)
        if capacity.get("vertical")
    ]
    return Table("vertical", rows, VERTICAL)


def vertical_told(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what became of the vertical component, and why, where there is a check against a demand."""
    demand = (results.get("spectra") or {}).get("SLV")
    if demand is None:
        return
    a_g, least = words.show(demand["a_g_g"]), words.comma(f"{THRUSTING_A_G:g}")
    if demand["kind"] == "record":
        yield words("text.vertical_record")
    elif demand["a_g_g"] < THRUSTING_A_G:
        yield words("text.vertical_low", a_g=a_g, least=least)
    else:
        done = bool(vertical(results).rows)
        yield words("text.vertical" if done else "text.vertical_left_out", a_g=a_g, least=least)
