"""The tables of a campaign: its records, every combination and run, fragility and loss by movement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from assessment.results.table import Results, Row, Table

PLACE = ("settlement", "share", "movement_m")
RECORDS = ("record", "record_pga_g", "sa_g", "scale", "duration_s", "time_step_s")
COMBINATIONS = (
    "settlement",
    "share",
    "record",
    "sign",
    "pga_safe_g",
    "pga_collapse_g",
    "pga_all_collapse_g",
    "sa_collapse_g",
    "runs",
    "reason",
)
POINTS = (
    "pga_g",
    "peak_displacement_m",
    "residual_displacement_m",
    "members",
    "members_collapsed",
    "time_of_collapse_s",
)
FRAGILITY = (
    *PLACE,
    "combinations",
    "withstood",
    "failed",
    "median_g",
    "median_low_g",
    "median_high_g",
    "beta",
    "beta_low",
    "beta_high",
    "median_all_collapse_g",
    "beta_record",
    "beta_ensemble",
)
LOSS = (
    *PLACE,
    "rule",
    "pga_collapse_g",
    "dynamic_loss",
    "dynamic_loss_low",
    "dynamic_loss_high",
    "left_out",
    "static_loss",
)
COUNTS = ("withstood", "failed", "left_out")  # told where they are not all zero
OF_ENSEMBLES = ("median_all_collapse_g", "beta_record", "beta_ensemble")  # of a single member there are none


def campaign_tables(results: Results) -> list[Table]:
    """List all tables of the campaign, long ones included; without rows where there is none."""
    return [
        records(results),
        combinations(results),
        points(results),
        fragilities(results),
        losses(results),
    ]


def reported_campaign(results: Results) -> list[Table]:
    """Return the tables of the report."""
    single = not results.get("campaign") or results["campaign"]["members"] == 1
    gone = OF_ENSEMBLES if single else ()
    return [records(results), _short(fragilities(results), gone), _short(losses(results))]


def records(results: Results) -> Table:
    """List the records, scaled or made as asked for."""
    return Table("campaign_records", [dict(each) for each in _found(results, "records")], RECORDS)


def combinations(results: Results) -> Table:
    """List the levels between which each combination collapses, and why where it was not completed."""
    rows = []
    for each in _found(results, "combinations"):
        row = {key: each[key] for key in COMBINATIONS if key in each}
        if each["pga_collapse_range"]:
            row["pga_all_collapse_g"] = each["pga_collapse_range"][1]
        rows.append(row)
    return Table("campaign", rows, COMBINATIONS)


def points(results: Results) -> Table:
    """List every level that was run."""
    rows = [
        {key: each[key] for key in ("settlement", "share", "record", "sign")}
        | {key: point[key] for key in POINTS}
        for each in _found(results, "combinations")
        for point in each["points"]
    ]
    return Table("campaign_curves", rows, ("settlement", "share", "record", "sign", *POINTS))


def fragilities(results: Results) -> Table:
    """List the fragility of every movement; the bounds are those of the bootstrap."""
    rows = []
    for each in _found(results, "fragility"):
        row = {key: each[key] for key in FRAGILITY if key in each}
        for name, unit in (("median", "_g"), ("beta", "")):
            low, high = each[f"{name}_range"] or (None, None)
            row |= {f"{name}_low{unit}": low, f"{name}_high{unit}": high}
        rows.append(row)
    return Table("campaign_fragility", rows, FRAGILITY)


def losses(results: Results) -> Table:
    """List what each movement costs, dynamic beside static, and the PGA that the standard takes."""
    rows: list[Row] = []
    fragility = _found(results, "fragility")
    for each, fit in zip(_found(results, "loss"), fragility, strict=True):
        low, high = each["dynamic_range"]
        row: Row = {key: each[key] for key in (*PLACE, "left_out")}
        row |= {"dynamic_loss": each["dynamic"], "dynamic_loss_low": low, "dynamic_loss_high": high}
        row |= {"static_loss": each["static"]}
        if fit["rule"]:
            row |= {key: fit[key] for key in ("rule", "pga_collapse_g")}
        rows.append(row)
    return Table("campaign_loss", rows, LOSS)


def _found(results: Results, what: str) -> list[Any]:
    return (results.get("campaign") or {}).get(what) or []


def _short(table: Table, without: Sequence[str] = ()) -> Table:
    """Return the table without counts that are all zero, the bounds of β, and the columns that are named."""
    empty = {key for key in COUNTS if not any(row.get(key) for row in table.rows)}
    gone = empty | {"beta_low", "beta_high", "combinations", *without}
    return Table(
        table.name,
        [{key: value for key, value in row.items() if key not in gone} for row in table.rows],
        tuple(column for column in table.columns if column not in gone),
    )
