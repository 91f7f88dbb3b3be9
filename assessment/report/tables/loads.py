"""The vertical loads of each layer in the seismic combination, and the text on the vertical component."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.ntc.vertical import THRUSTING_A_G
from assessment.report.tables.capacity import capacities
from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.table import Row, Table, cells

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
    return Table("loads", [cells(each, LOADS) for each in results.loads or []], LOADS)


def reported_loads(results: Results, words: Words) -> Table:
    """Return the loads with their sums, without what no layer has."""
    rows = loads(results).rows
    varies = any(layer.variable_load_kN for layer in results.loads or [])
    columns = tuple(column for column in LOADS if varies or column not in VARIABLE)
    sums: Row = {"layer": words.plain("value.sum")}
    sums |= {
        key: sum(each[key] for each in rows) for key in columns if key == "blocks" or key.endswith("_kN")
    }
    kept = [
        {key: each[key] for key in columns if each.get(key) is not None}
        for each in ([*rows, sums] if len(rows) > 1 else rows)
    ]
    return Table("loads", kept, columns)


def vertical(results: Results) -> Table:
    """List the linear checks at SLV with the vertical component of the seismic action."""
    rows = [
        {"state": name, "direction": direction} | cells(capacity.vertical, VERTICAL)
        for name, direction, capacity in capacities(results)
        if capacity.vertical
    ]
    return Table("vertical", rows, VERTICAL)


def vertical_told(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what became of the vertical component, and why, where there is a check against a demand."""
    demand = (results.spectra or {}).get("SLV")
    if demand is None:
        return
    a_g, least = words.show(demand.a_g_g), words.comma(f"{THRUSTING_A_G:g}")
    if demand.kind == "record":
        yield words("text.vertical_record")
    elif demand.a_g_g < THRUSTING_A_G:
        yield words("text.vertical_low", a_g=a_g, least=least)
    else:
        done = bool(vertical(results).rows)
        yield words("text.vertical" if done else "text.vertical_left_out", a_g=a_g, least=least)
