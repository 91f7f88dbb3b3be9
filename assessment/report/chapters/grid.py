"""Tables of results as cells of text in the report's language and units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from assessment.ntc.limit_states import CHECKS, INDEX, INDEXED, ROCK
from assessment.report.tables.capacity import SummaryLine, directions, summary_lines
from assessment.report.tables.ranges import Range
from assessment.report.tables.structure.ties import gains
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import cell, check_name, heading, is_text, written
from assessment.results.schema import Results
from assessment.results.table import Table, reference_of

AT_ONSET = {name for name in CHECKS if name not in INDEXED}
ROUNDING = 1e-9  # a reduction no larger is none
ORIGINAL = "original"
MANIFOLD = 10.0  # a value that grows by more has its factor in place of a reduction
REDUCTIONS = 3  # settled states beside the original in one table


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


def summary_grids(results: Results, words: Words) -> Iterator[Grid]:
    """Write the paper's Table 1: per direction a column per state, each settled one with its reduction."""
    settled = [name for name in results.states if name != ORIGINAL]
    portions = [settled[i : i + REDUCTIONS] for i in range(0, len(settled), REDUCTIONS)] or [[]]
    for direction in directions(results):
        lines = [line for line in summary_lines(results, direction) if not _again(line)]
        for names in portions:
            head = [heading("quantity", words), Markup.escape(words.state(ORIGINAL))]
            strengthened = {name for name in names if results.states[name].strengthening}
            for name in names:
                reduction = "reduction_strengthened" if name in strengthened else "reduction"
                head += [Markup.escape(words.state(name)), heading(reduction, words)]
            caption = f"caption.summary{'_strengthened' if strengthened else ''}"
            yield Grid(
                words(caption, direction=direction_name(direction)),
                head,
                [_summary_row(line, names, words, reference_of(results)) for line in lines],
                [True] + [False] * (len(head) - 1),
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


def strengthening_grid(results: Results, words: Words) -> Grid:
    """Write the capacities before and after every strengthening: a row a quantity; null: not reached."""
    head = ("state", "direction", "quantity", "before", "after", "gain")
    rows = []
    for row in results.strengthening or ():
        title = words("value.strengthened", state=row.state, of=words.state(row.of))
        where = written("direction", row.direction, words)
        for quantity, before, after, gain in gains(row):
            limit = row.limit_state if quantity in {"a_g_g", "zeta_E"} else None
            key = "index" if quantity == "zeta_E" and limit in INDEXED else quantity
            label = heading(key, words, reference_of(results)) + _limit(limit or "", words)
            values = (written(quantity, each, words) for each in (before, after))
            more = written("gain", gain, words)
            rows.append([title, where, label, *values, more])
            title = where = Markup("")  # named in the first row of each direction
    return Grid(
        words("caption.strengthening"),
        [heading(column, words) for column in head],
        rows,
        [is_text(column) for column in head],
    )


def _range_row(of: Range, words: Words, reference: str) -> list[Markup]:
    where = [
        written("state", of.state, words),
        written("direction", of.direction, words),
        written("contacts", of.contacts, words),
    ]
    label = heading(of.quantity, words, reference) + _limit(of.limit_state or "", words)
    return [*where, label, *(written(of.quantity, end, words) for end in (of.value, of.lowest, of.highest))]


def _limit(limit_state: str, words: Words) -> Markup:
    """Write the limit state behind the quantity that belongs to it."""
    return (
        Markup(" <span class='limit'>{}</span>").format(check_name(limit_state, words))
        if limit_state
        else Markup()
    )


def _again(line: SummaryLine) -> bool:
    """Return whether a row only repeats one above: checks of the onset are rigid, or at d_y* and T_0."""
    return line.quantity in {"d_star_m", "T_s"} and line.limit_state in AT_ONSET


def _summary_row(line: SummaryLine, names: list[str], words: Words, reference: str) -> list[Markup]:
    indexed = line.quantity == "zeta_E" and line.limit_state.partition(" ")[0] == INDEX
    label = heading("index" if indexed else line.quantity, words, reference)
    cells = [label + _limit(line.limit_state, words), _value(line, ORIGINAL, words)]
    for name in names:
        cells += [_value(line, name, words), _reduction(line, name, words)]
    return cells


def _value(line: SummaryLine, state: str, words: Words) -> Markup:
    known = state in line.values
    return written(line.quantity, line.values[state], words) if known else words("value.none")


def _reduction(line: SummaryLine, state: str, words: Words) -> Markup:
    asked = state in line.values and ORIGINAL in line.values
    if not asked:
        return words("value.none")
    lost = line.reduction(state)
    if lost is not None and lost < 1.0 - MANIFOLD:  # per cent of many thousands tell less than a factor
        return words("value.times", times=words.number(1.0 - lost, 2))
    return written("reduction", lost, words)
