"""The tables of time histories and of the incremental analysis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from assessment.results.table import (
    Results,
    Row,
    Table,
    brought_together,
    quoted_limit_state,
    reduction,
    static_pga,
)

HISTORY = (
    "state",
    "record",
    "pga_g",
    "contacts",
    "control",
    "peak_displacement_m",
    "residual_displacement_m",
    "collapsed",
    "time_of_collapse_s",
)
RANGES = (
    "state",
    "record",
    "integrator",
    "integrator_share",
    "members",
    "members_collapsed",
    "lowest_peak_m",
    "median_peak_m",
    "highest_peak_m",
)
ENERGY = (
    "input",
    "kinetic",
    "potential",
    "elastic",
    "friction",
    "impact",
    "viscous",
    "integrator",
    "residual",
)
SEARCH = (
    "state",
    "record",
    "record_pga_g",
    "pga_safe_g",
    "pga_collapse_g",
    "pga_all_collapse_g",
    "resurrections",
    "runs",
)
OF_STATES = (
    "state",
    "records",
    "mean_pga_collapse_g",
    "lowest_pga_collapse_g",
    "pga_collapse_g",
    "pga_all_collapse_g",
    "median_g",
    "dispersion",
)
COMPARED = (
    "state",
    "direction",
    "limit_state",
    "static_pga_g",
    "static_reduction",
    "dynamic_pga_g",
    "dynamic_reduction",
    "static_surface_pga_g",
    "dynamic_to_static",
)


def dynamic_tables(results: Results) -> list[Table]:
    """List all tables of the dynamic stages, long ones included."""
    return [
        histories(results),
        ranges(results),
        energy(results),
        history_curves(results),
        motions(results),
        incremental(results),
        incremental_states(results),
        incremental_curves(results),
        static_dynamic(results),
    ]


def histories(results: Results) -> Table:
    """List what every time history came to."""
    rows = []
    for state, entry in _histories(results):
        unasked = {None: "", True: "residual_displacement_m", False: "time_of_collapse_s"}[entry["collapsed"]]
        rows.append(
            {"state": state} | {key: entry[key] for key in HISTORY if key in entry and key != unasked}
        )
    return Table("history", rows, HISTORY)


def ranges(results: Results) -> Table:
    """List how every time history was integrated, by how many members, and the range of their peaks."""
    rows = []
    for state, entry in _histories(results):
        if "curve" not in entry:
            continue
        row: Row = {"state": state} | {key: entry[key] for key in RANGES if key in entry}
        if "peak_displacement_m_range" in entry:
            row["lowest_peak_m"], row["highest_peak_m"] = entry["peak_displacement_m_range"]
            row["median_peak_m"] = entry["peak_displacement_median_m"]
        rows.append(row)
    return Table("history_ranges", rows, RANGES)


def energy(results: Results) -> Table:
    """List the energy balance of every time history: input is what was stored and dissipated, and a residual, kNm."""
    rows = [
        {"state": state, "record": entry["record"]} | entry["energy"]
        for state, entry in _histories(results)
        if "energy" in entry
    ]
    return Table("history_energy", rows, ("state", "record", *(f"{name}_kNm" for name in ENERGY)))


def history_curves(results: Results) -> Table:
    """List the points of every control displacement history."""
    rows = [
        {"state": state, "record": entry["record"], "time_s": time, "displacement_m": displacement}
        for state, entry in _histories(results)
        if "curve" in entry
        for time, displacement in zip(entry["curve"]["time_s"], entry["curve"]["displacement_m"], strict=True)
    ]
    return Table("history_curves", rows, ("state", "record", "time_s", "displacement_m"))


def motions(results: Results) -> Table:
    """List the spectral ordinates (5 % damping) of the records of the time histories."""
    rows = [
        {"record": motion["name"], "T_s": period, "S_a_g": acceleration, "S_d_m": displacement}
        for motion in results.get("motions") or []
        for period, acceleration, displacement in zip(
            motion["T_s"], motion["S_a_g"], motion["S_d_m"], strict=True
        )
    ]
    return Table("record_spectra", rows, ("record", "T_s", "S_a_g", "S_d_m"))


def incremental(results: Results) -> Table:
    """List the bracket of the PGA at collapse of every record and state."""
    rows = [
        {"state": state}
        | {key: record[key] for key in SEARCH if key in record}
        | _all_collapse(record)
        | {"resurrections": "; ".join(f"{level:.3f}" for level in record["resurrections_g"])}
        for state, found in _incrementals(results)
        for record in found["records"]
    ]
    return Table("incremental", rows, SEARCH)


def incremental_states(results: Results) -> Table:
    """List mean, lowest and standard's PGA at collapse, and the fragility of every state."""
    rows: list[Row] = []
    for state, found in _incrementals(results):
        row: Row = {"state": state, "records": len(found["records"])}
        row |= {key: found[key] for key in OF_STATES if key in found and key != "records"}
        row |= _all_collapse(found)
        if found["fragility"]:
            row |= {key: found["fragility"][key] for key in ("median_g", "dispersion")}
        rows.append(row)
    return Table("incremental_states", rows, OF_STATES)


def incremental_curves(results: Results) -> Table:
    """List every run of the incremental analysis."""
    columns = (
        "pga_g",
        "peak_displacement_m",
        "members",
        "members_collapsed",
        "collapsed",
        "time_of_collapse_s",
    )
    rows = [
        {"state": state, "record": record["record"]} | {key: point[key] for key in columns if key in point}
        for state, found in _incrementals(results)
        for record in found["records"]
        for point in record["points"]
    ]
    return Table("incremental_curves", rows, ("state", "record", *columns))


def static_dynamic(results: Results) -> Table:
    """Set the a_g of the static check beside the PGA of the incremental analysis, with what a settlement costs.

    They are compared at the surface and without confidence factor: `static_surface_pga_g`.
    """
    found = dict(_incrementals(results))
    original = results["states"].get("original") or {}
    rows: list[Row] = []
    for state, dynamic in found.items():
        content = results["states"][state]
        for direction in content.get("capacity") or {None: None}:
            static = static_pga((content.get("capacity") or {}).get(direction))
            row: Row = {"state": state, "direction": direction}
            row |= {"limit_state": quoted_limit_state((content.get("capacity") or {}).get(direction))}
            row |= {"static_pga_g": static, "dynamic_pga_g": dynamic["pga_collapse_g"]}
            if state != "original":
                before = (original.get("capacity") or {}).get(direction)
                row["static_reduction"] = reduction(static_pga(before), static)
                row["dynamic_reduction"] = reduction(
                    (found.get("original") or {}).get("pga_collapse_g"), dynamic["pga_collapse_g"]
                )
            row |= brought_together((content.get("capacity") or {}).get(direction), dynamic["pga_collapse_g"])
            rows.append(row)
    return Table("static_dynamic", rows, COMPARED)


def _all_collapse(found: Mapping[str, Any]) -> Row:
    """The upper end of the range of a PGA at collapse, where there is a range."""
    return {"pga_all_collapse_g": found["pga_collapse_g_range"][1]} if "pga_collapse_g_range" in found else {}


def _histories(results: Results) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for name, content in results["states"].items():
        for entry in content.get("history") or []:
            yield name, entry


def _incrementals(results: Results) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for name, content in results["states"].items():
        if content.get("incremental"):
            yield name, content["incremental"]
