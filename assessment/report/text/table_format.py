"""Tables of results as cells of text in the report's language and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

from markupsafe import Markup

from assessment.ntc.capacity_return_period import stated
from assessment.ntc.demand.hazard_grid import RETURN_PERIODS
from assessment.ntc.limit_states import CHECKS, INDEXED, ROCK, SURFACE
from assessment.report.tables.capacity import directions
from assessment.report.tables.mechanisms import WHOLE
from assessment.report.text.language import Words, direction_name
from assessment.results.schema import Results
from assessment.results.table import Row, Table, reference_of

MILLIMETRES = {
    "d_y_m",
    "d_0_m",
    "d_0_star_m",
    "d_star_m",
    "displacement_x_m",
    "displacement_z_m",
    "ultimate_rigid_m",
    "ultimate_elastic_m",
    "ultimate_movement_m",
    "peak_displacement_m",
    "residual_displacement_m",
    "movement_m",
    "opening_m",
    "other_opening_m",
    "slip_m",
    "d_0_error_m",
    "peak_displacement_error_m",
    "peak_displacement_scatter_m",
    "lowest_peak_m",
    "median_peak_m",
    "highest_peak_m",
}
PERCENT = {"PAM", "damping", "reduction", "static_reduction", "dynamic_reduction"}
PERCENT |= {"dynamic_loss", "dynamic_loss_low", "dynamic_loss_high", "static_loss"}
PERCENT |= {"deviation", "hand_deviation", "relative_error", "relative_scatter", "integrator_share"}
COARSE = 2  # digits of what a few records tell no better
ROUGH = {
    "dynamic_loss",
    "dynamic_loss_low",
    "dynamic_loss_high",
    "static_loss",
}  # beside a loss known to 10 %
ROUGH |= {"beta", "beta_low", "beta_high", "beta_record", "beta_ensemble"}
TEXT = {"state", "direction", "limit_state", "layer", "support", "stage", "quantity"}
TEXT |= {
    "use_class",
    "use_category",
    "IS_V_class",
    "PAM_class",
    "risk_class",
    "parameter",
    "origin",
    "scaling",
    "counts",
    "mechanism",
    "macro_element",
    "governing",
    "kind",
    "soil",
    "topography",
    "refused",
}
TEXT |= {"property", "collapses", "table", "setting", "value", "expected", "computed", "verified"}
TEXT |= {
    "case",
    "source",
    "record",
    "contacts",
    "control",
    "collapsed",
    "resurrections",
    "integrator",
    "settlement",
    "rule",
}
Label = TypeVar("Label", str, Markup)
ROCK_COLUMNS = {
    "a_g_g",
    "demand_a_g_g",
    "static_pga_g",
    "a_g_error_g",
    "a_g_low_g",
    "a_g_base_g",
    "a_g_high_g",
}
SURFACE_COLUMNS = {
    "pga_g",
    "demand_pga_g",
    "dynamic_pga_g",
    "static_surface_pga_g",
    "record_pga_g",
    "pga_safe_g",
    "resurrections",
}
SURFACE_COLUMNS |= {"pga_collapse_g", "pga_all_collapse_g", "mean_pga_collapse_g", "lowest_pga_collapse_g"}
SURFACE_COLUMNS |= {"median_g", "pga_collapse_error_g"}
LETTERS = 125.0  # of average width in a row of a table
CENTRES = {"x_C_m", "z_C_m"}  # a block that does not turn has none
AT_ONSET = {name for name in CHECKS if name not in INDEXED}
ROUNDING = 1e-9  # a reduction no larger is none
FOUND = re.compile(r"(\d+) \+ (\d+)")  # a mechanism by its hinges and sliding joints
GENERATED = re.compile(r"generated (\d+)")  # the name of a record that the program made
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
        """Return the widths of the columns in per cent: numbers stay whole, words make room by wrapping."""
        whole, least = [], []
        for head, cells, text in zip(self.head, zip(*self.rows, strict=True), self.text, strict=True):
            title = max(1.2 * _room(word) for word in _parted(head))
            words = max(_room(word) for cell in cells for word in _parted(cell)) if text else 0.0
            whole.append(2.0 + min(36.0, max(6.0, title, *(_room(cell.striptags()) for cell in cells))))
            least.append(2.0 + min(36.0, max(title, words)) if text else whole[-1])
        spare = sum(whole) - sum(least)
        give = min(1.0, max(0.0, sum(whole) - LETTERS) / spare) if spare > 0.0 else 0.0
        kept = [wide - give * (wide - narrow) for wide, narrow in zip(whole, least, strict=True)]
        return [round(100.0 * wide / sum(kept), 2) for wide in kept]


def _parted(cell: Markup) -> list[str]:
    return cell.striptags().split() or [""]


def _room(text: str) -> float:
    """Return the width of a text in average letters; capitals and digits are wider."""
    capitals, digits = (sum(map(kind, text)) for kind in (str.isupper, str.isdigit))
    return len(text) + 0.4 * capitals + 0.15 * digits


def grid(table: Table, words: Words, caption: Markup, significant: int = 3, reference: str = ROCK) -> Grid:
    """Write a table for the report, without the columns that no row has; `reference`: of a_g, rock or surface."""
    columns = [column for column in table.columns if any(column in row for row in table.rows)]
    return Grid(
        caption,
        [heading(column, words, reference) for column in columns],
        [[cell(column, row, words, significant) for column in columns] for row in table.rows],
        [column in TEXT for column in columns],
    )


def heading(column: str, words: Words, reference: str) -> Markup:
    """Write the heading of a column; that of an acceleration says what it refers to."""
    text = words(f"column.{column}")
    if column in SURFACE_COLUMNS:
        return referenced(text, words, SURFACE)
    return referenced(text, words, reference) if column in ROCK_COLUMNS else text


def referenced(label: Label, words: Words, reference: str) -> Label:
    """Put into a label with the unit [g] whether the acceleration is on rock or at the surface."""
    return label.replace(" [g]", f" {words.plain(f'value.on_{reference}')} [g]")


def cell(column: str, row: Row, words: Words, significant: int = 3) -> Markup:
    """Write one value: a dash where it was not asked for, "not reached" for null, the unit of the heading."""
    value = row.get(column)
    if isinstance(value, Markup):
        return value
    if column not in row or (value is None and column in TEXT | CENTRES):
        return words("value.none")
    if column == "parameter":
        return words(f"value.parameter_{value}")
    if column == "governing":
        return governing(str(value), words)
    if column in {"return_period_years", "T_SLV_years"} and value is not None:
        return Markup.escape(_bounded(float(value), words))
    if value == "inf" and column not in TEXT:  # an input: results have no infinity
        return Markup("∞")
    if isinstance(value, float) and column == "share":
        return Markup.escape(words.comma(f"{100.0 * value:g}"))
    if isinstance(value, float):
        significant = min(significant, COARSE) if column in ROUGH else significant
        factor = 1000.0 if column in MILLIMETRES else 100.0 if column in PERCENT else 1.0
        return Markup.escape(words.number(factor * value, significant))
    return Markup.escape(_name(column, value, words))


def governing(text: str, words: Words) -> Markup:
    """Write what set a capacity: a share of d_0, a local limit, activation."""
    known = words.strings["governing"]
    parts = [
        Markup(known.get(part, words.comma(part)).replace("d_0", "d<sub>0</sub>"))
        for part in text.split(": ")
    ]
    return Markup(": ").join(parts)


def check_name(check: str, words: Words) -> str:
    """Write the name of a check: its limit state, and what it is where that has several."""
    if check == "SLV linear":
        return words.plain("value.slv_linear")
    limit, _, kind = check.partition(" ")
    return words.plain("value.elastic_branch", limit=limit) if kind else check


def _bounded(T_R: float, words: Words) -> str:
    """Write a return period: beyond the hazard as such with its estimate, at its bounds as there or beyond."""
    if beyond := stated(T_R):
        return f"{beyond} ({words.number(T_R)})"
    sign = "≤ " if RETURN_PERIODS[0] >= T_R else "≥ " if RETURN_PERIODS[-1] <= T_R else ""
    return f"{sign}{words.number(T_R)}"


def _name(column: str, value: Any, words: Words) -> str:
    """Return the report's word for a value that is no measure."""
    if column == "state":
        return words.state(value)
    if column == "direction":
        return direction_name(value)
    if column == "record" and (made := GENERATED.fullmatch(str(value))):
        return words.plain("value.generated", number=made[1])
    if column == "mechanism" and (found := FOUND.fullmatch(str(value))):
        counts = zip(("hinge", "slide"), found.groups(), strict=True)
        named = ((what if count == "1" else f"{what}s", count) for what, count in counts if count != "0")
        return ", ".join(words.plain(f"value.{what}", count=count) for what, count in named)
    if column in {"contacts", "property", "rule"}:
        return words.plain(f"value.{value}")
    if column == "verified" and value is not None:
        return words.plain("value.verified" if value else "value.not_verified")
    if column == "limit_state":
        return check_name(value, words)
    if column == "kind":
        return words.plain(f"value.{value}_spectrum")
    if column == "macro_element" and value == WHOLE:
        return words.plain("value.whole_structure")
    if column in {"use_category", "integrator"}:
        return str(words.strings["setting"].get(value, value))
    if column == "scaling":
        return words.plain(f"value.scaling_{value.replace('-', '_')}")
    if column == "stage":
        return ", ".join(words.strings["value"].get(part, part) for part in str(value).split(", "))
    return words.show(value)


def summary_grids(table: Table, results: Results, words: Words) -> Iterator[Grid]:
    """Write the paper's Table 1: per direction a column per state, each settled one with its reduction."""
    settled = [name for name in results.states if name != "original"]
    portions = [settled[i : i + REDUCTIONS] for i in range(0, len(settled), REDUCTIONS)] or [[]]
    for direction in directions(results):
        rows = [row for row in table.rows if row["direction"] == direction]
        for names in portions:
            head = [words("column.quantity"), Markup.escape(words.state("original"))]
            for name in names:
                head += [Markup.escape(name), words("column.reduction")]
            yield Grid(
                words("caption.summary", direction=direction_name(direction)),
                head,
                [_summary_row(row, names, words, reference_of(results)) for row in rows if not _again(row)],
                [True] + [False] * (len(head) - 1),
            )


def ranges_grid(table: Table, words: Words, reference: str = ROCK) -> Grid:
    """Write the ranges of paths that scatter: a row a quantity, under the contacts or the check that it is of.

    Ratios are left out: they are those of the a_g above them. `reference`: of a_g, rock or surface.
    """
    ends = ("value", "lowest", "highest")
    rows = []
    for row in table.rows:
        if row["quantity"] == "zeta_E":
            continue
        label = heading(row["quantity"], words, reference)
        if "limit_state" in row:
            label += Markup(" <span class='limit'>{}</span>").format(check_name(row["limit_state"], words))
        of = [cell(column, row, words) for column in ("state", "direction", "contacts")]
        rows.append(
            [*of, label, *(cell(row["quantity"], {row["quantity"]: row[end]}, words) for end in ends)]
        )
    head = ("state", "direction", "contacts", "quantity", "used", "lowest", "highest")
    return Grid(
        words("caption.static_ranges"),
        [words(f"column.{column}") for column in head],
        rows,
        [column in TEXT for column in head],
    )


def _again(row: Row) -> bool:
    """Return whether a row says once more what it has above: checks of the onset are rigid, or at d_y* and T_0."""
    return row["quantity"] in {"d_star_m", "T_s"} and row["limit_state"] in AT_ONSET


def _summary_row(row: Row, names: list[str], words: Words, reference: str) -> list[Markup]:
    quantity, limit = row["quantity"], row["limit_state"]
    indexed = quantity == "zeta_E" and limit.partition(" ")[0] in INDEXED
    label = heading("index" if indexed else quantity, words, reference)
    if limit:
        label += Markup(" <span class='limit'>{}</span>").format(check_name(limit, words))
    cells = [label, _valued(quantity, row, "original", words)]
    for name in names:
        cells.append(_valued(quantity, row, name, words))
        loss = row.get(f"reduction: {name}")
        shown = None if loss is None else loss if abs(loss) > ROUNDING else 0.0
        cells.append(words("value.none") if shown is None else Markup.escape(words.number(100.0 * shown)))
    return cells


def _valued(quantity: str, row: Row, state: str, words: Words) -> Markup:
    return cell(quantity, {quantity: row[state]} if state in row else {}, words)
