"""A judgement drafted in plain words from the numbers, for the engineer to edit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from assessment.ntc.limit_states import CHECKS
from assessment.report.chapters.grid import ROUNDING
from assessment.report.chapters.second_solver import agreement
from assessment.report.tables.capacity import capacities, directions, verification
from assessment.report.tables.structure.ties import gains
from assessment.report.tables.studies import bars
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import COARSE, check_name, written
from assessment.results.configurations.hand_check import hand_checks, mechanisms
from assessment.results.configurations.reactions import balances
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction, StrengtheningRow
from assessment.results.schema.part import known, present
from assessment.results.table import Row, among_known, compared, indices, reduction, reference_of
from assessment.results.undetermined import determined_indices, undetermined

RESIDUALS = {  # of the solutions, relative to the weight: what needs no word
    "equilibrium_residual": 1e-6,
    "cone_violation": 1e-6,
    "complementarity": 1e-3,
}
BALANCED = 1e-3  # reactions less loads, relative to the weight
AGREEMENT = 0.01  # of the virtual-work multiplier, as in the paper
ORIGINAL = "original"  # the state as drawn
ONE_PER_CENT = 0.01  # losses no larger have no sign worth a remark
Loss = tuple[float, str, Direction]  # 1 − settled/original, state, direction


class Place(NamedTuple):
    """Where a check is made."""

    state: str
    direction: Direction
    limit_state: str

    def worded(self, words: Words) -> dict[str, str]:
        """Return it in the report's words, as fields of a sentence."""
        return {
            "state": words.state(self.state),
            "direction": direction_name(self.direction),
            "limit": check_name(self.limit_state, words),
        }


def draft_judgement(results: Results, words: Words) -> list[Markup]:
    """Return sentences: governing condition, losses due to the movement, margins, trust in the numbers.

    All that a printed table has of a quantity is compared: no sentence may claim what a table contradicts.
    """
    if not results.model.self_weight_stable:
        return [words("judgement.unstable")]
    return [
        *_governing(results, words),
        *_chosen(results, words),
        *_losses(results, words),
        *_strengthened(results, words),
        *_dynamic(results, words),
        *_histories(results, words),
        *_campaign(results, words),
        *worst_scenario(results, words),
        *_sensitive(results, words),
        *_margins(results, words),
        *_trust(results, words),
    ]


def _governing(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the least ratio of all checks, the index at SLV, how many are satisfied; without checks the least α0."""
    rows = verification(results).rows
    made = [row for row in rows if row["zeta_E"] is not None]
    if made:
        worst = min(made, key=itemgetter("zeta_E"))
        yield words(
            "judgement.governing",
            **_place_of(worst).worded(words),
            capacity=worst["a_g_g"],
            demand=worst["demand_a_g_g"],
            reference=_reference(results, words),
            ratio=words.ratio(worst["zeta_E"]),
            outcome=words.plain("value.verified" if worst["verified"] else "value.not_verified"),
        )
        yield from _indices(results, words)
    else:
        yield from _least_multiplier(results, words)
    yield from _without_index(results, words)
    passed = sum(bool(row["verified"]) for row in made)
    if len(made) < len(rows):
        counts = {"passed": passed, "made": len(made), "open": len(rows) - len(made), "total": len(rows)}
        yield words("judgement.open_checks", **counts)
    elif rows:
        yield words("judgement.checks", passed=passed, total=len(rows))


def _place_of(row: Row) -> Place:
    return Place(row["state"], row["direction"], row["limit_state"])


def _indices(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the least ζ_E of the states that have one, and where SLC has less."""
    missing = undetermined(results)
    found = [
        (zeta, Place(name, direction, limit))
        for name, direction, capacity in capacities(results)
        for limit, zeta in indices(capacity.ratios).items()
        if name not in missing
    ]
    if not found:
        return
    at_life = [(zeta, place) for zeta, place in found if place.limit_state.startswith("SLV")]
    zeta, place = min(at_life or found, key=itemgetter(0))
    yield words(
        "judgement.zeta_known" if missing else "judgement.zeta", **place.worded(words), zeta=words.ratio(zeta)
    )
    least, place = min(found, key=itemgetter(0))
    if least < zeta:
        yield words("judgement.zeta_SLC", **place.worded(words), zeta=words.ratio(least))


def _without_index(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each state without index, with the directions in which it has no capacity."""
    for name, missing in undetermined(results).items():
        ways = ", ".join(map(direction_name, missing))
        yield words("judgement.undetermined", state=words.state(name), directions=ways)


def _least_multiplier(results: Results, words: Words) -> Iterator[Markup]:
    found = [(rigid.alpha_0, state, direction) for state, direction, rigid in mechanisms(results)]
    if found:
        alpha, state, direction = min(found, key=itemgetter(0))
        place = {"state": words.state(state), "direction": direction_name(direction)}
        yield words("judgement.governing_alpha", alpha=alpha, **place)


def _chosen(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the least ratio of the mechanisms that the engineer chose."""
    made = [
        (check.zeta_E, given, limit)
        for given in results.mechanisms or []
        for limit, check in given.checks.items()
        if check.zeta_E is not None
    ]
    if made:
        ratio, given, limit = min(made, key=itemgetter(0))
        yield words(
            "judgement.chosen",
            mechanism=given.name,
            state=words.state(given.state),
            limit=check_name(limit, words),
            ratio=words.ratio(ratio),
        )


def _losses(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what costs most of the a_g borne at each limit state; without any a_g, what costs most of α0."""
    lost: dict[tuple[str, Direction], list[str]] = {}
    losses: dict[tuple[str, Direction], list[Markup]] = {}
    none: list[Markup] = []
    reference = _reference(results, words)
    for check in CHECKS:
        unknown = list(_not_found(results, check))
        for each in unknown:
            lost.setdefault(each, []).append(check)
        found = _reductions(results, partial(_borne, results, check))
        if not found:
            continue
        largest, state, direction = max(found, key=itemgetter(0))
        if largest > ROUNDING:
            loss = _loss(results, state, direction, check, largest, words)
            losses.setdefault((state, direction), []).append(loss)
        elif not unknown:
            place = Place(state, direction, check).worded(words)
            increase = words.per_cent(max(0.0, -largest))
            none.append(words("judgement.no_reduction", **place, increase=increase, reference=reference))
    if losses:
        by_curve = [
            words(
                "judgement.reduction_at",
                state=words.state(state),
                direction=direction_name(direction),
                losses=Markup(", ").join(found),
            )
            for (state, direction), found in losses.items()
        ]
        yield words("judgement.reduction", losses=Markup("; ").join(by_curve), reference=reference)
    yield from none
    for (state, direction), checks in lost.items():
        yield words(
            "judgement.lost",
            state=words.state(state),
            direction=direction_name(direction),
            limits=", ".join(check_name(check, words) for check in checks),
            reference=reference,
        )
    if not any(each.checks for _, _, each in capacities(results)):
        yield from _multiplier_loss(results, words)


def _reductions(results: Results, value: Callable[[str, Direction], float | None]) -> list[Loss]:
    """Return the reductions of a quantity, which `value` gives of a state and direction, each with where it is."""
    return [
        (loss, state, direction)
        for direction in directions(results)
        for state in _settled(results)
        if (loss := reduction(value(ORIGINAL, direction), value(state, direction))) is not None
    ]


def _not_found(results: Results, check: str) -> Iterator[tuple[str, Direction]]:
    """Yield the settled states and directions without an a_g at a check, which the original state has."""
    for direction in directions(results):
        for state in _settled(results):
            before, after = (_borne(results, check, name, direction) for name in (ORIGINAL, state))
            if before is not None and after is None:
                yield state, direction


def _settled(results: Results) -> list[str]:
    return [name for name, state in results.states.items() if name != ORIGINAL and not state.strengthening]


def _borne(results: Results, check: str, state: str, direction: Direction) -> float | None:
    """Return the a_g borne at a check, g; None where there is none."""
    capacity = results.states[state].capacity.get(direction) if state in results.states else None
    found = capacity.checks.get(check) if capacity else None
    return found.a_g_g if found else None


def _loss(
    results: Results, state: str, direction: Direction, check: str, loss: float, words: Words
) -> Markup:
    """Return a reduction of a_g with its check, and between which values ranges of both states let it lie."""
    found = {"reduction": words.per_cent(loss)}
    low, high = (_range(results, name, direction, check) for name in (state, ORIGINAL))
    if low and high and (low[0] < low[1] or high[0] < high[1]):
        ends = {"least": 1.0 - low[1] / high[0], "most": 1.0 - low[0] / high[1]}
        shown = {end: words.per_cent(share) for end, share in ends.items()}
        if shown["least"] != shown["most"]:
            found |= shown
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
    alpha = {(state, direction): rigid.alpha_0 for state, direction, rigid in mechanisms(results)}
    found = _reductions(results, lambda state, direction: alpha.get((state, direction)))
    if not found:
        return
    largest, state, direction = max(found, key=itemgetter(0))
    if largest > ROUNDING:
        place = {"state": words.state(state), "direction": direction_name(direction)}
        yield words("judgement.alpha_reduction", **place, reduction=words.per_cent(largest))


def _strengthened(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what each strengthening gains in the direction that is weakest after it, and which ties yield."""
    for state in dict.fromkeys(row.state for row in results.strengthening or ()):
        own = [row for row in results.strengthening or () if row.state == state]
        for quantity in ("zeta_E", "alpha_0", "alpha_u", "dynamic_pga_g"):
            found = [
                (after, before, gain, row)
                for row in own
                for name, before, after, gain in gains(row)
                if name == quantity and gain is not None
            ]
            if found:
                after, before, gain, row = min(found, key=itemgetter(0))
                yield _gained(row, quantity, (before, after, gain), words)
                break
        yield from _interventions(results, state, words)
    yielding = dict.fromkeys(
        each.tie
        for state in results.states.values()
        for pushed in state.pushover.values()
        for push in pushed.by_contacts.values()
        for each in push.ties or ()
        if each.yields
    )
    if yielding:
        yield words("judgement.ties_yield", ties=", ".join(yielding))


def _interventions(results: Results, state: str, words: Words) -> Iterator[Markup]:
    """Yield which interventions of NTC 2018, §8.4, a strengthening amounts to."""
    found = determined_indices(results).get(state)
    if found is None or found.attained is None:
        return
    before = (
        words.plain("value.not_determined") if found.zeta_before is None else words.ratio(found.zeta_before)
    )
    told = Markup("; ").join(
        words(
            f"judgement.{'attained' if reached else 'not_attained'}",
            kind=words(f"judgement.of_{kind}"),
            least=found.required_zeta[kind],
        )
        for kind, reached in found.attained.items()
    )
    if told:
        yield words(
            "judgement.interventions", state=state, zeta=words.ratio(found.zeta_SLV), before=before, told=told
        )


def _gained(row: StrengtheningRow, quantity: str, values: tuple[float | None, ...], words: Words) -> Markup:
    """Return a sentence on a quantity before and after a strengthening, and its increase."""
    before, after, gain = values
    limit = check_name(row.limit_state, words) if row.limit_state else ""
    return words(
        "judgement.strengthened" if known(gain) > ROUNDING else "judgement.strengthened_less",
        state=row.state,
        of=words.state(row.of),
        quantity=words(f"judgement.of_{quantity}", limit=limit),
        before=written(quantity, before, words),
        after=written(quantity, after, words),
        gain=words.per_cent(known(gain)),
        direction=direction_name(row.direction or ""),
    )


def _dynamic(results: Results, words: Words) -> Iterator[Markup]:
    for each in results.comparison:
        if each.dynamic_pga_g is not None and each.static_surface_pga_g is not None:
            yield words(
                "judgement.dynamic",
                **Place(each.state, known(each.direction), known(each.limit_state)).worded(words),
                dynamic=each.dynamic_pga_g,
                static=each.static_surface_pga_g,
            )


def _histories(results: Results, words: Words) -> Iterator[Markup]:
    """Yield in which states each record ends in collapse; of one without collapse the largest peak."""
    entries = [(name, entry) for name, state in results.states.items() for entry in state.history]
    for record in dict.fromkeys(entry.record for _, entry in entries):
        own = [(name, entry) for name, entry in entries if entry.record == record]
        fallen = [name for name, entry in own if entry.collapsed]
        what = {"record": record, "pga": own[0][1].pga_g}
        if fallen:
            states = ", ".join(f"“{words.state(name)}”" for name in fallen)
            yield words("judgement.history_collapse", **what, states=states)
        peaks = [
            (entry.peak_displacement_m, name)
            for name, entry in own
            if not entry.collapsed and entry.peak_displacement_m is not None
        ]
        if peaks:
            peak, name = max(peaks)
            text = "judgement.history_stands" if fallen else "judgement.history_peak"
            yield words(text, **what, peak=words.millimetres(peak), state=words.state(name))


def _campaign(results: Results, words: Words) -> Iterator[Markup]:
    """Yield of each movement in full the medians before and after, and its loss beside the static one."""
    campaign = results.campaign
    if campaign is None:
        return
    before = {fit.settlement: fit.median_g for fit in campaign.fragility if fit.share == 0.0}
    rows = list(zip(campaign.fragility, campaign.loss, strict=True))
    for settlement in dict.fromkeys(fit.settlement for fit, _ in rows):
        fit, loss = max(
            (row for row in rows if row[0].settlement == settlement), key=lambda row: row[0].share
        )
        was = before.get(settlement)
        if fit.share == 0.0 or was is None or fit.median_g is None or loss.dynamic is None:
            continue
        pair = (loss.dynamic, loss.static)
        kind = "alone" if loss.static is None else "opposed" if _opposed(*pair) else "beside"
        yield words(
            f"judgement.campaign_{kind}",
            settlement=settlement,
            share=words.comma(f"{100.0 * fit.share:g}"),
            measure="PGA" if campaign.measure == "PGA" else words.plain("judgement.campaign_sa"),
            before=was,
            after=fit.median_g,
            dynamic=_signed(loss.dynamic, words),
            static=None if loss.static is None else _signed(loss.static, words),
        )


def _opposed(dynamic: float, static: float | None) -> bool:
    """Return whether one of two losses is a gain, both of them more than nothing as they are printed."""
    return static is not None and dynamic * static < 0.0 and min(abs(dynamic), abs(static)) >= ONE_PER_CENT


def _signed(loss: float, words: Words) -> str:
    return words.number(100.0 * loss, COARSE)


def _reference(results: Results, words: Words) -> str:
    """Return what the accelerations of the checks refer to."""
    return words.plain(f"value.stated_on_{reference_of(results)}")


def worst_scenario(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence that names the worst of the scenarios, where several were set side by side."""
    found = results.scenarios
    if found and (worst := found.worst):
        counts = None if worst.collapses else among_known(found)
        among = words("judgement.worst_among", known=counts[0], total=counts[1]) if counts else ""
        sentence = words(
            f"judgement.worst_{'collapses' if worst.collapses else found.quantity}",
            state=words.state(worst.state),
            movement=words.millimetres(worst.movement_m),
            direction=direction_name(worst.direction),
            capacity=compared(worst, found.quantity),
            limit=found.limit_state,
            reference=_reference(results, words),
            among=among,
        )
        if not worst.collapses and worst.reduction is not None:
            sentence += Markup(" ") + words(
                "judgement.worst_reduction", reduction=words.per_cent(worst.reduction)
            )
        yield sentence


def _sensitive(results: Results, words: Words) -> Iterator[Markup]:
    every, found = bars(results), results.sensitivity
    wide = [(bar.swing_g, bar) for bar in every if bar.swing_g]
    if found and wide:
        _, widest = max(wide, key=itemgetter(0))
        yield words(
            "judgement.sensitive",
            limit=found.limit_state,
            property=words.plain(f"value.{widest.property}"),
            state=words.state(widest.state),
            low=widest.low_factor,
            high=widest.high_factor,
            least=min(widest.capacities()),
            most=max(widest.capacities()),
            reference=_reference(results, words),
        )
    without = dict.fromkeys(bar.property for bar in every if bar.swing_g is None)
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
                    share=words.per_cent(applied / ultimate),
                    ultimate=1000.0 * ultimate,
                )


def _trust(results: Results, words: Words) -> Iterator[Markup]:
    quality = results.quality
    residuals = present(
        {
            "equilibrium_residual": quality.worst_equilibrium_residual,
            "cone_violation": quality.worst_cone_violation,
            "complementarity": quality.worst_complementarity,
        }
    )
    shown = {name: words.number(residual, COARSE) for name, residual in residuals.items()}
    poor = [name for name, residual in residuals.items() if residual > RESIDUALS[name]]
    for name in poor:
        yield words("judgement.poor_certificates", what=words(f"judgement.{name}"), residual=shown[name])
    if len(residuals) == len(RESIDUALS) and not poor:
        yield words("judgement.certificates", **shown)
    yield from _converged(results, words)
    yield from agreement(results, words)
    deviations = [
        abs(deviation) for each in hand_checks(results) for deviation in (each.deviation, each.hand_deviation)
    ]
    if deviations:
        key = "hand_agrees" if max(deviations) <= AGREEMENT else "hand_differs"
        yield words(f"judgement.{key}", deviation=words.number(100.0 * max(deviations), COARSE))
    unbalanced = [each.unbalanced for each in balances(results)]
    if unbalanced:
        worst = float(np.max(unbalanced))  # NaN if any is
        yield words(
            f"judgement.{'balanced' if worst <= BALANCED else 'unbalanced'}",
            unbalanced=words.number(worst, COARSE),
        )
    warnings = all_warnings(results)
    if warnings:
        yield words("judgement.warnings", count=len(warnings))


def _converged(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what refinement says of the discretisation error."""
    tolerance = results.convergence.tolerance
    if not tolerance:
        yield words("judgement.no_convergence")
        return
    rows = [*results.convergence.rows, *(results.convergence.incremental or [])]
    found = [row.relative_error for row in rows]
    errors = [error for error in found if error is not None]
    if errors:
        good = max(errors) <= tolerance and len(errors) == len(found)
        key = "judgement.converged" if good else "judgement.not_converged"
        error = words.number(100.0 * max(errors), COARSE)
        yield words(key, error=error, tolerance=words.comma(f"{100.0 * tolerance:g}"))


def all_warnings(results: Results) -> list[str]:
    """Return the warnings of model, run and solves, each once, in order."""
    return list(dict.fromkeys([*results.model.warnings, *results.quality.warnings]))
