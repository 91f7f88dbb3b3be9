"""Sentences that chapters have where the results call for them: assumptions, limits, curves, ties, identification."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from markupsafe import Markup

from assessment.ntc.limit_states import QUOTED
from assessment.ntc.vertical import THRUSTING_A_G
from assessment.report.tables.capacity import capacities, directions
from assessment.report.tables.curves import alpha_at_d_0, excesses
from assessment.report.tables.structure.cracks import SEEN, cracks_of
from assessment.report.tables.structure.cracks import printed as printed_cracks
from assessment.report.tables.structure.joints import bounded, crushes, edge_pressures
from assessment.report.tables.structure.joints import printed as printed_joints
from assessment.report.text.language import Words, direction_name
from assessment.report.text.messages import translated
from assessment.report.text.quantities import COARSE, told
from assessment.results.configurations.hand_check import (
    BY_HAND,
    figures_of,
    governing_mechanisms,
    mechanisms,
    outline_area,
)
from assessment.results.echo import collisions, coulomb, limit_states, local_limit, segments
from assessment.results.identified import UNLIKELY, best_of, fits, settlement_lines, told_of
from assessment.results.schema import Results
from assessment.results.schema.model import Echo
from assessment.results.schema.static import Contacts, RigidPush, TieTension
from assessment.results.undetermined import determined_indices

ORIGINAL = "original"
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


def crack_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what the table of cracks holds, what of it is not among those `printed`, or has no width."""
    yield words("text.cracks", seen=words.comma(f"{1000.0 * SEEN:g}"))
    by_state = [cracks_of(results, state) for state in results.states]
    most = printed_cracks(results)
    if any(len(found) > most for found in by_state):
        yield words("text.cracks_printed", printed=most)
    if any(crack.opening_m is None for found in by_state for crack in found[:most]):
        yield words("text.cracks_apart")


def damping_sentence(results: Results, words: Words) -> Markup:
    """Return the damping of the circular whose rules apply."""
    return words(f"text.damping_{_circular(results)}")


def index_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what the indices of the tables are: those that need a return period only where one is known."""
    yield words("text.indices")
    if any(each.I_S is not None for each in determined_indices(results).values()):
        yield words("text.indices_known")


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


def assumptions(results: Results, words: Words, contacts: Sequence[str]) -> Iterator[Markup]:
    """Yield what the model assumes of blocks, joints, supports and ties; `contacts`: how joints are taken."""
    for key in ("blocks_rigid", "plane", "no_tension"):
        yield words(f"text.{key}")
    yield from joint_law(results, words, "elastic" in contacts)
    yield words("text.supports_rigid")
    yield from tie_assumptions(results, words, contacts)


def joint_law(results: Results, words: Words, elastic: bool) -> Iterator[Markup]:
    """Yield the sentences on joints: how they are found, press, crush, slide and meet; `elastic`: whether any is."""
    yield words("text.joints")
    yield from _bed(results.echo, words) if elastic else [words("text.rigid_joints")]
    strengths = [joint.compressive_strength_kN_m2 for joint in results.geometry.joints]
    limits = sorted({each for each in strengths if each is not None})
    strength = "; ".join(told("compressive_strength_kN_m2", each, words) for each in limits)
    key = "no_strength" if not limits else "some_strength" if None in strengths else "strength"
    yield words(f"text.{key}", strength=strength)
    pressed = edge_pressures(results)
    if pressed and bounded(pressed):
        most = pressed[0]
        yield words(
            "text.greatest_pressure",
            pressure=told("edge_pressure_kN_m2", most.edge_pressure_kN_m2, words),
            state=words.state(most.state),
            first=most.block_a,
            second=most.block_b,
        )
    yield words("text.sliding_coulomb" if coulomb(results.echo) else "text.sliding")
    yield words("text.collisions" if collisions(results.echo) else "text.no_collisions")


def _bed(echo: Echo, words: Words) -> Iterator[Markup]:
    if found := segments(echo):
        yield words("text.bed_points", segments=", ".join(map(str, found)))
    else:
        yield words("text.bed_exact")


def pressure_sentences(results: Results, words: Words) -> Markup:
    """Return what the table of the report holds, or why it is left out; nothing where no forces are known."""
    found = edge_pressures(results)
    if not found:
        return Markup("")
    if not bounded(found):
        return words("text.unbounded_pressures")
    sentences = [
        words("text.edge_pressures"),
        words("text.edge_pressures_printed", count=printed_joints(results))
        if len(found) > printed_joints(results)
        else "",
        words("text.crushing") if crushes(results) else "",
    ]
    return Markup(" ").join(each for each in sentences if each)


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


PLACES = 2  # of a displacement in mm: what is less is none that a drawing shows
ONSET = 0.01  # of α_0: an onset below it by more closes hinges first
NEAR = 0.9  # of α_0: an earlier peak above it is reported


def onsets(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each curve that begins, at `alpha_onset`, by closing hinges of the settlement.

    As drawn there are none; blocks that meet others are a warning.
    """
    for name, direction, rigid in sorted(mechanisms(results), key=lambda each: each[1]):
        if name == ORIGINAL or rigid.alpha_onset >= (1.0 - ONSET) * rigid.alpha_0:
            continue
        alpha = rigid.curve.multiplier
        peak = alpha.index(max(alpha))
        yield words(
            "text.onset",
            state=words.state(name),
            direction=direction_name(direction),
            onset=words.show(rigid.alpha_onset),
            least=words.show(min(alpha[: peak + 1])),
            near=_near(rigid, peak, words),
            alpha_0=words.show(rigid.alpha_0),
            place=_place(rigid, peak, words),
        )


def _near(rigid: RigidPush, peak: int, words: Words) -> Markup:
    """Return where the multiplier has come near α_0 before it is largest; nothing where it has not."""
    earlier = _first_peak(rigid.curve.multiplier[: peak + 1])
    if earlier is None:
        return Markup("")
    near = words.show(rigid.curve.multiplier[earlier])
    return words("text.onset_near", near=near, place=_place(rigid, earlier, words))


def _first_peak(alpha: Sequence[float]) -> int | None:
    """Return the first peak of a curve that ends at its largest multiplier and comes near that; None without one."""
    inner = (
        point for point in range(1, len(alpha) - 1) if alpha[point - 1] < alpha[point] > alpha[point + 1]
    )
    return next((point for point in inner if alpha[point] >= NEAR * alpha[-1]), None)


def _place(rigid: RigidPush, point: int, words: Words) -> str:
    place = words.rounded(1000.0 * abs(rigid.curve.displacement_m[point]), PLACES)
    return f"= {place}" if place != "0" else f"< {words.comma(f'{10.0**-PLACES:g}')}"


def lost_before_zero(results: Results, words: Words) -> Iterator[Markup]:
    """Yield the states whose d_0 is not where α vanishes: they lose equilibrium before, at an α that is left."""
    found = [
        words(
            "text.lost_at",
            state=words.state(name),
            direction=direction_name(direction),
            alpha=words.show(left),
        )
        for name, direction, rigid in mechanisms(results)
        if (left := alpha_at_d_0(rigid)) is not None
    ]
    if found:
        yield words("text.lost_before_zero", where=Markup("; ").join(found))


def fitted_above(results: Results, words: Words) -> Iterator[Markup]:
    """Yield where the fitted curve lies far above the elastic one at a displacement that is checked."""
    found = list(excesses(results))
    if not found:
        return
    listed = [
        words(
            "text.fitted_above_at",
            state=words.state(each.state),
            direction=direction_name(each.direction),
            limit=each.limit_state,
            fitted=each.fitted_g,
            elastic=each.elastic_g,
        )
        for each in found
    ]
    least = min(math.sqrt(each.elastic_g / each.fitted_g) for each in found)
    yield words("text.fitted_above", where=Markup("; ").join(listed), factor=words.number(least, 2))


SOLVERS_AGREE = 1e-4  # relative: less between two programs is no finding


def second_solver(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was compared and with what, or why nothing was; nothing without rigid curves."""
    rigid = [each for _, _, each in mechanisms(results)]
    if any(each.second_solver for each in rigid):
        yield words("text.second_solver", version=results.software.packages.get("scipy", ""))
        coulomb = any(each.sliding == "coulomb" for each in rigid)
        yield words("text.second_solver_coulomb" if coulomb else "text.second_solver_alpha_0")
    elif any("second_solver" in each.model_fields_set for each in rigid):
        yield words("text.no_second_solver")


def agreement(results: Results, words: Words) -> Iterator[Markup]:
    """Yield how far the two programs are apart at most, and where one of them has no result."""
    found = [each.second_solver for _, _, each in mechanisms(results) if each.second_solver]
    known = [abs(each.relative_difference) for each in found if each.relative_difference is not None]
    if known:
        agree = max(known) <= SOLVERS_AGREE
        key = f"judgement.second_{'agrees' if agree else 'differs'}"
        yield words(key, difference=words.number(max(known), COARSE))
    if len(known) < len(found):
        yield words("judgement.second_missing", count=len(found) - len(known))


NOTICED = 0.01  # of the size of a block, the root of its area


def overlap_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what a penetration is, and the analyses in which the largest is more than a hundredth of a block."""
    size = float(np.median([outline_area(block.vertices_m) ** 0.5 for block in results.geometry.blocks]))
    deep = [row for row in results.quality.by_stage if (row.worst_penetration_m or 0.0) > NOTICED * size]
    if not deep:
        return
    listed = []
    for row in deep:
        stage = ", ".join(words.name("value", part) for part in row.stage.split(", "))
        named = f"{words.state(row.state)}, {stage}" if row.state else stage
        listed.append(f"{named}: {words.millimetres(row.worst_penetration_m)}")
    yield words("text.overlap", where="; ".join(listed))


def identification_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was found, as sentences; nothing without an identification."""
    found = results.identification
    if found is None:
        return
    best = best_of(found)
    if best is None:
        yield words("text.identification_none")
        return
    told = told_of(found)
    yield words("text.identification_best", hypothesis=translated(best.hypothesis, words), aic=best.aic)
    if best.probability is not None and best.probability < UNLIKELY:
        yield words("text.identification_poor", probability=best.probability)
    for other in told[1:]:
        yield words("text.identification_alike", hypothesis=translated(other.hypothesis, words))
    for each in told:
        name = translated(each.hypothesis, words)
        for text in each.undetermined:
            yield words("text.identification_open", hypothesis=name, movement=translated(text, words))
        if each.contradicting:
            yield words(
                "text.identification_contradicting", hypothesis=name, names="; ".join(each.contradicting)
            )
        if each.at_collapse:
            yield words("text.identification_collapse", hypothesis=name)
    if not found.settlements:
        yield words("text.identification_several")


def ready_lines(results: Results, words: Words) -> str:
    """Return the lines of the best movement for the project file, none where there are none.

    A comment heads those of a movement that does not explain the measurements.
    """
    found = results.identification
    best = best_of(found) if found else None
    if found is None or best is None or not found.settlements:
        return ""
    lines = ["\n".join(settlement_lines(each)) for each in found.settlements]
    heading = [] if fits(best) else [f"# {words.plain('text.identification_unfit')}"]
    return "\n".join([*heading, "\n\n".join(lines)])


def vertical_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what became of the vertical component, and why, where there is a check against a demand."""
    demand = (results.spectra or {}).get("SLV")
    if demand is None:
        return
    a_g, least = words.show(demand.a_g_g), words.comma(f"{THRUSTING_A_G:g}")
    if demand.kind == "record":
        yield words("text.vertical_record")
    elif demand.a_g_g < THRUSTING_A_G:
        yield words("text.vertical_low", a_g=a_g, least=least)
    else:
        done = any(each.vertical for _, _, each in capacities(results))
        yield words("text.vertical" if done else "text.vertical_left_out", a_g=a_g, least=least)
