"""The annex of the report with the steps of the verifications: a row to a step, a column to a state and direction.

A formula is printed once for all the columns that follow it. What it is worked out from stands in the rows above it, or
in the tables of the seismic action and of the capacity curve, under the name that it has in the formula.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from assessment.ntc.tables import renamed
from assessment.report.chapters.grids import Grid
from assessment.report.language import Words, check_name, heading, translated
from assessment.report.tables import capacities
from assessment.report.tables import capacity as capacity_tables
from assessment.results.schema import CHECKS, Results
from assessment.results.schema.model import Line as Step
from assessment.results.summary import determined_indices

Steps = Sequence[Step]
COLUMNS = 4  # of results in one table
BETWEEN_NODES = "D.M. 14/01/2008, Allegato A, eq."  # of the hazard, in full annexes
DIGITS = 6  # significant, of full annexes
CONSTANTS = {"g": 9.80665}  # given at the beginning of the report
SHARED = "capacity"  # the part that the checks of a direction have in common


@dataclass(frozen=True)
class TraceRow:
    """A row, as far as all columns that have it agree. `turn` counts the rows that are otherwise equal."""

    symbol: str
    formula: str
    unit: str
    paragraph: str
    turn: int = 0


Column = Mapping[TraceRow, float]


def traces(results: Results, words: Words) -> Iterator[Grid]:
    """Yield the calculation of the governing check, in full annexes of everything: action, curve, checks, indices."""
    least = results.summary.governing
    if results.echo.report.get("annexes") == "full":
        action = {limit: demand.trace or [] for limit, demand in (results.spectra or {}).items()}
        spectra = {limit: _column(steps, []) for limit, steps in action.items() if steps}
        yield from _tables(spectra, words("caption.trace_spectrum"), words)
        directions = {
            words.at(name, direction): dict(capacity_tables.traces(capacity))
            for name, direction, capacity in capacities(results)
        }
        yield from _parts(directions, action, "capacity_curve", "trace", words)
        found = determined_indices(results)
        indices = {words.state(name): _column(each.trace, []) for name, each in found.items()}
        yield from _tables(indices, words("caption.trace_indices"), words)
        if results.knowledge and (known := results.knowledge.trace):
            whole = {words.plain("value.whole_structure"): _column(known, [])}
            yield from _tables(whole, words("caption.knowledge"), words)
        chosen = {given.name: dict(capacity_tables.traces(given)) for given in results.mechanisms or []}
        yield from _parts(chosen, action, "virtual_work", "trace_chosen", words)
    elif least is not None:
        place = (least.state, least.direction)
        row = next(row for row in results.summary.rows if (row.state, row.direction) == place)
        demand = (results.spectra or {}).get(least.limit_state)
        before = demand.trace or [] if demand else []
        shown = [step for step in before if not step.paragraph.startswith(BETWEEN_NODES)]
        spectrum = {least.limit_state: _column(shown, [])} if shown else {}
        yield from _tables(spectrum, words("caption.trace_spectrum"), words, 4)
        steps = dict(capacity_tables.traces(results.states[least.state].capacity[least.direction]))
        own = {part: steps[part] for part in (SHARED, row.checks[least.limit_state].check) if part in steps}
        action = {least.limit_state: before, SHARED: before}
        yield from _parts({words.at(*place): own}, action, "capacity_curve", "trace", words, 4)


def _parts(
    calculations: Mapping[str, Mapping[str, Steps]],
    action: Mapping[str, Steps],
    shared: str,
    caption: str,
    words: Words,
    digits: int = DIGITS,
) -> Iterator[Grid]:
    """Yield the tables of each part of some calculations: what their checks share, then check by check.

    `action`: what is printed before, by limit state, and before what is shared.
    """
    named = {SHARED: shared} | {part: part for part in capacity_tables.BESIDE}
    for part in (SHARED, *CHECKS, *capacity_tables.BESIDE):
        before = action.get(part.split()[0], [])
        columns = {
            title: _column(parts[part], before if part == SHARED else [*before, *parts.get(SHARED, [])])
            for title, parts in calculations.items()
            if part in parts
        }
        title = words(f"value.{named[part]}") if part in named else check_name(part, words)
        yield from _tables(columns, words(f"caption.{caption}", limit=title), words, digits)


def _column(steps: Steps, before: Steps) -> Column:
    """Return the lines of a calculation, each with its result, without those printed `before` it.

    An input whose value an earlier line gives under another name takes the name of that line. An input that no line
    gives becomes a line of its own, as a datum. A line is printed again if its name has had another value since.
    """
    known = {step.symbol: step.result for step in before}
    units = {_head(step.symbol): step.unit for step in (*before, *steps)}
    lines: dict[TraceRow, float] = {}

    def add(line: TraceRow, value: float) -> None:
        while line in lines:
            line = TraceRow(line.symbol, line.formula, line.unit, line.paragraph, line.turn + 1)
        lines[line] = value
        known[line.symbol] = value

    for number, step in enumerate(steps):
        if known.get(step.symbol) == step.result and (step in before or step in steps[:number]):
            continue
        names: dict[str, str] = {}
        for name, value in step.inputs.items():
            if known.get(name) == value or name in CONSTANTS:
                continue
            # both are displacements, say; ends of an interpolation keep their names
            alike = [symbol for symbol in known if known[symbol] == value and _head(symbol) == _head(name)]
            if same := [] if name.endswith(("_1", "_2")) else alike:
                names[name] = same[-1]
            else:
                add(TraceRow(name, "", units.get(_head(name), ""), step.paragraph), value)
        formula = renamed(step.formula, names)
        add(TraceRow(step.symbol, formula, step.unit, step.paragraph), step.result)
    return lines


def _head(symbol: str) -> str:
    """Return the quantity of a symbol, which has one unit; a return period is no period of vibration."""
    return "T_R" if symbol.startswith("T_R") else symbol.split("_", maxsplit=1)[0]


def _tables(
    columns: Mapping[str, Column], caption: Markup, words: Words, digits: int = DIGITS
) -> Iterator[Grid]:
    """Yield the columns side by side, COLUMNS to a table."""
    titles = list(columns)
    for start in range(0, len(titles), COLUMNS):
        shown = {title: columns[title] for title in titles[start : start + COLUMNS]}
        head = [heading("symbol", words), heading("formula", words), *map(Markup.escape, shown)]
        rows = [_row(line, shown.values(), words, digits) for line in _merged(shown.values())]
        texts = [True, True, *[False] * len(shown), True]
        yield Grid(caption, [*head, heading("paragraph", words)], rows, texts)


def _merged(columns: Iterable[Column]) -> list[TraceRow]:
    """Return the lines of all columns, each once, in an order that keeps that of every column where it can."""
    merged: list[TraceRow] = []
    for column in columns:
        place = 0
        for line in column:
            if line in merged:
                place = merged.index(line) + 1
            else:
                merged.insert(place, line)
                place += 1
    return merged


def _row(line: TraceRow, columns: Iterable[Column], words: Words, digits: int) -> list[Markup]:
    """Write a line with its result in each column; where a number comes from in the language of the report."""
    unit, mark = words.name("unit", line.unit), words.plain("value.decimal_mark")
    cells = [typeset(line.symbol, words) + (f" [{unit}]" if unit else "")]
    cells.append(typeset(line.formula, words) or words("value.datum"))
    for column in columns:
        text = words.number(round(column[line], 12), digits) if line in column else words("value.none")
        decimal = mark in text and "·" not in text
        cells.append(Markup.escape(text.rstrip("0").rstrip(mark) if decimal else text))
    text = translated(line.paragraph, words)
    if text == line.paragraph:  # paragraphs of standards stay as they are
        phrases = (phrase.split(": ") for phrase in text.split("; "))
        text = "; ".join(": ".join(words.name("source", part) for part in phrase) for phrase in phrases)
    text = re.sub(r"\b([A-Za-zα-ω])_(\w+)", r"\1<sub>\2</sub>", str(Markup.escape(text)))
    return [*cells, Markup(text)]


_NAME = re.compile(r"[A-Za-z_]\w*")
_SIGNS = {
    "sqrt": "√",
    "log": "ln",
    "pi": "π",
    "eta": "η",
    "alpha": "α",
    "Gamma": "Γ",
    "gamma": "γ",
    "psi": "ψ",
}
_SIGNS |= {"xi": "ξ", "Sigma": "Σ", "delta": "δ", "zeta": "ζ", "theta": "θ", "lambda": "λ"}
# names whose parts are no subscripts: sums over the weights that move, and an index of D.M. 58/2017
_WHOLE = {
    "Sigma_P": "ΣP",
    "Sigma_P_delta": "ΣPδ<sub>x</sub>",
    "Sigma_P_delta_2": "ΣPδ<sub>x</sub>²",
    "IS_V": "IS-V",
}
_SUM = re.compile(r"(Sigma_\w+)(?=\*\*)")
_POWER = re.compile(r"\*\*(?:\(((?:[^()]|\([^()]*\))*)\)|([\w.]+))")


def typeset(formula: str, words: Words) -> Markup:
    """Write a symbol or a formula; where the decimal mark is a comma, arguments are parted by a semicolon."""
    text = _SUM.sub(r"(\1)", str(Markup.escape(formula)))  # (Σ…)², beside a sum of squares
    while (raised := _POWER.sub(lambda it: f"<sup>{it[1] or it[2]}</sup>", text)) != text:
        text = raised
    text = re.sub(r"abs\(([^()]*)\)", r"|\1|", text).replace("*", "·").replace("-", "−")
    text = _NAME.sub(lambda it: _symbol(it[0], words), text)
    mark = words.plain("value.decimal_mark")
    return Markup(text if mark == "." else re.sub(r"(\d)\.(\d)", rf"\1{mark}\2", text.replace(", ", "; ")))


def _symbol(name: str, words: Words) -> str:
    if name in _WHOLE:
        return _WHOLE[name]
    head, *rest = name.split("_")
    known = words.strings["subscript"]
    parts = [_SIGNS.get(part, known.get(part, part)) for part in rest if part != "star"]
    subscript = f"<sub>{','.join(parts)}</sub>" if parts else ""
    return _SIGNS.get(head, head) + subscript + ("*" if "star" in rest else "")
