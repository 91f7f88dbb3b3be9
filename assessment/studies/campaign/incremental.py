"""Incremental dynamic analysis: the peak ground acceleration at collapse of each record, sign and state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from assessment.analyses.accuracy import accuracy_of
from assessment.analyses.dynamic.fragility import ENOUGH, over_records, standard_value
from assessment.analyses.dynamic.record_set import Measures
from assessment.project.schema import ORIGINAL
from assessment.results.schema.dynamic import Fragility, Incremental, Search, SignScan
from assessment.results.schema.studies import ConvergenceRow
from assessment.studies.campaign.scans import (
    Asked,
    Scans,
    asked_for,
    mirror_image,
    numbers,
    observed_in,
    own_setting,
    reach_of,
)
from assessment.studies.campaign.summary import fitted, paired_loss, record_levels, within_records
from assessment.studies.variants import Study
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.analyses.dynamic.inputs import MotionInputs
    from assessment.project.motions import BaseMotion

DIRECTIONS = {1: "+x", -1: "-x"}  # of the load by the sign of the record


@dataclass
class Found(Study):
    """What the analysis leaves beside what every study does: each state's part, and errors of the time step."""

    states: dict[str, Incremental] = field(default_factory=dict)
    errors: list[ConvergenceRow] = field(default_factory=list)


def incremental(inputs: MotionInputs, motions: Sequence[BaseMotion], scans: Scans) -> Found:
    """Scan every record, of both signs, from every state, and sum them up by state."""
    project, table = inputs.project, inputs.project.incremental
    assert table is not None
    drawn, found = inputs.starts[ORIGINAL, table.contacts].model, Found()
    tasks = [("", task, 1.0, None) for task in inputs.tasks(table, motions, own_setting(table))]
    asked = asked_for(tasks, tuple(DIRECTIONS), reach_of(project), mirror_image(project, drawn, table))
    scans.settle(
        "incremental", asked, len(DIRECTIONS) if accuracy_of(project).tolerance is None else 0, found
    )
    found.errors = scans.refine(asked, found)
    measures, ratios = Measures(project), Measures(project).of(motions)
    by_state: dict[str, list[Asked]] = {}
    for each in asked:
        by_state.setdefault(each.shaking.state, []).append(each)
        if each.sign == each.run_sign:
            scans.tell(each, f"incremental, {each.record}", found)
    for state, own in by_state.items():
        searches = [_search(both, scans) for both in zip(own[::2], own[1::2], strict=True)]
        found.states[state] = summarise(searches, found.warnings, state, measures, ratios)
    beta = within_records(part.fragility.beta_ensemble for part in found.states.values() if part.fragility)
    for state, own in by_state.items():
        if state != ORIGINAL and (before := by_state.get(ORIGINAL)):
            loss = paired_loss(list(zip(before, own, strict=True)), scans, beta)
            found.states[state] = found.states[state].replace(loss=loss)
    return found


def _search(both: Sequence[Asked], scans: Scans) -> Search:
    """Return the row of a record: the numbers of its worse sign, and both signs."""
    signs = []
    for each in both:
        part = SignScan(sign=each.sign, **numbers(scans.of(each)))
        if each.run_sign != each.sign:
            part = part.replace(same_as=each.run_sign, runs=0, points=[], counts=None)
        signs.append(part)
    failed = [part for part in signs if part.reason is not None]
    worse = failed[0] if failed else min(signs, key=lambda part: part.pga_collapse_g or float("inf"))
    counted = next(each for each in both if each.sign == worse.sign)
    seen, motion = observed_in(scans.of(counted)), counted.shaking.motion
    shown = numbers(scans.of(counted)) | {"runs": sum(part.runs for part in signs)}
    return Search(
        record=motion.name,
        record_pga_g=motion.pga,
        sign=None if failed else worse.sign,
        pga_collapse_g_range=None if seen.lowest is None else [seen.capacity, seen.certain],
        signs=signs,
        seconds=sum(scans.of(each).seconds for each in both if each.sign == each.run_sign),
        **shown,
    )


def summarise(
    records: Sequence[Search],
    warnings: list[Message],
    state: str,
    measures: Measures | None = None,
    ratios: Mapping[str, Mapping[str, float]] | None = None,
) -> Incremental:
    """Return mean and lowest PGA at collapse of a state, the value by NTC 2018 §7.3.5, and the fragility.

    `ratios`: of each record, other measures of intensity over its PGA.
    """
    title = message("{state}", state=state)
    if len(records) < ENOUGH:
        few = message(
            "records of the incremental analysis: {count}; NTC 2018 §7.3.5 asks for at least {least}; "
            "the scatter from record to record is not known",
            count=len(records),
            least=ENOUGH,
        )
        warnings.append(headed(title, few))
    signs = [(each.record, part) for each in records for part in each.signs]
    if any(part.same_as is not None for _, part in signs):
        alike = message(
            "a symmetric structure: one sign of each record was run, the other is its mirror image; "
            "motions that turn on their last digits would differ by a few percent"
        )
        warnings.append(headed(title, alike))
    standard = standard_value([(each.pga_collapse_g, each.pga_safe_g) for each in records])
    by_sign = {
        sign: standard_value([(p.pga_collapse_g, p.pga_safe_g) for _, p in signs if p.sign == sign]).pga
        for sign in DIRECTIONS
    }
    found = Incremental(
        records=list(records),
        mean_pga_collapse_g=standard.mean,
        lowest_pga_collapse_g=standard.lowest,
        rule=standard.rule,
        pga_collapse_g=standard.pga,
        directions={DIRECTIONS[sign]: pga for sign, pga in by_sign.items()},
        fragility=_fragility(signs, measures, ratios or {}),
    )
    ends = [each.pga_collapse_g_range[1] for each in records if each.pga_collapse_g_range]
    if not ends:
        return found
    reached = [end for end in ends if end is not None]
    upper = min(reached, default=None)
    if standard.rule == "mean":
        upper = sum(reached) / len(reached) if len(reached) == len(records) else None
    return found.replace(pga_collapse_g_range=[standard.pga, upper])


def _fragility(
    signs: Sequence[tuple[str, SignScan]],
    measures: Measures | None,
    ratios: Mapping[str, Mapping[str, float]],
) -> Fragility | None:
    """Return the fragility of a state over records and signs; None where fewer than two records collapse."""
    levels = record_levels(signs)
    fallen = {each.record for each in levels if not each.withstood}
    fit = over_records(levels) if len(fallen) > 1 and len(levels) == len(signs) else None
    if fit is None:
        return None
    return Fragility(
        dispersion=fit.beta,
        records=len({record for record, _ in signs}),
        censored=sum(each.withstood for each in levels),
        measures=measures.fits(levels, ratios) if measures else [],
        **fitted(fit),
    )
