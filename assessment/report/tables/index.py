"""The tables of a set of results: CSV files, and the same rows for the report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from assessment.report.tables.campaign import campaign_tables, fragility_model
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
from assessment.report.tables.identification import identification_tables
from assessment.report.tables.indices import index_tables
from assessment.report.tables.ranges import static_ranges
from assessment.report.tables.structure.cracks import cracks
from assessment.report.tables.structure.joints import edge_pressure_table
from assessment.report.tables.structure.loads import loads, vertical
from assessment.report.tables.structure.mechanisms import all_mechanisms, mechanisms, second_solver
from assessment.report.tables.structure.ties import shaken_ties, strengthening, tie_tensions, ties
from assessment.report.tables.studies import study_tables
from assessment.results.configurations.hand_check import hand_check, macro_block_table, outline_area
from assessment.results.configurations.reactions import balance, joint_table, reactions
from assessment.results.echo import material, taken_to_collapse
from assessment.results.schema import Results
from assessment.results.schema.model import Block
from assessment.results.table import COMPARISON, Row, Table, cells
from assessment.runtime.files.atomic_files import write_atomically

RUN = ("=", "+", "-", "@", "\t", "\r")  # what a formula begins with in a spreadsheet


def write_tables(results: Results, folder: Path) -> None:
    """Write every table that has rows as CSV (comma, point, UTF-8) into the folder, and fragilities as NRML.

    A text that a spreadsheet would take for a formula, names as well as +x, has an apostrophe in front.
    """
    if model := fragility_model(results):
        write_atomically(folder / "fragility.xml", model.encode())
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
        strengthening(results),
        ties(results),
        tie_tensions(results),
        shaken_ties(results),
        reactions(results),
        balance(results),
        joint_table(results),
        edge_pressure_table(results),
        cracks(results),
        macro_block_table(results),
        hand_check(results),
        second_solver(results),
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
        *identification_tables(results),
        *study_tables(results),
        *dynamic_tables(results),
        *campaign_tables(results),
        *convergence_tables(results),
    ]


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
    return Table("comparison", [cells(each, COMPARISON) for each in results.comparison], COMPARISON)


def quality(results: Results) -> Table:
    """List the worst certificates of the solutions by state and stage."""
    return Table("quality", [cells(each, QUALITY) for each in results.quality.by_stage], QUALITY)


def blocks(results: Results) -> Table:
    """List every block: layer, support, centroid, area, volume and extra load."""
    rows = []
    for number, block in enumerate(results.geometry.blocks):
        rows.append(
            {
                "block": number,
                "layer": block.layer,
                "support": block.support,
                "x_m": block.centroid_m[0],
                "z_m": block.centroid_m[1],
                "area_m2": outline_area(block.vertices_m),
                "depth_m": block.depth_m,
                "vertical_load_kN": block.vertical_load_kN,
            }
        )
    return Table("blocks", rows, tuple(rows[0]))


def layers(results: Results) -> Table:
    """Sum up each layer: its role, blocks, depth, material and loads; defaults from [material]."""
    rows = []
    by_layer: dict[str, list[Block]] = {}
    for block in results.geometry.blocks:
        name = f"{block.layer}, {block.region}" if block.region else block.layer
        by_layer.setdefault(name, []).append(block)
    for layer, own in sorted(by_layer.items()):
        given = material(results.echo, own[0])
        rows.append(
            {
                "layer": layer,
                "support": own[0].support,
                "blocks": len(own),
                "depth_m": own[0].depth_m,
                "area_m2": sum(outline_area(block.vertices_m) for block in own),
                "vertical_load_kN": sum(block.vertical_load_kN for block in own),
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
    rows, sought = [], taken_to_collapse(results.echo)
    for name, state in results.states.items():
        if settlement := state.settlement:
            found: Row = {
                "state": name,
                "support": settlement.support,
                "displacement_x_m": settlement.displacement_m[0],
                "displacement_z_m": settlement.displacement_m[1],
                "rotation_rad": settlement.rotation_rad,
            }
            if settlement.after is not None:
                found["after"] = settlement.after
            for contacts, path in state.pushdown.items():
                if name in sought or path.ultimate_movement_m is not None:
                    found[f"ultimate_{contacts}_m"] = path.ultimate_movement_m
            rows.append(found)
    after = ("after",) if any("after" in row for row in rows) else ()
    columns = ("state", *after, "support", "displacement_x_m", "displacement_z_m", "rotation_rad")
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
        for name, state in results.states.items()
        for contacts, path in state.pushdown.items()
        for movement, reaction_x, reaction_z in zip(
            path.movement_m, path.reaction_x_kN, path.reaction_z_kN, strict=True
        )
    ]
    return Table("pushdown", rows, ("state", "contacts", "movement_m", "reaction_x_kN", "reaction_z_kN"))


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
        for name, state in results.states.items()
        for direction, pushover in state.pushover.items()
        for contacts, push in pushover.by_contacts.items()
        for displacement, multiplier in zip(push.curve.displacement_m, push.curve.multiplier, strict=True)
    ]
    return Table("pushover", rows, ("state", "direction", "contacts", "displacement_m", "multiplier"))
