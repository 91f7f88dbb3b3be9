"""The tables of a set of results: CSV files, and the same rows for the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from assessment.ntc.limit_states import CHECKS
from assessment.report.cracks import cracks
from assessment.report.joints import edge_pressures
from assessment.report.tables.campaign import campaign_tables
from assessment.report.tables.capacity import (
    action,
    capacity_curves,
    chosen_checks,
    chosen_mechanisms,
    linear_checks,
    scalings,
    spectrum,
    summary,
    trace,
    verification,
)
from assessment.report.tables.convergence import convergence_tables
from assessment.report.tables.dynamic import dynamic_tables
from assessment.report.tables.indices import index_tables
from assessment.report.tables.loads import loads, vertical
from assessment.report.tables.mechanisms import all_mechanisms
from assessment.report.tables.studies import study_tables
from assessment.results.hand_check import hand_check, macro_block_table, outline_area
from assessment.results.reactions import balance, joint_table, reactions
from assessment.results.table import Results, Row, Table, taken_to_collapse
from assessment.runtime.atomic_files import write_atomically

OTHER_LAW = ("alpha_0_coulomb", "alpha_0_associative")
RUN = ("=", "+", "-", "@", "\t", "\r")  # what a formula begins with in a spreadsheet


def write_tables(results: Results, folder: Path) -> None:
    """Write every table of the results that has rows as CSV (comma, point, UTF-8) into the folder.

    A text that a spreadsheet would take for a formula, names as well as +x, has an apostrophe in front.
    """
    import pandas as pd  # late: the report needs the rows only

    for table in tables(results):
        if table.rows:
            frame = pd.DataFrame(table.rows, columns=list(table.columns))
            words = [name for name, kind in frame.dtypes.items() if not pd.api.types.is_numeric_dtype(kind)]
            frame = frame.assign(**{str(name): frame[name].map(inert) for name in words})
            frame.columns = frame.columns.map(inert)
            path = folder / f"{table.name}.csv"
            write_atomically(path, frame.to_csv(index=False, lineterminator="\n").encode())


def inert(cell: Any) -> Any:
    """Return a cell that no spreadsheet runs: texts that begin like a formula get an apostrophe in front."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(RUN) else cell


def tables(results: Results) -> list[Table]:
    """List all tables of the results, long ones included."""
    return [
        blocks(results),
        layers(results),
        loads(results),
        settlements(results),
        pushdown_curves(results),
        mechanisms(results),
        static_ranges(results),
        pushover_curves(results),
        capacity_curves(results),
        summary(results),
        verification(results),
        comparison(results),
        reactions(results),
        balance(results),
        joint_table(results),
        edge_pressures(results),
        cracks(results),
        macro_block_table(results),
        hand_check(results),
        quality(results),
        spectrum(results),
        action(results),
        chosen_mechanisms(results),
        chosen_checks(results),
        all_mechanisms(results),
        linear_checks(results),
        vertical(results),
        scalings(results),
        trace(results),
        *index_tables(results),
        *study_tables(results),
        *dynamic_tables(results),
        *campaign_tables(results),
        *convergence_tables(results),
    ]


COMPARISON = (
    "state",
    "direction",
    "limit_state",
    "static_pga_g",
    "static_reduction",
    "dynamic_pga_g",
    "dynamic_reduction",
)
QUALITY = (
    "state",
    "stage",
    "solves",
    "worst_equilibrium_residual",
    "worst_penetration_m",
    "worst_complementarity",
    "worst_cone_violation",
)


def comparison(results: Results) -> Table:
    """List the capacities of each settled state beside the original one's."""
    return Table("comparison", list(results.get("comparison") or []), COMPARISON)


def quality(results: Results) -> Table:
    """List the worst certificates of the solutions by state and stage."""
    return Table("quality", list(results["quality"].get("by_stage") or []), QUALITY)


def blocks(results: Results) -> Table:
    """List every block: layer, support, centroid, area, volume and extra load."""
    rows = []
    for number, block in enumerate(results["geometry"]["blocks"]):
        area = outline_area(block["vertices_m"])
        rows.append(
            {
                "block": number,
                "layer": block["layer"],
                "support": block["support"],
                "x_m": block["centroid_m"][0],
                "z_m": block["centroid_m"][1],
                "area_m2": area,
                "depth_m": block["depth_m"],
                "vertical_load_kN": block["vertical_load_kN"],
            }
        )
    return Table("blocks", rows, tuple(rows[0]))


def layers(results: Results) -> Table:
    """Sum up each layer: its role, blocks, depth, material and loads; defaults from [material]."""
    echo, rows = results["echo"], []
    by_layer: dict[str, list[Any]] = {}
    for block in results["geometry"]["blocks"]:
        by_layer.setdefault(block["layer"], []).append(block)
    for layer, own in sorted(by_layer.items()):
        given = {**(echo.get("material") or {}), **((echo.get("layers") or {}).get(layer) or {})}
        rows.append(
            {
                "layer": layer,
                "support": own[0]["support"],
                "blocks": len(own),
                "depth_m": own[0]["depth_m"],
                "area_m2": sum(outline_area(block["vertices_m"]) for block in own),
                "vertical_load_kN": sum(block["vertical_load_kN"] for block in own),
            }
            | {key: given[key] for key in MATERIAL if given.get(key) is not None}
        )
    return Table(
        "layers",
        rows,
        ("layer", "support", "blocks", "depth_m", "area_m2", *MATERIAL, "vertical_load_kN"),
    )


MATERIAL = (
    "unit_weight_kN_m3",
    "friction",
    "normal_stiffness_kN_m3",
    "tangential_stiffness_kN_m3",
    "compressive_strength_kN_m2",
)


def settlements(results: Results) -> Table:
    """List the movements and how far each may go: the ultimate movement by kind of contact."""
    rows, sought = [], taken_to_collapse(results)
    for name, content in results["states"].items():
        settlement = content.get("settlement")
        if settlement:
            row = {
                "state": name,
                "support": settlement["support"],
                "displacement_x_m": settlement["displacement_m"][0],
                "displacement_z_m": settlement["displacement_m"][1],
                "rotation_rad": settlement.get("rotation_rad") or 0.0,
            }
            for contacts, stage in (content.get("pushdown") or {}).items():
                if name in sought or stage["ultimate_movement_m"] is not None:
                    row[f"ultimate_{contacts}_m"] = stage["ultimate_movement_m"]
            rows.append(row)
    columns = ("state", "support", "displacement_x_m", "displacement_z_m", "rotation_rad")
    return Table("settlements", rows, (*columns, "ultimate_rigid_m", "ultimate_elastic_m"))


def pushdown_curves(results: Results) -> Table:
    """List the points of every pushdown curve."""
    rows = [
        {
            "state": name,
            "contacts": contacts,
            "movement_m": movement,
            "reaction_x_kN": reaction_x,
            "reaction_z_kN": reaction_z,
        }
        for name, content in results["states"].items()
        for contacts, stage in (content.get("pushdown") or {}).items()
        for movement, reaction_x, reaction_z in zip(
            stage["movement_m"], stage["reaction_x_kN"], stage["reaction_z_kN"], strict=True
        )
    ]
    return Table("pushdown", rows, ("state", "contacts", "movement_m", "reaction_x_kN", "reaction_z_kN"))


def mechanisms(results: Results) -> Table:
    """List the rigid mechanism of every state and direction.

    It is that of α0, beside it that by the other law of friction where the two differ; where the control point takes no
    part in that mechanism, `mechanism_alpha` is the multiplier at which the one listed is activated.
    """
    rows = []
    for name, direction, pushover in _pushovers(results):
        mechanism = pushover.get("rigid", {}).get("mechanism")
        if mechanism:
            alpha_0, own = pushover["rigid"]["alpha_0"], mechanism["alpha"]
            rows.append(
                {"state": name, "direction": direction, "alpha_0": alpha_0}
                | ({} if own == alpha_0 else {"mechanism_alpha": own})
                | {key: value for key, value in pushover["rigid"].items() if key in OTHER_LAW}
                | {key: mechanism.get(key) for key in ("hinges", "moving_weight_kN", "e_star", "gamma_star")}
                | {"sliding_joints": len(mechanism["sliding_joints"])}
            )
    named = [key for key in (*OTHER_LAW, "mechanism_alpha") if any(key in row for row in rows)]
    columns = ("hinges", "sliding_joints", "moving_weight_kN", "e_star", "gamma_star")
    return Table("mechanisms", rows, ("state", "direction", "alpha_0", *named, *columns))


def static_ranges(results: Results) -> Table:
    """List the ranges of the states whose paths scatter: what is used, and what the members of the ensemble found."""
    rows: list[Row] = []
    for name, state in results["states"].items():
        for contacts, numbers in (state.get("pushdown") or {}).items():
            rows += _ranges(numbers, {"state": name, "contacts": contacts})
        for direction, pushover in (state.get("pushover") or {}).items():
            for contacts in ("rigid", "elastic"):
                of = {"state": name, "direction": direction, "contacts": contacts}
                rows += _ranges((pushover or {}).get(contacts) or {}, of)
        for direction, capacity in (state.get("capacity") or {}).items():
            for check in CHECKS:
                of = {"state": name, "direction": direction, "limit_state": check}
                rows += _ranges((capacity or {}).get(check) or {}, of)
    columns = ("state", "direction", "contacts", "limit_state", "quantity", "value", "lowest", "highest")
    return Table("static_ranges", rows, columns)


def _ranges(numbers: Mapping[str, Any], of: Row) -> Iterator[Row]:
    for name, ends in numbers.items():
        if name.endswith("_range"):
            quantity = name.removesuffix("_range")
            yield of | {
                "quantity": quantity,
                "value": numbers[quantity],
                "lowest": ends[0],
                "highest": ends[1],
            }


def pushover_curves(results: Results) -> Table:
    """List the points of every pushover curve; displacements along x: towards −x they are negative."""
    rows = [
        {
            "state": name,
            "direction": direction,
            "contacts": contacts,
            "displacement_m": displacement,
            "multiplier": multiplier,
        }
        for name, direction, pushover in _pushovers(results)
        for contacts in ("rigid", "elastic")
        if contacts in pushover
        for displacement, multiplier in zip(
            pushover[contacts]["curve"]["displacement_m"],
            pushover[contacts]["curve"]["multiplier"],
            strict=True,
        )
    ]
    return Table("pushover", rows, ("state", "direction", "contacts", "displacement_m", "multiplier"))


def _pushovers(results: Results) -> Iterator[tuple[str, str, Any]]:
    for name, content in results["states"].items():
        for direction, pushover in (content.get("pushover") or {}).items():
            if pushover:
                yield name, direction, pushover
