"""What was measured: rows of fields, as CSV and as a Markdown table."""

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]
"""Fields by name, `case` first; None or NaN: not measured; `failed`: why."""

IN_PER_CENT = ("error", "saves")


def known(value: object) -> bool:
    """Whether a cell has a value."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def fields(rows: Sequence[Row]) -> list[str]:
    """Names of the fields that any row has a value of, in their order."""
    return list(dict.fromkeys(name for row in rows for name, value in row.items() if known(value)))


def as_csv(rows: Sequence[Row]) -> bytes:
    """All fields that are known of any row; one that is not is empty."""
    text, names = io.StringIO(), fields(rows)
    lines = [[row[name] if known(row.get(name)) else "" for name in names] for row in rows]
    csv.writer(text, lineterminator="\n").writerows([names, *lines])
    return text.getvalue().encode()


def table(rows: Sequence[Row], index: Sequence[str] = (), across: str = "", cells: Sequence[str] = ()) -> str:
    """A Markdown table: a line for each row or value of `index`, a column for each value of `across`."""
    if not across:
        names = [name for name in fields(rows) if name in index or (not index and name != "parameter")]
        return _markdown(names, [[written(name, row.get(name)) for name in names] for row in rows])
    headings = list(dict.fromkeys(written(across, row[across], row) for row in rows))
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        told = [written(name, row.get(name)) for name in cells if known(row.get(name))]
        text = "; ".join(told) if row.get("failed") is None else "fails"
        line = lines.setdefault(tuple(str(row.get(name, "")) for name in index), {})
        line[written(across, row[across], row)] = f"**{text}**" if row.get("default") else text
    return _markdown(
        [*index, *headings], [[*at, *(line.get(each, "") for each in headings)] for at, line in lines.items()]
    )


def _markdown(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in (headings, ["---"] * len(headings), *lines))


def written(name: str, value: Any, row: Row | None = None) -> str:
    """The text of a field; infinitely many segments are the exact bed."""
    if not known(value):
        return ""
    if name == "value" and row:
        times = row["parameter"] == "increment"
        text = "exact" if math.isinf(value) else f"{'× ' if times else ''}{value:g}"
        return f"{1e3 * value:.3g} ms" if row["parameter"].startswith("time step") else text
    if name in IN_PER_CENT:
        return "< 1e-5 %" if 0.0 < abs(value) < 1e-7 else f"{number(100.0 * value)} %"
    if name == "alpha" or name.endswith(("_end_m", "_g")):
        return f"{value:.5f}"
    if name in ("least", "median", "most"):
        return f"{value:.3g}"
    return number(value) if isinstance(value, float) else str(value)


def number(value: float) -> str:
    """Two significant digits."""
    if value != 0.0 and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return f"{value:.0e}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}" if value else "0"
