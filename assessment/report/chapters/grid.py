"""Tables of results as cells of text in the report's language and units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from assessment.ntc.limit_states import CHECKS, INDEX, INDEXED, ROCK
from assessment.report.tables.capacity import SummaryLine, directions, summary_lines
from assessment.report.tables.ranges import Range
from assessment.report.tables.structure.ties import gains
from assessment.report.text.columns import cell, check_name, heading, is_text, written
from assessment.report.text.language import Words, direction_name
from assessment.results.schema import Results
from assessment.results.table import Table, reference_of

LETTERS = 109.0  # of a's width in a row of a table
PADDING = 1.7  # letters, of a cell
BOLD = 1.1  # of a heading, beside the same words in a row
HEADING_LINES = 2  # of a heading: one that takes more is given what room a row leaves
SIZES = {
    letter: size
    for letters, size in (("ijl’'|.,;: \u00a0", 0.5), ("frt()[]-/", 0.65), ("mwMW%", 1.5))
    for letter in letters
}
BLANK = SIZES[" "]
BLANKS = re.compile(
    r"[ \n]+"
)  # where a line may end: not at a blank that holds a number and its unit together
AT_ONSET = {name for name in CHECKS if name not in INDEXED}
ROUNDING = 1e-9  # a reduction, or a width in letters, no larger is none
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

    @property
    def widths(self) -> list[float]:
        """Return the widths of the columns in per cent: numbers stay whole, words make room by wrapping.

        A letter at a time is taken from the column of words where that costs the table the fewest lines, from the
        left ones, the names, last.
        """
        columns = [
            _Column.of(head, cells, text)
            for head, cells, text in zip(self.head, zip(*self.rows, strict=True), self.text, strict=True)
        ]
        widths = [column.natural for column in columns]
        lines = [column.lines(width) for column, width in zip(columns, widths, strict=True)]
        while (excess := sum(widths) - LETTERS) > ROUNDING:
            ways = []
            for at, column in enumerate(columns):
                if widths[at] > column.least:
                    width = max(column.least, widths[at] - min(1.0, excess))
                    tried = [*lines[:at], column.lines(width), *lines[at + 1 :]]
                    ways.append((sum(map(max, zip(*tried, strict=True))), -at, width, tried))
            if not ways:
                break
            _, at, width, lines = min(ways, key=lambda way: way[:2])
            widths[-at] = width
        widths = _headings_in_fewer_lines(columns, widths)
        return [round(100.0 * width / sum(widths), 2) for width in widths]


@dataclass(frozen=True)
class _Column:
    """What the words of a column take, in letters: those of its heading, then those of each cell.

    `natural`: a width in which no cell wraps; `least`: one in which no word is parted.
    """

    words: list[list[float]]
    natural: float
    least: float

    @classmethod
    def of(cls, head: Markup, cells: Sequence[Markup], text: bool) -> _Column:
        title = [BOLD * _room(word) for word in _parted(head)]
        words = [[_room(word) for word in _parted(cell)] for cell in cells]
        whole = max(*title, *(_room(cell.striptags()) for cell in cells))
        natural = PADDING + min(36.0, max(6.0, whole))
        longest = max(*title, *(max(of) for of in words))
        return cls([title, *words], natural, PADDING + min(36.0, longest) if text else natural)

    def lines(self, width: float) -> list[int]:
        """Return how many lines each cell takes, the heading first."""
        return [_lines(of, width - PADDING) for of in self.words]


def _headings_in_fewer_lines(columns: Sequence[_Column], widths: Sequence[float]) -> list[float]:
    """Return the widths with what they leave of a row given to the headings that take the most lines."""
    wider = list(widths)
    while True:
        tall = [column.lines(width)[0] for column, width in zip(columns, wider, strict=True)]
        at = tall.index(max(tall))
        width = wider[at]
        while tall[at] > HEADING_LINES and columns[at].lines(width)[0] == tall[at]:
            width += 1.0
        if width == wider[at] or sum(wider) + width - wider[at] > LETTERS:
            return wider
        wider[at] = width


def _lines(words: Sequence[float], width: float) -> int:
    lines, used = 1, -BLANK
    for word in words:
        used += BLANK + word
        if used > width + ROUNDING and used > word:
            lines, used = lines + 1, word
    return lines


def _parted(cell: Markup) -> list[str]:
    return BLANKS.split(cell.striptags()) or [""]


def _room(text: str) -> float:
    """Return the width of a text in letters like a; capitals and digits are wider."""
    return sum(SIZES.get(each, 1.12 if each.isupper() else 1.05 if each.isdigit() else 1.0) for each in text)


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
            head = [words("column.quantity"), Markup.escape(words.state(ORIGINAL))]
            strengthened = {name for name in names if results.states[name].strengthening}
            for name in names:
                reduction = f"column.reduction{'_strengthened' if name in strengthened else ''}"
                head += [Markup.escape(words.state(name)), words(reduction)]
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
        [words(f"column.{column}") for column in head],
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
        [words(f"column.{column}") for column in head],
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
