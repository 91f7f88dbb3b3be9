"""Sentences about a calculation that a report words in its own language: a template with what it is about.

A message is its English sentence, and goes wherever a string does. Its template names it: a report finds its own
wording by it, and puts the same fields in.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from math import isfinite
from string import Formatter
from typing import Any

Item = str | float
"""A text (which may be a Message itself) or a number."""
Field = Item | Sequence[Item]
"""What stands in a field; the items of a list are parted by commas."""


class Message(str):
    """The English sentence of a `template` whose named `fields` are filled in."""

    __slots__ = ("fields", "template")
    template: str
    fields: Mapping[str, Field]

    def __new__(cls, template: str, fields: Mapping[str, Field]) -> Message:
        """Return the sentence. Raises KeyError for a field that is missing."""
        fields = {name: _plain(value) for name, value in fields.items()}
        self = super().__new__(cls, filled(template, fields, lambda _, item, form: english(item, form)))
        self.template, self.fields = template, fields
        return self

    def __getnewargs__(self) -> tuple[str, Mapping[str, Field]]:  # type: ignore[override]
        """Return what the message is made of, for copies and other processes."""
        return self.template, self.fields


class SaidError(Exception):
    """An error that a report may tell, by its `message`."""

    def __init__(self, message: Message) -> None:
        super().__init__(message)
        self.message = message


def message(template: str, /, **fields: Field) -> Message:
    """Return the message of a template, whose fields are named, in the format of Python: "{size:.3g} m"."""
    return Message(template, fields)


def headed(title: str, text: str) -> Message:
    """Return a message with what it is about before it."""
    return message("{title}: {text}", title=title, text=text)


def linked(parts: Sequence[Message]) -> Message:
    """Return messages, one or more, as one, parted by semicolons."""
    return reduce(lambda first, second: message("{first}; {second}", first=first, second=second), parts)


def filled(template: str, fields: Mapping[str, Any], written: Callable[[str, Any, str], str]) -> str:
    """Return a template with its fields, each item as `written(name, item, form)`, `form` the format of the field."""
    text = ""
    for literal, name, form, _ in Formatter().parse(template):
        text += literal
        if name is not None:
            value = fields[name]
            items = value if isinstance(value, list) else [value]
            text += ", ".join(written(name, item, form or "") for item in items)
    return text


def english(item: Item, form: str) -> str:
    """Return a text as it is, and a number in its format."""
    return str(item) if isinstance(item, str) else format(item, form)


def taken_apart(value: Any) -> Any:
    """Return a value whose messages are tables, template and fields; a list that begins with a number has none."""
    if isinstance(value, Message):
        return {"template": value.template, "fields": taken_apart(value.fields)}
    if isinstance(value, Mapping):
        return {name: taken_apart(item) for name, item in value.items()}
    if isinstance(value, list | tuple) and value and not isinstance(value[0], int | float):
        return [taken_apart(item) for item in value]
    return value


def put_together(table: Mapping[str, Any]) -> Any:
    """Return the message that was taken apart into a table; any other table as it is."""
    return Message(**table) if table.keys() == {"template", "fields"} else table


def visible(text: str) -> str:
    """Return a text of unknown origin with what is not seen, such as control characters, as escapes.

    A terminal or a page shows such a text and does nothing else with it.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def layer_key(name: str) -> str:
    """Return what is the same of the name of a layer in any case of letters, accents composed or not."""
    return unicodedata.normalize("NFC", name).lower()


def _plain(value: Any) -> Any:
    """Return a value of NumPy, or a sequence, in types of JSON, which has no numbers but finite ones: texts."""
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence):
        return [_plain(item) for item in value]
    number = value.item() if hasattr(value, "item") else value
    return str(number) if isinstance(number, float) and not isfinite(number) else number
