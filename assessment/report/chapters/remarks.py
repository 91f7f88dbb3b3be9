"""Sentences that chapters have where the results call for them; the template calls each by name: `said.onsets`."""

import math
from collections.abc import Iterator, Sequence

from markupsafe import Markup

from assessment.ntc.verification import THRUSTING_A_G
from assessment.report.language import Words, translated
from assessment.report.tables import capacities, structure
from assessment.report.tables.dynamic import shaken
from assessment.report.tables.mechanisms import alpha_at_d_0, excesses
from assessment.report.tables.structure import SEEN, cracks_of, surveyed
from assessment.results import hand_check, summary
from assessment.results.schema import Behaviour, Direction, Results
from assessment.results.summary import UNLIKELY, best_of, fits, settlement_lines, told_of
from assessment.results.table import ORIGINAL

ELASTIC_END = "end of the elastic curve"  # what governs a check
PLACES = 2  # of a displacement in mm: what is less is none that a drawing shows
ONSET = 0.01  # of α_0: an onset below it by more closes hinges first
LEFT = 0.5  # of a pretension: a tie at rest with less tension is reported
SOLVERS_AGREE = 1e-4  # relative: less between two programs is no finding
NOTICED = 0.01  # of the size of a block, the root of its area
RISK = ("abita", "residen", "produtt", "dwelling", "housing", "home")  # uses with classes of D.M. 58/2017
SCHOOL = ("scuol", "scol", "school")  # uses with a threshold of their own (NTC 2018, §8.4.2)

Sentences = Iterator[Markup]


def used_as(results: Results, kinds: Sequence[str]) -> bool:
    """Return whether the use of the building is one of some kinds."""
    return any(kind in results.echo.report.get("use", "").lower() for kind in kinds)


def contacts_of(results: Results) -> list[Behaviour]:
    """Return the kinds of contact of which there is any curve."""
    found: set[Behaviour] = set()
    for state in results.states.values():
        found.update(state.pushdown, *(pushover.by_contacts for pushover in state.pushover.values()))
    kinds: tuple[Behaviour, ...] = ("rigid", "elastic")
    return [contacts for contacts in kinds if contacts in found]


def members(results: Results) -> int:
    """Return how many motions an ensemble of the project may have: 1 where each is run once."""
    several = [entry.members or 1 for state in results.states.values() for entry in state.history]
    return max([results.echo.scatter or 1, *several])


def few_records(results: Results) -> dict[str, bool]:
    """Return where fewer records than NTC 2018, §7.3.5, asks for leave something out, by what it is left out of."""
    moved = shaken(results, "campaign")
    searched = [each for each in moved if each.campaign and each.campaign.method == "incremental"]
    return {
        "campaign": any(not each.fit.rule for each in searched),
        "interval": any(each.fit.median_g is not None and each.fit.median_range is None for each in moved),
        "incremental": any(not each.fit.rule for each in shaken(results, "incremental")),
    }


def assumptions(results: Results, words: Words) -> Sentences:
    """Yield what the model assumes of blocks, joints, supports and ties."""
    contacts = contacts_of(results)
    yield from (words(f"text.{key}") for key in ("blocks_rigid", "plane", "no_tension"))
    yield from joint_law(results, words, "elastic" in contacts)
    yield words("text.supports_rigid")
    if ties := structure.tie_strength(results):
        yield words("text.ties")
        yield from (words(f"text.ties_{kind}") for kind in contacts)
        if unlimited := [name for name, limit in ties.items() if limit is None]:
            yield words("text.ties_unlimited", ties=", ".join(unlimited))
        yield words("text.ties_unverified")


def joint_law(results: Results, words: Words, elastic: bool) -> Sentences:
    """Yield the sentences on joints: how they are found, press, crush, slide and meet; `elastic`: whether any is."""
    yield words("text.joints")
    if not elastic:
        yield words("text.rigid_joints")
    elif found := summary.segments(results.echo):
        yield words("text.bed_points", segments=", ".join(map(str, found)))
    else:
        yield words("text.bed_exact")
    strengths = [joint.compressive_strength_kN_m2 for joint in results.geometry.joints]
    limits = sorted({each for each in strengths if each is not None})
    strength = "; ".join(words.told("compressive_strength_kN_m2", each) for each in limits)
    key = "no_strength" if not limits else "some_strength" if None in strengths else "strength"
    yield words(f"text.{key}", strength=strength)
    pressed = structure.edge_pressures(results)
    if pressed and structure.bounded(pressed):
        place = {"state": pressed[0].state, "first": pressed[0].block_a, "second": pressed[0].block_b}
        yield words("text.greatest_pressure", pressure=pressed[0].edge_pressure_kN_m2, **place)
    yield words("text.sliding_coulomb" if summary.coulomb(results.echo) else "text.sliding")
    yield words("text.collisions" if summary.collisions(results.echo) else "text.no_collisions")
    if summary.damped(results.echo):
        yield words("text.dashpots")


def strengthened(results: Results, words: Words) -> Sentences:
    """Yield what was done to each state that is strengthened, and when."""
    for name, state in results.states.items():
        if made := state.strengthening:
            before = results.states.get(made.of)
            parts = (("ties", made.ties), ("layers", made.layers))
            done = [words(f"text.strengthened_{key}", names=", ".join(own)) for key, own in parts if own]
            key = "strengthened_after" if before and before.settlement else "strengthened_as_drawn"
            yield words(f"text.{key}", state=name, of=words.state(made.of), done=Markup("; ").join(done))


def cracks(results: Results, words: Words) -> Sentences:
    """Yield what the table of cracks holds, what of it is not among those `printed`, or has no width."""
    yield words("text.cracks", seen=SEEN)
    by_state = [cracks_of(results, state) for state in results.states]
    most = structure.printed(results)
    if any(len(found) > most for found in by_state):
        yield words("text.cracks_printed", printed=most)
    if any(crack.opening_m is None for found in by_state for crack in found[:most]):
        yield words("text.cracks_apart")


def survey(results: Results, words: Words) -> Sentences:
    """Yield how many of the surveyed cracks lie at joints that open or slip in each settled state, and which do not."""
    for state in results.states:
        if found := surveyed(results, state):
            open_ = [each.mark for each in found if not each.seen]
            seen = {"seen": SEEN, "marks": ", ".join(open_)}
            counts = {"count": len(found), "met": len(found) - len(open_)}
            yield words(f"text.survey_{'missing' if open_ else 'met'}", state=state, **counts, **seen)


def pressures(results: Results, words: Words) -> Sentences:
    """Yield what the table of edge pressures holds, or why it is left out; nothing where no forces are known."""
    found = structure.edge_pressures(results)
    if found and not structure.bounded(found):
        yield words("text.unbounded_pressures")
    elif found:
        yield words("text.edge_pressures")
        if len(found) > structure.printed(results):
            yield words("text.edge_pressures_printed", count=structure.printed(results))
        if structure.crushes(results):
            yield words("text.crushing")


def missing_pushovers(results: Results, words: Words) -> Sentences:
    """Yield a sentence for each state without the pushover that another state has."""
    pushed = {direction for state in results.states.values() for direction in state.pushover}
    for direction in sorted(pushed):
        for name, state in results.states.items():
            if direction not in state.pushover:
                yield words("text.missing_pushover", state=name, direction=direction)


def onsets(results: Results, words: Words) -> Sentences:
    """Yield a sentence for each curve that begins, at `alpha_onset`, by closing hinges of the settlement.

    As drawn there are none; blocks that meet others are a warning.
    """
    for name, direction, rigid in sorted(hand_check.mechanisms(results), key=lambda each: each[1]):
        if name == ORIGINAL or rigid.alpha_onset >= (1.0 - ONSET) * rigid.alpha_0:
            continue
        least = min(rigid.curve.multiplier[: rigid.peak + 1])
        numbers = {"onset": rigid.alpha_onset, "alpha_0": rigid.alpha_0}
        numbers["least"] = round(least, 6) + 0.0  # what is left of zero is the residual of the program
        place = words.rounded(1000.0 * abs(rigid.curve.displacement_m[rigid.peak]), PLACES)
        place = f"= {place}" if place != "0" else f"< {words.comma(f'{10.0**-PLACES:g}')}"
        yield words("text.onset", state=name, direction=direction, place=place, **numbers)


def displacement_limits(results: Results, words: Words) -> Sentences:
    """Yield where the displacement limits come from: shares of d_0, a local limit, the end of an elastic curve."""
    given = results.echo.assessment or {}
    yield words(f"text.limits_{given.get('circular', 2019)}")
    checks = [(name, check) for _, _, each in capacities(results) for name, check in each.checks.items()]
    if {"SLV linear", "SLV"} <= {name for name, _ in checks}:
        yield words("text.linear_beside")
    yield from lost_before_zero(results, words)
    if (limit := given.get("local_displacement_limit_m")) is not None:
        reason = given.get("local_displacement_reason") or words.plain("value.no_reason")
        yield words("text.local_limit", limit=limit, reason=reason)
    else:
        lost = []
        for name, direction, rigid in hand_check.mechanisms(results):
            if loss := rigid.local_loss:  # a joint that bears: the local limit of its direction
                at = {"state": name, "direction": direction, "limit": loss.displacement_m}
                if loss.tie is not None:
                    lost.append(words("text.broken_tie_at", tie=loss.tie, longest=loss.longest_m, **at))
                    continue
                first, second = loss.blocks
                blocks = {"first": first, "second": second, "overlap": loss.overlap_m}
                lost.append(words("text.local_loss_at", **blocks, **at))
        if lost:
            yield words("text.local_loss", where=Markup("; ").join(lost))
    if any(ELASTIC_END in (check.governing or "") for _, check in checks):
        yield words("text.elastic_end")


def lost_before_zero(results: Results, words: Words) -> Sentences:
    """Yield the states whose d_0 is not where α vanishes: they lose equilibrium before, at an α that is left."""
    found = [
        words("text.lost_at", state=name, direction=direction, alpha=left)
        for name, direction, rigid in hand_check.mechanisms(results)
        if (left := alpha_at_d_0(rigid)) is not None
    ]
    if found:
        yield words("text.lost_before_zero", where=Markup("; ").join(found))


def fitted_above(results: Results, words: Words) -> Sentences:
    """Yield where the fitted curve lies far above the elastic one at a displacement that is checked."""
    if found := list(excesses(results)):
        listed = [words("text.fitted_above_at", **each) for each in found]
        least = min(math.sqrt(each["elastic_g"] / each["fitted_g"]) for each in found)
        yield words("text.fitted_above", where=Markup("; ").join(listed), factor=words.number(least, 2))


def vertical(results: Results, words: Words) -> Sentences:
    """Yield what became of the vertical component, and why, where there is a check against a demand."""
    if demand := (results.spectra or {}).get("SLV"):
        done = any(each.vertical for _, _, each in capacities(results))
        key = "vertical" if done else "vertical_left_out"
        if demand.kind == "record":
            key = "vertical_record"
        elif demand.a_g_g < THRUSTING_A_G:
            key = "vertical_low"
        yield words(f"text.{key}", a_g=demand.a_g_g, least=words.comma(f"{THRUSTING_A_G:g}"))


def indices(results: Results, words: Words) -> Sentences:
    """Yield what the indices of the tables are: those that need a return period only where one is known."""
    yield words("text.indices")
    if any(each.I_S is not None for each in summary.determined_indices(results).values()):
        yield words("text.indices_known")


def yielding(results: Results, words: Words) -> Sentences:
    """Yield which ties yield on the way to the activation of a mechanism, or at it."""
    found: dict[str, dict[str, float]] = {}
    for where, each in structure.tensions(results):
        if each.yields and "direction" in where:
            found.setdefault(each.tie, {})[words.at(*where.values())] = each.lengthening_m
    for tie, places in found.items():
        yield words("text.tie_yields", tie=tie, where="; ".join(places), most=max(places.values()))


def slackened(results: Results, words: Words) -> Sentences:
    """Yield how much of its pretension is left to each tie that has lost most of it before the push."""
    given = {tie.name: tie.pretension_kN for tie in results.model.ties or ()}
    left = {
        (each.tie, where["state"]): each.rest_kN
        for where, each in structure.tensions(results)
        if where.get("direction") and where["contacts"] == "elastic"
        if each.rest_kN is not None and each.rest_kN < LEFT * given[each.tie]
    }
    for (tie, state), rest in left.items():
        forces = {"pretension": given[tie], "rest": words.rounded(rest, 2)}
        yield words("text.tie_slackened", tie=tie, state=state, **forces)


def second_solver(results: Results, words: Words) -> Sentences:
    """Yield what was compared and with what, or why nothing was; nothing without rigid curves."""
    rigid = [each for _, _, each in hand_check.mechanisms(results)]
    if any(each.second_solver for each in rigid):
        yield words("text.second_solver", version=results.software.packages.get("scipy", ""))
        law = any(each.sliding == "coulomb" for each in rigid)
        yield words("text.second_solver_coulomb" if law else "text.second_solver_alpha_0")
    elif any("second_solver" in each.model_fields_set for each in rigid):
        yield words("text.no_second_solver")


def agreement(results: Results, words: Words) -> Sentences:
    """Yield how far the two programs are apart at most, and where one of them has no result."""
    found = [each.second_solver for _, _, each in hand_check.mechanisms(results) if each.second_solver]
    known = [abs(each.relative_difference) for each in found if each.relative_difference is not None]
    if known:
        key = f"judgement.second_{'agrees' if max(known) <= SOLVERS_AGREE else 'differs'}"
        yield words(key, difference=max(known))
    if len(known) < len(found):
        yield words("judgement.second_missing", count=len(found) - len(known))


def worked_by_hand(results: Results) -> list[tuple[str, Direction]]:
    """Return state and direction of the mechanisms whose macro-blocks are printed: in short annexes that governs."""
    if results.echo.report.get("annexes") == "full":
        return hand_check.governing_mechanisms(results)
    return [*filter(None, [hand_check.governing_view(results)])]


def too_many(results: Results, words: Words, most: int = hand_check.BY_HAND) -> Sentences:
    """Yield a sentence for each mechanism of more macro-blocks than a hand works out, which are `most`."""
    for name, direction in worked_by_hand(results):
        count = len(hand_check.macro_blocks(results, name, direction))
        if count > most:
            yield words("text.many_macro_blocks", count=count, state=name, direction=direction)


def overlaps(results: Results, words: Words) -> Sentences:
    """Yield what a penetration is, and the analyses in which the largest is more than a hundredth of a block."""
    least = NOTICED * hand_check.block_size(results)
    listed = []
    for row in results.quality.by_stage:
        if (row.worst_penetration_m or 0.0) > least:
            stage = ", ".join(words.name("value", part) for part in row.stage.split(", "))
            named = f"{words.state(row.state)}, {stage}" if row.state else stage
            listed.append(f"{named}: {words.told('worst_penetration_m', row.worst_penetration_m)}")
    if listed:
        yield words("text.overlap", where="; ".join(listed))


def identified(results: Results, words: Words) -> Sentences:
    """Yield what was found, as sentences; nothing without an identification."""
    found = results.identification
    best = best_of(found) if found else None
    if found is None or best is None:
        yield from [words("text.identification_none")] if found else []
        return
    alike = told_of(found)
    yield words("text.identification_best", hypothesis=translated(best.hypothesis, words), aic=best.aic)
    if best.probability is not None and best.probability < UNLIKELY:
        yield words("text.identification_poor", probability=best.probability)
    for other in alike[1:]:
        yield words("text.identification_alike", hypothesis=translated(other.hypothesis, words))
    for each in alike:
        name = translated(each.hypothesis, words)
        for text in each.undetermined:
            yield words("text.identification_open", hypothesis=name, movement=translated(text, words))
        if each.contradicting:
            names = "; ".join(each.contradicting)
            yield words("text.identification_contradicting", hypothesis=name, names=names)
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
