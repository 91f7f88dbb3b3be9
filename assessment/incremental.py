"""Incremental dynamic analysis: the peak ground acceleration at incipient collapse of each record and state."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.campaign import Campaign
from assessment.dynamics import Numbers, Setting, StageResult, Start, quality_row, respond
from mechanics import Assembly, ConvergenceError

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion
    from mechanics.program import Certificate

# shares of the PGA at collapse where the order of collapse is not taken on trust
GRID = (0.2, 0.4, 0.6, 0.8, 1.2, 1.4, 1.6)
MEAN_FROM, ENOUGH = 7, 3  # records: NTC 2018 §7.3.5
RUNS = 12  # of a search, about: what it costs


@dataclass(frozen=True)
class Bracket:
    """`safe` (g) was withstood and `collapse` (g) not, no lower one tried collapsed; None: nothing tried collapsed.

    `resurrections` (g): what was tried above `collapse` and withstood.
    """

    safe: float
    collapse: float | None
    resurrections: tuple[float, ...]

    @property
    def width(self) -> float:
        """How far apart its ends are, g; 0 where nothing collapsed."""
        return 0.0 if self.collapse is None else self.collapse - self.safe


def find_collapse(
    collapses: Callable[[float], bool], first: float, largest: float, tolerance: float
) -> Bracket:
    """Bracket the lowest peak ground acceleration at collapse within `tolerance`; everything in g.

    From `first` by doubling, up to `largest`, or halving to a level on each side, then by bisection between levels
    that were both run. A structure that falls at one level may stand at a higher one: levels on a coarse grid below
    and above are tried too, and a collapse found below starts the bisection again. At zero the state stands by itself.
    """
    tried: dict[float, bool] = {}

    def falls(level: float) -> bool:
        if level not in tried:
            tried[level] = collapses(level)
        return tried[level]

    def lowest() -> float | None:
        return min((level for level, fallen in tried.items() if fallen), default=None)

    def safe_below(limit: float) -> float:
        return max((level for level, fallen in tried.items() if not fallen and level < limit), default=0.0)

    level = min(first, largest)
    if falls(level):
        while level > tolerance and falls(level):
            level /= 2.0
    else:
        while level < largest and not falls(min(2.0 * level, largest)):
            level = min(2.0 * level, largest)
    while True:
        collapse = lowest()
        if collapse is not None and collapse - safe_below(collapse) > tolerance:
            falls(0.5 * (collapse + safe_below(collapse)))
            continue
        about = collapse or largest
        wanted = [share * about for share in GRID if share * about <= largest]
        new = [level for level in wanted if min(abs(level - other) for other in tried) > tolerance]
        if not new:
            break
        falls(new[0])
    if collapse is None:
        return Bracket(largest, None, ())
    above = (level for level, fallen in tried.items() if not fallen and level > collapse)
    return Bracket(safe_below(collapse), collapse, tuple(sorted(above)))


def collapse_near(
    collapses: Callable[[float], bool], near: Bracket, largest: float, tolerance: float
) -> Bracket:
    """Bracket a collapse within `tolerance` that is expected in the bracket `near`; everything in g.

    Two runs where it is there. Else away from it, down where `near.safe` collapses, up to `largest` where
    `near.collapse` is withstood, by steps that double from its width, and by bisection between the last two. Levels
    below the one that is withstood then are not tried.
    """
    low, high, step = near.safe, near.collapse, near.width or tolerance
    if low > 0.0 and collapses(low):
        low, high = max(low - step, 0.0), low
        while low > 0.0 and collapses(low):
            step *= 2.0
            low, high = max(low - step, 0.0), low
    elif high is None:
        return near
    else:
        while not collapses(high):
            if high >= largest:
                return Bracket(high, None, ())
            low, high, step = high, min(high + step, largest), 2.0 * step
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if collapses(middle) else (middle, high)
    return Bracket(low, high, ())


def searches(campaign: Campaign, motions: list[BaseMotion]) -> list[StageResult]:
    """The search of every record from every state, state by state."""
    table = campaign.project.incremental
    assert table is not None
    tasks = campaign.tasks(table, motions)
    return campaign.each("incremental", search, tasks, RUNS, table.max_scale, table.tolerance_g)


def search(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    state: str,
    start: Start,
    max_scale: float,
    tolerance: float,
) -> StageResult:
    """The PGA at incipient collapse of one record from one state, with every run made on the way, in numbers."""
    title = search_title(state, motion)
    result = _searched(
        model, motion, setting, state, start,
        lambda collapses: find_collapse(collapses, motion.pga, max_scale * motion.pga, tolerance),
    )  # fmt: skip
    lowest, safe = result.numbers["pga_collapse_g"], result.numbers["pga_safe_g"]
    if lowest is None and safe is not None:
        result.warnings.append(
            f"{title}: no collapse up to {safe:.3g} g, max_scale = {max_scale:g}; raise it to find one"
        )
    if resurrections := result.numbers["resurrections_g"]:
        result.warnings.append(
            f"{title}: collapse at {lowest:.3g} g, but stands at "
            f"{', '.join(f'{level:.3g}' for level in resurrections)} g; the lowest collapse counts"
        )
    return result


def search_again(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    state: str,
    start: Start,
    near: Bracket,
    max_scale: float,
    tolerance: float,
) -> StageResult:
    """The PGA at incipient collapse where another model, or another time step, gave the bracket `near`."""
    return _searched(
        model, motion, setting, state, start,
        lambda collapses: collapse_near(collapses, near, max_scale * motion.pga, tolerance),
    )  # fmt: skip


def search_title(state: str, motion: BaseMotion) -> str:
    """Return what warnings of a search begin with."""
    return f"{state}, incremental analysis with {motion.name}"


def _searched(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    state: str,
    start: Start,
    bracketing: Callable[[Callable[[float], bool]], Bracket],
) -> StageResult:
    """Return what `bracketing` finds when given whether a level (g) collapses the structure, in numbers."""
    title = search_title(state, motion)
    numbers: Numbers = {
        "record": motion.name,
        "record_pga_g": motion.pga,
        "pga_collapse_g": None,
        "pga_safe_g": None,
        "runs": 0,
        "resurrections_g": [],
        "points": [],
        "reason": None,
    }
    result = StageResult(state, "incremental", numbers)
    if isinstance(start, str):
        numbers["reason"] = start
        result.warnings.append(f"{title}: {start}")
        return result
    worst: Certificate | None = None
    solves = 0

    def collapses(pga: float) -> bool:
        nonlocal worst, solves
        response = respond(model, motion, setting, start, pga / motion.pga)
        fallen = response.last.collapsed
        numbers["points"].append(
            {
                "pga_g": pga,
                "peak_displacement_m": None if fallen else float(abs(response.displacement).max()),
                "collapsed": fallen,
                "time_of_collapse_s": motion.start + float(response.time[-1]) if fallen else None,
                "reason": response.last.collapse_reason or None,
            }
        )
        solves += response.total("solves")
        worst = response.certificate if worst is None else worst.joined(response.certificate)
        return fallen

    began = time.perf_counter()
    try:
        bracket = bracketing(collapses)
        numbers |= {
            "pga_collapse_g": bracket.collapse,
            "pga_safe_g": bracket.safe,
            "resurrections_g": list(bracket.resurrections),
        }
    except ConvergenceError as error:
        numbers["reason"] = str(error)
        result.failures.append(f"{title}: {error}")
    result.seconds = time.perf_counter() - began
    numbers["points"].sort(key=lambda point: point["pga_g"])
    numbers |= {"runs": len(numbers["points"]), "seconds": result.seconds}
    if worst is not None:
        result.quality.append(quality_row(state, f"incremental, {motion.name}", solves, worst))
    return result


def summarise(records: Sequence[Mapping[str, Any]], warnings: list[str], state: str) -> Numbers:
    """The searches of a state together: mean, lowest, what NTC 2018 §7.3.5 takes of them, and the fragility.

    §7.3.5 [k: known, not re-read]: with seven records or more the mean of the effects counts, with three to six the
    most unfavourable: the lowest PGA at collapse. Fewer are not enough: their lowest is given, with a warning.
    A mean or lowest that a record without collapse leaves open is None.
    """
    collapses = [record["pga_collapse_g"] for record in records]
    found = [pga for pga in collapses if pga is not None]
    withstood = [r["pga_safe_g"] for r in records if r["pga_collapse_g"] is None]
    unknown = [pga for pga in withstood if pga is None]
    mean = float(np.mean(found)) if found and not withstood else None
    lowest = min(found, default=None)
    if lowest is not None and (unknown or min(withstood, default=math.inf) < lowest):
        lowest = None
    rule = "mean" if len(records) >= MEAN_FROM else "lowest"
    if len(records) < ENOUGH:
        warnings.append(
            f"{state}: records of the incremental analysis: {len(records)}; "
            f"NTC 2018 §7.3.5 asks for at least {ENOUGH}"
        )
    return {
        "records": list(records),
        "mean_pga_collapse_g": mean,
        "lowest_pga_collapse_g": lowest,
        "rule": rule,
        "pga_collapse_g": mean if rule == "mean" else lowest,
        "fragility": None if unknown else fragility(found, withstood),
    }


def fragility(collapses: Sequence[float], withstood: Sequence[float] = ()) -> Numbers | None:
    """Median (g) and dispersion (of ln PGA) of the lognormal distribution of collapse, by maximum likelihood.

    `withstood` (g): largest levels tried of records that made nothing collapse; they count as censored. None where
    two different levels of collapse are wanting.
    """
    if len(set(collapses)) < 2:
        return None
    from scipy.stats import CensoredData, norm

    data = CensoredData(uncensored=np.log(collapses), right=np.log(withstood))
    mean, deviation = norm.fit(data)
    return {
        "median_g": float(np.exp(mean)),
        "dispersion": float(deviation),
        "records": len(collapses) + len(withstood),
        "censored": len(withstood),
    }
