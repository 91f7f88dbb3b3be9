"""One combination of a campaign, a pure function of its inputs: one record of one sign from one state at rest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from assessment.analyses.dynamic.bracket import BELOW, DOUBLE, find_collapse
from assessment.analyses.dynamic.ensemble import PAIR, Scatter
from assessment.analyses.dynamic.incremental import Levels, Member, point
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import thinned
from assessment.results.schema.campaign import CampaignCurve, CampaignLevel
from mechanics import Assembly, ConvergenceError, State
from mechanics.messages import Message

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion

LEAST = 1e-3  # g: the lowest level of a search
CURVE_POINTS = 400  # of a curve: those of ten thousand motions stay below 100 MB


@dataclass(frozen=True)
class Reach:
    """How far a search goes, `max_scale` times the PGA of the record, and the relative `tolerance` of its bracket."""

    max_scale: float
    tolerance: float


@dataclass(frozen=True)
class Judged:
    """Levels (PGA, g) of a combination: the least at which a member collapses, None: none; the largest `safe` one.

    `span`: from the collapse of a member to that of all, None without an ensemble; `resurrections`: levels above at
    which the structure stands again. `fallen`, `all_fallen` (stripes): whether some, or all, collapse at each level.
    """

    collapse: float | None = None
    safe: float | None = None
    span: list[float | None] | None = None
    resurrections: list[float] = field(default_factory=list)
    fallen: list[bool] | None = None
    all_fallen: list[bool] | None = None


@dataclass
class Combination:
    """Result of a combination: its levels, the motions run, the `points` of every level that was run.

    `reason`: why there is no answer; `failures`: why it could not be completed; its levels are then None. `programs`:
    number of programs solved, `worst`: their worst residual.
    """

    judged: Judged
    reason: str | None = None
    runs: int = 0
    points: list[CampaignLevel] = field(default_factory=list)
    programs: int = 0
    worst: float = 0.0
    seconds: float = 0.0
    failures: list[Message] = field(default_factory=list)


def search_collapse(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    start: State,
    scatter: Scatter,
    reach: Reach,
    curves: tuple[int, ...] = (),
    near: float | None = None,
) -> Combination:
    """Bracket the PGA (g) at collapse within its tolerance.

    `curves`: numbers of the members whose curves are kept; `near` (g): level at which collapse is expected, from which
    the search goes on in steps of the tolerance; None: it doubles or halves the record itself.
    """
    first, stride = (motion.pga, DOUBLE) if near is None else (near, 1.0 + reach.tolerance)

    def searched(levels: Levels) -> Judged:
        found = find_collapse(
            levels.some,
            levels.every,
            first,
            reach.max_scale * motion.pga,
            LEAST,
            reach.tolerance,
            BELOW,
            stride,
        )
        return Judged(
            found.collapse,
            found.safe,
            [found.collapse, found.certain] if scatter.members > 1 else None,
            list(found.resurrections),
        )

    return _completed(Levels(model, motion, setting, start, scatter), searched, curves)


def level_found(found: Combination) -> float | None:
    """Return a level (g) in the bracket of a search, the one withstood where none collapsed; None: not completed."""
    judged = found.judged
    if judged.collapse is None or not judged.safe:
        return judged.collapse or judged.safe
    return math.sqrt(judged.safe * judged.collapse)


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

    def struck(levels: Levels) -> Judged:
        some = [levels.some(pga) for pga in pgas]
        every = [fallen and levels.every(pga) for fallen, pga in zip(some, pgas, strict=True)]
        first = next((pga for fallen, pga in zip(some, pgas, strict=True) if fallen), None)
        certain = next((pga for fallen, pga in zip(every, pgas, strict=True) if fallen), None)
        stood = [pga for fallen, pga in zip(some, pgas, strict=True) if not fallen]
        return Judged(
            first,
            max((pga for pga in stood if first is None or pga < first), default=0.0),
            [first, certain] if scatter.members > 1 else None,
            [pga for pga in stood if first is not None and pga > first],
            some,
            every,
        )

    expected = len(pgas) * min(PAIR, scatter.members)
    return _completed(Levels(model, motion, setting, start, scatter, expected), struck, curves)


def _completed(levels: Levels, run: Callable[[Levels], Judged], curves: tuple[int, ...]) -> Combination:
    began = time.perf_counter()
    result = Combination(Judged())
    try:
        result.judged = run(levels)
    except ConvergenceError as error:
        result.reason = error.message
        result.failures.append(error.message)
    members = [each for level in levels.members.values() for each in level]
    result.runs = len(members)
    for pga, level in sorted(levels.members.items()):
        if level:
            reached = point(CampaignLevel, pga, level, residual_displacement_m=_residual(level))
            result.points.append(
                reached.replace(curves=_curves(levels, level, curves)) if curves else reached
            )
    result.programs = sum(each.programs for each in members)
    result.worst = max((each.worst for each in members), default=0.0)
    result.seconds = time.perf_counter() - began
    return result


def _curves(levels: Levels, members: list[Member], numbers: tuple[int, ...]) -> list[CampaignCurve]:
    """Return displacement (m) over time (s, of the record's file) of the members of these numbers that were run."""
    found = []
    for number in sorted(number for number in numbers if number <= len(members)):
        member = members[number - 1]
        kept = thinned(member.displacement, CURVE_POINTS)
        found.append(
            CampaignCurve(
                member=number,
                factor=levels.scatter.strongest_first[number - 1],
                time_s=(levels.motion.start + member.time[kept]).round(6).tolist(),
                displacement_m=member.displacement[kept].round(7).tolist(),
            )
        )
    return found


def _residual(members: list[Member]) -> float | None:
    """Return the largest residual displacement (m) of the members; None if one collapses."""
    if any(each.collapsed for each in members):
        return None
    return max(abs(float(each.displacement[-1])) for each in members)
