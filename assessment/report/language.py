"""The words of the report in one language: its strings, numbers, quantities, and the messages of the analyses."""

import math
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Self, TypeVar

from markupsafe import Markup, escape

from assessment.ntc.tables import ROCK
from assessment.results.schema import QUANTITIES, Quantity, Results, ratio_decimals, unit_of
from assessment.results.table import Row, reference_of
from assessment.runtime.files import template_table
from mechanics.messages import Message, english, filled

LANGUAGES = ("it", "en")
# where no line ends: at the blank before a unit, around the equals sign before a number, at the stroke of a unit
KEPT = re.compile(
    r"(?<=\d) (?=(?:mm|cm|m|kN|kNm|rad|mrad|°|%|s|g)(?!\w))|(?<=[\w>*]) = (?=[−\d])|(?<=[≤≥×]) (?=\d)"
    r"|(?<=kN)/(?=m)|(?<=\[m)/(?=s)"
)
NO_BREAK, WORD_JOINER = "\u00a0", "\u2060"
PLACE = ("state", "direction", "contacts")  # where a quantity is of
NOTHING_M = 1e-6  # m; displacements below it are rounding
Label = TypeVar("Label", str, Markup)
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


@dataclass(frozen=True)
class _Shown:
    """A value of a sentence; the format of its field is the quantity that it is: {before:a_g_g}."""

    words: "Words"
    name: str
    value: object

    def __format__(self, quantity: str) -> str:
        words = self.words
        return words.told(quantity, self.value) if quantity else words.field(self.name, self.value)


@dataclass(frozen=True)
class Words:
    """Strings of `templates/strings.toml` in a language, found by dotted keys; numbers with its decimal mark.

    `reference`: where the a_g of the checks is, on rock or at the surface.
    """

    language: str
    strings: Mapping[str, Any]
    reference: str = ROCK

    @classmethod
    def of(cls, language: str, reference: str = ROCK) -> Self:
        """Return the words of a language."""
        return cls(language, _strings(language), reference)

    def __call__(self, key: str, **values: object) -> Markup:
        """Return the string as HTML, its {fields} shown by `field`, {fields:quantity} by `told`, and escaped."""
        return Markup(self._find(key)).format(**self._shown(values))

    def plain(self, key: str, **values: object) -> str:
        """Return the string as plain text, for figures."""
        return str(self._find(key)).format(**self._shown(values))

    def field(self, name: str, value: object) -> str:
        """Write a value for a field of that name: states, directions and contacts as they are called, else `show`."""
        of_place = isinstance(value, str) and name in PLACE
        return WRITERS[name](value, self) if of_place else self.show(value)

    def at(self, *place: str | None) -> str:
        """Write a place: state, direction, contacts, as far as they are given."""
        named = zip(PLACE, place, strict=False)
        return ", ".join(self.field(name, value) for name, value in named if value)

    def _shown(self, values: Mapping[str, object]) -> dict[str, Any]:
        return {name: x if isinstance(x, Markup) else _Shown(self, name, x) for name, x in values.items()}

    def told(self, quantity: str, value: object) -> str:
        """Write a value of a quantity of the results, or of a unit, with it: no line parts them.

        A text is a number that is written already; what is less than a micrometre is rounding.
        """
        found, text = QUANTITIES.get(quantity), self.show(value)
        if found and value is None:
            return self.plain(f"value.{found.null or 'not_reached'}")
        if found and isinstance(value, int | float):
            less = found.shown == "mm" and 0.0 < abs(value) < NOTHING_M
            text = f"< {self.comma('0.001')}" if less else number(found, value, self)
        unit = self.name("unit", found.printed_unit if found else quantity)
        return f"{text}{NO_BREAK}{unit}" if unit else text

    def name(self, table: str, name: str, default: str | None = None) -> str:
        """Return what a name of the program is called in a table of the strings; where it has none, the default or it.

        Raises KeyError for a table that is not there.
        """
        return str(self.strings[table].get(name, name if default is None else default))

    def show(self, value: object) -> str:
        """Write a value of results.json: null is "not reached", floats have three significant digits."""
        if value is None:
            return self.plain("value.not_reached")
        if isinstance(value, bool):
            return self.plain("value.yes" if value else "value.no")
        if isinstance(value, float):
            return self.number(value)
        return value if isinstance(value, str) else str(value)  # Markup stays Markup

    def number(self, value: float, significant: int = 3) -> str:
        """Write a number with so many significant digits; never fewer digits than its whole part has."""
        value = float(f"{value:.12g}")  # what differs by rounding alone is written alike
        if value == 0.0 or not math.isfinite(value):
            return "0" if value == 0.0 else ("∞" if value > 0 else "−∞")
        mantissa, _, power = f"{value:.{significant - 1}e}".partition("e")
        exponent = int(power)
        if -5 < exponent < 7:
            text = f"{value:.{max(0, significant - 1 - exponent)}f}"
        else:
            text = f"{mantissa}{power_of_ten(power)}"
        return self.comma(text).replace("-", "−")

    def ratio(self, value: float) -> str:
        """Write what is compared with 1: two decimals, more where they would not tell on which side of 1 it is."""
        if abs(value) >= 10.0 or value == 0.0:
            return self.number(value)
        return self.rounded(value, ratio_decimals(value, 2 - min(0, math.floor(math.log10(abs(value))) + 1)))

    def rounded(self, value: float, decimals: int) -> str:
        """Write a number with so many decimals; what they do not tell from nothing is 0."""
        text = f"{value:.{decimals}f}"
        return self.comma(text).replace("-", "−") if float(text) else "0"

    def comma(self, text: str) -> str:
        """Put the language's decimal mark into a number written with a point."""
        return text.replace(".", self._find("value.decimal_mark"))

    def state(self, name: str) -> str:
        """Return the display name of a state; only the implicit one, "original", is translated."""
        return self.plain("value.original") if name == "original" else name

    def _find(self, key: str) -> str:
        node: Any = self.strings
        for part in key.split("."):
            node = node[part]
        return str(node)


def power_of_ten(exponent: str) -> str:
    """Return the factor behind a mantissa."""
    return f"·10{str(int(exponent.replace('−', '-'))).translate(SUPERSCRIPTS)}"


def joined(text: Label) -> Label:
    """Return a text, or HTML, in which no line ends between a number and its unit or its symbol."""
    return type(text)(KEPT.sub(lambda it: it[0].replace(" ", NO_BREAK).replace("/", f"/{WORD_JOINER}"), text))


def plain_text(html: Markup) -> str:
    """Return a sentence of the report without HTML: subscripts after an underscore, every blank a plain one."""
    return Markup(re.sub(r"<sub>(.*?)</sub>", r"_\1", str(html))).striptags()


def words_of(results: Results) -> Words:
    """Return the words of the language that the project's [report] table names. Raises ValueError for any other one."""
    language = results.echo.report.get("language")
    if language not in LANGUAGES:
        raise ValueError(f"report.language = {language!r}: must be one of {', '.join(LANGUAGES)}")
    return Words.of(language, reference_of(results))


@cache
def _strings(language: str) -> Mapping[str, Any]:
    at = LANGUAGES.index(language)
    return {
        name: {key: text if isinstance(text, str) else text[at] for key, text in own.items()}
        for name, own in template_table("strings.toml").items()
    }


def direction_name(direction: str) -> str:
    """Write a direction with a true minus sign: +x, −x."""
    return direction.replace("-", "−")


def slug(results: Results, state: str) -> str:
    """Return a file name for a state: its number among the states and its plain letters."""
    number = list(results.states).index(state)
    ascii_name = unicodedata.normalize("NFKD", state).encode("ascii", "ignore").decode().lower()
    return f"{number}_{re.sub(r'[^a-z0-9]+', '_', ascii_name).strip('_')[:40]}".rstrip("_")


COARSE = 2  # digits of numbers that follow from a few records, or are only shown to be small
WHOLE = "*"  # the macro-element of a mechanism in which every layer moves
COUNTED = re.compile(r"(\d+) \+ (\d+)")  # a mechanism by its hinges and sliding joints
GENERATED = re.compile(r"^generated (\d+)$")  # the name of a record that the program made
SAID = ("state", "record", "direction", "limit_state", "stage")  # columns that are fields of sentences too
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
    from assessment.ntc.hazard import RETURN_PERIODS, stated  # late: with it comes all that computes

    if beyond := stated(value):
        return f"{beyond} ({words.number(value, COARSE)})"
    sign = "≤ " if RETURN_PERIODS[0] >= value else "≥ " if RETURN_PERIODS[-1] <= value else ""
    return f"{sign}{words.rounded(value, 0)}"


def _mechanism(value: str, words: Words) -> str:
    if not (counted := COUNTED.fullmatch(value)):
        return value
    counts = zip(("hinge", "slide"), counted.groups(), strict=True)
    named = ((what if count == "1" else f"{what}s", count) for what, count in counts if count != "0")
    return ", ".join(words.plain(f"value.{what}", count=count) for what, count in named)


# of values that are more than a number or a user's own words
WRITERS: Mapping[str, Callable[[Any, Words], str]] = {
    "state": lambda value, words: words.state(value),
    "states": lambda value, words: "; ".join(map(words.state, value.split("; "))),
    "direction": lambda value, _: direction_name(value),
    "limit_state": check_name,
    "parameter": lambda value, words: words(f"value.parameter_{value}"),
    "governing": _governing,
    "mechanism": _mechanism,
    "record": lambda value, words: GENERATED.sub(words.plain("value.generated", number=r"\1"), value),
    "hypothesis": lambda value, words: str(translated(value, words)),
    "stage": lambda value, words: ", ".join(words.name("value", part) for part in value.split(", ")),
    "verified": lambda value, words: words.plain(f"value.{'verified' if value else 'not_verified'}"),
    "distinguishable": lambda value, words: words.plain(f"value.{'distinct' if value else 'indistinct'}"),
    "kind": lambda value, words: words.plain(f"value.{value}_spectrum"),
    "macro_element": lambda value, words: words.plain("value.whole_structure") if value == WHOLE else value,
    "return_period_years": _return_period,
    "T_SLV_years": _return_period,
    "share": lambda value, words: words.comma(f"{100.0 * value:g}"),
    **dict.fromkeys(("resurrections", "widest_gap"), lambda value, words: words.comma(value)),
    **dict.fromkeys(
        ("analysis", "contacts", "property", "rule", "measured_kind", "intervention"),
        lambda value, words: words.name("value", value),
    ),
    **dict.fromkeys(("use_category", "integrator"), lambda value, words: words.name("setting", value)),
}


def indexed(label: str) -> Markup:
    """Return a label as HTML: what stands behind an underscore is an index."""
    return Markup(INDEX.sub(r"<sub>\1</sub>", str(Markup.escape(label))))


def label(name: str, words: Words) -> str:
    """Return what a quantity is called, with its unit; of an acceleration what it refers to."""
    found = QUANTITIES[name]
    text = found.label[words.language]
    if found.ground:
        text += " " + words.plain(f"value.on_{words.reference if found.ground == ROCK else found.ground}")
    return f"{text} [{words.name('unit', found.printed_unit)}]" if found.printed_unit else text


def key_name(key: str, words: Words, name: Markup | str = "") -> Markup:
    """Return what a key, or a table, of the project file is called, with its unit; the key where it has no name."""
    if not name:
        name = words(f"input.{key}") if key in words.strings["input"] else direction_name(key)
    name = Markup.escape(name)
    return name + (f" [{words.name('unit', unit)}]" if (unit := unit_of(key)) else "")


def scale(name: str) -> float:
    """Return the factor from a quantity in results.json to the unit that its `label` tells, for figures."""
    return QUANTITIES[name].factor


def heading(name: str, words: Words) -> Markup:
    """Return the heading of a column: see `label`."""
    return indexed(label(name, words))


def cell(name: str, row: Row, words: Words, significant: int = 3) -> Markup:
    """Write the value of a column in a row: a dash where it was not requested."""
    return written(name, row[name], words, significant) if name in row else words("value.none")


def written(name: str, value: Any, words: Words, significant: int = 3) -> Markup:
    """Write a value of a quantity in the unit of its heading: what null means for null, HTML as it is."""
    if isinstance(value, Markup):
        return value
    found = QUANTITIES[name]
    if value is None:
        null = found.null or ("none" if found.words else "not_reached")
        return words("value.open" if null == "not_determined" and not found.words else f"value.{null}")
    if name in WRITERS:
        return Markup.escape(WRITERS[name](value, words))
    if value == "inf" and not found.words:  # an input: results have no infinity
        return Markup("∞")
    if isinstance(value, float):
        return Markup.escape(number(found, value, words, significant))
    return Markup.escape(words.show(value))


def number(found: Quantity, value: float, words: Words, significant: int = 3) -> str:
    """Write a number of a quantity in the unit of reports, without it."""
    if found.ratio:
        return words.ratio(value)
    if found.change:  # two digits, and one decimal at most
        share = found.factor * value
        return words.number(share, 2) if abs(share) >= 0.995 else words.rounded(share, 1)
    if found.decimals is not None:
        return words.rounded(found.factor * value, found.decimals)
    if found.shown == "mm" and abs(value) < NOTHING_M:
        return "0"
    return words.number(found.factor * value, min(significant, found.digits or significant))


_POWER = re.compile(r"(?<=\d)e([+−-]?\d+)\b")
_SYMBOL = re.compile(r"(?<![\w.])(?:(?=α0\b)|(?=\w_))([αdTaS])_?(0|[uyge]|De|SL[A-Z])(?!\w)")
_PERCENT = re.compile(r"(?<=\d)%")
_WORD = re.compile(r"[a-zà-ù]{2}(?!\S*\.\w)")  # no name of a file


def translated(text: str, words: Words) -> str:
    """Return a sentence of the results in the report's language, its numbers with that language's decimal mark."""
    if not isinstance(text, Message):
        return text
    template = templates(words.language).get(text.template, text.template)
    return filled(template, text.fields, lambda name, item, form: _item(name, item, form, words))


def sentence(text: str, words: Words) -> Markup:
    """Return a sentence of the results as one of the report, HTML: its powers and symbols set as such."""
    text = _PERCENT.sub(" %", _POWER.sub(lambda it: power_of_ten(it[1]), translated(text, words)))
    start = text[0].upper() if _WORD.match(text) else text[0]
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(f"{start}{text[1:].rstrip('.')}."))))


def _item(name: str, item: Any, form: str, words: Words) -> str:
    if isinstance(item, Message):
        return translated(item, words)
    if not isinstance(item, str):
        return words.comma(english(item, form)).replace("-", "−")
    if name == "contacts" and words.language != "en":
        return words.plain(f"value.{item}")
    named = {"check": "limit_state", "study": "stage"}.get(name, name)
    return WRITERS[named](item, words) if named in SAID else item


@cache
def templates(language: str) -> Mapping[str, str]:
    """Return the wording of each template in a language other than English."""
    return {} if language == "en" else template_table(f"messages_{language}.toml")
