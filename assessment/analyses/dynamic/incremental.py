"""Incremental dynamic analysis: the peak ground acceleration at incipient collapse of each record and state."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

import numpy as np

from assessment.analyses.dynamic.bracket import Bracket, collapse_near, find_collapse
from assessment.analyses.dynamic.ensemble import Course, Scatter, enough, lowest_median_highest, scatter_of
from assessment.analyses.dynamic.inputs import Campaign
from assessment.analyses.dynamic.response import Setting, respond
from assessment.analyses.dynamic.time_history import DynamicResult, Shaking, quality_row
from assessment.results.schema.dynamic import Fragility, Incremental, Level, Search
from mechanics import Assembly, ConvergenceError, State
from mechanics.messages import Message, headed, message
from mechanics.progress import stretch

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion

Kind = TypeVar("Kind", bound=Level)

MEAN_FROM, ENOUGH = 7, 3  # records: NTC 2018 §7.3.5
RUNS = 30  # motions of a search, about
AGAIN = 20  # of one that is repeated near its result, about, at two to eight levels


def searches(campaign: Campaign, motions: list[BaseMotion]) -> list[DynamicResult[Search]]:
    """Return the search of every record from every state, state by state."""
    table = campaign.project.incremental
    assert table is not None
    tasks = [(task,) for task in campaign.tasks(table, motions)]
    scatter = scatter_of(campaign.project)
    return campaign.each("incremental", search, tasks, RUNS, scatter, table.max_scale, table.tolerance_g)


def search(shaking: Shaking, scatter: Scatter, max_scale: float, tolerance: float) -> DynamicResult[Search]:
    """Return the PGA (g) at incipient collapse of one record from one state, with every run of the search.

    The levels go up to `max_scale` times the PGA of the record; `tolerance` (g): of the result.
    """
    pga = shaking.motion.pga
    result = _searched(
        shaking,
        scatter,
        lambda levels: find_collapse(levels.some, levels.every, pga, max_scale * pga, tolerance),
    )
    title = search_title(shaking)
    result.warnings += [headed(title, note) for note in _notes(result.numbers, max_scale, max_scale * pga)]
    return result


def _notes(found: Search, max_scale: float, largest: float) -> Iterator[Message]:
    """Yield warnings of a search up to `largest` (g): no collapse, members far apart, withstood levels above one."""
    lowest, safe = found.pga_collapse_g, found.pga_safe_g
    if lowest is None and safe is not None:
        yield message(
            "no collapse up to a PGA of {safe:.3g} g at the surface, max_scale = {scale:g}; raise it to find one",
            safe=safe,
            scale=max_scale,
        )
    if lowest is not None and found.pga_collapse_g_range and found.pga_collapse_g_range[1] != lowest:
        yield _spread(lowest, found.pga_collapse_g_range[1], largest)
    if lowest is not None and found.resurrections_g:
        yield message(
            "collapse at a PGA of {pga:.3g} g at the surface, but stands at {levels:.3g} g; "
            "the lowest collapse counts",
            pga=lowest,
            levels=found.resurrections_g,
        )


def _spread(lowest: float, upper: float | None, largest: float) -> Message:
    if upper is None:
        return message(
            "members of the ensemble collapse from a PGA of {low:.3g} g at the surface on, "
            "not all of them up to {high:.3g} g; the lowest counts",
            low=lowest,
            high=largest,
        )
    return message(
        "members of the ensemble collapse from a PGA of {low:.3g} g at the surface on, "
        "all of them from {high:.3g} g on; the lowest counts",
        low=lowest,
        high=upper,
    )


def search_again(
    shaking: Shaking, near: Bracket, scatter: Scatter, max_scale: float, tolerance: float
) -> DynamicResult[Search]:
    """Return the PGA (g) at incipient collapse, searched near the bracket that another time step gave."""
    largest = max_scale * shaking.motion.pga
    return _searched(
        shaking, scatter, lambda levels: collapse_near(levels.some, near, largest, tolerance), AGAIN
    )


def search_title(shaking: Shaking) -> Message:
    """Return the beginning of the warnings of a search."""
    return message(
        "{state}, incremental analysis with {record}", state=shaking.state, record=shaking.motion.name
    )


def _searched(
    shaking: Shaking, scatter: Scatter, bracketing: Callable[[Levels], Bracket], expected: int = RUNS
) -> DynamicResult[Search]:
    """Return the numbers of the bracket that `bracketing` finds with the levels (g), in `expected` motions about."""
    title, motion, start = search_title(shaking), shaking.motion, shaking.start
    nothing = Search(
        record=motion.name,
        record_pga_g=motion.pga,
        pga_collapse_g=None,
        pga_safe_g=None,
        runs=0,
        resurrections_g=[],
        points=[],
        reason=None,
    )
    if isinstance(start, str):
        unanswered = nothing.replace(reason=start)
        return DynamicResult(shaking.state, "incremental", unanswered, warnings=[headed(title, start)])
    levels = Levels(shaking.model, motion, shaking.setting, start, scatter, expected)
    failures = []
    began = time.perf_counter()
    try:
        bracket = bracketing(levels)
        found = nothing.replace(
            pga_collapse_g=bracket.collapse,
            pga_safe_g=bracket.safe,
            resurrections_g=list(bracket.resurrections),
        )
        if scatter.members > 1:
            found = found.replace(pga_collapse_g_range=[bracket.collapse, bracket.certain])
    except ConvergenceError as error:
        found = nothing.replace(reason=error.message)
        failures.append(headed(title, error.message))
    seconds = time.perf_counter() - began
    members = [each for level in levels.members.values() for each in level]
    points = [point(Level, pga, level) for pga, level in sorted(levels.members.items()) if level]
    found = found.replace(runs=len(members), points=points, seconds=seconds)
    result = DynamicResult(shaking.state, "incremental", found, failures=failures, seconds=seconds)
    if members:
        worst, programs = max(each.worst for each in members), sum(each.programs for each in members)
        result.quality.append(quality_row(shaking.state, f"incremental, {motion.name}", programs, worst))
    return result


@dataclass(frozen=True, eq=False)
class Member(Course):
    """One motion of an ensemble: its `end` (s, of the record's file), why it `fell`, programs and worst residual."""

    end: float
    fell: str
    programs: int
    worst: float


@dataclass
class Levels:
    """The ensembles of a search, by level (g): as many members of each as its question needs.

    `expected`: motions of all of them, about.
    """

    model: Assembly
    motion: BaseMotion
    setting: Setting
    start: State
    scatter: Scatter
    expected: int = RUNS
    members: dict[float, list[Member]] = field(default_factory=dict)

    def some(self, pga: float) -> bool:
        """Whether any member collapses; members are run until one does, or until a pair that withstands agrees."""
        found = self.members.setdefault(pga, [])
        while not any(each.collapsed for each in found) and not enough(found, self.scatter, self.model.size):
            found.append(self._run(pga, len(found)))
        return any(each.collapsed for each in found)

    def every(self, pga: float) -> bool:
        """Whether all members collapse; members are run until one withstands."""
        found = self.members.setdefault(pga, [])
        while all(each.collapsed for each in found) and len(found) < self.scatter.members:
            found.append(self._run(pga, len(found)))
        return all(each.collapsed for each in found)

    def _run(self, pga: float, number: int) -> Member:
        factor = self.scatter.strongest_first[number] * pga / self.motion.pga
        done = sum(map(len, self.members.values()))
        expected = max(self.expected, done + 1)
        with stretch(done / expected, (done + 1) / expected):
            response = respond(self.model, self.motion, self.setting, self.start, factor)
        return Member(
            response.time,
            response.displacement,
            response.collapsed,
            self.motion.start + float(response.time[-1]),
            response.last.collapse_reason,
            response.total("programs"),
            response.worst,
        )


def point(kind: type[Kind], pga: float, members: Sequence[Member], **more: Any) -> Kind:
    """Return a level (PGA, g) of the search from its members, with what such a part has `more`.

    It counts as a collapse if any member collapses.
    """
    fallen = [each for each in members if each.collapsed]
    first = min(fallen, key=lambda each: each.end, default=None)
    low, _, high = lowest_median_highest(
        [None if each.collapsed else float(abs(each.displacement).max()) for each in members]
    )
    return kind(
        pga_g=pga,
        peak_displacement_m=high,
        peak_displacement_m_range=[low, high],
        members=len(members),
        members_collapsed=len(fallen),
        collapsed=bool(fallen),
        time_of_collapse_s=first.end if first else None,
        reason=first.fell if first else None,
        **more,
    )


def summarise(records: Sequence[Search], warnings: list[Message], state: str) -> Incremental:
    """Return mean and lowest PGA at collapse of a state, the value by NTC 2018 §7.3.5, and the fragility."""
    if len(records) < ENOUGH:
        few = message(
            "records of the incremental analysis: {count}; NTC 2018 §7.3.5 asks for at least {least}",
            count=len(records),
            least=ENOUGH,
        )
        warnings.append(headed(message("{state}", state=state), few))
    standard = standard_value([(each.pga_collapse_g, each.pga_safe_g) for each in records])
    collapses = [each.pga_collapse_g for each in records if each.pga_collapse_g is not None]
    withstood = [each.pga_safe_g for each in records if each.pga_collapse_g is None]
    bounds = [pga for pga in withstood if pga is not None]
    found = Incremental(
        records=list(records),
        mean_pga_collapse_g=standard.mean,
        lowest_pga_collapse_g=standard.lowest,
        rule=standard.rule,
        pga_collapse_g=standard.pga,
        fragility=None if len(bounds) < len(withstood) else fragility(collapses, bounds),
    )
    surely = [each.pga_collapse_g_range[1] for each in records if each.pga_collapse_g_range]
    if not surely:
        return found
    known = [pga for pga in surely if pga is not None]
    upper = min(known, default=None)
    if standard.rule == "mean":
        upper = float(np.mean(known)) if len(known) == len(records) else None
    return found.replace(pga_collapse_g_range=[standard.pga, upper])


class Standard(NamedTuple):
    """Mean and lowest PGA at collapse of some records (g), and which of them counts by the `rule`.

    None: undecided; a rule of None: fewer records than §7.3.5 asks for.
    """

    mean: float | None
    lowest: float | None
    rule: Literal["mean", "lowest"] | None

    @property
    def pga(self) -> float | None:
        """The PGA that counts, g; of too few records the lowest, which is no value of the standard."""
        return self.mean if self.rule == "mean" else self.lowest


def standard_value(records: Sequence[tuple[float | None, float | None]]) -> Standard:
    """Return the PGA at collapse by NTC 2018 §7.3.5; `records`: PGA at collapse and largest safe PGA of each, g.

    §7.3.5 [k]: with seven records or more the mean of the effects counts, with three to six the
    most unfavourable: the lowest PGA at collapse. With fewer there is no rule. A mean or lowest that a record without
    collapse leaves undecided is None.
    """
    found = [collapse for collapse, _ in records if collapse is not None]
    withstood = [safe for collapse, safe in records if collapse is None]
    mean = float(np.mean(found)) if found and not withstood else None
    lowest = min(found, default=None)
    bounds = [safe for safe in withstood if safe is not None]
    if lowest is not None and (len(bounds) < len(withstood) or min(bounds, default=math.inf) < lowest):
        lowest = None
    if len(records) < ENOUGH:
        return Standard(mean, lowest, None)
    return Standard(mean, lowest, "mean" if len(records) >= MEAN_FROM else "lowest")


def fragility(collapses: Sequence[float], withstood: Sequence[float] = ()) -> Fragility | None:
    """Return median (g) and dispersion (of ln PGA) of the lognormal distribution of collapse, by maximum likelihood.

    `withstood` (g): highest levels of the records without collapse, which count as censored. None if there are not two
    different levels of collapse.
    """
    if len(set(collapses)) < 2:
        return None
    from scipy.stats import CensoredData, norm

    data = CensoredData(uncensored=np.log(collapses), right=np.log(withstood))
    mean, deviation = norm.fit(data)
    return Fragility(
        median_g=float(np.exp(mean)),
        dispersion=float(deviation),
        records=len(collapses) + len(withstood),
        censored=len(withstood),
    )
