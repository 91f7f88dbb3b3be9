"""Estimated discretisation errors as tables, for CSV files and for the report."""

from __future__ import annotations

from collections.abc import Sequence

from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.studies import ConvergenceRow
from assessment.results.table import Row, Table, cells

STATIC = ("alpha_0_error", "d_0_error_m", "alpha_u_error", "a_g_error_g")


def convergence(results: Results) -> Table:
    """List the estimated errors of the capacities of every state and direction."""
    columns = ("state", "direction", "halvings", *STATIC, "relative_error", "met")
    return Table(
        "convergence", _rows([each for each in results.convergence.rows if each.direction], columns), columns
    )


def history_convergence(results: Results) -> Table:
    """List the estimated errors of the peak displacements of every time history."""
    columns = (
        "state",
        "record",
        "halvings",
        "order",
        "peak_displacement_error_m",
        "peak_displacement_scatter_m",
        "relative_error",
        "relative_scatter",
        "met",
    )
    return Table(
        "history_convergence",
        _rows([each for each in results.convergence.rows if each.record], columns),
        columns,
    )


def incremental_convergence(results: Results) -> Table:
    """List the estimated errors of the PGA at collapse of every record and state."""
    columns = (
        "state",
        "record",
        "order",
        "pga_collapse_error_g",
        "pga_collapse_scatter_g",
        "relative_error",
        "relative_scatter",
        "met",
    )
    return Table("incremental_convergence", _rows(results.convergence.incremental or [], columns), columns)


def convergence_tables(results: Results) -> list[Table]:
    """List all tables of discretisation errors."""
    return [
        convergence(results),
        history_convergence(results),
        incremental_convergence(results),
    ]


def reported(table: Table, words: Words) -> Table:
    """Return the table for the report: an error of null is not known."""
    rows = [
        {key: words("value.not_known") if value is None else value for key, value in each.items()}
        for each in table.rows
    ]
    return Table(table.name, rows, table.columns)


def _rows(found: Sequence[ConvergenceRow], columns: Sequence[str]) -> list[Row]:
    return [cells(each, columns) for each in found]
