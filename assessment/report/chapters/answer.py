"""The answer in sentences, with which report, page and terminal begin: from `summary` of the results alone."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.tables.synthesis import (
    ORIGINAL,
    index_limit,
    index_of,
    least_row,
    rows_of,
    settled,
    worst_settled,
)
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import COARSE, indexed, label, written
from assessment.results.schema import Results
from assessment.results.schema.summary import SummaryRow

QUALITY_ANNEX = "D"  # of the report: where warnings are listed


def lead(results: Results, words: Words) -> list[Markup]:
    """Return the answer in sentences: the index of each kind of state, its loss, and whether it is verified."""
    if not results.model.self_weight_stable:
        return [words("judgement.unstable")]
    worst = worst_settled(results)
    sentences = [_of_state(results, worst or ORIGINAL, words)]
    sentences += [
        _strengthened(results, name, words) for name, state in results.states.items() if state.strengthening
    ]
    sentences += _open(results, words)
    sentences += _dynamic(results, worst or ORIGINAL, words)
    return [each for each in sentences if each]


def _of_state(results: Results, name: str, words: Words) -> Markup:
    """Return a sentence on the original or the worst settled state: its index, and what it was before."""
    row, limit = least_row(results, name), index_limit(results)
    if any(not each.reached for each in rows_of(results, name)):
        return words("synthesis.collapses", state=words.state(name))
    if row is None:
        return Markup("") if rows_of(results, name) else words("synthesis.nothing")
    check = index_of(row, limit)
    value, loss = (check.zeta_E, check.loss) if check else (row.alpha_0, row.alpha_loss)
    elastic = not check and row.alpha_0 is None
    value, quantity = (row.alpha_u, "alpha_u") if elastic else (value, "zeta_E" if check else "alpha_0")
    place = {
        "symbol": indexed(label(quantity, words)),
        "value": written(quantity, value, words),
        "where": ", ".join([*([limit] if check and limit else []), direction_name(row.direction or "")]),
        "outcome": _outcome(results, name, words) if check else "",
    }
    if name == ORIGINAL:
        return words("synthesis.original", **place)
    key = "current" if len(settled(results)) == 1 else "worst"
    told = words(f"synthesis.{key}", state=words.state(name), count=len(settled(results)), **place)
    if loss is None or value is None or loss >= 1.0:
        return told + _ending(place["outcome"])
    before = written(quantity, value / (1.0 - loss), words)
    change = words(f"synthesis.{'loss' if loss >= 0.0 else 'gain'}", share=words.per_cent(abs(loss)))
    return told + words("synthesis.before", before=before, change=change) + _ending(place["outcome"])


def _ending(outcome: str) -> Markup:
    return Markup.escape(f". {outcome}" if outcome else ".")


def _outcome(results: Results, name: str, words: Words) -> str:
    """Return whether a state is verified in every direction, as a sentence."""
    verified = [row.verified for row in rows_of(results, name)]
    kind = "not_verified" if False in verified else "undetermined" if None in verified else "verified"
    return words.plain(f"synthesis.{kind}")


def _strengthened(results: Results, name: str, words: Words) -> Markup:
    """Return a sentence on what an intervention gives back, in the direction that is weakest after it."""
    row, limit = least_row(results, name), index_limit(results)
    check = index_of(row, limit) if row else None
    if row is None or check is None or check.zeta_E is None or check.gain is None or check.gain <= -1.0:
        return Markup("")
    return words(
        "synthesis.strengthened",
        state=words.state(name),
        before=words.ratio(check.zeta_E / (1.0 + check.gain)),
        after=words.ratio(check.zeta_E),
        gain=words.per_cent(check.gain),
        where=f"{limit}, {direction_name(row.direction or '')}",
        outcome=_outcome(results, name, words),
    )


def _is_open(results: Results, row: SummaryRow) -> bool:
    limit = index_limit(results)
    return bool(row.checks and limit and row.reached and index_of(row, limit) is None)


def _open(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the states and directions without an index, in one sentence."""
    where = [
        words(
            "synthesis.open_at", state=words.state(row.state), direction=direction_name(row.direction or "")
        )
        for row in results.summary.rows
        if _is_open(results, row)
    ]
    if where:
        yield words("synthesis.open", where=Markup("; ").join(where), annex=QUALITY_ANNEX)


def _dynamic(results: Results, name: str, words: Words) -> Iterator[Markup]:
    """Yield the dynamic capacity beside the static one on the same reference, and what the motions lose of it."""
    row = least_row(results, name) or next(iter(rows_of(results, name)), None)
    if row is not None and row.dynamic_pga_g is not None:
        dynamic = words.number(row.dynamic_pga_g)
        if row.static_nominal_pga_g is None:
            yield words("synthesis.dynamic", dynamic=dynamic)
        else:
            static = words.number(row.static_nominal_pga_g)
            yield words("synthesis.dynamic_static", dynamic=dynamic, static=static)
    whole = [each for each in (results.campaign.loss if results.campaign else []) if each.share == 1.0]
    loss = results.states[name].incremental.loss or next((e for e in whole if e.settlement == name), None)
    if loss is not None and loss.dynamic is not None and None not in loss.dynamic_range:
        low, high = (words.number(100.0 * (bound or 0.0), COARSE) for bound in loss.dynamic_range)
        key = "loss_indistinct" if loss.distinguishable is False else "dynamic_loss"
        yield words(f"synthesis.{key}", loss=words.number(100.0 * loss.dynamic, COARSE), low=low, high=high)
