"""The first page: the table of what was found, the governing mechanism, and what the result rests on."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.ntc.demand.return_period import USE_COEFFICIENT, return_period
from assessment.report.chapters.grid import Grid
from assessment.report.tables.structure.joints import bounded, edge_pressures
from assessment.report.tables.structure.mechanisms import mechanism_name
from assessment.report.tables.synthesis import ORIGINAL, governing_view, index_limit, least_row
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import heading, told, written
from assessment.results.configurations.hand_check import rigid_push
from assessment.results.echo import coulomb
from assessment.results.schema import Results
from assessment.results.schema.summary import SummaryRow

LISTED = ("alpha_0", "d_0_m", "alpha_u", "static_pga_g", "dynamic_pga_g")


def synthesis_grid(results: Results, words: Words) -> Grid | None:
    """Return the table of the first page: a row a state and direction; None without any row."""
    rows = [row for row in results.summary.rows if row.direction or row.dynamic_pga_g is not None]
    if not rows:
        return None
    first = index_limit(results)
    limits = list(dict.fromkeys([*filter(None, [first]), *(limit for row in rows for limit in row.checks)]))
    listed = [name for name in LISTED if any(getattr(row, name) is not None for row in rows)]
    if "alpha_0" in listed and "alpha_u" in listed:
        listed.remove("alpha_u")
    farthest = "/".join(sorted({row.limit_state for row in rows if row.limit_state}))
    changed = bool(first) and any(row.checks[first].loss is not None for row in rows if first in row.checks)
    dash = words("value.none")

    def cells(row: SummaryRow) -> Iterator[str]:
        yield from (words.state(row.state), direction_name(row.direction or "–"))
        yield from (_ratio(row, limit, words) for limit in limits)
        if changed:
            loss = row.checks[first].loss if first and row.state != ORIGINAL else None
            yield dash if loss is None else words.per_cent(-loss)
        values = {name: getattr(row, name) for name in listed}
        yield from (dash if value is None else written(name, value, words) for name, value in values.items())
        known = row.direction if row.mechanism else None
        yield mechanism_name(results, row.state, known, words) if known else dash
        if limits:
            yield written("verified", row.verified, words)

    texts = ["mechanism", *(["verified"] if limits else [])]
    indices = ["index" if limit == first else "ratio" for limit in limits]
    head = [heading("state", words), words("synthesis.direction")]
    head += [words(f"synthesis.{kind}", limit=limit) for kind, limit in zip(indices, limits, strict=True)]
    head += [words("synthesis.change")] if changed else []
    for name in [*listed, *texts]:
        static = name == "static_pga_g"
        head.append(words("synthesis.static", limit=farthest) if static else heading(name, words))
    text = [True, True, *[False] * (len(head) - 2 - len(texts)), *[True] * len(texts)]
    grid = [[Markup.escape(cell) for cell in cells(row)] for row in rows]
    return Grid(words("caption.synthesis"), head, grid, text)


def _ratio(row: SummaryRow, limit: str, words: Words) -> Markup:
    check = row.checks.get(limit)
    if check is None or check.zeta_E is None:
        return words("value.none" if check is None else "value.open")
    return written("zeta_E", check.zeta_E, words)


def governing_mechanism(results: Results, words: Words) -> Markup:
    """Return the governing mechanism in words, with the weight that moves; empty without any."""
    view = governing_view(results)
    if view is None:
        return Markup("")
    weight = rigid_push(results, *view).mechanism.moving_weight_kN
    return words(
        "synthesis.mechanism",
        name=mechanism_name(results, *view, words),
        state=words.state(view[0]),
        direction=direction_name(view[1]),
        weight=words.number(weight),
        share=words.per_cent(weight / results.model.weight_kN if results.model.weight_kN else 0.0),
    )


def basis(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what the result rests on: friction, knowledge, hazard, ranges, crushing, and what is warned of."""
    yield _friction(results, words)
    assessment = results.echo.assessment or {}
    if assessment:
        yield knowledge(results, words)
    if (demand := (results.spectra or {}).get("SLV")) is not None:
        pga = demand.pga_g if demand.pga_g is not None else demand.a_g_g
        yield words("synthesis.hazard", pga=words.number(pga), reference=reference_life(results, words))
    yield _range(results, words)
    yield from _pressure(results, words)
    if results.echo.report.protection:
        yield words("synthesis.listed", decree=results.echo.report.protection)


def _friction(results: Results, words: Words) -> Markup:
    """Return the law of friction, and the index by the other one where it differs by more than 2 %."""
    found = {joint.friction for joint in results.geometry.joints if joint.friction is not None}
    mu = "–".join(words.number(each, 2) for each in sorted({min(found), max(found)})) if found else "∞"
    law = "coulomb" if coulomb(results.echo) else "associative"
    told = words(f"synthesis.friction_{law}", mu=mu)
    limit = index_limit(results)
    others = [
        words(
            "synthesis.other_at",
            zeta=words.ratio(ratio),
            state=words.state(row.state),
            direction=direction_name(row.direction or ""),
        )
        for row in results.summary.rows
        if row.other_law and limit and (ratio := (row.other_law.zeta_E or {}).get(limit)) is not None
    ]
    return told + words(f"synthesis.other_than_{law}", where=Markup("; ").join(others)) if others else told


def knowledge(results: Results, words: Words) -> Markup:
    """Return the confidence factor with the level that it follows from, or that it has none."""
    found = results.knowledge
    if found is None:
        return words(
            "synthesis.no_knowledge", factor=(results.echo.assessment or {}).get("confidence_factor", 1.0)
        )
    return words(
        f"synthesis.knowledge_{'level' if found.level else 'components'}", factor=found.F_C, level=found.level
    )


def reference_life(results: Results, words: Words) -> Markup:
    """Return V_N, C_U, V_R and the return period at SLV; empty without a nominal life and a class of use."""
    site = (results.echo.assessment or {}).get("site") or {}
    life, use = site.get("nominal_life_years"), site.get("use_class")
    if not life or use not in USE_COEFFICIENT:
        return Markup("")
    return words(
        "synthesis.life",
        V_N=words.comma(f"{life:g}"),
        use_class=use,
        C_U=words.comma(f"{USE_COEFFICIENT[use]:g}"),
        V_R=words.comma(f"{life * USE_COEFFICIENT[use]:g}"),
        T_R=words.rounded(return_period("SLV", life, use), 0),
    )


def _range(results: Results, words: Words) -> Markup:
    """Return the range of the governing index where an ensemble was run, else that none was."""
    least = results.summary.governing
    row = least_row(results, least.state) if least else None
    check = row.checks.get(least.limit_state) if row and least else None
    if check and check.zeta_E_range:
        low, high = (
            words.ratio(end) if end is not None else words.plain("value.not_determined")
            for end in check.zeta_E_range
        )
        return words("synthesis.range", low=low, high=high)
    return words("synthesis.no_range" if (results.echo.scatter or 1) == 1 else "synthesis.one_path")


def _pressure(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the greatest edge pressure beside the strength that was given, or that none was."""
    strengths = [joint.compressive_strength_kN_m2 for joint in results.geometry.joints]
    limits = [each for each in strengths if each is not None]
    pressed = edge_pressures(results)
    known = bool(pressed) and bounded(pressed)
    most = told("edge_pressure_kN_m2", pressed[0].edge_pressure_kN_m2, words) if known else ""
    if limits:
        strength = told("compressive_strength_kN_m2", min(limits), words)
        yield words(
            "synthesis.strength" if known else "synthesis.strength_alone", strength=strength, pressure=most
        )
    else:
        yield words("synthesis.no_strength_pressure" if known else "synthesis.no_strength", pressure=most)
