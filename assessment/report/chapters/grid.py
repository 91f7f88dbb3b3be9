"""Tables of results as cells of text in the report's language and units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from assessment.ntc.limit_states import ROCK
from assessment.report.tables.ranges import Range
from assessment.report.text.language import Words
from assessment.report.text.quantities import cell, check_name, heading, is_text, written
from assessment.results.table import Table


@dataclass(frozen=True)
class Grid:
    """A table of the report: headings (HTML) and rows of cells; `text` marks the columns of words."""

    caption: Markup
    head: list[Markup]
    rows: list[list[Markup]]
    text: list[bool]


def grid(table: Table, words: Words, caption: Markup, significant: int = 3, reference: str = ROCK) -> Grid:
    """Write a table for the report, without the columns that no row has; `reference`: of a_g, rock or surface."""
    columns = [column for column in table.columns if any(column in row for row in table.rows)]
    return Grid(
        caption,
        [heading(column, words, reference) for column in columns],
        [[cell(column, row, words, significant) for column in columns] for row in table.rows],
        [is_text(column) for column in columns],
    )


def ranges_grid(ranges: Sequence[Range], words: Words, reference: str = ROCK) -> Grid:
    """Write the ranges of paths that scatter: a row a quantity, under the contacts or the check that it is of.

    Ratios are left out: they are those of the a_g above them. `reference`: of a_g, rock or surface.
    """
    head = ("state", "direction", "contacts", "quantity", "used", "lowest", "highest")
    return Grid(
        words("caption.static_ranges"),
        [heading(column, words) for column in head],
        [_range_row(each, words, reference) for each in ranges if each.quantity != "zeta_E"],
        [is_text(column) for column in head],
    )


def _range_row(of: Range, words: Words, reference: str) -> list[Markup]:
    where = [written(name, getattr(of, name), words) for name in ("state", "direction", "contacts")]
    limit = f" {check_name(of.limit_state, words)}" if of.limit_state else ""
    ends = (written(of.quantity, end, words) for end in (of.value, of.lowest, of.highest))
    return [*where, heading(of.quantity, words, reference) + limit, *ends]
