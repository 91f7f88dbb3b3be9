"""A judgement drafted in plain words from the numbers, for the engineer to edit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from markupsafe import Markup

from assessment.capacity_tables import decisive_checks
from assessment.hand_check import hand_check
from assessment.reactions import balance
from assessment.study_tables import tornado
from assessment.words import Words, direction_name

Results = Mapping[str, Any]
ACCURATE = 1e-6  # equilibrium residual relative to the weight
BALANCED = 1e-3  # reactions less loads, relative to the weight
AGREEMENT = 0.01  # of the virtual-work multiplier, as in the paper


def draft_judgement(results: Results, words: Words) -> list[Markup]:
    """Return sentences: governing condition, losses due to the movement, margins, trust in the numbers."""
    if not results["model"]["self_weight_stable"]:
        return [words("judgement.unstable")]
    return [
        *_governing(results, words),
        *_losses(results, words),
        *worst_scenario(results, words),
        *_sensitive(results, words),
        *_margins(results, words),
        *_trust(results, words),
    ]


def _governing(results: Results, words: Words) -> Iterator[Markup]:
    checks = decisive_checks(results)
    if checks:
        worst = min(checks, key=lambda row: row["zeta_E"])
        yield words(
            "judgement.governing",
            state=words.state(worst["state"]),
            direction=direction_name(worst["direction"]),
            limit=worst["limit_state"],
            capacity=worst.get("a_g_g"),
            demand=worst.get("demand_a_g_g"),
            zeta=worst["zeta_E"],
            outcome=words.plain("value.verified" if worst.get("verified") else "value.not_verified"),
        )
        passed = sum(bool(row.get("verified")) for row in checks)
        yield words("judgement.checks", passed=passed, total=len(checks))
        return
    found = dict(_multipliers(results))
    if found:
        state, direction = min(found, key=lambda place: found[place])
        yield words(
            "judgement.governing_alpha",
            alpha=found[state, direction],
            state=words.state(state),
            direction=direction_name(direction),
        )


def _losses(results: Results, words: Words) -> Iterator[Markup]:
    rows = list(results.get("comparison") or [])
    static = [row for row in rows if row.get("static_reduction") is not None]
    if static:
        worst = max(static, key=lambda row: row["static_reduction"])
        yield _loss("reduction" if worst["static_reduction"] > 0.0 else "increase", worst, words)
    else:
        yield from _multiplier_losses(results, words)
    for row in rows:
        if row.get("dynamic_pga_g") is not None and row.get("static_pga_g") is not None:
            yield words(
                "judgement.dynamic",
                state=words.state(row["state"]),
                direction=direction_name(row["direction"]),
                dynamic=row["dynamic_pga_g"],
                static=row["static_pga_g"],
            )


def _loss(key: str, row: Mapping[str, Any], words: Words) -> Markup:
    return words(
        f"judgement.{key}",
        state=words.state(row["state"]),
        direction=direction_name(row["direction"]),
        reduction=100.0 * row["static_reduction"],
    )


def _multiplier_losses(results: Results, words: Words) -> Iterator[Markup]:
    found = dict(_multipliers(results))
    losses = {
        (state, direction): 1.0 - alpha / found["original", direction]
        for (state, direction), alpha in found.items()
        if state != "original" and found.get(("original", direction))
    }
    if losses and max(losses.values()) > 0.0:
        state, direction = max(losses, key=lambda place: losses[place])
        yield words(
            "judgement.alpha_reduction",
            state=words.state(state),
            direction=direction_name(direction),
            reduction=100.0 * losses[state, direction],
        )


def worst_scenario(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence that names the worst of the scenarios, where several were set side by side."""
    worst = (results.get("scenarios") or {}).get("worst")
    if worst:
        by = results["scenarios"]["quantity"]
        key = "collapses" if worst["collapses"] else by
        yield words(
            f"judgement.worst_{key}",
            state=words.state(worst["state"]),
            movement=words.millimetres(worst["movement_m"]),
            direction=direction_name(worst["direction"]),
            capacity=worst[by],
            limit=results["scenarios"]["limit_state"],
            reduction=None if worst["reduction"] is None else 100.0 * worst["reduction"],
        )


def _sensitive(results: Results, words: Words) -> Iterator[Markup]:
    bars = [row for row in tornado(results).rows if row["swing_g"] is not None]
    if bars:
        widest = max(bars, key=lambda row: row["swing_g"])
        yield words(
            "judgement.sensitive",
            property=words.plain(f"value.{widest['property']}"),
            state=words.state(widest["state"]),
            low=float(widest["low_factor"]),
            high=float(widest["high_factor"]),
            least=min(widest["a_g_low_g"], widest["a_g_base_g"], widest["a_g_high_g"]),
            most=max(widest["a_g_low_g"], widest["a_g_base_g"], widest["a_g_high_g"]),
        )


def _margins(results: Results, words: Words) -> Iterator[Markup]:
    for name, content in results["states"].items():
        settlement = content.get("settlement")
        applied = max(map(abs, settlement["displacement_m"])) if settlement else 0.0
        for contacts, stage in (content.get("pushdown") or {}).items():
            ultimate = stage.get("ultimate_movement_m")
            if ultimate and applied:
                yield words(
                    "judgement.margin",
                    state=words.state(name),
                    contacts=words.plain(f"value.{contacts}"),
                    applied=1000.0 * applied,
                    share=100.0 * applied / ultimate,
                    ultimate=1000.0 * ultimate,
                )


def _trust(results: Results, words: Words) -> Iterator[Markup]:
    residual = results["quality"].get("worst_equilibrium_residual")
    if residual is not None:
        good = residual <= ACCURATE
        yield words(
            "judgement.certificates" if good else "judgement.poor_certificates", residual=float(residual)
        )
    deviations = [
        abs(row[key]) for row in hand_check(results).rows for key in ("deviation", "hand_deviation")
    ]
    if deviations:
        key = "hand_agrees" if max(deviations) <= AGREEMENT else "hand_differs"
        yield words(f"judgement.{key}", deviation=100.0 * max(deviations))
    unbalanced = [row["unbalanced"] for row in balance(results).rows]
    if unbalanced:
        good = max(unbalanced) <= BALANCED
        yield words(f"judgement.{'balanced' if good else 'unbalanced'}", unbalanced=max(unbalanced))
    warnings = all_warnings(results)
    if warnings:
        yield words("judgement.warnings", count=len(warnings))


def all_warnings(results: Results) -> list[str]:
    """Return the warnings of model, run and solves, each once, in order."""
    listed = [
        *(results["model"].get("warnings") or []),
        *(results.get("warnings") or []),
        *(results["quality"].get("warnings") or []),
    ]
    return list(dict.fromkeys(listed))


def _multipliers(results: Results) -> Iterator[tuple[tuple[str, str], float]]:
    for name, content in results["states"].items():
        for direction, pushover in (content.get("pushover") or {}).items():
            alpha = (pushover or {}).get("rigid", {}).get("alpha_0")
            if alpha is not None:
                yield (name, direction), alpha
