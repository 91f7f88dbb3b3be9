"""Messages in results and in their file: there each is its English sentence, and a table tells what that is made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

from pydantic import BaseModel

from assessment.results.schema.messages import Worded
from mechanics.messages import Message


def table_of(results: BaseModel) -> dict[str, Worded]:
    """Return what each message in results is made of, by its sentence."""
    return {str(text): worded(text) for text in _messages(results)}


def worded(text: Message) -> Worded:
    """Return what a message is made of, with the messages within."""
    return Worded(template=text.template, fields={name: _value(value) for name, value in text.fields.items()})


def with_messages(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file of results whose sentences are the messages that its table has.

    Raises KeyError, TypeError or ValueError for a table that is damaged.
    """
    table = {text: _message(made) for text, made in (content.get("messages") or {}).items()}
    return {name: value if name == "messages" else _said(value, table) for name, value in content.items()}


def _message(made: Mapping[str, Any]) -> Message:
    fields = {
        name: [_item(each) for each in value] if isinstance(value, list) else _item(value)
        for name, value in made["fields"].items()
    }
    return Message(made["template"], fields)


def _item(value: Any) -> Any:
    return _message(value) if isinstance(value, Mapping) else value


def _said(value: Any, table: Mapping[str, Message]) -> Any:
    """Return a part of the content with its messages; lists of numbers are left out by their first item."""
    if isinstance(value, str):
        return table.get(value, value)
    if isinstance(value, dict):
        return {name: _said(inner, table) for name, inner in value.items()}
    if isinstance(value, list) and value and not isinstance(value[0], int | float):
        return [_said(inner, table) for inner in value]
    return value


def _value(value: Any) -> Any:
    if isinstance(value, Message):
        return worded(value)
    if isinstance(value, list):
        return [_value(item) for item in value]
    # JSON has no such numbers, and they have but one way to be written
    return str(value) if isinstance(value, float) and not isfinite(value) else value


def _messages(value: Any) -> Iterator[Message]:
    """Yield the messages in a part of the results; lists of numbers are left out by their first item."""
    if isinstance(value, Message):
        yield value
    elif isinstance(value, BaseModel):
        for name in value.model_fields_set:
            yield from _messages(getattr(value, name))
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _messages(inner)
    elif isinstance(value, list) and value and not isinstance(value[0], int | float):
        for inner in value:
            yield from _messages(inner)
