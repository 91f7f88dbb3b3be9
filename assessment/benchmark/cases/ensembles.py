"""Motions of many impacts, which converge as distributions only: ensembles of members at amplitudes within 1 %."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from assessment.benchmark.cases.dynamics import Case, shaking
from assessment.benchmark.cases.structures import assembly, running_bond, template
from assessment.benchmark.measure import history_programs, piqp
from assessment.benchmark.table import Precision, number, percent, pivoted
from mechanics import ConvergenceError, TimeHistory
from mechanics.procedures.time_history import HISTORY, HistoryTolerances, Integrator
from mechanics.types import Array

AMPLITUDES = np.linspace(0.99, 1.01, 9)
QUICK = AMPLITUDES[::4]
# two branches of motions: the median of nine members may be on either, that of these is known to some per cent
MANY = np.linspace(0.99, 1.01, 45)
CONFIDENCE = 0.95
STEPS, QUICK_STEPS = (0.01, 0.005, 0.0025, 0.00125), (0.005,)  # s
FINE = 0.0003125  # s: of the resolved ensemble
DEFAULT_STEP = 0.005
SAMPLES = 5  # programs of an ensemble that PIQP solves


@dataclass(frozen=True, slots=True)
class Way:
    """How a motion is integrated: `levels` down to which Moreau and Jean's steps are halved, None with the others."""

    integrator: Integrator
    levels: int | None = None

    @property
    def tolerances(self) -> HistoryTolerances:
        """Those of the program, but for the levels."""
        if self.levels is None:
            return HISTORY
        return HistoryTolerances(resolved=replace(HISTORY.resolved, levels=self.levels))

    def __str__(self) -> str:
        return self.integrator if self.levels is None else f"{self.integrator}, {self.levels} levels"


DEFAULT = Way("moreau-jean", HISTORY.resolved.levels)
WAYS = (
    Way("implicit-euler"),
    *(Way("moreau-jean", levels) for levels in (0, 2, 4, HISTORY.resolved.levels, 8)),
    Way("second-order"),
)
QUICK_WAYS = (WAYS[0], DEFAULT)


@dataclass(frozen=True, kw_only=True)
class Point(Precision):
    """Least, median and largest displacement (m) of an ensemble, and the `resolved` median, known between two bounds.

    Of `members` so many `collapsed`, others were `not_solved`; `seconds` of all, `step_ms` of one step.
    """

    way: str
    integrator: Integrator
    levels: int | None
    resolved_m: float
    resolved_low_m: float
    resolved_high_m: float
    resolved_members: int
    members: int = 0
    not_solved: int = 0
    least_m: float = np.nan
    median_m: float = np.nan
    most_m: float = np.nan
    collapsed: int | None = None
    steps: int | None = None
    step_ms: float = np.nan
    programs_per_step: float = np.nan
    integrator_share: float = np.nan
    imbalance: float = np.nan


def ensembles(quick: bool) -> Iterator[Point]:
    """A row for every case, way and time step: median, range, distance from the resolved median, and cost."""
    for case in cases(quick):
        factors = QUICK if quick else AMPLITUDES
        resolved = peaks(case, members(case, DEFAULT, _finest(quick), AMPLITUDES if quick else MANY))
        for way in QUICK_WAYS if quick else WAYS:
            for step in QUICK_STEPS if quick else STEPS:
                yield measured(case, way, step, factors, resolved)


def cases(quick: bool) -> list[Case]:
    """Rigid structures of many impacts; quick: one."""
    springing = template("buttressed-arch").pushover_control("+x").point_m
    arch = Case(
        "buttressed arch, shaken, rigid", assembly("buttressed-arch"), "rigid", springing, 3.0, shaking(0.12)
    )
    wall = Case(
        "Ferris and Tin-Loi's wall 1, shaken, rigid", running_bond(), "rigid", (5 * 0.4, 6 * 0.175), 3.0,
        shaking(0.5),
    )  # fmt: skip
    return [arch] if quick else [arch, wall]


def _finest(quick: bool) -> float:
    return 4.0 * FINE if quick else FINE


def members(case: Case, way: Way, step: float, factors: Array) -> list[TimeHistory]:
    """The motions of a case shaken at some factors of its amplitude, those that are solved."""
    found = []
    for factor in factors:
        with suppress(ConvergenceError):
            found.append(scaled(case, float(factor)).run(step, way.integrator, way.tolerances))
    return found


def peaks(case: Case, motions: Sequence[TimeHistory]) -> Array:
    """Largest displacements (m) of motions."""
    return np.array([case.peak(motion)[0] for motion in motions])


def scaled(case: Case, factor: float) -> Case:
    """The case with its base motion multiplied by a factor."""
    record: Callable[[Array], Array] = case.record
    return replace(case, record=lambda times: factor * record(times))


def median_between(values: Array) -> tuple[float, float]:
    """Two of the values (k,) between which the median of all that might be drawn lies, with 95 % CONFIDENCE.

    The number of values below it is distributed as the heads of k tosses of a coin. Raises ValueError for fewer than
    six values.
    """
    from scipy.stats import binom

    count = len(values)
    below = int(binom.ppf(0.5 * (1.0 - CONFIDENCE), count, 0.5))  # fewer of them are hardly ever below
    if below < 1:
        raise ValueError(f"the median of {count} values is not known with so much confidence")
    ordered = np.sort(values)
    return float(ordered[below - 1]), float(ordered[count - below])


def measured(case: Case, way: Way, step: float, factors: Array, resolved: Array) -> Point:
    """A row of ensembles; `resolved` (k,) m: peaks of members at a time step that resolves the impacts."""
    low, high = median_between(resolved)
    middle = float(np.median(resolved))
    began = time.process_time()
    motions = members(case, way, step, factors)
    seconds = time.process_time() - began
    row = Point(
        case=case.name,
        parameter="time step",
        value=step,
        default=step == DEFAULT_STEP and way == DEFAULT,
        way=str(way),
        integrator=way.integrator,
        levels=way.levels,
        resolved_m=middle,
        resolved_low_m=low,
        resolved_high_m=high,
        resolved_members=len(resolved),
        members=len(motions),
        not_solved=len(factors) - len(motions),
    )
    if len(motions) <= row.not_solved:
        return replace(row, failed="most members are not solved")
    found = peaks(case, motions)
    steps = sum(len(m.time) - 1 for m in motions)
    some = motions[len(motions) // 2]
    programs = history_programs(
        case.model, case.contacts, some, case.acceleration(step), max(len(some.time) // SAMPLES, 1)
    )
    each = float(np.mean([min(piqp(program) for _ in range(3)) for program in programs]))
    median = float(np.median(found))
    return replace(
        row,
        least_m=float(found.min()),
        median_m=median,
        most_m=float(found.max()),
        error=abs(median / middle - 1.0),
        collapsed=sum(m.collapsed for m in motions),
        steps=steps,
        seconds=seconds,
        step_ms=1e3 * seconds / steps,
        ratio=seconds / steps / each,
        programs_per_step=sum(m.programs for m in motions) / steps,
        integrator_share=float(np.median([m.energy.integrator_share for m in motions])),
        imbalance=max(m.energy.imbalance for m in motions),
    )


def millimetres(rows: Sequence[Point]) -> str:
    """A table of ensembles: least, median and largest displacement in mm, and ms a step; then the resolved medians."""

    def cell(row: Point) -> str:
        if row.failed is not None:
            return "fails"
        three = " – ".join(f"{1e3 * size:.1f}" for size in (row.least_m, row.median_m, row.most_m))
        text = f"{three}; {number(row.step_ms)} ms"
        if row.not_solved:
            text += f"; {row.not_solved} not solved"
        return f"**{text}**" if row.default else text

    lines = [pivoted(rows, ["case", "way"], ["value"], lambda row: f"{1e3 * row.value:g} ms", cell)]
    for row in {row.case: row for row in rows}.values():
        middle, low, high = (1e3 * m for m in (row.resolved_m, row.resolved_low_m, row.resolved_high_m))
        lines.append(
            f"{row.case}: resolved, the median is {middle:.1f} mm of {row.resolved_members} members, with "
            f"{percent(CONFIDENCE)} confidence between {low:.1f} and {high:.1f} mm."
        )
    return "\n\n".join(lines)
