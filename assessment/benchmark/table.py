"""Rows as CSV and as Markdown."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any, TypeVar

Column = tuple[str, str, Callable[[Any], str]]
"""Field of the rows, heading, and how a value is written."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A line of a table: what was measured. None or NaN: it was not; `failed`: why."""

    case: str
    failed: str | None = None


@dataclass(frozen=True, kw_only=True)
class Precision(Row):
    """Relative error and processor time (s) at a value of a parameter, the program's own by `default`.

    `ratio`: of the time to PIQP once a step.
    """

    parameter: str
    value: float
    default: bool = False
    error: float = math.nan
    seconds: float = math.nan
    ratio: float = math.nan


Kind = TypeVar("Kind", bound=Row)


def is_known(value: object) -> bool:
    """Whether a cell has a value."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def as_csv(rows: Sequence[Row]) -> bytes:
    """All fields that are known of any row; one that is not is empty."""
    names = dict.fromkeys(field.name for row in rows for field in fields(row))
    columns = [name for name in names if any(is_known(getattr(row, name, None)) for row in rows)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        cells = (getattr(row, name, None) for name in columns)
        writer.writerow([cell if is_known(cell) else "" for cell in cells])
    return text.getvalue().encode()


def listed(rows: Iterable[Row], columns: Sequence[Column]) -> str:
    """A Markdown table with a line for each row."""
    lines = [
        [write(value) if is_known(value := getattr(row, name)) else "" for name, _, write in columns]
        for row in rows
    ]
    return _markdown([heading for _, heading, _ in columns], lines)


def pivoted(
    rows: Sequence[Kind],
    index: Sequence[str],
    columns: Sequence[str],
    heading: Callable[[Kind], str],
    cell: Callable[[Kind], str],
) -> str:
    """A Markdown table with a line for each value of the `index` fields, a column for each of the `columns` fields."""
    across: dict[object, str] = {}
    down: dict[tuple[object, ...], dict[object, str]] = {}
    for row in rows:
        at = attrgetter(*columns)(row)
        across[at] = heading(row)
        down.setdefault(tuple(getattr(row, name) for name in index), {})[at] = cell(row)
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
