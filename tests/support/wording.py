"""Messages in the words of a report, without results around them."""

import re

from assessment.report.language import Words, translated


def in_italian(text: str) -> str:
    """Return a message in Italian."""
    return translated(text, Words.of("it"))


def squeezed(text: str) -> str:
    """Return a text without its blanks."""
    return re.sub(r"\s+", "", text)
