"""Rows as CSV and as Markdown."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from assessment.benchmark.measure import Row

Column = tuple[str, str, Callable[[Any], str]]
"""Key of the rows, heading, and how a value is written."""


def as_csv(rows: Sequence[Row]) -> bytes:
    """All columns that any row has, in the order in which they appear; a value that a row lacks is empty."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def listed(rows: Iterable[Row], columns: Sequence[Column]) -> str:
    """A Markdown table with a line for each row."""
    lines = [
        [write(row[key]) if row.get(key) is not None else "" for key, _, write in columns] for row in rows
    ]
    return _markdown([heading for _, heading, _ in columns], lines)


def pivoted(
    rows: Sequence[Row],
    index: Sequence[str],
    columns: Sequence[str],
    heading: Callable[[Row], str],
    cell: Callable[[Row], str],
) -> str:
    """A Markdown table with a line for each value of the `index` keys, and a column for each of the `columns` keys."""
    across: dict[tuple[Any, ...], str] = {}
    down: dict[tuple[Any, ...], dict[tuple[Any, ...], str]] = {}
    for row in rows:
        at = tuple(row[key] for key in columns)
        across[at] = heading(row)
        down.setdefault(tuple(row[key] for key in index), {})[at] = cell(row)
    lines = [[*map(str, line), *(cells.get(at, "") for at in across)] for line, cells in down.items()]
    return _markdown([*index, *across.values()], lines)


def _markdown(headings: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    rule = ["---"] * len(headings)
    return "\n".join(f"| {' | '.join(line)} |" for line in (headings, rule, *lines))


def number(value: float) -> str:
    """Two significant digits; a dash for what is not known."""
    if math.isnan(value):
        return "–"
    if value != 0.0 and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return f"{value:.0e}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}" if value else "0"


def percent(share: float) -> str:
    """A share in per cent, two significant digits."""
    if 0.0 < abs(share) < 1e-7:
        return "< 1e-5 %"
    return f"{number(100.0 * share)} %"
