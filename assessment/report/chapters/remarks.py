"""Sentences that a chapter has where the results call for them: what is missing, what limits, how a curve begins."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.ntc.limit_states import QUOTED
from assessment.report.chapters.curve_remarks import lost_before_zero
from assessment.report.tables.capacity import capacities, directions
from assessment.report.tables.structure.cracks import PRINTED, SEEN, cracks_of
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.hand_check import BY_HAND, figures_of, governing_mechanisms, mechanisms
from assessment.results.echo import limit_states, local_limit
from assessment.results.schema import Results
from assessment.results.schema.static import Contacts
from assessment.results.undetermined import determined_indices, undetermined

ELASTIC_END = "end of the elastic curve"  # what governs a check


def too_many(results: Results, words: Words, most: int = BY_HAND) -> Iterator[Markup]:
    """Yield a sentence for each mechanism of more macro-blocks than a hand works out, which are `most`."""
    for name, direction in governing_mechanisms(results):
        count = len(figures_of(results, name, direction))
        if count > most:
            where = {"state": words.state(name), "direction": direction_name(direction)}
            yield words("text.many_macro_blocks", count=count, **where)


def displacement_limits(results: Results, words: Words) -> Iterator[Markup]:
    """Yield where the displacement limits come from: shares of d_0, a local limit, the end of an elastic curve."""
    yield words(f"text.limits_{_circular(results)}")
    checks = {name: check for _, _, each in capacities(results) for name, check in each.checks.items()}
    if "SLV linear" in checks and "SLV" in checks:
        yield words("text.linear_beside")
    yield from lost_before_zero(results, words)
    limit, reason = local_limit(results.echo)
    if limit is None:
        yield from _losses(results, words)
    else:
        reason = reason or words.plain("value.no_reason")
        yield words("text.local_limit", limit=1000.0 * limit, reason=reason)
    every = (check for _, _, each in capacities(results) for check in each.checks.values())
    if any(ELASTIC_END in (check.governing or "") for check in every):
        yield words("text.elastic_end")


def _circular(results: Results) -> int:
    return int((results.echo.assessment or {}).get("circular", 2019))


def _losses(results: Results, words: Words) -> Iterator[Markup]:
    """Yield where a path loses a joint that bears: the local limit of its direction, where the project gives none."""
    for name, direction, rigid in mechanisms(results):
        if loss := rigid.local_loss:
            yield words(
                "text.local_loss",
                state=words.state(name),
                direction=direction_name(direction),
                first=loss.blocks[0],
                second=loss.blocks[1],
                overlap=1000.0 * loss.overlap_m,
                limit=1000.0 * loss.displacement_m,
            )


def farthest_limit_state(results: Results) -> str:
    """Return the farthest limit state asked for, that of the losses printed; empty where none was."""
    asked = limit_states(results.echo)
    return next((limit for limit in QUOTED if limit in asked), "")


def contacts_of(results: Results) -> list[Contacts]:
    """Return the kinds of contact of which there is any curve."""
    found: set[Contacts] = set()
    for state in results.states.values():
        found.update(state.pushdown, *(pushover.by_contacts for pushover in state.pushover.values()))
    kinds: tuple[Contacts, ...] = ("rigid", "elastic")
    return [contacts for contacts in kinds if contacts in found]


def crack_sentences(results: Results, words: Words, printed: int = PRINTED) -> Iterator[Markup]:
    """Yield what the table of cracks holds, what of it is not among those `printed`, or has no width."""
    yield words("text.cracks", seen=words.comma(f"{1000.0 * SEEN:g}"))
    by_state = [cracks_of(results, state) for state in results.states]
    if any(len(found) > printed for found in by_state):
        yield words("text.cracks_printed", printed=printed)
    if any(crack.opening_m is None for found in by_state for crack in found[:printed]):
        yield words("text.cracks_apart")


def damping_sentence(results: Results, words: Words) -> Markup:
    """Return the damping of the circular whose rules apply."""
    return words(f"text.damping_{_circular(results)}")


def headlines(results: Results, words: Words) -> Iterator[Markup]:
    """Yield ζ_E at SLV of each state, and that it is not determined where a direction has no capacity."""
    known, missing = determined_indices(results), undetermined(results)
    for name in results.states:
        if found := known.get(name):
            yield words(
                "text.headline",
                state=words.state(name),
                zeta=words.ratio(found.zeta_SLV),
                direction=direction_name(found.direction),
            )
        elif name in missing:
            names = ", ".join(map(direction_name, missing[name]))
            yield words("text.undetermined", state=words.state(name), directions=names)


def index_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what the indices of the tables are: those that need a return period only where one is known."""
    found = list(determined_indices(results).values())
    yield words("text.indices")
    if any(each.I_S is not None for each in found):
        yield words("text.indices_known")
    yield words("text.risk")
    if any(each.PAM is None for each in found):
        yield words("text.no_pam")


def members(results: Results) -> int:
    """Return how many motions an ensemble of the project may have: 1 where each is run once."""
    told = [entry.members or 1 for state in results.states.values() for entry in state.history]
    return max([results.echo.scatter or 1, *told])


def few_records(results: Results) -> dict[str, bool]:
    """Return where fewer records than NTC 2018, §7.3.5, asks for leave something out, by what it is left out of."""
    campaign = results.campaign
    fits = campaign.fragility if campaign else []
    searches = [
        state.incremental for state in results.states.values() if state.incremental.records is not None
    ]
    return {
        "campaign": bool(campaign and campaign.method == "incremental") and any(not fit.rule for fit in fits),
        "interval": any(fit.median_g is not None and fit.median_range is None for fit in fits),
        "incremental": any(not each.rule for each in searches),
    }


def missing_pushovers(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each state without the pushover that another state has."""
    for direction in directions(results):
        for name, state in results.states.items():
            if direction not in state.pushover:
                yield words(
                    "text.missing_pushover", state=words.state(name), direction=direction_name(direction)
                )
