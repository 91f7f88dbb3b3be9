"""Incremental dynamic analysis: the peak ground acceleration at incipient collapse of each record and state."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.bracket import Bracket, Share, collapse_near, find_collapse
from assessment.campaign import Campaign
from assessment.dynamics import Numbers, StageResult, Start, quality_row
from assessment.ensemble import Course, Scatter, enough, lowest_median_highest, scatter_of
from assessment.response import Response, Setting, respond
from mechanics import Assembly, ConvergenceError, State

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion

MEAN_FROM, ENOUGH = 7, 3  # records: NTC 2018 §7.3.5
RUNS = 30  # of a search, about: what it costs


def searches(campaign: Campaign, motions: list[BaseMotion]) -> list[StageResult]:
    """The search of every record from every state, state by state."""
    table = campaign.project.incremental
    assert table is not None
    tasks = campaign.tasks(table, motions)
    scatter = scatter_of(campaign.project)
    return campaign.each("incremental", search, tasks, RUNS, scatter, table.max_scale, table.tolerance_g)


def search(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    state: str,
    start: Start,
    scatter: Scatter,
    max_scale: float,
    tolerance: float,
) -> StageResult:
    """The PGA at incipient collapse of one record from one state, with every run made on the way, in numbers."""
    title = search_title(state, motion)
    result = _searched(
        model, motion, setting, state, start, scatter,
        lambda share: find_collapse(share, motion.pga, max_scale * motion.pga, tolerance),
    )  # fmt: skip
    lowest, safe = result.numbers["pga_collapse_g"], result.numbers["pga_safe_g"]
    if lowest is None and safe is not None:
        result.warnings.append(
            f"{title}: no collapse up to {safe:.3g} g, max_scale = {max_scale:g}; raise it to find one"
        )
    upper = result.numbers.get("pga_collapse_range", [None, None])[1]
    if lowest is not None and scatter.members > 1 and upper != lowest:
        result.warnings.append(_spread(title, lowest, upper, max_scale * motion.pga))
    if resurrections := result.numbers["resurrections_g"]:
        result.warnings.append(
            f"{title}: collapse at {lowest:.3g} g, but stands at "
            f"{', '.join(f'{level:.3g}' for level in resurrections)} g; the lowest collapse counts"
        )
    return result


def _spread(title: str, lowest: float, upper: float | None, largest: float) -> str:
    if upper is None:
        return (
            f"{title}: members of the ensemble collapse from {lowest:.3g} g on, not all of them up to {largest:.3g} g; "
            "the lowest counts"
        )
    return (
        f"{title}: members of the ensemble collapse from {lowest:.3g} g on, all of them from {upper:.3g} g on; "
        "the lowest counts"
    )


def search_again(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    state: str,
    start: Start,
    near: Bracket,
    scatter: Scatter,
    max_scale: float,
    tolerance: float,
) -> StageResult:
    """The PGA at incipient collapse where another model, or another time step, gave the bracket `near`."""
    return _searched(
        model, motion, setting, state, start, scatter,
        lambda share: collapse_near(share, near, max_scale * motion.pga, tolerance),
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
    scatter: Scatter,
    bracketing: Callable[[Share], Bracket],
) -> StageResult:
    """Return what `bracketing` finds when given the share of members that collapse at a level (g), in numbers."""
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
    worst, programs, runs = 0.0, 0, 0

    def share(pga: float) -> float:
        nonlocal worst, programs, runs
        members = members_at(model, motion, setting, start, scatter, pga / motion.pga)
        numbers["points"].append(point(pga, motion.start, members))
        programs += sum(each.total("programs") for each in members)
        worst, runs = max([worst, *(each.worst for each in members)]), runs + len(members)
        return sum(each.collapsed for each in members) / len(members)

    began = time.perf_counter()
    try:
        bracket = bracketing(share)
        numbers |= {
            "pga_collapse_g": bracket.collapse,
            "pga_safe_g": bracket.safe,
            "resurrections_g": list(bracket.resurrections),
        }
        if scatter.members > 1:
            numbers["pga_collapse_range"] = [bracket.collapse, bracket.certain]
    except ConvergenceError as error:
        numbers["reason"] = str(error)
        result.failures.append(f"{title}: {error}")
    result.seconds = time.perf_counter() - began
    numbers["points"].sort(key=lambda point: point["pga_g"])
    numbers |= {"runs": runs, "seconds": result.seconds}
    if runs:
        result.quality.append(quality_row(state, f"incremental, {motion.name}", programs, worst))
    return result


def members_at(
    model: Assembly, motion: BaseMotion, setting: Setting, start: State, scatter: Scatter, factor: float
) -> list[Response]:
    """The motions of an ensemble under a base motion times `factor`: a pair, and the others where these differ."""
    found: list[Response] = []
    for amplitude in scatter.amplitudes:
        courses = [Course(each.time, each.displacement, each.collapsed) for each in found]
        if found and enough(courses, scatter, model.size):
            break
        found.append(respond(model, motion, setting, start, amplitude * factor))
    return found


def point(pga: float, begins: float, members: Sequence[Response]) -> Numbers:
    """A level of the search: what its members come to; any collapse counts as one, and has no peak."""
    fallen = [each for each in members if each.collapsed]
    first = min(fallen, key=lambda each: float(each.time[-1]), default=None)
    peaks = [None if each.collapsed else float(abs(each.displacement).max()) for each in members]
    low, _, high = lowest_median_highest(peaks)
    numbers: Numbers = {
        "pga_g": pga,
        "peak_displacement_m": high,
        "collapsed": bool(fallen),
        "time_of_collapse_s": begins + float(first.time[-1]) if first else None,
        "reason": first.last.collapse_reason if first else None,
    }
    if len(members) > 1:
        numbers |= {
            "peak_displacement_range": [low, high],
            "members": len(members),
            "members_collapsed": len(fallen),
        }
    return numbers


def summarise(records: Sequence[Mapping[str, Any]], warnings: list[str], state: str) -> Numbers:
    """The searches of a state together: mean, lowest, what NTC 2018 §7.3.5 takes of them, and the fragility.

    §7.3.5 [k: known, not re-read]: with seven records or more the mean of the effects counts, with three to six the
    most unfavourable: the lowest PGA at collapse. Fewer are not enough: their lowest is given, with a warning.
    A mean or lowest that a record without collapse leaves open is None.
    """
    collapses = [record["pga_collapse_g"] for record in records]
    surely = [record["pga_collapse_range"][1] for record in records if record.get("pga_collapse_range")]
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
    numbers: Numbers = {
        "records": list(records),
        "mean_pga_collapse_g": mean,
        "lowest_pga_collapse_g": lowest,
        "rule": rule,
        "pga_collapse_g": mean if rule == "mean" else lowest,
        "fragility": None if unknown else fragility(found, withstood),
    }
    if surely:
        known = [pga for pga in surely if pga is not None]
        upper = min(known, default=None)
        if rule == "mean":
            upper = float(np.mean(known)) if len(known) == len(records) else None
        numbers["pga_collapse_range"] = [numbers["pga_collapse_g"], upper]
    return numbers


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
