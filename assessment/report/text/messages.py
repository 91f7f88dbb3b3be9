"""The messages of the analyses, which are English, in the language of the report.

The results have a table of what their sentences are made of (assessment/results/messages.py), and
`templates/messages_LANGUAGE.toml` the wording of each template. A sentence that neither knows stays as it is: nothing
is ever left out.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

from markupsafe import Markup, escape

from assessment.report.text.language import SUPERSCRIPTS, Words, direction_name
from assessment.results.schema.messages import Worded
from mechanics.messages import english, filled

HEADED = "{title}: {text}"
OF_THE_REPORT = {  # messages that name keys and what to write there, and what the report says instead
    "{factor:g} is below {least:g}, which Circolare 7/2019, C8.7.1.2, asks for where compressive strength is "
    "left out, as here; write {meant}": "text.low_confidence_factor",
}
_POWER = re.compile(r"(?<=\d)e([+−-]?\d+)\b")
_SYMBOL = re.compile(r"(?<![\w.])(?:(?=α0\b)|(?=\w_))([αdTaS])_?(0|[uyge]|De|SL[A-Z])(?!\w)")
_PERCENT = re.compile(r"(?<=\d)%")
_WORD = re.compile(r"[a-zà-ù]{2}(?!\S*\.\w)")  # no name of a file


def translated(text: str, words: Words) -> str:
    """Return a sentence of the results in the report's language, its numbers with that language's decimal mark."""
    return text if words.language == "en" else _worded(text, words)


def sentence(text: str, words: Words) -> Markup:
    """Return a sentence of the results as one of the report, HTML: its powers and symbols set as such."""
    said = _of_the_report(text, words) or _worded(text, words)
    text = _PERCENT.sub(" %", _POWER.sub(_power, said))
    start = text[0].upper() if _WORD.match(text) else text[0]
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(f"{start}{text[1:].rstrip('.')}."))))


def _power(found: re.Match[str]) -> str:
    exponent = int(found[1].replace("−", "-"))
    return f"·10{str(exponent).translate(SUPERSCRIPTS)}"


def _worded(text: str, words: Words) -> str:
    made = words.messages.get(text)
    return text if made is None else _filled(made, words)


def _of_the_report(text: str, words: Words) -> str | None:
    """Return what the report says in place of a message to who writes the project file; None: the message."""
    made = words.messages.get(text)
    while made is not None and made.template == HEADED:
        inner = made.fields["text"]
        made = inner if isinstance(inner, Worded) else None
    key = OF_THE_REPORT.get(made.template) if made is not None else None
    return None if made is None or key is None else words.plain(key, **made.fields)


def _filled(made: Worded, words: Words) -> str:
    """Return the wording of a template in the report's language, filled; in English where it has none."""
    template = templates(words.language).get(made.template)
    if template is None:
        return _english(made)
    return filled(template, made.fields, lambda name, item, form: _item(name, item, form, words))


def _item(name: str, item: str | float | Worded, form: str, words: Words) -> str:
    if isinstance(item, Worded):
        return _filled(item, words)
    if not isinstance(item, str):
        return words.comma(english(item, form)).replace("-", "−")
    if name == "state":
        return words.state(item)
    if name == "contacts":
        return words.plain(f"value.{item}")
    return direction_name(item) if name == "direction" else item


def _english(made: Worded) -> str:
    return filled(
        made.template,
        made.fields,
        _item_in_english,
    )


def _item_in_english(name: str, item: str | float | Worded, form: str) -> str:
    """Return an item of a template that no language words: as it is, its minus signs those of a report."""
    if isinstance(item, Worded):
        return _english(item)
    minus = name == "direction" or not isinstance(item, str)
    return english(item, form).replace("-", "−") if minus else str(item)


@cache
def templates(language: str) -> Mapping[str, str]:
    """Return the wording of each template in a language."""
    text = (files("templates") / f"messages_{language}.toml").read_text(encoding="utf-8")
    return dict(tomllib.loads(text))
