"""How quantities are headed and written in the language of a report; what they are is told by the schema of results."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from markupsafe import Markup

from assessment.ntc.limit_states import ROCK
from assessment.report.text.language import NOTHING_M, Words, direction_name
from assessment.results.schema import derived  # noqa: F401 - its columns
from assessment.results.schema.part import QUANTITIES, Quantity
from assessment.results.table import Row

COARSE = 2  # digits of numbers that follow from a few records, or are only shown to be small
WHOLE = "*"  # the macro-element of a mechanism in which every layer moves
COUNTED = re.compile(r"(\d+) \+ (\d+)")  # a mechanism by its hinges and sliding joints
GENERATED = re.compile(r"generated (\d+)")  # the name of a record that the program made
INDEX = re.compile(r"_(\w+(?:,\w+)*)")


def check_name(check: str, words: Words) -> str:
    """Write the name of a check: its limit state, and what it is where that has several."""
    if check == "SLV linear":
        return words.plain("value.slv_linear")
    limit, _, kind = check.partition(" ")
    return words.plain("value.elastic_branch", limit=limit) if kind else check


def _governing(value: str, words: Words) -> Markup:
    """Write what set a capacity: a share of d_0, a local limit, activation."""
    parts = [indexed(words.name("governing", part, words.comma(part))) for part in value.split(": ")]
    return Markup(": ").join(parts)


def _return_period(value: float, words: Words) -> str:
    """Write a return period: beyond the hazard as such with its estimate, at its bounds as there or beyond."""
    from assessment.ntc.capacity.return_period import stated  # late: with it comes all that computes
    from assessment.ntc.demand.hazard_grid import RETURN_PERIODS

    if beyond := stated(value):
        return f"{beyond} ({words.number(value, COARSE)})"
    sign = "≤ " if RETURN_PERIODS[0] >= value else "≥ " if RETURN_PERIODS[-1] <= value else ""
    return f"{sign}{words.rounded(value, 0)}"


def _hypothesis(value: str, words: Words) -> str:
    from assessment.report.text.messages import translated  # late: as above

    return translated(value, words)


def _mechanism(value: str, words: Words) -> str:
    if not (counted := COUNTED.fullmatch(value)):
        return value
    counts = zip(("hinge", "slide"), counted.groups(), strict=True)
    named = ((what if count == "1" else f"{what}s", count) for what, count in counts if count != "0")
    return ", ".join(words.plain(f"value.{what}", count=count) for what, count in named)


def _record(value: str, words: Words) -> str:
    made = GENERATED.fullmatch(value)
    return words.plain("value.generated", number=made[1]) if made else value


def _named(table: str) -> Callable[[Any, Words], str]:
    return lambda value, words: words.name(table, value)


WRITERS: Mapping[
    str, Callable[[Any, Words], str]
] = {  # of values that are more than a number or a user's own words
    "state": lambda value, words: words.state(value),
    "states": lambda value, words: "; ".join(map(words.state, value.split("; "))),
    "direction": lambda value, _: direction_name(value),
    "limit_state": check_name,
    "parameter": lambda value, words: words(f"value.parameter_{value}"),
    "governing": _governing,
    "mechanism": _mechanism,
    "record": _record,
    "hypothesis": _hypothesis,
    "stage": lambda value, words: ", ".join(words.name("value", part) for part in value.split(", ")),
    "verified": lambda value, words: words.plain(f"value.{'verified' if value else 'not_verified'}"),
    "distinguishable": lambda value, words: words.plain(f"value.{'distinct' if value else 'indistinct'}"),
    "kind": lambda value, words: words.plain(f"value.{value}_spectrum"),
    "scaling": lambda value, words: words.plain(f"value.scaling_{value.replace('-', '_')}"),
    "macro_element": lambda value, words: words.plain("value.whole_structure") if value == WHOLE else value,
    "return_period_years": _return_period,
    "T_SLV_years": _return_period,
    "share": lambda value, words: words.comma(f"{100.0 * value:g}"),
    **dict.fromkeys(("resurrections", "widest_gap"), lambda value, words: words.comma(value)),
    **dict.fromkeys(("analysis", "contacts", "property", "rule", "measured_kind"), _named("value")),
    **dict.fromkeys(("use_category", "integrator"), _named("setting")),
}


def indexed(label: str) -> Markup:
    """Return a label as HTML: what stands behind an underscore is an index."""
    return Markup(INDEX.sub(r"<sub>\1</sub>", str(Markup.escape(label))))


def quantity(name: str) -> Quantity:
    """Return what the schema of results says of a quantity. Raises KeyError for one that it does not describe."""
    return QUANTITIES[name]


def label(name: str, words: Words, reference: str = ROCK) -> str:
    """Return what a quantity is called, with its unit; of an acceleration what it refers to.

    `reference`: of the a_g of the checks, `ROCK` or `SURFACE`.
    """
    found = quantity(name)
    text = found.label[words.language]
    if found.ground:
        text += " " + words.plain(f"value.on_{reference if found.ground == ROCK else found.ground}")
    return f"{text} [{words.name('unit', found.printed_unit)}]" if found.printed_unit else text


def heading(name: str, words: Words, reference: str = ROCK) -> Markup:
    """Return the heading of a column: see `label`."""
    return indexed(label(name, words, reference))


def is_text(name: str) -> bool:
    """Return whether the values of a column are words, set to the left."""
    return quantity(name).words


def cell(name: str, row: Row, words: Words, significant: int = 3) -> Markup:
    """Write the value of a column in a row: a dash where it was not requested."""
    return written(name, row[name], words, significant) if name in row else words("value.none")


def written(name: str, value: Any, words: Words, significant: int = 3) -> Markup:
    """Write a value of a quantity in the unit of its heading: what null means for null, HTML as it is."""
    if isinstance(value, Markup):
        return value
    found = quantity(name)
    if value is None:
        return words(f"value.{found.null or ('none' if found.words else 'not_reached')}")
    if name in WRITERS:
        return Markup.escape(WRITERS[name](value, words))
    if value == "inf" and not found.words:  # an input: results have no infinity
        return Markup("∞")
    if isinstance(value, float):
        return Markup.escape(number(found, value, words, significant))
    return Markup.escape(words.show(value))


def told(name: str, value: float, words: Words) -> str:
    """Write a number of a quantity in the unit of reports, which a sentence gives to its field: `{name:unit}`."""
    return number(quantity(name), value, words)


def number(found: Quantity, value: float, words: Words, significant: int = 3) -> str:
    """Write a number of a quantity in the unit of reports, without it."""
    if found.ratio:
        return words.ratio(value)
    if found.change:
        return words.per_cent(value)
    if found.decimals is not None:
        return words.rounded(found.factor * value, found.decimals)
    if found.shown == "mm" and abs(value) < NOTHING_M:
        return "0"
    return words.number(found.factor * value, min(significant, found.digits or significant))
