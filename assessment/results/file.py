"""The file results.json: written as its schema says, and read only where it is so."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from assessment.results.schema import FORMAT, Results
from assessment.results.schema.part import UndocumentedError, said

AGAIN = "run the project again"


def typed(content: Mapping[str, Any]) -> Results:
    """Return plain results by type. Raises UndocumentedError where a key is missing or not described."""
    try:
        return Results.model_validate(content)
    except ValidationError as error:
        raise UndocumentedError(f"results.json: {said(error)}") from None


def as_bytes(content: Mapping[str, Any]) -> bytes:
    """Return plain results as they are written, in their own order."""
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def read_content(path: Path) -> dict[str, Any]:
    """Return plain results from their file, in the order in which they were written.

    Raises ValueError naming file and key for a file that holds none, that is of another version, or damaged.
    """
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
        Results.model_validate(content)
    except ValidationError as error:
        raise ValueError(f"{path}: {said(error)}: damaged, or written by another version; {AGAIN}") from None
    plain: dict[str, Any] = content
    return plain
