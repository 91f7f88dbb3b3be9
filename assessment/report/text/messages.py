"""The messages of the analyses, which are English, in the language of the report.

`templates/messages_LANGUAGE.toml` has each message with fields in the place of what it is about. A message that it does
not know stays as it is: nothing is ever left out.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

from markupsafe import Markup, escape

from assessment.report.text.language import SUPERSCRIPTS, Words, direction_name

NESTED = ("text", "reason", "block")  # fields that are messages themselves, or made of them
KINDS = {"contacts": "rigid|elastic", "limit": "SL[A-Z]", "direction": "[+-]x", "a": r"\d+", "b": r"\d+"}
_FIELD = re.compile(r"\{(\w+)\}")
_POINT = re.compile(r"(?<=\d)\.(?=\d)")
_POWER = re.compile(r"(?<=\d)e([+−-]?\d+)\b")
_SYMBOL = re.compile(r"(?<![\w.])(?:(?=α0\b)|(?=\w_))([αdTaS])_?(0|[uyge]|De|SL[A-Z])(?!\w)")
_WORD = re.compile(r"[a-zà-ù]{2}(?!\S*\.\w)")  # no name of a file

Entry = tuple[re.Pattern[str], str]


def translated(message: str, words: Words) -> str:
    """Return a message in the report's language, its numbers with that language's decimal mark."""
    return (
        message
        if words.language == "en"
        else _translated(message, words, _entries(words.language)) or message
    )


def sentence(message: str, words: Words) -> Markup:
    """Return a message as a sentence of the report, HTML: in its language, its powers and symbols set as such."""
    text = translated(message, words) if words.language != "en" else _dressed(message)
    text = _POWER.sub(_power, text)
    start = text[0].upper() if _WORD.match(text) else text[0]
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(f"{start}{text[1:].rstrip('.')}."))))


def _power(found: re.Match[str]) -> str:
    exponent = int(found[1].replace("−", "-"))
    return f"·10{str(exponent).translate(SUPERSCRIPTS)}"


def _dressed(message: str) -> str:
    """Name the state of an English message as one: "State “moved”, pushover towards +x, …"."""
    for pattern, text in _entries("en"):
        if found := pattern.fullmatch(message):
            return text.format(**{name: direction_name(part) if name == "direction" else part
                                  for name, part in found.groupdict().items()})  # fmt: skip
    return message


def _translated(
    message: str, words: Words, entries: Sequence[Entry], known: dict[str, str | None] | None = None
) -> str | None:
    """Return the message by the first entry that fits it with all the messages inside; None where there is none.

    `known`: parts met before, since a name full of colons can be cut in many ways.
    """
    known = {} if known is None else known
    if message in known:
        return known[message]
    answer = None
    for pattern, text in entries:
        if (found := pattern.fullmatch(message)) is None:
            continue
        fields = {name: _field(name, part, words, entries, known) for name, part in found.groupdict().items()}
        if None not in fields.values():
            answer = text.format(**fields)
            break
    known[message] = answer
    return answer


def _field(
    name: str, value: str, words: Words, entries: Sequence[Entry], known: dict[str, str | None]
) -> str | None:
    kind = name.partition("_")[0]
    if name in NESTED or re.fullmatch(rf"({'|'.join(NESTED)})_\d", name):
        return _translated(value, words, entries, known)
    if kind == "state":
        return direction_name(value) if value in {"+x", "-x"} else words.state(value)
    if kind == "contacts":
        return words.plain(f"value.{value}")
    if kind in {"name", "record", "layer", "layers", "where", "found", "own", "unit"}:
        return value  # names and places as they were given
    return _POINT.sub(words.plain("value.decimal_mark"), value).replace("-", "−")


@cache
def _entries(language: str) -> Sequence[Entry]:
    text = (files("templates") / f"messages_{language}.toml").read_text(encoding="utf-8")
    return [(_pattern(english), other) for english, other in tomllib.loads(text).items()]


def _pattern(english: str) -> re.Pattern[str]:
    """Return the pattern of a message: a field matches as little as it can, of its kind."""
    parts = _FIELD.split(english)
    text = "".join(
        re.escape(part) if number % 2 == 0 else f"(?P<{part}>{KINDS.get(part, '.+?')})"
        for number, part in enumerate(parts)
    )
    return re.compile(text, re.DOTALL)
