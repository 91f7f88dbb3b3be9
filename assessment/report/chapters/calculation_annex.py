"""The annex of the report with the steps of the verifications: the lines of tables/trace.csv, with the numbers put in.

Lines that a check shares with the seismic action of its limit state are printed there alone.
"""

import re
from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.chapters.grids import Grid, grid
from assessment.report.language import Words, check_name, translated
from assessment.report.tables.capacity import calculations
from assessment.results.schema import Results
from assessment.results.schema.model import Line
from assessment.results.table import Row, Table

BETWEEN_NODES = "D.M. 14/01/2008, Allegato A, eq."  # of the hazard, in full annexes
COLUMNS = ("symbol", "formula", "inputs", "result", "paragraph")


def traces(results: Results, words: Words) -> Iterator[Grid]:
    """Yield the calculation of the governing check, in full annexes of everything: action, curve, checks, indices."""
    full, least, wanted = results.echo.report.get("annexes") == "full", results.summary.governing, []
    if least is not None:
        place = least.state, least.direction
        row = next(row for row in results.summary.rows if (row.state, row.direction) == place)
        wanted = [("", "", f"spectrum {least.limit_state}"), (*place, "capacity")]
        wanted += [(*place, row.checks[least.limit_state].check)]
    action: dict[str, list[Line]] = {}
    for state, direction, part, steps in calculations(results):
        if not full and (state, direction, part) not in wanted:
            continue
        mechanism, _, check = part.rpartition(": ")
        kind, _, limit = check.partition(" ")
        if kind == "spectrum":
            before, action[limit] = [], steps
        else:
            before = action.get(kind, [])
        own = [line for line in steps if line not in before]
        if not full:
            own = [line for line in own if not line.paragraph.startswith(BETWEEN_NODES)]
        rows = [_row(line, words, 6 if full else 4) for line in own]
        if not rows:
            continue
        named = kind in words.strings["calculation"]
        title = words(f"calculation.{kind}", limit=limit) if named else check_name(check, words)
        where = filter(None, [mechanism, title, words.at(state, direction)])
        caption = words("caption.trace", title=Markup(", ").join(where))
        yield grid(Table("trace", rows, COLUMNS), words, caption)


def _row(line: Line, words: Words, digits: int) -> Row:
    """Write a line, numbers with so many digits; where it comes from in the language of the report."""
    unit, mark = words.name("unit", line.unit), words.plain("value.decimal_mark")

    def number(value: float) -> str:
        text = words.number(round(value, 12), digits)
        return text.rstrip("0").rstrip(mark) if mark in text and "·" not in text else text

    source = translated(line.paragraph, words)
    if source == line.paragraph:  # paragraphs of standards stay as they are
        phrases = (phrase.split(": ") for phrase in source.split("; "))
        source = "; ".join(": ".join(words.name("source", part) for part in phrase) for phrase in phrases)
    source = re.sub(r"\b([A-Za-zα-ω])_(\w+)", r"\1<sub>\2</sub>", str(Markup.escape(source)))
    inputs = (typeset(name, words) + f" = {number(value)}" for name, value in line.inputs.items())
    return {
        "symbol": typeset(line.symbol, words) + (f" [{unit}]" if unit else ""),
        "formula": typeset(line.formula, words) or words("value.datum"),
        "inputs": Markup("; ").join(inputs),
        "result": Markup.escape(number(line.result)),
        "paragraph": Markup(source),
    }


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
