"""One combination of a campaign, a pure function of its inputs: one record of one sign from one state at rest."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from assessment.analyses.dynamic.bracket import BELOW, find_collapse
from assessment.analyses.dynamic.ensemble import Scatter
from assessment.analyses.dynamic.incremental import Levels, Member, point
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import thinned
from mechanics import Assembly, ConvergenceError, State

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion

Numbers = dict[str, Any]
LEAST = 1e-3  # g: the lowest level of a search
CURVE_POINTS = 400  # of a curve: those of ten thousand motions stay below 100 MB


@dataclass
class Combination:
    """Result of a combination: `numbers` for results.json, number of programs solved, and their worst residual.

    `failures`: why it could not be completed; its numbers are then null.
    """

    numbers: Numbers
    programs: int = 0
    worst: float = 0.0
    seconds: float = 0.0
    failures: list[str] = field(default_factory=list)


def search_collapse(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    start: State,
    scatter: Scatter,
    max_scale: float,
    tolerance: float,
    curves: tuple[int, ...] = (),
) -> Combination:
    """Bracket the PGA (g) at collapse within a relative `tolerance`, up to `max_scale` times the PGA of the record.

    `curves`: numbers of the members whose curves are kept.
    """

    def searched(levels: Levels) -> Numbers:
        found = find_collapse(
            levels.some,
            levels.every,
            motion.pga,
            max_scale * motion.pga,
            LEAST,
            tolerance,
            BELOW,
        )
        return {
            "pga_collapse_g": found.collapse,
            "pga_safe_g": found.safe,
            "pga_collapse_range": [found.collapse, found.certain] if scatter.members > 1 else None,
            "resurrections_g": list(found.resurrections),
        }

    return _completed(Levels(model, motion, setting, start, scatter), searched, curves)


def run_stripes(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    start: State,
    scatter: Scatter,
    pgas: tuple[float, ...],
    curves: tuple[int, ...] = (),
) -> Combination:
    """Return at which of the levels `pgas` (g), in ascending order, some member collapses, and at which all do.

    `curves`: numbers of the members whose curves are kept.
    """

    def struck(levels: Levels) -> Numbers:
        some = [levels.some(pga) for pga in pgas]
        every = [fallen and levels.every(pga) for fallen, pga in zip(some, pgas, strict=True)]
        first = next((pga for fallen, pga in zip(some, pgas, strict=True) if fallen), None)
        certain = next((pga for fallen, pga in zip(every, pgas, strict=True) if fallen), None)
        stood = [pga for fallen, pga in zip(some, pgas, strict=True) if not fallen]
        return {
            "pga_collapse_g": first,
            "pga_safe_g": max((pga for pga in stood if first is None or pga < first), default=0.0),
            "pga_collapse_range": [first, certain] if scatter.members > 1 else None,
            "resurrections_g": [pga for pga in stood if first is not None and pga > first],
            "collapsed": some,
            "all_collapsed": every,
        }

    return _completed(Levels(model, motion, setting, start, scatter), struck, curves)


def open_numbers(reason: str | None) -> Numbers:
    """Return the numbers of a combination that was not run, or not completed."""
    return {
        "pga_collapse_g": None,
        "pga_safe_g": None,
        "pga_collapse_range": None,
        "resurrections_g": [],
        "reason": reason,
        "runs": 0,
        "points": [],
    }


def _completed(
    levels: Levels, run: Callable[[Levels], Mapping[str, Any]], curves: tuple[int, ...]
) -> Combination:
    began = time.perf_counter()
    result = Combination(open_numbers(None))
    try:
        result.numbers |= run(levels)
    except ConvergenceError as error:
        result.numbers["reason"] = str(error)
        result.failures.append(str(error))
    members = [each for level in levels.members.values() for each in level]
    result.numbers |= {
        "runs": len(members),
        "points": [
            point(pga, level)
            | {"residual_displacement_m": _residual(level)}
            | ({"curves": _curves(levels, level, curves)} if curves else {})
            for pga, level in sorted(levels.members.items())
            if level
        ],
    }
    result.programs = sum(each.programs for each in members)
    result.worst = max((each.worst for each in members), default=0.0)
    result.seconds = time.perf_counter() - began
    return result


def _curves(levels: Levels, members: list[Member], numbers: tuple[int, ...]) -> list[Numbers]:
    """Return displacement (m) over time (s, of the record's file) of the members of these numbers that were run."""
    found = []
    for number in sorted(number for number in numbers if number <= len(members)):
        member = members[number - 1]
        kept = thinned(member.displacement, CURVE_POINTS)
        found.append(
            {
                "member": number,
                "factor": levels.scatter.strongest_first[number - 1],
                "time_s": (levels.motion.start + member.time[kept]).round(6).tolist(),
                "displacement_m": member.displacement[kept].round(7).tolist(),
            }
        )
    return found


def _residual(members: list[Member]) -> float | None:
    """Return the largest residual displacement (m) of the members; None if one collapses."""
    if any(each.collapsed for each in members):
        return None
    return max(abs(float(each.displacement[-1])) for each in members)
