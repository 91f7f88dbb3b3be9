"""The file results.json: written by its schema, and read only where it agrees with it."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ValidationError

from assessment.results.messages import table_of, with_messages
from assessment.results.plain import plain
from assessment.results.schema import FORMAT, Results
from assessment.results.schema.part import first_error

AGAIN = "run the project again"
MOST_BYTES = (
    1_000_000_000  # of a file: a campaign of ten thousand combinations with all its curves has a fifteenth
)


def as_bytes(results: Results) -> bytes:
    """Return results as they are written, in the order of their schema."""
    if table := table_of(results):
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
