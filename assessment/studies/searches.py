"""What the scans of records sum up to: fragility, the standard's value, loss of capacity; the incremental analysis."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from assessment.analyses import fragility
from assessment.analyses.found import accuracy_of, as_part
from assessment.analyses.fragility import Measures
from assessment.analyses.time_history import MotionInputs, Start
from assessment.project.motions import BaseMotion
from assessment.project.schema import ORIGINAL, CampaignTable
from assessment.results.schema import ConvergenceRow, dynamic
from assessment.results.table import reduction
from assessment.studies.scans import (
    Asked,
    Scans,
    asked_for,
    mirror_image,
    numbers,
    observed_in,
    own_setting,
    reach_of,
)
from assessment.studies.variants import Study
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.types import Array

RESAMPLED = 7  # seed of what levels of a record are known to, in the bootstrap of a loss


@dataclass(frozen=True, eq=False)
class Moved:
    """A share of a movement: its largest component, assembly, state at rest or why there is none, static capacity.

    `static_capacity`: PGA at the surface (g) of the check, or α where there is none, of the weaker direction;
    `ultimate` and `d_0_m` (m): control displacements at which it vanishes in both directions, and in the first. None:
    not known.
    """

    settlement: str
    share: float
    movement_m: float
    model: Assembly
    start: Start
    static_capacity: float | None
    ultimate: float | None
    d_0_m: float | None

    @property
    def title(self) -> Message:
        """The state, for messages."""
        return moved_title(self.settlement, self.share)


def moved_title(settlement: str, share: float) -> Message:
    """Return the beginning of messages about the state after a share of a movement."""
    return message("{state} × {share:g}", state=settlement, share=share)


def fragility_of(
    state: Moved,
    own: Sequence[tuple[Asked, dynamic.CampaignCombination]],
    scans: Scans,
    table: CampaignTable,
    measures: Measures,
) -> dynamic.CampaignFragility:
    """Return the fragility of a state and its `own` rows, of the measure; of few records without ranges and rule."""
    known = [(each, row) for each, row in own if row.reason is None]
    levels = record_levels([(each.record, row) for each, row in known])
    rule = None if table.levels_g else standard_of([(each.record, row) for each, row in own])
    fit = None
    if table.levels_g:
        fit = _of_stripes([each for each, _ in known], scans, table.levels_g)
    elif known and len(levels) == len(known):
        ratio = (each.ratio for each, _ in known)
        fit = fragility.over_records(
            [replace(x, level=x.level * by) for by, x in zip(ratio, levels, strict=True)]
        )
    numbers = fitted(fit)
    if table.levels_g:
        numbers |= {"beta_record": None, "beta_ensemble": None}
    return as_part(
        dynamic.CampaignFragility, state, combinations=len(own), failed=len(own) - len(known),
        withstood=sum(row.lowest_collapse_g is None for _, row in known), beta=fit.beta if fit else None,
        measures=measures.fits(levels) if fit and not table.levels_g else [],
        rule=rule.rule if rule else None, pga_collapse_g=rule.pga if rule and rule.rule else None, **numbers,
    )  # fmt: skip


def fitted(fit: fragility.Dispersion | None) -> dict[str, Any]:
    """Return the keys that the fragilities of [incremental] and [campaign] share; null without a fit."""
    alike = ("median_range", "beta_range", "beta_record", "beta_ensemble")
    low, high = fit.probable if fit and fit.beta < math.inf else (None, None)
    found: dict[str, Any] = {"median_g": fit.median if fit else None, "level_16_g": low, "level_84_g": high}
    found |= {name: getattr(fit, name, None) for name in alike}
    return found | {"band": [list(each) for each in fit.band] if fit else []}


def record_levels(parts: Sequence[tuple[str, dynamic.Scanned]]) -> list[fragility.RecordLevel]:
    """Return the 50 % levels of records and signs that were completed; lower bounds where none collapses."""
    return [
        fragility.RecordLevel(record, level, part.level_50_g is None, part.beta or 0.0)
        for record, part in parts
        if part.reason is None and (level := part.level_50_g or part.pga_safe_g)
    ]


def _of_stripes(known: Sequence[Asked], scans: Scans, levels: Sequence[float]) -> fragility.Dispersion | None:
    """Return the fit of stripes, of each record the share of its motions that collapse at a level; None: no median."""
    if not known:
        return None
    fallen = _shares(known, scans)
    fit = fragility.fit_stripes(np.array(levels), fallen, np.ones((1, len(known))))
    median, beta = float(fit.median[0]), float(fit.beta[0])
    if not (0.0 < median < math.inf and math.isfinite(beta)):
        return None
    weights = fragility.samples_of_records([each.record for each in known])
    if weights is None:
        return fragility.Dispersion(median, beta, beta, 0.0, None, None)
    samples = fragility.fit_stripes(np.array(levels), fallen, weights)
    ranges = fragility.confidence(samples.median), fragility.confidence(samples.beta)
    return fragility.Dispersion(
        median, beta, beta, 0.0, *ranges, fragility.band_of(samples.median, samples.beta)
    )


def _shares(known: Sequence[Asked], scans: Scans) -> Array:
    """Return the shares (n, k) of motions that collapse at each level of the stripes."""
    points = (scans.of(each).points for each in known)
    return np.array([[point.members_collapsed / point.members for point in own] for own in points])


def standard_of(parts: Sequence[tuple[str, dynamic.Scanned]]) -> fragility.Standard:
    """Return the value by NTC 2018 §7.3.5: each record with its worse sign; mean of seven or more, else the lowest.

    `parts`: records and signs. A record of which a sign was not completed decides nothing.
    """
    by_record: dict[str, list[dynamic.Scanned]] = {}
    for record, part in parts:
        by_record.setdefault(record, []).append(part)
    signs = [[] if any(part.reason is not None for part in own) else own for own in by_record.values()]

    def least(levels: Iterable[float | None]) -> float | None:
        return min((level for level in levels if level is not None), default=None)

    ends = ((least(p.pga_collapse_g for p in own), least(p.pga_safe_g for p in own)) for own in signs)
    return fragility.standard_value(list(ends))


def loss_of(
    state: Moved, base: Moved | None, asked: Sequence[Asked], scans: Scans, levels: Sequence[float] | None
) -> dynamic.CampaignLoss:
    """Return the loss of capacity 1 − after/before of a movement against its `base`, dynamic and static."""
    own, before = ([each for each in asked if each.state is of] for of in (state, base))
    loss = UNKNOWN
    if base is not None:
        pairs = list(zip(before, own, strict=True))
        loss = _loss_of_stripes(pairs, scans, levels) if levels else paired_loss(pairs, scans)
        if state is base:
            loss = loss.replace(dynamic_range=[0.0, 0.0])
    static = reduction(base.static_capacity, state.static_capacity) if base else None
    return as_part(dynamic.CampaignLoss, loss, state, static=static)


UNKNOWN = dynamic.Loss(dynamic=None, dynamic_range=[None, None], distinguishable=None, left_out=0)


def paired_loss(pairs: Sequence[tuple[Asked, Asked]], scans: Scans) -> dynamic.Loss:
    """Return the median over `pairs`, before and after, of the losses of 50 % levels, at one time step.

    Its range is that of the bootstrap over records, with what each level is known to where collapse scatters by the
    root of the mean square of the β of all these levels. Pairs with a value missing are counted in `left_out`.
    """
    names, changes, errors = [], [], []
    seen = [tuple(observed_in(scan) for scan in scans.paired(*both)) for both in pairs]
    betas = [each.beta for both in seen for each in both if each.lowest is not None]
    beta = math.sqrt(sum(each**2 for each in betas) / max(len(betas), 1))
    for (one, _), (before, after) in zip(pairs, seen, strict=True):
        if before.middle is None or not (after.middle or after.safe):
            continue
        names.append(one.record)
        changes.append(math.log(after.middle / before.middle) if after.middle else math.inf)
        errors.append(math.hypot(before.known_to(beta), after.known_to(beta)))
    left_out = len(pairs) - len(names)
    if not names:
        return UNKNOWN.replace(left_out=left_out)
    samples = fragility.samples_of_records(names)
    weights = (np.ones((1, len(names))) if samples is None else samples).astype(int)
    random = np.random.default_rng(RESAMPLED)
    noise = random.standard_normal((fragility.SAMPLES, len(names))) * errors + changes
    medians = [float(np.median(np.repeat(each, weights[k % len(weights)]))) for k, each in enumerate(noise)]
    low, high = (_lost(value) for value in np.quantile(medians, [0.975, 0.025], method="nearest"))
    unmoved = all(one is other for one, other in pairs)
    return dynamic.Loss(
        dynamic=_lost(float(np.median(changes))),
        dynamic_range=[low, high],
        distinguishable=None if unmoved or low is None or high is None else not low <= 0.0 <= high,
        left_out=left_out,
    )


def _loss_of_stripes(
    pairs: Sequence[tuple[Asked, Asked]], scans: Scans, levels: Sequence[float]
) -> dynamic.Loss:
    """Return the loss of the median over `pairs`, before and after; its range is that of the bootstrap over records."""
    known = [both for both in pairs if all(each.starts and scans.of(each).reason is None for each in both)]
    loss = UNKNOWN.replace(left_out=len(pairs) - len(known))
    if not known:
        return loss
    samples = fragility.samples_of_records([one.record for one, _ in known])
    weights = np.vstack([np.ones(len(known)), *([] if samples is None else samples)])
    shares = (_shares(own, scans) for own in zip(*known, strict=True))
    medians = (fragility.fit_stripes(np.array(levels), each, weights).median for each in shares)
    # no level collapses: ∞, or all do: 0: only a bound is known
    before, after = (np.where((each > 0.0) & (each < math.inf), each, math.nan) for each in medians)
    lost = 1.0 - after / before
    if not math.isfinite(lost[0]):
        return loss
    loss = loss.replace(dynamic=float(lost[0]))
    if len(lost) == 1 or not np.isfinite(lost).all():
        return loss
    low, high = fragility.confidence(lost[1:])
    assert low is not None and high is not None  # all are finite
    apart = None if all(one is other for one, other in pairs) else not low <= 0.0 <= high
    return loss.replace(dynamic_range=[low, high], distinguishable=apart)


def _lost(change: float) -> float | None:
    """Return the loss of a change of ln level; None where only an upper bound of it is known."""
    return None if math.isinf(change) else 1.0 - math.exp(change)


DIRECTIONS = {1: "+x", -1: "-x"}  # of the load by the sign of the record


@dataclass
class Searched(Study):
    """What the analysis leaves beside what every study does: each state's part, and errors of the time step."""

    states: dict[str, dynamic.Incremental] = field(default_factory=dict)
    errors: list[ConvergenceRow] = field(default_factory=list)


def incremental(inputs: MotionInputs, motions: Sequence[BaseMotion], scans: Scans) -> Searched:
    """Scan every record, of both signs, from every state, and sum them up by state."""
    project, table = inputs.project, inputs.project.incremental
    assert table is not None
    drawn, found = inputs.starts[ORIGINAL, table.contacts][0], Searched()
    tasks = [("", task, 1.0, None) for task in inputs.tasks(table, motions, own_setting(table))]
    asked = asked_for(tasks, tuple(DIRECTIONS), reach_of(project), mirror_image(project, drawn, table))
    scans.settle("incremental", asked, accuracy_of(project).tolerance is None, found)
    found.errors = scans.refine(asked, found)
    measures = Measures.of(project, motions)
    by_state: dict[str, list[Asked]] = {}
    for each in asked:
        by_state.setdefault(each.shaking.state, []).append(each)
        if each.sign == each.run_sign:
            scans.tell(each, f"incremental, {each.record}", found)
    for state, own in by_state.items():
        searches = [_search(both, scans) for both in zip(own[::2], own[1::2], strict=True)]
        found.states[state] = summarise(searches, found.warnings, state, measures)
    for state, own in by_state.items():
        if state != ORIGINAL and (before := by_state.get(ORIGINAL)):
            loss = paired_loss(list(zip(before, own, strict=True)), scans)
            found.states[state] = found.states[state].replace(loss=loss)
    return found


def _search(both: Sequence[Asked], scans: Scans) -> dynamic.Search:
    """Return the row of a record: the numbers of its worse sign, and both signs."""
    signs = []
    for each in both:
        part = dynamic.SignScan(sign=each.sign, **numbers(scans.of(each)))
        if each.run_sign != each.sign:
            part = part.replace(same_as=each.run_sign, runs=0, points=[], counts=None)
        signs.append(part)
    failed = [part for part in signs if part.reason is not None]
    worse = failed[0] if failed else min(signs, key=lambda part: part.pga_collapse_g or float("inf"))
    counted = next(each for each in both if each.sign == worse.sign)
    seen, motion = observed_in(scans.of(counted)), counted.shaking.motion
    shown = numbers(scans.of(counted)) | {"runs": sum(part.runs for part in signs)} | motion.told_vertical
    return dynamic.Search(
        record=motion.name, record_pga_g=motion.pga, sign=None if failed else worse.sign, signs=signs,
        pga_collapse_g_range=None if seen.lowest is None else [seen.capacity, seen.certain],
        seconds=sum(scans.of(each).seconds for each in both if each.sign == each.run_sign), **shown,
    )  # fmt: skip


def summarise(
    records: Sequence[dynamic.Search], warnings: list[Message], state: str, measures: Measures | None = None
) -> dynamic.Incremental:
    """Return mean and lowest PGA at collapse of a state, the value by NTC 2018 §7.3.5, and the fragility."""
    title = message("{state}", state=state)
    if len(records) < fragility.ENOUGH:
        few = message(
            "records of the incremental analysis: {count}; NTC 2018 §7.3.5 asks for at least {least}; "
            "the scatter from record to record is not known", count=len(records), least=fragility.ENOUGH,
        )  # fmt: skip
        warnings.append(headed(title, few))
    signs = [(each.record, part) for each in records for part in each.signs]
    if any(part.same_as is not None for _, part in signs):
        alike = message(
            "a symmetric structure: one sign of each record was run, the other is its mirror image; "
            "motions that turn on their last digits would differ by a few percent"
        )
        warnings.append(headed(title, alike))
    standard = standard_of(signs)
    found = dynamic.Incremental(
        records=list(records), mean_pga_collapse_g=standard.mean, lowest_pga_collapse_g=standard.lowest,
        rule=standard.rule, pga_collapse_g=standard.pga, fragility=_fragility(signs, measures),
        directions={way: standard_of([p for p in signs if p[1].sign == sign]).pga for sign, way in DIRECTIONS.items()},
    )  # fmt: skip
    ends = [each.pga_collapse_g_range[1] for each in records if each.pga_collapse_g_range]
    if not ends:
        return found
    reached = [end for end in ends if end is not None]
    mean = sum(reached) / len(reached) if len(reached) == len(records) else None
    upper = mean if standard.rule == "mean" else min(reached, default=None)
    return found.replace(pga_collapse_g_range=[standard.pga, upper])


def _fragility(
    signs: Sequence[tuple[str, dynamic.SignScan]], measures: Measures | None
) -> dynamic.Fragility | None:
    """Return the fragility of a state over records and signs; None where fewer than two records collapse."""
    levels = record_levels(signs)
    fallen = {each.record for each in levels if not each.withstood}
    fit = fragility.over_records(levels) if len(fallen) > 1 and len(levels) == len(signs) else None
    if fit is None:
        return None
    return dynamic.Fragility(
        dispersion=fit.beta,
        records=len({record for record, _ in signs}),
        censored=sum(each.withstood for each in levels),
        measures=measures.fits(levels) if measures else [],
        **fitted(fit),
    )
