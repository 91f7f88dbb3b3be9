"""Sentences on ties and on what strengthens a state: how they are modelled, and what is not verified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.static import TieTension

LEFT = 0.5  # of a pretension: a tie at rest with less tension is reported
NEARLY = 0.99  # of the yield force: a tie above it that does not yield is reported


def tie_assumptions(results: Results, words: Words, contacts: Sequence[str]) -> Iterator[Markup]:
    """Yield how ties are modelled under the contacts that are analysed, and what is left to the engineer."""
    ties = results.model.ties
    if not ties:
        return
    yield words("text.ties")
    if "rigid" in contacts:
        yield words("text.ties_rigid")
    if "elastic" in contacts:
        yield words("text.ties_elastic")
    unlimited = [tie.name for tie in ties if tie.yield_force_kN is None]
    if unlimited:
        yield words("text.ties_unlimited", ties=", ".join(unlimited))
    yield words("text.ties_unverified")


def strengthening_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was done to each state that is strengthened, and when."""
    for name, state in results.states.items():
        if (made := state.strengthening) is None:
            continue
        before = results.states.get(made.of)
        done = [
            words(f"text.strengthened_{what}", names=", ".join(names))
            for what, names in (("ties", made.ties), ("layers", made.layers))
            if names
        ]
        yield words(
            "text.strengthened_after" if before and before.settlement else "text.strengthened_as_drawn",
            state=name,
            of=words.state(made.of),
            done=Markup("; ").join(done),
        )


def pretension_sentence(results: Results, words: Words) -> Iterator[Markup]:
    """Yield how much of its pretension is left to each tie that has lost most of it before the push."""
    given = {tie.name: tie.pretension_kN for tie in results.model.ties or ()}
    left: dict[tuple[str, str], float] = {}
    for name, _, contacts, each in _along_pushes(results):
        if contacts == "elastic" and each.rest_kN is not None and each.rest_kN < LEFT * given[each.tie]:
            left[each.tie, name] = each.rest_kN
    for (tie, state), rest in left.items():
        yield words(
            "text.tie_slackened",
            tie=tie,
            state=words.state(state),
            pretension=words.number(given[tie]),
            rest=words.rounded(rest, 2),
        )


def _along_pushes(results: Results) -> Iterator[tuple[str, str, str, TieTension]]:
    """Yield state, direction and contacts of each tension along a pushover."""
    for name, state in results.states.items():
        for direction, pushed in state.pushover.items():
            for contacts, push in pushed.by_contacts.items():
                for each in push.ties or ():
                    yield name, direction, contacts, each


def nearly_yielding(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the ties that come within a hundredth of their yield force without being found to yield."""
    strength = {tie.name: tie.yield_force_kN for tie in results.model.ties or ()}
    paths = [(name, direction, contacts, each) for name, direction, contacts, each in _along_pushes(results)]
    paths += [
        (name, "", contacts, each)
        for name, state in results.states.items()
        for contacts, moved in state.pushdown.items()
        for each in moved.ties or ()
    ]
    for name, direction, contacts, each in paths:
        limit = strength[each.tie]
        if limit is None or each.greatest_kN is None or each.yields or each.greatest_kN < NEARLY * limit:
            continue
        where = [words.state(name), direction.replace("-", "−"), words.plain(f"value.{contacts}")]
        yield words(
            "text.tie_nearly",
            tie=each.tie,
            where=", ".join(part for part in where if part),
            greatest=words.number(each.greatest_kN, 6),
            share=words.number(100.0 * each.greatest_kN / limit, 4),
        )


def yielding_sentence(results: Results, words: Words) -> Iterator[Markup]:
    """Yield which ties yield on the way to the activation of a mechanism, or at it."""
    found = [
        (each.tie, name, direction, contacts)
        for name, direction, contacts, each in _along_pushes(results)
        if each.yields
    ]
    for tie in dict.fromkeys(tie for tie, *_ in found):
        where = "; ".join(
            dict.fromkeys(
                f"{words.state(state)}, {direction.replace('-', '−')}, {words.plain(f'value.{contacts}')}"
                for each, state, direction, contacts in found
                if each == tie
            )
        )
        yield words("text.tie_yields", tie=tie, where=where)
