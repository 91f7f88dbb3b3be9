"""The first page: the answer in sentences, the table of what was found, and what it rests on, from `summary` alone."""

from collections.abc import Iterator
from itertools import groupby

from markupsafe import Markup

from assessment.ntc.tables import ENOUGH, INDEXED, LINEAR, USE_COEFFICIENT, return_period
from assessment.report.chapters.grids import Grid, grid
from assessment.report.chapters.remarks import few_records
from assessment.report.language import Words, direction_name, indexed, label, number, written
from assessment.report.tables.dynamic import shaken
from assessment.report.tables.mechanisms import mechanism_name
from assessment.report.tables.structure import bounded, edge_pressures
from assessment.results import schema, summary
from assessment.results.hand_check import governing_view, rigid_push
from assessment.results.schema import QUANTITIES, Part, Results, SummaryCheck, SummaryRow, known, present
from assessment.results.table import ORIGINAL, Row, Table, reduction

QUALITY_ANNEX = "D"  # of the report: where warnings are listed
ALIKE = 1e-3  # ratio of capacities that are alike
SPACED = 0.05  # of the levels of motions: a change no larger is none
LISTED = ("alpha_0", "d_0_m", "alpha_u", "static_pga_g", "dynamic_pga_g")


def lead(results: Results, words: Words) -> list[Markup]:
    """Return the answer in sentences: the index of each kind of state, its loss, whether it is verified."""
    if not results.model.self_weight_stable:
        return [words("judgement.unstable")]
    worst, limit = summary.worst_settled(results) or ORIGINAL, summary.index_limit(results)
    sentences = [_of_state(results, worst, words)]
    stronger = [name for name, state in results.states.items() if state.strengthening]
    sentences += [_strengthened(results, name, words) for name in stronger]
    # states and directions without an index
    where = [
        words("synthesis.open_at", state=row.state, direction=row.direction or "")
        for row in results.summary.rows
        if row.checks and limit and row.reached and summary.index_of(row, limit) is None
    ]
    if where:
        sentences.append(words("synthesis.open", where=Markup("; ").join(where), annex=QUALITY_ANNEX))
    # the dynamic capacity beside the static one on the same reference, and what the motions lose of it
    row = summary.least_row(results, worst) or next(iter(summary.rows_of(results, worst)), None)
    if row is not None and (dynamic := row.dynamic_pga_g) is not None:
        static = row.static_nominal_pga_g
        key = f"synthesis.dynamic{'' if static is None else '_static'}"
        sentences.append(words(key, dynamic=dynamic, static=static))
    moved = (each.loss for each in shaken(results) if each.state == worst and each.share in (None, 1.0))
    loss = next(filter(None, moved), None)
    if loss is not None and loss.dynamic is not None and None not in loss.dynamic_range:
        low, high = loss.dynamic_range
        few = loss.records is not None and loss.records < ENOUGH
        kind = "loss_indistinct" if loss.distinguishable is False else f"dynamic_loss{'_few' * few}"
        sentences.append(words(f"synthesis.{kind}", loss=loss.dynamic, low=low, high=high))
        sentences += of_one_sign(worst, loss, words)
    # how many lowest collapses are ties that break, which are no falls; of a movement in shares the whole one counts
    whole = (each for each in shaken(results) if each.share in (None, 1.0))
    for (analysis, state), of in groupby(whole, key=lambda each: (each.analysis, each.state)):
        rows = [found for each in of for found in each.rows if found.lowest_collapse_g is not None]
        if broken := [found.broken_tie for found in rows if found.broken_tie]:
            ties, named = ", ".join(dict.fromkeys(broken)), words.plain(f"value.{analysis}")
            place = {"state": state, "analysis": named, "ties": ties}
            sentences.append(words("synthesis.tie_breaks", **place, count=len(broken), total=len(rows)))
    return [*filter(None, sentences)]


def of_one_sign(state: str, loss: schema.Loss, words: Words) -> list[Markup]:
    """Return a sentence that tells of which sign of the records a loss is, where the other gains."""
    ways = [way for way, lost in (loss.directions or {}).items() if lost == loss.dynamic]
    return [words("judgement.one_sign", settlement=state, direction=way) for way in ways]


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
    loss, distinct = (
        (check.loss, check.distinguishable) if check else (row.alpha_loss, row.alpha_distinguishable)
    )
    outcome = _outcome(results, name, words) if check else ""
    where = [_kind(check, words), limit if check else "", direction_name(row.direction or "")]
    rows = [at for at in results.summary.rows if at.direction]
    lacking = [at for at in rows if (summary.index_of(at, limit) if check else getattr(at, quantity)) is None]
    ways = ", ".join(direction_name(known(at.direction)) for at in lacking if at.state == name)
    where += [words.plain("synthesis.open_ways", directions=ways)] if ways else []
    symbol, shown = indexed(label(quantity, words)), written(quantity, value, words)
    place = {"symbol": symbol, "value": shown, "where": ", ".join(filter(None, where)), "outcome": outcome}
    if name == ORIGINAL:
        return words("synthesis.original", **place)
    worst = "known" if {at.state for at in lacking} & set(summary.settled(results)) else "worst"
    key = "current" if len(summary.settled(results)) == 1 else worst
    said = words(f"synthesis.{key}", state=name, count=len(summary.settled(results)), **place)
    drawn = {each.direction: summary.index_of(each, limit) for each in summary.rows_of(results, ORIGINAL)}
    if loss is not None and value is not None and loss < 1.0:
        before = written(quantity, value / (1.0 - loss), words)
        kind = "indistinct" if distinct is False else "loss" if loss >= 0.0 else "gain"
        kind = "unchanged" if number(QUANTITIES["reduction"], loss, words) == "0" else kind
        said += words("synthesis.before", before=before, change=words(f"synthesis.{kind}", share=abs(loss)))
    elif check and (was := drawn.get(row.direction)):
        said += words("synthesis.before_by", before=was.zeta_E, kind=_kind(was, words))
    return said + Markup.escape(f". {outcome}" if outcome else ".")


def _kind(check: Part | None, words: Words) -> str:
    return words.plain(f"value.{'linear' if getattr(check, 'check', '') in LINEAR else 'pushover'}")


def _outcome(results: Results, name: str, words: Words) -> str:
    """Return whether a state is verified in every direction, as a sentence; where the index is, what is not."""
    rows = summary.rows_of(results, name)
    counting = [{x: row.checks[x] for x in INDEXED if x in row.checks} or row.checks for row in rows]
    failing = [x for x in INDEXED if any(x in each and each[x].verified is False for each in counting)]
    if failing and summary.index_limit(results) not in failing:
        return words.plain("synthesis.not_verified_at", limits=", ".join(failing))
    verified = [row.verified for row in rows]
    if False in verified:
        return words.plain("synthesis.not_verified")
    if None not in verified:
        return words.plain("synthesis.verified")
    # of what is open the least ends of ranges: some runs of an ensemble are verified, or not all have a capacity
    open_ = [check for each in counting for check in each.values() if check.verified is None]
    lows = [check.zeta_E_range[0] or 0.0 for check in open_ if check.zeta_E_range]
    if not lows:
        return words.plain("synthesis.undetermined")
    return words.plain(f"synthesis.{'undecided' if min(lows) else 'not_all_runs'}", low=min(lows))


def _strengthened(results: Results, name: str, words: Words) -> Markup:
    """Return a sentence on what an intervention gives back, in the direction in which it found the structure weakest.

    That is of the index, without checks of the multiplier; of directions that were alike, the one that is weakest now.
    Where the structure is now weakest in another direction, the value there is given too. The sentence gives
    the result of the motions too, where that is the opposite.
    """
    limit, of = summary.index_limit(results), known(results.states[name].strengthening).of
    if (least := summary.least_row(results, of)) is None:
        return Markup("")
    quantity = "zeta_E" if limit else "alpha_u" if least.alpha_0 is None else "alpha_0"

    def part(at: SummaryRow) -> Part | None:
        if limit:
            return summary.index_of(at, limit)
        pushed = results.states[at.state].pushover.get(known(at.direction))
        return pushed and (pushed.elastic if quantity == "alpha_u" else pushed.rigid)

    def where(at: SummaryRow) -> str:
        return ", ".join(filter(None, (limit, direction_name(at.direction or ""))))

    def value(at: SummaryRow) -> float:
        return getattr(part(at), quantity, None) or 0.0

    rows = {at.direction: at for at in summary.rows_of(results, name)}
    pairs = [(at, rows[at.direction]) for at in summary.rows_of(results, of) if at.direction in rows]
    pairs = [pair for pair in pairs if all(map(part, pair))]
    weakest = min((value(at) for at, _ in pairs), default=0.0)
    alike = [pair for pair in pairs if value(pair[0]) <= (1.0 + ALIKE) * weakest]
    if not alike:
        return Markup("")
    # of directions that were alike the one that is weakest now
    before, row = min(alike, key=lambda pair: value(pair[1]))
    was, now = known(part(before)), known(part(row))
    if not (one := getattr(was, quantity)):
        return Markup("")
    after, least, now_least = getattr(now, quantity), known(summary.least_row(results, name)), Markup("")
    gain = now.gain if isinstance(now, SummaryCheck) else after / one - 1.0
    distinct = gain is not None and summary.apart(was, now, quantity)
    key = "_by" if gain is None else "" if distinct else "_same"  # of a linear check and one that is not
    change = words(f"synthesis.{'more' if (gain or 0.0) >= 0.0 else 'loss'}", gain=gain, share=-(gain or 0.0))
    if least is not row:
        shown = written(quantity, getattr(part(least), quantity), words)
        now_least = words("synthesis.strengthened_least", least=shown, where=where(least))
    ends = {"before": written(quantity, one, words), "after": written(quantity, after, words)}
    kinds = {"kind": _kind(now, words), "kind_before": _kind(was, words)}
    what = {"symbol": indexed(label(quantity, words)), "change": change, "least": now_least} | kinds
    said = words(f"synthesis.strengthened{key}", state=name, where=where(row), **ends, **what)
    if limit:
        said += Markup.escape(f" {_outcome(results, name, words)}")
    shook, shakes = (results.states[state].incremental.fragility for state in (of, name))
    if distinct and shook and shakes and summary.apart(shook, shakes, "pga_collapse_g"):
        level, later = shook.pga_collapse_g, shakes.pga_collapse_g
        lost = reduction(level, later) or 0.0
        if abs(lost) > SPACED and lost * (gain or 0.0) > 0.0:  # one gains where the other loses
            said += Markup(" ") + words("synthesis.strengthened_opposed", before=level, after=later)
    return said


def synthesis_grid(results: Results, words: Words) -> Grid | None:
    """Return the table of the first page: a row a state and direction; None without any row."""
    rows = [row for row in results.summary.rows if row.direction or row.dynamic_pga_g is not None]
    if not rows:
        return None
    first = summary.index_limit(results)
    limits = list(dict.fromkeys([*filter(None, [first]), *(limit for row in rows for limit in row.checks)]))
    listed = [name for name in LISTED if any(getattr(row, name) is not None for row in rows)]
    if "alpha_0" in listed and "alpha_u" in listed:
        listed.remove("alpha_u")
    changed = any(row.checks[first].loss is not None for row in rows if first and first in row.checks)
    columns = ["state", "direction", *limits, *["reduction"] * changed, *listed, "mechanism"]
    columns += ["verified"] * bool(limits)
    farthest = "/".join(sorted({row.limit_state for row in rows if row.limit_state}))
    heads = {x: words(f"synthesis.{'index' if x == first else 'ratio'}", limit=x) for x in limits}
    heads |= {"direction": words("synthesis.direction"), "reduction": words("synthesis.change")}
    heads |= {"static_pga_g": words("synthesis.static", limit=farthest)}
    judged = [limit for limit in limits if limit in ("SLV", "SLC")] or limits  # as `verified` of a row
    caption = words("caption.synthesis_judged" if judged else "caption.synthesis", limits=", ".join(judged))
    made = []
    for row in rows:  # without what it cannot have: of the listed quantities those of another analysis
        found: Row = {"state": row.state} | present({"direction": row.direction}) | {"verified": row.verified}
        found |= {limit: written("zeta_E", check.zeta_E, words) for limit, check in row.checks.items()}
        if row.state != ORIGINAL and first and (check := row.checks.get(first)):
            loss = check.loss
            same = loss is not None and check.distinguishable is False
            found["reduction"] = words("value.indistinct") if same else None if loss is None else -loss
        asked = {"static_pga_g": bool(row.checks), "d_0_m": row.alpha_0 is not None}
        asked["dynamic_pga_g"] = results.states[row.state].incremental.fragility is not None
        for name in listed:
            if (value := getattr(row, name)) is not None or asked.get(name):
                found[name] = value
            elif row.direction and not name.endswith("_pga_g"):
                found[name] = words("value.open")
        if row.mechanism and row.direction:
            found["mechanism"] = mechanism_name(results, row.state, row.direction, words)
        made.append(found)
    return grid(Table("synthesis", made, tuple(columns)), words, caption, heads=heads)


def governing_mechanism(results: Results, words: Words) -> Markup:
    """Return the governing mechanism in words, with the weight that moves; empty without any."""
    view = governing_view(results)
    if view is None:
        return Markup("")
    weight, whole = rigid_push(results, *view).mechanism.moving_weight_kN, results.model.weight_kN
    where = {"name": mechanism_name(results, *view, words), "state": view[0], "direction": view[1]}
    return words("synthesis.mechanism", **where, weight=weight, share=weight / whole if whole else 0.0)


def basis(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what the result rests on: friction, knowledge, hazard, ranges, crushing, and what is warned of."""
    limit = summary.index_limit(results) or ""
    # the law of friction, and the index by the other one where it differs by more than 2 %
    found = {joint.friction for joint in results.geometry.joints if joint.friction is not None}
    mu = "–".join(words.number(each, 2) for each in sorted({min(found), max(found)})) if found else "∞"
    law = "coulomb" if summary.coulomb(results.echo) else "associative"
    others = [
        words("synthesis.other_at", zeta=ratio, state=row.state, direction=row.direction or "")
        for row in results.summary.rows
        if row.other_law and limit and (ratio := (row.other_law.zeta_E or {}).get(limit)) is not None
    ]
    friction = words(f"synthesis.friction_{law}", mu=mu)
    if others:
        friction += words(f"synthesis.other_than_{law}", where=Markup("; ").join(others))
    yield friction
    if results.echo.assessment:
        yield knowledge(results, words)
    if (demand := (results.spectra or {}).get(limit)) is not None:
        life, pga = reference_life(results, words), demand.pga_g or demand.a_g_g
        yield words("synthesis.hazard", pga=pga, limit=limit, reference=life)
    checks = (check for row in results.summary.rows for check in row.checks.values())
    if any(check.verified is False and (check.zeta_E or 0.0) >= 1.0 for check in checks):
        yield words("synthesis.record_maximum")
    if results.echo.pushover:
        yield _range(results, words)
    if few_records(results)["incremental"]:
        yield words("text.few_records")
    # the greatest edge pressure beside the strength that was given
    limits = [s for joint in results.geometry.joints if (s := joint.compressive_strength_kN_m2) is not None]
    pressed = edge_pressures(results)
    most = pressed[0].edge_pressure_kN_m2 if pressed and bounded(pressed) else None
    if limits:
        key = "synthesis.strength_alone" if most is None else "synthesis.strength"
    else:
        key = "synthesis.no_strength" if most is None else "synthesis.no_strength_pressure"
    yield words(key, strength=min(limits, default=None), pressure=most)
    if decree := results.echo.report.get("protection"):
        yield words("synthesis.listed", decree=decree)


def knowledge(results: Results, words: Words) -> Markup:
    """Return the confidence factor with the level that it follows from, or that it has none; empty without checks."""
    assessment, found = results.echo.assessment, results.knowledge
    if not assessment:
        return Markup("")
    if found is None:
        return words("synthesis.no_knowledge", factor=assessment.get("confidence_factor", 1.0))
    key = f"synthesis.knowledge_{'level' if found.level else 'components'}"
    return words(key, factor=found.F_C, level=found.level)


def reference_life(results: Results, words: Words) -> Markup:
    """Return V_N, C_U, V_R and the return period of the index; empty without a nominal life and a class of use."""
    site = (results.echo.assessment or {}).get("site") or {}
    life, use = site.get("nominal_life_years"), site.get("use_class")
    if not life or use not in USE_COEFFICIENT:
        return Markup("")
    figures = {"V_N": life, "C_U": USE_COEFFICIENT[use], "V_R": life * USE_COEFFICIENT[use]}
    shown = {name: words.comma(f"{value:g}") for name, value in figures.items()}
    shown["T_R"] = words.rounded(return_period(limit := summary.index_limit(results) or "SLV", life, use), 0)
    return words("synthesis.life", use_class=use, limit=limit, **shown)


def _range(results: Results, words: Words) -> Markup:
    """Return the range of the governing index, without one of α0, where an ensemble was run, else that none was."""
    least = results.summary.governing
    row = summary.least_row(results, least.state if least else summary.worst_settled(results) or ORIGINAL)
    check = row.checks.get(least.limit_state) if row and least else None
    if check and check.zeta_E_range:
        low, high = check.zeta_E_range
        return words("synthesis.range", used=check.zeta_E, low=low, high=high)
    push = rigid_push(results, row.state, row.direction) if row and row.direction and row.alpha_0 else None
    if push and not least and push.alpha_0_range:
        low, high = push.alpha_0_range
        return words("synthesis.range_alpha", used=push.alpha_0, low=low, high=high)
    return words("synthesis.no_range" if (results.echo.scatter or 1) == 1 else "synthesis.one_path")
