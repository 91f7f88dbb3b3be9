"""The tables of an identification: hypotheses side by side, their movements, what is measured beside predicted."""

from __future__ import annotations

from collections.abc import Iterable

from assessment.results.identified import told_of
from assessment.results.schema import Results
from assessment.results.schema.identification import Explanation, Fitted
from assessment.results.table import Row, Table, cells

HYPOTHESES = (
    *("hypothesis", "unknowns", "chi_squared", "degrees_of_freedom", "chi_squared_probability"),
    *("aic", "told_apart"),
)
MOVEMENTS = (
    *("hypothesis", "support", "displacement_x_m", "x_error_m", "displacement_z_m", "z_error_m"),
    *("rotation_mrad", "rotation_error_mrad"),
)
MEASUREMENTS = (
    *("hypothesis", "number", "measurement", "measured_kind", "x_m", "z_m", "unit"),
    *("measured", "sigma", "predicted", "residual", "residual_in_sigma"),
)
PRINTED = (
    "number",
    "measurement",
    "measured_kind",
    "unit",
    "measured",
    "sigma",
    "predicted",
    "residual_in_sigma",
)


def identification_tables(results: Results) -> list[Table]:
    """List the tables of an identification, every hypothesis in them."""
    found = results.identification
    every = found.hypotheses if found else []
    return [hypotheses(results), _movements(every), _measurements(results, every, MEASUREMENTS)]


def reported_identification(results: Results) -> list[Table]:
    """Return the tables of the report: of movements and measurements those of hypotheses not told from the best."""
    told = told_of(results.identification) if results.identification else []
    columns = PRINTED if len(told) < 2 else ("hypothesis", *PRINTED)
    return [hypotheses(results), _movements(told), _measurements(results, told, columns)]


def hypotheses(results: Results) -> Table:
    """List every hypothesis: how well it fits, with how many unknowns."""
    found = results.identification
    rows: list[Row] = [
        {
            **cells(each, HYPOTHESES),
            "chi_squared_probability": each.probability,
            "told_apart": each.distinguished,
        }
        for each in (found.hypotheses if found else [])
    ]
    return Table("hypotheses", rows, HYPOTHESES)


def _movements(told: Iterable[Explanation]) -> Table:
    """List the movement of each support of each hypothesis; without error: not determined, or held."""
    rows = []
    for each in told:
        for moved in each.movement:
            rotation = moved.rotation_standard_error_rad
            rows.append(
                {
                    "hypothesis": each.hypothesis,
                    "support": moved.support,
                    "displacement_x_m": moved.x_m,
                    "x_error_m": moved.x_standard_error_m,
                    "displacement_z_m": moved.z_m,
                    "z_error_m": moved.z_standard_error_m,
                    "rotation_mrad": 1e3 * moved.rotation_rad,
                    "rotation_error_mrad": None if rotation is None else 1e3 * rotation,
                }
            )
    return Table("identified_movements", rows, MOVEMENTS)


def _measurements(results: Results, told: Iterable[Explanation], columns: tuple[str, ...]) -> Table:
    """List every measurement beside what each hypothesis predicts; numbers are those of the drawing."""
    found = results.identification
    points = [site.point_m for site in found.sites] if found else []
    rows = [
        _fitted(each, number, row, point)
        for each in told
        for number, (row, point) in enumerate(zip(each.fit, points, strict=True), 1)
    ]
    return Table("measurements", [{key: row[key] for key in columns} for row in rows], columns)


def _fitted(each: Explanation, number: int, row: Fitted, point: list[float]) -> Row:
    own = cells(
        row, ("measurement", "unit", "measured", "sigma", "predicted", "residual", "residual_in_sigma")
    )
    place = {"x_m": point[0], "z_m": point[1]}
    return {"hypothesis": each.hypothesis, "number": number, "measured_kind": row.kind, **place, **own}
