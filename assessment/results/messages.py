"""The table of the sentences in results, from the messages that analyses left in them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from assessment.results.schema import Results
from assessment.results.schema.messages import Worded
from mechanics.messages import Message


def with_messages(results: Results) -> Results:
    """Return results with the messages in them in their table, beside those that it has."""
    found = {str(text): worded(text) for text in _messages(results)}
    return results.replace(messages=(results.messages or {}) | found) if found else results


def worded(text: Message) -> Worded:
    """Return what a message is made of, with the messages within."""
    return Worded(template=text.template, fields={name: _value(value) for name, value in text.fields.items()})


def _value(value: Any) -> Any:
    if isinstance(value, Message):
        return worded(value)
    if isinstance(value, list):
        return [_value(item) for item in value]
    # JSON has no such numbers, and they have but one way to be written
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


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
