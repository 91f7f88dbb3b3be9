"""Sentences on an identification: the best movement, what it leaves open, and its lines for the project file."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.report.text.messages import translated
from assessment.results.identified import UNLIKELY, best_of, fits, settlement_lines, told_of
from assessment.results.schema import Results


def identification_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was found, as sentences; nothing without an identification."""
    found = results.identification
    if found is None:
        return
    best = best_of(found)
    if best is None:
        yield words("text.identification_none")
        return
    told = told_of(found)
    yield words("text.identification_best", hypothesis=translated(best.hypothesis, words), aic=best.aic)
    if best.probability is not None and best.probability < UNLIKELY:
        yield words("text.identification_poor", probability=best.probability)
    for other in told[1:]:
        yield words("text.identification_alike", hypothesis=translated(other.hypothesis, words))
    for each in told:
        name = translated(each.hypothesis, words)
        for text in each.undetermined:
            yield words("text.identification_open", hypothesis=name, movement=translated(text, words))
        if each.contradicting:
            yield words(
                "text.identification_contradicting", hypothesis=name, names="; ".join(each.contradicting)
            )
        if each.at_collapse:
            yield words("text.identification_collapse", hypothesis=name)
    if not found.settlements:
        yield words("text.identification_several")


def ready_lines(results: Results, words: Words) -> str:
    """Return the lines of the best movement for the project file, none where there are none.

    A comment heads those of a movement that does not explain the measurements.
    """
    found = results.identification
    best = best_of(found) if found else None
    if found is None or best is None or not found.settlements:
        return ""
    lines = ["\n".join(settlement_lines(each)) for each in found.settlements]
    heading = [] if fits(best) else [f"# {words.plain('text.identification_unfit')}"]
    return "\n".join([*heading, "\n\n".join(lines)])
