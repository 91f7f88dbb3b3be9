"""Messages in the words of a report, without results around them."""

from __future__ import annotations

from dataclasses import replace

from assessment.report.text.language import Words
from assessment.report.text.messages import sentence, translated
from assessment.results.messages import worded
from mechanics.messages import Message


def in_italian(text: Message) -> str:
    """Return a message in Italian. Raises AttributeError for a plain string."""
    return translated(text, knowing(text, "it"))


def as_sentence(text: Message, language: str) -> str:
    """Return a message as a sentence of the report in a language."""
    return str(sentence(text, knowing(text, language)))


def knowing(text: Message, language: str) -> Words:
    """Return the words of a language for results that have the message."""
    return replace(Words.of(language), messages={str(text): worded(text)})
