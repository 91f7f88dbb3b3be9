"""The file results.json: written by its schema, each message as its sentence, and read only where it agrees with it."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from assessment.results.schema import FORMAT, Results, Worded, first_error, plain
from mechanics.messages import Message, put_together, taken_apart

AGAIN = "run the project again"
# of a file: a campaign of ten thousand combinations with all its curves has a fifteenth
MOST_BYTES = 1_000_000_000


def as_bytes(results: Results) -> bytes:
    """Return results as they are written, in the order of their schema, with what their sentences are made of."""
    if table := {str(text): Worded(**taken_apart(text)) for text in _messages(results)}:
        results = results.replace(messages=table)
    return json.dumps(plain(results), ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def read_results(path: Path) -> Results:
    """Return results from their file.

    Raises ValueError naming file and key for a file that holds none, that is of another version, or damaged.
    """
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: more than {MOST_BYTES} bytes: not readable as results; {AGAIN}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = content.get("format") if "assesto" in content else None
    except (ValueError, TypeError, AttributeError, RecursionError):
        content = None
    if content is None or "assesto" not in content:
        raise ValueError(f"{path}: not readable as results; {AGAIN}")
    if found != FORMAT:
        written = "no format" if found is None else f"format {found!r}"
        raise ValueError(
            f"{path}: format: {written}, this version reads {FORMAT}: written by another version of assesto; {AGAIN}"
        )
    try:
        return Results.model_validate(with_messages(content))
    except ValidationError as error:
        wrong = first_error(error)
    except (AttributeError, KeyError, TypeError, ValueError):  # of a table of messages
        wrong = "messages: not as they are written"
    raise ValueError(f"{path}: {wrong}: damaged, or written by another version; {AGAIN}")


def with_messages(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file of results whose sentences are the messages that its table has.

    Raises KeyError, TypeError or ValueError for a table that is damaged.
    """
    table = json.loads(json.dumps(content.get("messages") or {}), object_hook=put_together)
    return {name: value if name == "messages" else _said(value, table) for name, value in content.items()}


def _said(value: Any, table: Mapping[str, Message]) -> Any:
    """Return a part of the content with its messages; lists of numbers are left out by their first item."""
    if isinstance(value, str):
        return table.get(value, value)
    if isinstance(value, dict):
        return {name: _said(inner, table) for name, inner in value.items()}
    if isinstance(value, list) and value and not isinstance(value[0], int | float):
        return [_said(inner, table) for inner in value]
    return value


def _messages(value: Any) -> Iterator[Message]:
    """Yield the messages in a part of the results; lists of numbers are left out by their first item."""
    if isinstance(value, Message):
        yield value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:  # in their order: the same bytes at every run
            yield from _messages(getattr(value, name))
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _messages(inner)
    elif isinstance(value, list) and value and not isinstance(value[0], int | float):
        for inner in value:
            yield from _messages(inner)
