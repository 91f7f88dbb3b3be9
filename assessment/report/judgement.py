"""A judgement drafted in plain words from the numbers, for the engineer to edit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from markupsafe import Markup

from assessment.ntc.limit_states import CHECKS
from assessment.report.second_solver import agreement
from assessment.report.tables.capacity import capacities, chosen_checks, summary, verification
from assessment.report.tables.convergence import convergence_tables
from assessment.report.tables.index import mechanisms
from assessment.report.tables.studies import tornado
from assessment.report.text.language import Words, direction_name
from assessment.report.text.table_format import ROUNDING, check_name
from assessment.results.hand_check import hand_check
from assessment.results.reactions import balance
from assessment.results.schema import Results
from assessment.results.schema.part import present
from assessment.results.table import Row, cells, compared, indices, reference_of

RESIDUALS = {  # of the solutions, relative to the weight: what needs no word
    "equilibrium_residual": 1e-6,
    "cone_violation": 1e-6,
    "complementarity": 1e-3,
}
BALANCED = 1e-3  # reactions less loads, relative to the weight
AGREEMENT = 0.01  # of the virtual-work multiplier, as in the paper


def draft_judgement(results: Results, words: Words) -> list[Markup]:
    """Return sentences: governing condition, losses due to the movement, margins, trust in the numbers.

    Each is drawn from a table that is printed, all rows of it compared: none may claim what a table contradicts.
    """
    if not results.model.self_weight_stable:
        return [words("judgement.unstable")]
    return [
        *_governing(results, words),
        *_chosen(results, words),
        *_losses(results, words),
        *_dynamic(results, words),
        *worst_scenario(results, words),
        *_sensitive(results, words),
        *_margins(results, words),
        *_trust(results, words),
    ]


def _governing(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the least ratio of all checks, the index at SLV, how many are satisfied; without checks the least α0."""
    rows = verification(results).rows
    made = [row for row in rows if row.get("zeta_E") is not None]
    if not made:
        yield from _least_multiplier(results, words)
        return
    worst = min(made, key=lambda row: row["zeta_E"])
    yield words(
        "judgement.governing",
        **_where(worst, words),
        capacity=worst.get("a_g_g"),
        demand=worst.get("demand_a_g_g"),
        reference=_reference(results, words),
        ratio=worst["zeta_E"],
        outcome=words.plain("value.verified" if worst.get("verified") else "value.not_verified"),
    )
    found = [
        (zeta, {"state": name, "direction": direction, "limit_state": limit})
        for name, direction, capacity in capacities(results)
        for limit, zeta in indices(capacity.ratios).items()
    ]
    at_life = [each for each in found if each[1]["limit_state"].startswith("SLV")]
    if found:
        zeta, place = min(at_life or found, key=lambda each: each[0])
        yield words("judgement.zeta", **_where(place, words), zeta=zeta)
        least, place = min(found, key=lambda each: each[0])
        if least < zeta:
            yield words("judgement.zeta_SLC", **_where(place, words), zeta=least)
    passed = sum(bool(row.get("verified")) for row in made)
    yield words("judgement.checks", passed=passed, total=len(rows))
    if len(made) < len(rows):
        yield words("judgement.open_checks", count=len(rows) - len(made))


def _least_multiplier(results: Results, words: Words) -> Iterator[Markup]:
    found = {
        (row["state"], row["direction"]): row["alpha_0"]
        for row in mechanisms(results).rows
        if row["alpha_0"] is not None
    }
    if found:
        state, direction = min(found, key=lambda place: found[place])
        place = {"state": words.state(state), "direction": direction_name(direction)}
        yield words("judgement.governing_alpha", alpha=found[state, direction], **place)


def _chosen(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the least ratio of the mechanisms that the engineer chose."""
    rows = [row for row in chosen_checks(results).rows if row.get("zeta_E") is not None]
    if rows:
        worst = min(rows, key=lambda row: row["zeta_E"])
        yield words(
            "judgement.chosen",
            mechanism=worst["mechanism"],
            state=words.state(worst["state"]),
            limit=check_name(worst["limit_state"], words),
            ratio=worst["zeta_E"],
        )


def _losses(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what costs most of the a_g borne at each limit state; without any a_g, what costs most of α0."""
    rows = [row for row in summary(results).rows if row["quantity"] == "a_g_g"]
    lost: dict[tuple[str, str], list[str]] = {}
    losses: dict[tuple[str, str], list[Markup]] = {}
    none: list[Markup] = []
    reference = _reference(results, words)
    for check in CHECKS:
        of_check = [row for row in rows if row["limit_state"] == check]
        unknown = list(_not_found(results, of_check))
        for each in unknown:
            lost.setdefault(each, []).append(check)
        found = _reductions(results, of_check)
        largest, state, direction = max(found, key=lambda each: each[0], default=(0.0, "", ""))
        if not state:
            continue
        place = _where({"state": state, "direction": direction, "limit_state": check}, words)
        if largest > ROUNDING:
            loss = _loss(results, state, direction, check, largest, words)
            losses.setdefault((state, direction), []).append(loss)
        elif not unknown:
            increase = max(0.0, -100.0 * largest)
            none.append(words("judgement.no_reduction", **place, increase=increase, reference=reference))
    if losses:
        told = [
            words(
                "judgement.reduction_at",
                state=words.state(state),
                direction=direction_name(direction),
                losses=Markup(", ").join(found),
            )
            for (state, direction), found in losses.items()
        ]
        yield words("judgement.reduction", losses=Markup("; ").join(told), reference=reference)
    yield from none
    for (state, direction), checks in lost.items():
        yield words(
            "judgement.lost",
            state=words.state(state),
            direction=direction_name(direction),
            limits=", ".join(check_name(check, words) for check in checks),
            reference=reference,
        )
    if not rows:
        yield from _multiplier_loss(results, words)


def _reductions(results: Results, rows: Iterable[Row]) -> list[tuple[float, str, str]]:
    """Return the reductions of a quantity, each with its state and direction."""
    return [
        (loss, state, row["direction"])
        for row in rows
        for state in results.states
        if (loss := row.get(f"reduction: {state}")) is not None
    ]


def _not_found(results: Results, rows: Iterable[Row]) -> Iterator[tuple[str, str]]:
    """Yield the settled states and directions without a value that the original state has."""
    for row in rows:
        for state in results.states:
            if state != "original" and row.get("original") is not None and row.get(state) is None:
                yield state, row["direction"]


def _loss(results: Results, state: str, direction: str, check: str, loss: float, words: Words) -> Markup:
    """Return a reduction of a_g with its check, and between which values ranges of both states let it lie."""
    found = {"reduction": 100.0 * loss}
    low, high = (_range(results, name, direction, check) for name in (state, "original"))
    if low and high and (low[0] < low[1] or high[0] < high[1]):
        ends = {"least": 100.0 * (1.0 - low[1] / high[0]), "most": 100.0 * (1.0 - low[0] / high[1])}
        if words.number(ends["least"]) != words.number(ends["most"]):
            found |= ends
    kind = "range" if "least" in found else "of"
    return words(f"judgement.reduction_{kind}", limit=check_name(check, words), **found)


def _range(results: Results, state: str, direction: str, check: str) -> tuple[float, float] | None:
    """Return the least and the largest a_g of a check, twice the same where it has no range; None if either is open."""
    found = next(
        each.checks[check] for name, way, each in capacities(results) if (name, way) == (state, direction)
    )
    low, high = found.a_g_g_range or (found.a_g_g, found.a_g_g)
    return None if low is None or high is None or low <= 0.0 else (low, high)


def _multiplier_loss(results: Results, words: Words) -> Iterator[Markup]:
    rows = [row for row in summary(results).rows if row["quantity"] == "alpha_0"]
    largest, state, direction = max(_reductions(results, rows), default=(0.0, "", ""))
    if largest > ROUNDING:
        place = {"state": words.state(state), "direction": direction_name(direction)}
        yield words("judgement.alpha_reduction", **place, reduction=100.0 * largest)


def _dynamic(results: Results, words: Words) -> Iterator[Markup]:
    for each in results.comparison:
        if each.dynamic_pga_g is not None and each.static_surface_pga_g is not None:
            yield words(
                "judgement.dynamic",
                **_where(cells(each, ("state", "direction", "limit_state")), words),
                dynamic=each.dynamic_pga_g,
                static=each.static_surface_pga_g,
            )


def _reference(results: Results, words: Words) -> str:
    """Return what the accelerations of the checks refer to."""
    return words.plain(f"value.stated_on_{reference_of(results)}")


def _where(place: Row, words: Words) -> dict[str, str]:
    """Return state, direction and limit state of a row in the report's words."""
    return {
        "state": words.state(place["state"]),
        "direction": direction_name(place["direction"]),
        "limit": check_name(place["limit_state"], words),
    }


def worst_scenario(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence that names the worst of the scenarios, where several were set side by side."""
    found = results.scenarios
    if found and (worst := found.worst):
        sentence = words(
            f"judgement.worst_{'collapses' if worst.collapses else found.quantity}",
            state=words.state(worst.state),
            movement=words.millimetres(worst.movement_m),
            direction=direction_name(worst.direction),
            capacity=compared(worst, found.quantity),
            limit=found.limit_state,
            reference=_reference(results, words),
        )
        if not worst.collapses and worst.reduction is not None:
            sentence += Markup(" ") + words("judgement.worst_reduction", reduction=100.0 * worst.reduction)
        yield sentence


def _sensitive(results: Results, words: Words) -> Iterator[Markup]:
    rows, found = tornado(results).rows, results.sensitivity
    bars = [bar for bar in rows if bar["swing_g"]]
    if found and bars:
        widest = max(bars, key=lambda row: row["swing_g"])
        span = [widest[key] for key in ("a_g_low_g", "a_g_base_g", "a_g_high_g")]
        yield words(
            "judgement.sensitive",
            limit=found.limit_state,
            property=words.plain(f"value.{widest['property']}"),
            state=words.state(widest["state"]),
            low=float(widest["low_factor"]),
            high=float(widest["high_factor"]),
            least=min(span),
            most=max(span),
            reference=_reference(results, words),
        )
    without = dict.fromkeys(row["property"] for row in rows if row["swing_g"] is None)
    if without:
        names = ", ".join(words.plain(f"value.{name}") for name in without)
        yield words("judgement.sensitive_open", properties=names)


def _margins(results: Results, words: Words) -> Iterator[Markup]:
    for name, state in results.states.items():
        for contacts, path in state.pushdown.items():
            ultimate, applied = path.ultimate_movement_m, path.applied_movement_m
            if ultimate:
                yield words(
                    "judgement.margin" if applied < ultimate else "judgement.no_margin",
                    state=words.state(name),
                    contacts=words.plain(f"value.{contacts}"),
                    applied=1000.0 * applied,
                    share=100.0 * applied / ultimate,
                    ultimate=1000.0 * ultimate,
                )


def _trust(results: Results, words: Words) -> Iterator[Markup]:
    quality = results.quality
    known = present(
        {
            "equilibrium_residual": quality.worst_equilibrium_residual,
            "cone_violation": quality.worst_cone_violation,
            "complementarity": quality.worst_complementarity,
        }
    )
    poor = [name for name, residual in known.items() if residual > RESIDUALS[name]]
    for name in poor:
        yield words("judgement.poor_certificates", what=words(f"judgement.{name}"), residual=known[name])
    if len(known) == len(RESIDUALS) and not poor:
        yield words("judgement.certificates", **known)
    yield from _converged(results, words)
    yield from agreement(results, words)
    deviations = [
        abs(row[key]) for row in hand_check(results).rows for key in ("deviation", "hand_deviation")
    ]
    if deviations:
        key = "hand_agrees" if max(deviations) <= AGREEMENT else "hand_differs"
        yield words(f"judgement.{key}", deviation=100.0 * max(deviations))
    unbalanced = [row["unbalanced"] for row in balance(results).rows]
    if unbalanced:
        worst = float(np.max(unbalanced))  # NaN if any is
        yield words(f"judgement.{'balanced' if worst <= BALANCED else 'unbalanced'}", unbalanced=worst)
    warnings = all_warnings(results)
    if warnings:
        yield words("judgement.warnings", count=len(warnings))


def _converged(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what refinement says of the discretisation error."""
    tolerance = results.convergence.tolerance
    if not tolerance:
        yield words("judgement.no_convergence")
        return
    rows = [row for table in convergence_tables(results) for row in table.rows]
    found = [row.get("relative_error") for row in rows]
    known = [float(error) for error in found if error is not None]
    if known:
        good = max(known) <= tolerance and len(known) == len(found)
        key = "judgement.converged" if good else "judgement.not_converged"
        yield words(key, error=100.0 * max(known), tolerance=100.0 * tolerance)


def all_warnings(results: Results) -> list[str]:
    """Return the warnings of model, run and solves, each once, in order."""
    return list(dict.fromkeys([*results.model.warnings, *results.quality.warnings]))
