"""The error that ends a command with one message, and the remedies that messages propose."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_MOST_NAMES = 12
_QUOTED = 120  # characters of a line of the user's file that a message shows


class ProjectError(ValueError):
    """The project cannot be used as it is; one line per problem, `FILE: KEY: what is wrong; what to do`."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the remedy for a name that does not exist: the nearest valid one, or what is valid."""
    by_lower = {each.lower(): each for each in valid}
    close = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.5)
    if close:
        return f'did you mean "{by_lower[close[0]]}"?'
    shown = [f'"{each}"' for each in by_lower.values()]
    return f"valid: {', '.join(shown[:_MOST_NAMES])}{', …' if len(shown) > _MOST_NAMES else ''}"


def shortened(text: str, most: int = _QUOTED) -> str:
    """Return a text of the user's in as many characters as a message shows."""
    return text if len(text) <= most else text[: most - 1] + "…"
