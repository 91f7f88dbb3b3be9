"""Messages in the words of a report, without results around them."""

from __future__ import annotations

from assessment.report.text.language import Words, sentence, translated


def in_italian(text: str) -> str:
    """Return a message in Italian."""
    return translated(text, Words.of("it"))


def as_sentence(text: str, language: str) -> str:
    """Return a message as a sentence of the report in a language."""
    return str(sentence(text, Words.of(language)))
