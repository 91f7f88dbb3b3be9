"""The one place that words the messages of the analyses: `templates/messages_it.toml` has the Italian of each template.

A message is its English sentence; what has no wording stays as it is: nothing is ever left out.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from markupsafe import Markup, escape

from assessment.report.text.language import SUPERSCRIPTS, Words, direction_name
from mechanics.messages import Message, english, filled

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
    text = _PERCENT.sub(" %", _POWER.sub(_power, translated(text, words)))
    start = text[0].upper() if _WORD.match(text) else text[0]
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(f"{start}{text[1:].rstrip('.')}."))))


def merged(texts: Iterable[str]) -> list[str]:
    """Return sentences, of those that differ in numbers alone one with their ranges, in the order of the first."""
    alike: dict[Any, list[str]] = {}
    for text in texts:
        alike.setdefault(_without_numbers(text), []).append(text)
    return [_ranged(own) for own in alike.values()]


@dataclass(frozen=True)
class Span:
    """Least and largest of a number in several messages, written as one."""

    low: float
    high: float

    def __format__(self, form: str) -> str:
        """Return both ends in a format, once where they look alike."""
        low, high = format(self.low, form), format(self.high, form)
        return low if low == high else f"{low}–{high}"


def _without_numbers(value: Any) -> Any:
    """Return what messages that differ in numbers alone have in common."""
    if isinstance(value, Message):
        return value.template, tuple((name, _without_numbers(each)) for name, each in value.fields.items())
    if isinstance(value, list):
        return tuple(map(_without_numbers, value))
    return None if isinstance(value, int | float) and not isinstance(value, bool) else value


def _ranged(alike: list[Any]) -> Any:
    """Return one value for those of several messages that are alike."""
    first = alike[0]
    if isinstance(first, Message):
        return Message(
            first.template, {name: _ranged([each.fields[name] for each in alike]) for name in first.fields}
        )
    if isinstance(first, list):
        return [_ranged(list(items)) for items in zip(*alike, strict=True)]
    return first if isinstance(first, str) or min(alike) == max(alike) else Span(min(alike), max(alike))


def _power(found: re.Match[str]) -> str:
    exponent = int(found[1].replace("−", "-"))
    return f"·10{str(exponent).translate(SUPERSCRIPTS)}"


def _item(name: str, item: Any, form: str, words: Words) -> str:
    if isinstance(item, Message):
        return translated(item, words)
    if not isinstance(item, str):
        return words.comma(english(item, form)).replace("-", "−")
    if name == "state":
        return words.state(item)
    if name == "contacts" and words.language != "en":
        return words.plain(f"value.{item}")
    return direction_name(item) if name == "direction" else item


@cache
def templates(language: str) -> Mapping[str, str]:
    """Return the wording of each template in a language other than English."""
    if language == "en":
        return {}
    text = (files("templates") / f"messages_{language}.toml").read_text(encoding="utf-8")
    return dict(tomllib.loads(text))
