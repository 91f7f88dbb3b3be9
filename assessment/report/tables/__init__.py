"""The tables of the report and of the CSV files: one CSV each, and the fragilities as NRML."""

from pathlib import Path
from typing import Any

from assessment.report.tables import capacity, cracks, dynamic, mechanisms, structure, studies  # noqa: F401 - entered
from assessment.report.tables.dynamic import fragility_model
from assessment.report.tables.rows import TABLES
from assessment.results.schema import Results
from assessment.results.table import Table
from assessment.runtime.files import write_atomically

RUN = ("=", "+", "-", "@", "\t", "\r")  # what a formula begins with in a spreadsheet


def write_tables(results: Results, folder: Path) -> None:
    """Write every table that has rows as CSV (comma, point, UTF-8) into the folder, and fragilities as NRML.

    A text that a spreadsheet would take for a formula, names as well as +x, has an apostrophe in front.
    """
    import pandas as pd  # late: the report needs the rows only

    if model := fragility_model(results):
        write_atomically(folder / "fragility.xml", model)
    for each in tables(results):
        if each.rows:
            frame = pd.DataFrame(each.rows, columns=list(each.columns))
            words = [name for name, kind in frame.dtypes.items() if not pd.api.types.is_numeric_dtype(kind)]
            frame = frame.assign(**{str(name): frame[name].map(inert) for name in words})
            frame.columns = frame.columns.map(inert)
            path = folder / f"{each.name}.csv"
            write_atomically(path, frame.to_csv(index=False, lineterminator="\n").encode())


def inert(cell: Any) -> Any:
    """Return a cell that no spreadsheet runs: texts that begin like a formula get an apostrophe in front."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(RUN) else cell


def tables(results: Results) -> list[Table]:
    """List all tables of the results, long ones included."""
    return [made(results) for made in TABLES.values()]
