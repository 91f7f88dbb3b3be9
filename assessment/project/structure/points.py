"""Points of the project file that lie in blocks."""

from __future__ import annotations

from assessment.runtime.errors import ProjectError
from mechanics import ArgumentError, Assembly


def block_at(model: Assembly, key: str, point: tuple[float, float]) -> int:
    """Return the block that contains a point (m). Raises ProjectError naming its key where none does."""
    try:
        return model.block_at(point)
    except ArgumentError as error:
        reason = str(error).partition("must be ")[2]
        raise ProjectError(f"{key}: {list(point)} must be {reason}; move it there") from None
