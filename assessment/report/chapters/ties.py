"""Sentences on ties and on what strengthens a state: how they are modelled, and what is not verified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.results.schema import Results


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


def yielding_sentence(results: Results, words: Words) -> Iterator[Markup]:
    """Yield which ties yield on the way to the activation of a mechanism, or at it."""
    found = [
        (each.tie, name, direction, contacts)
        for name, state in results.states.items()
        for direction, pushed in state.pushover.items()
        for contacts, push in pushed.by_contacts.items()
        for each in push.ties or ()
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
