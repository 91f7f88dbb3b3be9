"""The words of the report in one language, and how its numbers are written."""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, TypeVar

from markupsafe import Markup

from assessment.results.plain import ratio_decimals
from assessment.results.schema import Results

LANGUAGES = ("it", "en")
# blanks at which no line ends: before a unit that stands in the text, around the equals sign before a number
KEPT = re.compile(
    r"(?<=\d) (?=(?:mm|cm|m|kN|kNm|rad|mrad|°|%|s|g)(?!\w))|(?<=[\w>*]) = (?=[−\d])|(?<=[≤≥×]) (?=\d)"
)
NO_BREAK = "\u00a0"
NOTHING_M = 1e-6  # m; displacements below it are rounding
Label = TypeVar("Label", str, Markup)
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


class _Shown(str):
    """A value as it is written; the format of its field is its unit, which no line parts from it."""

    def __format__(self, unit: str) -> str:
        return f"{self}{NO_BREAK}{unit}" if unit else str(self)


@dataclass(frozen=True)
class Words:
    """Strings of `templates/strings_<language>.toml`, found by dotted keys; numbers with its decimal mark."""

    language: str
    strings: Mapping[str, Any]

    @classmethod
    def of(cls, language: str) -> Words:
        """Return the words of a language."""
        return cls(language, _strings(language))

    def __call__(self, key: str, **values: object) -> Markup:
        """Return the string as HTML, its {fields}, or {fields:unit}, shown by `field` and escaped."""
        return Markup(self._find(key)).format(**self._shown(values))

    def plain(self, key: str, **values: object) -> str:
        """Return the string as plain text, for figures."""
        return str(self._find(key)).format(**self._shown(values))

    def field(self, name: str, value: object) -> str:
        """Write a value for a field of that name: states, directions and contacts as they are called, else `show`."""
        if isinstance(value, str) and name == "state":
            return self.state(value)
        if isinstance(value, str) and name == "direction":
            return direction_name(value)
        if isinstance(value, str) and name == "contacts":
            return self.name("value", value)
        return self.show(value)

    def at(self, *place: str | None) -> str:
        """Write a place: state, direction, contacts, as far as they are given."""
        named = zip(("state", "direction", "contacts"), place, strict=False)
        return ", ".join(self.field(name, value) for name, value in named if value)

    def _shown(self, values: Mapping[str, object]) -> dict[str, Any]:
        shown = {name: self.field(name, value) for name, value in values.items()}
        return {name: text if isinstance(text, Markup) else _Shown(text) for name, text in shown.items()}

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
        if value == 0.0 or not math.isfinite(value):
            return "0" if value == 0.0 else ("∞" if value > 0 else "−∞")
        mantissa, _, power = f"{value:.{significant - 1}e}".partition("e")
        exponent = int(power)
        if -5 < exponent < 7:
            text = f"{value:.{max(0, significant - 1 - exponent)}f}"
        else:
            text = f"{mantissa}·10{str(exponent).translate(SUPERSCRIPTS)}"
        return self.comma(text).replace("-", "−")

    def ratio(self, value: float) -> str:
        """Write what is compared with 1: two decimals, more where they would not tell on which side of 1 it is."""
        if abs(value) >= 10.0 or value == 0.0:
            return self.number(value)
        return self.rounded(value, ratio_decimals(value, 2 - min(0, math.floor(math.log10(abs(value))) + 1)))

    def per_cent(self, share: float) -> str:
        """Write a share in per cent, without the sign: two digits, and one decimal at most."""
        value = 100.0 * share
        return self.number(value, 2) if abs(value) >= 0.995 else self.rounded(value, 1)

    def rounded(self, value: float, decimals: int) -> str:
        """Write a number with so many decimals; what they do not tell from nothing is 0."""
        text = f"{value:.{decimals}f}"
        return self.comma(text).replace("-", "−") if float(text) else "0"

    def millimetres(self, value: float | None) -> str:
        """Write a length given in metres as millimetres, with the unit; one below a micrometre is rounding."""
        if value is None:
            return self.show(None)
        less = 0.0 < abs(value) < NOTHING_M
        return f"< {self.comma('0.001')} mm" if less else f"{self.number(1000.0 * value)} mm"

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


def joined(text: Label) -> Label:
    """Return a text, or HTML, in which no line ends between a number and its unit or its symbol."""
    return type(text)(KEPT.sub(lambda found: found[0].replace(" ", NO_BREAK), text))


def plain_text(html: Markup) -> str:
    """Return a sentence of the report without HTML: subscripts after an underscore, every blank a plain one."""
    return Markup(re.sub(r"<sub>(.*?)</sub>", r"_\1", str(html))).striptags()


def words_of(results: Results) -> Words:
    """Return the words of the language that the project's [report] table names. Raises ValueError for any other one."""
    language = results.echo.report.language
    if language not in LANGUAGES:
        raise ValueError(f"report.language = {language!r}: must be one of {', '.join(LANGUAGES)}")
    return Words(language, _strings(language))


@cache
def _strings(language: str) -> Mapping[str, Any]:
    return tomllib.loads((files("templates") / f"strings_{language}.toml").read_text(encoding="utf-8"))


def direction_name(direction: str) -> str:
    """Write a direction with a true minus sign: +x, −x."""
    return direction.replace("-", "−")


def slug(results: Results, state: str) -> str:
    """Return a file name for a state: its number among the states and its plain letters."""
    number = list(results.states).index(state)
    ascii_name = unicodedata.normalize("NFKD", state).encode("ascii", "ignore").decode().lower()
    return f"{number}_{re.sub(r'[^a-z0-9]+', '_', ascii_name).strip('_')[:40]}".rstrip("_")
