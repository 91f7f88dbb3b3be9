"""Summary of the combinations of a campaign at one movement: fragility, the standard's value, loss of capacity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from assessment.analyses.dynamic.incremental import ENOUGH, standard_value
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

Numbers = dict[str, Any]

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


def fragility(observed: Sequence[Observed], levels: Sequence[float] | None, members: int) -> Numbers:
    """Fit the lognormal fragility of a movement; `levels` (g): of stripes; `members` of each ensemble.

    `median_g` and `beta` refer to the measure at which some member collapses; their ranges are those of the bootstrap.
    `beta_ensemble` is the scatter within a combination, from the range of its members (Tippett); `beta_record` is the
    rest of `beta`. `pga_collapse_g` (PGA): the value by NTC 2018 §7.3.5, with its `rule`.
    """
    known = [each for each in observed if not each.failed]
    row: Numbers = {
        "combinations": len(observed),
        "failed": len(observed) - len(known),
        "withstood": sum(each.collapse is None for each in known),
    }
    row |= dict.fromkeys(
        ("median_g", "beta", "median_range", "beta_range", "median_all_collapse_g", "beta_record",
         "beta_ensemble")
    )  # fmt: skip
    if known:
        names = list(dict.fromkeys(each.record for each in known))
        record = np.array([names.index(each.record) for each in known])
        whole = np.ones((1, len(known)))
        fit = _fit(known, levels, whole)
        median, beta = float(fit.median[0]), float(fit.beta[0])
        if math.isfinite(median) and math.isfinite(beta) and beta > 0.0:
            row |= {"median_g": median, "beta": beta} | _scatter(known, levels, members, median, beta)
            if len(names) >= ENOUGH:
                samples = _fit(known, levels, samples_of_records(record))
                row |= {
                    "median_range": confidence(samples.median),
                    "beta_range": confidence(samples.beta),
                }
    return row | (_standard(observed) if levels is None else {"rule": None, "pga_collapse_g": None})


def _fit(known: Sequence[Observed], levels: Sequence[float] | None, weights: Array) -> Lognormal:
    if levels is not None:
        return fit_stripes(np.array(levels), np.array([each.fallen for each in known]), weights)
    level = np.array([each.ratio * (each.collapse or each.safe or 0.0) for each in known])
    return fit_levels(level, np.array([each.collapse is None for each in known]), weights)


def _scatter(
    known: Sequence[Observed], levels: Sequence[float] | None, members: int, median: float, beta: float
) -> Numbers:
    """Divide the scatter into that within the ensembles and that between the records."""
    if members < 2:
        return {}
    unit = Scatter.of(members)
    if levels is not None:
        certain = np.array([each.all_fallen for each in known])
        of_all = float(fit_stripes(np.array(levels), certain, np.ones((1, len(known)))).median[0])
        if not (0.0 < of_all < math.inf):
            return {}
        within = max(0.0, math.log(of_all / median)) / unit.mean_range
    else:
        ends = [(each.collapse, each.certain) for each in known]
        closed = [math.log(high / low) for low, high in ends if low is not None and high is not None]
        if len(closed) < len(known):
            return {}
        of_all = float(np.exp(np.mean([math.log(each.ratio * (each.certain or 0.0)) for each in known])))
        within = float(np.mean(closed)) / unit.mean_range
    left = beta**2 - unit.variance_of_smallest * within**2
    return {
        "median_all_collapse_g": of_all,
        "beta_ensemble": within,
        "beta_record": math.sqrt(max(0.0, left)),
    }


def _standard(observed: Sequence[Observed]) -> Numbers:
    """Return the value by NTC 2018 §7.3.5: each record with its worse sign; mean of seven or more, else the lowest."""
    worse = []
    for name in dict.fromkeys(each.record for each in observed):
        own = [each for each in observed if each.record == name]
        fallen = [each.collapse for each in own if each.collapse is not None]
        failed = any(each.failed for each in own)
        collapse = None if failed else min(fallen, default=None)
        safe = None if failed else min(each.safe for each in own if each.safe is not None)
        worse.append({"record": name, "pga_collapse_g": collapse, "pga_safe_g": safe})
    found = standard_value(worse)
    return {key: found[key] for key in ("rule", "pga_collapse_g")}


def loss(
    before: Sequence[Observed],
    after: Sequence[Observed],
    static_before: float | None,
    static_after: float | None,
    levels: Sequence[float] | None,
) -> Numbers:
    """Return the loss of capacity 1 − after/before of a movement, `dynamic` beside `static`.

    Searches give the median of the losses of single records, each sign by itself, and their 16-84 %; pairs with a value
    missing are counted in `left_out`. Stripes give the loss of the median, without a range.
    """
    row: Numbers = {
        "dynamic": None,
        "dynamic_range": [None, None],
        "left_out": 0,
        "static": reduction(static_before, static_after),
        "static_capacity": static_after,
    }
    if levels is not None:
        medians = [fragility(each, levels, 1)["median_g"] for each in (before, after)]
        return row | {"dynamic": reduction(*medians)}
    of_before = {(each.record, each.sign): each.collapse for each in before}
    pairs = [(of_before.get((each.record, each.sign)), each) for each in after]
    losses = [
        -math.inf if each.collapse is None else 1.0 - each.collapse / first
        for first, each in pairs
        if first is not None and not each.failed
    ]
    row["left_out"] = len(pairs) - len(losses)
    if losses:
        low, middle, high = (_quantile(losses, share) for share in (BAND[0], 0.5, BAND[1]))
        row |= {"dynamic": middle, "dynamic_range": [low, high]}
    return row


def _quantile(values: Sequence[float], share: float) -> float | None:
    """Return a quantile; None if only an upper bound of it is known."""
    place = share * (len(values) - 1)
    low, high = (sorted(values)[place_of(place)] for place_of in (math.floor, math.ceil))
    if math.isinf(low):
        return None
    return low + (place - math.floor(place)) * (high - low)
