"""The annex of the report with every step of the verifications, in signs and subscripts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from assessment import capacity_tables
from assessment.display import Grid, check_name, grid
from assessment.table import Row, Table
from assessment.trace import pretty
from assessment.words import Words, direction_name

Results = Mapping[str, Any]


def traces(results: Results, words: Words) -> Iterator[Grid]:
    """Yield every calculation: the spectra, then each direction of each state, then the chosen mechanisms.

    What the table of its spectrum, or the same table, has already said is not printed again.
    """
    spectra = {limit: content.get("trace") or [] for limit, content in (results.get("spectra") or {}).items()}
    for limit, steps in spectra.items():
        yield from _calculation(steps, [], words("caption.trace_spectrum", limit=limit), words)
    for name, direction, capacity in capacity_tables.capacities(results):
        for part, steps in capacity_tables.traces(capacity):
            where = {"state": words.state(name), "direction": direction_name(direction)}
            caption = words("caption.trace", limit=_part(part, "capacity_curve", words), **where)
            yield from _calculation(steps, spectra.get(part.split()[0], []), caption, words)
    for given in results.get("mechanisms") or []:
        for part, steps in capacity_tables.traces(given):
            title = _part(part, "virtual_work", words)
            caption = words("caption.trace_chosen", name=given["name"], limit=title)
            yield from _calculation(steps, spectra.get(part.split()[0], []), caption, words)


def _part(part: str, shared: str, words: Words) -> str:
    return words.plain(f"value.{shared}") if part == "capacity" else check_name(part, words)


def _calculation(
    steps: Sequence[Mapping[str, Any]], said: Sequence[Mapping[str, Any]], caption: Markup, words: Words
) -> Iterator[Grid]:
    columns = ("symbol", "formula", "inputs", "result", "paragraph")
    lines: list[Mapping[str, Any]] = []
    for step in steps:
        if step not in said and step not in lines:
            lines.append(step)
    if lines:
        yield grid(Table("trace", [_step(step, words) for step in lines], columns), words, caption)


def _step(step: Mapping[str, Any], words: Words) -> Row:
    unit = words.strings["unit"].get(step["unit"], step["unit"])
    inputs = (f"{_signs(name)} = {words.number(value, 6)}" for name, value in step["inputs"].items())
    return {
        "symbol": _signs(step["symbol"]),
        "formula": _signs(step["formula"]) or words("value.datum"),
        "inputs": Markup("; ".join(inputs)),
        "result": f"{words.number(step['result'], 6)} {unit}".strip(),
        "paragraph": _source(step["paragraph"], words),
    }


def _signs(formula: str) -> Markup:
    """Write a symbol or formula with signs and subscripts."""
    return Markup(pretty(str(Markup.escape(formula)), "<sub>{}</sub>".format).replace("_", ","))


def _source(paragraph: str, words: Words) -> str:
    """Write where a number comes from in the language of the report; paragraphs of standards stay as they are."""
    known = words.strings["source"]
    return "; ".join(
        ": ".join(known.get(part, part) for part in phrase.split(": ")) for phrase in paragraph.split("; ")
    )
