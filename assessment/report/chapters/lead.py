"""The answer in sentences, with which report, page and terminal begin: from `summary` alone, and quick to load."""

from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.language import Words, direction_name, indexed, label, written
from assessment.results import summary
from assessment.results.schema import Results, SummaryRow, known
from assessment.results.table import ORIGINAL

QUALITY_ANNEX = "D"  # of the report: where warnings are listed


def lead(results: Results, words: Words) -> list[Markup]:
    """Return the answer in sentences, with which report, page and terminal begin.

    The index of each kind of state, its loss, and whether it is verified.
    """
    if not results.model.self_weight_stable:
        return [words("judgement.unstable")]
    worst = summary.worst_settled(results) or ORIGINAL
    sentences = [_of_state(results, worst, words)]
    sentences += [
        _strengthened(results, name, words) for name, state in results.states.items() if state.strengthening
    ]
    sentences += _open(results, words)
    sentences += _dynamic(results, worst, words)
    return [each for each in sentences if each]


def _of_state(results: Results, name: str, words: Words) -> Markup:
    """Return a sentence on the original or the worst settled state: its index, and what it was before."""
    row, limit = summary.least_row(results, name), summary.index_limit(results)
    if any(not each.reached for each in summary.rows_of(results, name)):
        return words("synthesis.collapses", state=name)
    if row is None:
        return Markup("") if summary.rows_of(results, name) else words("synthesis.nothing")
    check = summary.index_of(row, limit)
    quantity = "zeta_E" if check else "alpha_u" if row.alpha_0 is None else "alpha_0"
    value = check.zeta_E if check else getattr(row, quantity)
    loss = check.loss if check else row.alpha_loss
    outcome = _outcome(results, name, words) if check else ""
    where = [words.plain("value.pushover"), limit if check else "", direction_name(row.direction or "")]
    place = {
        "symbol": indexed(label(quantity, words)),
        "value": written(quantity, value, words),
        "where": ", ".join(filter(None, where)),
        "outcome": outcome,
    }
    if name == ORIGINAL:
        return words("synthesis.original", **place)
    key = "current" if len(summary.settled(results)) == 1 else "worst"
    said = words(f"synthesis.{key}", state=name, count=len(summary.settled(results)), **place)
    if loss is not None and value is not None and loss < 1.0:
        before = written(quantity, value / (1.0 - loss), words)
        change = words(f"synthesis.{'loss' if loss >= 0.0 else 'gain'}", share=abs(loss))
        said += words("synthesis.before", before=before, change=change)
    return said + Markup.escape(f". {outcome}" if outcome else ".")


def _outcome(results: Results, name: str, words: Words) -> str:
    """Return whether a state is verified in every direction, as a sentence."""
    verified = [row.verified for row in summary.rows_of(results, name)]
    kind = "not_verified" if False in verified else "undetermined" if None in verified else "verified"
    return words.plain(f"synthesis.{kind}")


def _strengthened(results: Results, name: str, words: Words) -> Markup:
    """Return a sentence on what an intervention gives back, in the direction in which it found the structure weakest.

    Where the structure is now weakest in another direction, the index there is given too.
    """
    limit = summary.index_limit(results)
    before = summary.least_row(results, known(results.states[name].strengthening).of)
    row = next(
        (row for row in summary.rows_of(results, name) if before and row.direction == before.direction), None
    )
    check = summary.index_of(row, limit) if row else None
    if row is None or check is None or check.zeta_E is None or check.gain is None or check.gain <= -1.0:
        return Markup("")

    def where(each: SummaryRow) -> str:
        return f"{limit}, {direction_name(each.direction or '')}"

    numbers = {"before": check.zeta_E / (1.0 + check.gain), "after": check.zeta_E, "gain": check.gain}
    said = {"state": name, "where": where(row), "outcome": _outcome(results, name, words), "least": ""}
    least = known(summary.least_row(results, name))
    if least is not row:
        ratio = known(summary.index_of(least, limit)).zeta_E
        said["least"] = words("synthesis.strengthened_least", least=ratio, where=where(least))
    return words("synthesis.strengthened", **said, **numbers)


def _open(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the states and directions without an index, in one sentence."""
    limit = summary.index_limit(results)
    where = [
        words("synthesis.open_at", state=row.state, direction=row.direction or "")
        for row in results.summary.rows
        if row.checks and limit and row.reached and summary.index_of(row, limit) is None
    ]
    if where:
        yield words("synthesis.open", where=Markup("; ").join(where), annex=QUALITY_ANNEX)


def _dynamic(results: Results, name: str, words: Words) -> Iterator[Markup]:
    """Yield the dynamic capacity beside the static one on the same reference, and what the motions lose of it."""
    row = summary.least_row(results, name) or next(iter(summary.rows_of(results, name)), None)
    if row is not None and (dynamic := row.dynamic_pga_g) is not None:
        static = row.static_nominal_pga_g
        kind = "dynamic" if static is None else "dynamic_static"
        yield words(f"synthesis.{kind}", dynamic=dynamic, static=static)
    whole = [each for each in (results.campaign.loss if results.campaign else []) if each.share == 1.0]
    found = [results.states[name].incremental.loss] if name in results.states else []
    found += [each for each in whole if each.settlement == name]
    loss = next(filter(None, found), None)
    if loss is not None and loss.dynamic is not None and None not in loss.dynamic_range:
        low, high = loss.dynamic_range
        kind = "loss_indistinct" if loss.distinguishable is False else "dynamic_loss"
        yield words(f"synthesis.{kind}", loss=loss.dynamic, low=low, high=high)
