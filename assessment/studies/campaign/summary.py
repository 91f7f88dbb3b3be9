"""What the combinations of a campaign sum up to at one movement: fragility, the standard's value, loss of capacity."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.dynamic.fragility import (
    ENOUGH,
    SAMPLES,
    Dispersion,
    RecordLevel,
    Standard,
    band_of,
    confidence,
    fit_stripes,
    over_records,
    samples_of_records,
    standard_value,
)
from assessment.results.schema.dynamic import CampaignFragility, CampaignLoss, Loss
from assessment.results.table import reduction
from assessment.studies.campaign.movements import Moved
from assessment.studies.campaign.scans import Asked, Scans, observed_in

if TYPE_CHECKING:
    from assessment.analyses.dynamic.record_set import Measures
    from assessment.project.schema import CampaignTable
    from assessment.results.schema.dynamic import CampaignCombination, Scanned

RESAMPLED = 7  # seed of what levels of a record are known to, in the bootstrap of a loss


def fragility_of(
    state: Moved,
    own: Sequence[tuple[Asked, CampaignCombination]],
    scans: Scans,
    table: CampaignTable,
    measures: Measures,
    ratios: Mapping[str, Mapping[str, float]],
) -> CampaignFragility:
    """Return the fragility of a state and its `own` rows, of the measure; of few records without ranges and rule."""
    known = [(each, row) for each, row in own if row.reason is None]
    levels = record_levels([(each.record, row) for each, row in known])
    rule = None if table.levels_g else standard_of([row for _, row in own])
    fit = None
    if table.levels_g:
        fit = _of_stripes([each for each, _ in known], scans, table.levels_g)
    elif known and len(levels) == len(known):
        by_measure = [
            replace(x, level=x.level * each.ratio) for (each, _), x in zip(known, levels, strict=True)
        ]
        fit = over_records(by_measure)
    numbers = fitted(fit)
    if table.levels_g:
        numbers |= {"beta_record": None, "beta_ensemble": None}
    return CampaignFragility(
        settlement=state.settlement,
        share=state.share,
        movement_m=state.movement,
        combinations=len(own),
        failed=len(own) - len(known),
        withstood=sum(row.lowest_collapse_g is None for _, row in known),
        beta=fit.beta if fit else None,
        measures=measures.fits(levels, ratios) if fit and not table.levels_g else [],
        rule=rule.rule if rule else None,
        pga_collapse_g=rule.pga if rule and rule.rule else None,
        **numbers,
    )


def fitted(fit: Dispersion | None) -> dict[str, Any]:
    """Return the keys that the fragilities of [incremental] and [campaign] share; null without a fit."""
    names = (
        "median_g",
        "median_range",
        "beta_range",
        "beta_record",
        "beta_ensemble",
        "level_16_g",
        "level_84_g",
    )
    if fit is None:
        return dict.fromkeys(names) | {"band": []}
    low, high = fit.probable if fit.beta < math.inf else (None, None)
    told = (fit.median, fit.median_range, fit.beta_range, fit.beta_record, fit.beta_ensemble, low, high)
    return dict(zip(names, told, strict=True)) | {"band": [list(each) for each in fit.band]}


def record_levels(parts: Sequence[tuple[str, Scanned]]) -> list[RecordLevel]:
    """Return the 50 % levels of records and signs that were completed; lower bounds where none collapses."""
    return [
        RecordLevel(record, level, part.level_50_g is None, part.beta or 0.0)
        for record, part in parts
        if part.reason is None and (level := part.level_50_g or part.pga_safe_g)
    ]


def _of_stripes(known: Sequence[Asked], scans: Scans, levels: Sequence[float]) -> Dispersion | None:
    """Return the fit of stripes: of each record the share of its motions that collapse at each level.

    None: the outcomes tell no median (see fit_stripes).
    """
    if not known:
        return None
    fallen = np.array(
        [[point.members_collapsed / point.members for point in scans.of(each).points] for each in known]
    )
    fit = fit_stripes(np.array(levels), fallen, np.ones((1, len(known))))
    median, beta = float(fit.median[0]), float(fit.beta[0])
    if not (0.0 < median < math.inf and math.isfinite(beta)):
        return None
    names = list(dict.fromkeys(each.record for each in known))
    if len(names) < ENOUGH:
        return Dispersion(median, beta, beta, 0.0, None, None)
    weights = samples_of_records(np.array([names.index(each.record) for each in known]))
    samples = fit_stripes(np.array(levels), fallen, weights)
    ranges = confidence(samples.median), confidence(samples.beta)
    return Dispersion(median, beta, beta, 0.0, *ranges, band_of(samples.median, samples.beta))


def standard_of(rows: Sequence[CampaignCombination]) -> Standard:
    """Return the value by NTC 2018 §7.3.5: each record with its worse sign; mean of seven or more, else the lowest."""
    worse: list[tuple[float | None, float | None]] = []
    for name in dict.fromkeys(row.record for row in rows):
        own = [row for row in rows if row.record == name]
        if any(row.reason is not None for row in own):
            worse.append((None, None))
            continue
        collapse = min((row.pga_collapse_g for row in own if row.pga_collapse_g is not None), default=None)
        worse.append((collapse, min(row.pga_safe_g for row in own if row.pga_safe_g is not None)))
    return standard_value(worse)


def within_records(betas: Iterable[float | None]) -> float:
    """Return β of the levels of one record over all states, given those of each: how far a single level is known."""
    found = [beta for beta in betas if beta is not None]
    return math.sqrt(sum(beta**2 for beta in found) / len(found)) if found else 0.0


def loss_of(
    state: Moved,
    base: Moved | None,
    asked: Sequence[Asked],
    scans: Scans,
    beta: float,
    fits: Mapping[Moved, CampaignFragility],
) -> CampaignLoss:
    """Return the loss of capacity 1 − after/before of a movement against its `base`, dynamic beside static.

    Scans give the median over records and signs of the losses of 50 % levels, at one time step; its range is that of
    the bootstrap over records, with what each level is known to (`beta`: of the levels of one record). Pairs with a
    value missing are counted in `left_out`. Stripes give the loss of the median, without a range.
    """
    own, before = ([each for each in asked if each.state is of] for of in (state, base))
    loss = Loss(dynamic=None, dynamic_range=[None, None], distinguishable=None, left_out=0)
    if base is not None and own and own[0].reach.stripes:
        loss = loss.replace(dynamic=reduction(fits[base].median_g, fits[state].median_g))
    elif base is not None:
        loss = paired_loss(list(zip(before, own, strict=True)), scans, beta)
        if state is base:
            loss = loss.replace(dynamic_range=[0.0, 0.0])
    return CampaignLoss(
        settlement=state.settlement,
        share=state.share,
        movement_m=state.movement,
        static=reduction(base.static, state.static) if base else None,
        static_capacity=state.static,
        **{name: getattr(loss, name) for name in Loss.model_fields},
    )


def paired_loss(pairs: Sequence[tuple[Asked, Asked]], scans: Scans, beta: float) -> Loss:
    """Return the median loss of `pairs`, before and after, with its range; see loss_of."""
    names, changes, errors = [], [], []
    for both in pairs:
        before, after = (observed_in(scan) for scan in scans.paired(*both))
        if before.middle is None or not (after.middle or after.safe):
            continue
        names.append(both[0].record)
        changes.append(math.log(after.middle / before.middle) if after.middle else math.inf)
        errors.append(math.hypot(before.known_to(beta), after.known_to(beta)))
    left_out = len(pairs) - len(names)
    if not names:
        return Loss(dynamic=None, dynamic_range=[None, None], distinguishable=None, left_out=left_out)
    records = list(dict.fromkeys(names))
    weights = np.ones((1, len(names)), dtype=int)
    if len(records) >= ENOUGH:
        weights = samples_of_records(np.array([records.index(name) for name in names])).astype(int)
    random = np.random.default_rng(RESAMPLED)
    noise = random.standard_normal((SAMPLES, len(names))) * errors + changes
    medians = [
        float(np.median(np.repeat(values, weights[k % len(weights)]))) for k, values in enumerate(noise)
    ]
    low, high = (_lost(value) for value in np.quantile(medians, [0.975, 0.025], method="nearest"))
    unmoved = all(one is other for one, other in pairs)
    return Loss(
        dynamic=_lost(float(np.median(changes))),
        dynamic_range=[low, high],
        distinguishable=None if unmoved or low is None or high is None else not low <= 0.0 <= high,
        left_out=left_out,
    )


def _lost(change: float) -> float | None:
    """Return the loss of a change of ln level; None where only an upper bound of it is known."""
    return None if math.isinf(change) else 1.0 - math.exp(change)
