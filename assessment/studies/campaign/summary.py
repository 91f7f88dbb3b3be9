"""Summary of the combinations of a campaign at one movement: fragility, the standard's value, loss of capacity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assessment.analyses.dynamic.incremental import ENOUGH, Standard, standard_value
from assessment.results.schema.campaign import CampaignFragility, CampaignLoss
from assessment.results.table import reduction
from assessment.studies.campaign.fragility import (
    Lognormal,
    Scatter,
    confidence,
    fit_levels,
    fit_stripes,
    samples_of_records,
)
from mechanics.types import Array

BAND = (0.16, 0.84)  # of the losses of single records: one standard deviation to either side


@dataclass(frozen=True)
class Observed:
    """Result of a record of one sign at one movement. Levels are PGA (g); `ratio` times the PGA is the measure.

    `collapse`: level at which some member collapses, None: none does up to `safe`; both None: not completed. `certain`:
    level at which all members collapse. `fallen`, `all_fallen` (stripes): whether some, or all, collapse at each.
    """

    record: str
    sign: int
    ratio: float
    collapse: float | None
    safe: float | None
    certain: float | None
    fallen: tuple[bool, ...]
    all_fallen: tuple[bool, ...]

    @property
    def failed(self) -> bool:
        """Whether the combination could not be completed."""
        return self.collapse is None and self.safe is None


@dataclass(frozen=True)
class Place:
    """A share of a movement, and its largest component (m)."""

    settlement: str
    share: float
    movement: float


def fragility(
    place: Place, observed: Sequence[Observed], levels: Sequence[float] | None, members: int
) -> CampaignFragility:
    """Fit the lognormal fragility at a place; `levels` (g): of stripes; `members` of each ensemble.

    `median_g` and `beta` refer to the measure at which some member collapses; their ranges are those of the bootstrap.
    Equal levels have β = 0; None: all withstood, or stripes that tell no median (see fit_stripes).
    `beta_ensemble` is the scatter within a combination, from the range of its members (Tippett); `beta_record` is the
    rest of `beta`. `pga_collapse_g` (PGA): by NTC 2018 §7.3.5, with its `rule`; of fewer than three records none.
    """
    known = [each for each in observed if not each.failed]
    standard = _standard(observed) if levels is None else None
    row = CampaignFragility(
        settlement=place.settlement,
        share=place.share,
        movement_m=place.movement,
        combinations=len(observed),
        failed=len(observed) - len(known),
        withstood=sum(each.collapse is None for each in known),
        median_g=None,
        median_range=None,
        beta=None,
        beta_range=None,
        median_all_collapse_g=None,
        beta_record=None,
        beta_ensemble=None,
        rule=standard.rule if standard else None,
        pga_collapse_g=standard.pga if standard and standard.rule else None,
    )
    if not known:
        return row
    fit = _fit(known, levels, np.ones((1, len(known))))
    median, beta = float(fit.median[0]), float(fit.beta[0])
    if not (math.isfinite(median) and math.isfinite(beta)):
        return row
    row = _divided(row.replace(median_g=median, beta=beta), known, levels, members)
    names = list(dict.fromkeys(each.record for each in known))
    if len(names) < ENOUGH:
        return row
    record = np.array([names.index(each.record) for each in known])
    samples = _fit(known, levels, samples_of_records(record))
    return row.replace(median_range=confidence(samples.median), beta_range=confidence(samples.beta))


def _fit(known: Sequence[Observed], levels: Sequence[float] | None, weights: Array) -> Lognormal:
    if levels is not None:
        return fit_stripes(np.array(levels), np.array([each.fallen for each in known]), weights)
    level = np.array([each.ratio * (each.collapse or each.safe or 0.0) for each in known])
    return fit_levels(level, np.array([each.collapse is None for each in known]), weights)


def _divided(
    row: CampaignFragility, known: Sequence[Observed], levels: Sequence[float] | None, members: int
) -> CampaignFragility:
    """Return the fragility with its scatter divided into that within the ensembles and that between the records."""
    if members < 2 or row.median_g is None or row.beta is None:
        return row
    unit = Scatter.of(members)
    if levels is not None:
        certain = np.array([each.all_fallen for each in known])
        of_all = float(fit_stripes(np.array(levels), certain, np.ones((1, len(known)))).median[0])
        if not (0.0 < of_all < math.inf):
            return row
        within = max(0.0, math.log(of_all / row.median_g)) / unit.mean_range
    else:
        ends = [(each.collapse, each.certain) for each in known]
        closed = [math.log(high / low) for low, high in ends if low is not None and high is not None]
        if len(closed) < len(known):
            return row
        of_all = float(np.exp(np.mean([math.log(each.ratio * (each.certain or 0.0)) for each in known])))
        within = float(np.mean(closed)) / unit.mean_range
    left = row.beta**2 - unit.variance_of_smallest * within**2
    return row.replace(
        median_all_collapse_g=of_all, beta_ensemble=within, beta_record=math.sqrt(max(0.0, left))
    )


def _standard(observed: Sequence[Observed]) -> Standard:
    """Return the value by NTC 2018 §7.3.5: each record with its worse sign; mean of seven or more, else the lowest."""
    worse: list[tuple[float | None, float | None]] = []
    for name in dict.fromkeys(each.record for each in observed):
        own = [each for each in observed if each.record == name]
        if any(each.failed for each in own):
            worse.append((None, None))
            continue
        collapse = min((each.collapse for each in own if each.collapse is not None), default=None)
        worse.append((collapse, min(each.safe for each in own if each.safe is not None)))
    return standard_value(worse)


def loss(
    place: Place,
    before: Sequence[Observed],
    after: Sequence[Observed],
    static_before: float | None,
    static_after: float | None,
    levels: Sequence[float] | None,
) -> CampaignLoss:
    """Return the loss of capacity 1 − after/before of a movement, `dynamic` beside `static`.

    Searches give the median of the losses of single records, each sign by itself, and their 16-84 %; pairs with a value
    missing are counted in `left_out`. Stripes give the loss of the median, without a range.
    """
    row = CampaignLoss(
        settlement=place.settlement,
        share=place.share,
        movement_m=place.movement,
        dynamic=None,
        dynamic_range=[None, None],
        left_out=0,
        static=reduction(static_before, static_after),
        static_capacity=static_after,
    )
    if levels is not None:
        medians = [fragility(place, each, levels, 1).median_g for each in (before, after)]
        return row.replace(dynamic=reduction(*medians))
    of_before = {(each.record, each.sign): each.collapse for each in before}
    pairs = [(of_before.get((each.record, each.sign)), each) for each in after]
    losses = [
        -math.inf if each.collapse is None else 1.0 - each.collapse / first
        for first, each in pairs
        if first is not None and not each.failed
    ]
    row = row.replace(left_out=len(pairs) - len(losses))
    if not losses:
        return row
    low, middle, high = (_quantile(losses, share) for share in (BAND[0], 0.5, BAND[1]))
    return row.replace(dynamic=middle, dynamic_range=[low, high])


def _quantile(values: Sequence[float], share: float) -> float | None:
    """Return a quantile; None if only an upper bound of it is known."""
    place = share * (len(values) - 1)
    low, high = (sorted(values)[place_of(place)] for place_of in (math.floor, math.ceil))
    if math.isinf(low):
        return None
    return low + (place - math.floor(place)) * (high - low)
