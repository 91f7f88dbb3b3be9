"""Motions of many impacts, which converge as distributions only: ensembles of members at amplitudes within 1 %."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from assessment.benchmark.cases.dynamics import DAMPING, Case, shaking
from assessment.benchmark.cases.steps import STEP, WINDOW, strong_record
from assessment.benchmark.cases.structures import assembly, running_bond, template
from assessment.benchmark.measure import history_programs, piqp
from assessment.benchmark.table import Precision, number, percent, pivoted
from mechanics import Assembly, ConvergenceError, TimeHistory
from mechanics.procedures.time_history import HISTORY, HistoryTolerances, Integrator
from mechanics.types import Array

NINE, FIVE = np.linspace(0.99, 1.01, 9), np.linspace(0.99, 1.01, 5)  # of the amplitude
QUICK = NINE[::4]
# two branches of motions: the median of nine members may be on either, that of these is known to some per cent
MANY, FIFTEEN = np.linspace(0.99, 1.01, 45), np.linspace(0.99, 1.01, 15)
CONFIDENCE = 0.95
FINE = 0.0003125  # s: of the resolved ensemble
STEPS = (0.02, 0.01, 0.005, 0.0025, 0.00125)  # s
ALL_STEPS, QUICK_STEPS = (*STEPS, 0.000625, FINE), (0.005,)
DEFAULT_STEP = 0.005
SAMPLES = 5  # programs of an ensemble that PIQP solves
STIFF = (1e7, 1e8)  # kN/m³, of joints on which the arch falls
MOVED, FELL = "largest displacement, mm", "time of collapse, s"


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


EULER, DEFAULT, SECOND = (
    Way("implicit-euler"),
    Way("moreau-jean", HISTORY.resolved.levels),
    Way("second-order"),
)
UNHALVED = Way("moreau-jean", 0)
OTHERS = tuple(Way("moreau-jean", levels) for levels in (2, 4, 8))


@dataclass(frozen=True, eq=False)
class Shaken:
    """A case, what is measured of it, and its `ways`: each with its time steps (s) and factors of the amplitude.

    `resolved`: time step and factors of the members of which the median counts.
    """

    case: Case
    ways: Mapping[Way, tuple[tuple[float, ...], Array]]
    resolved: tuple[float, Array]
    measure: str = MOVED

    def sizes(self, motions: Sequence[TimeHistory]) -> Array:
        """Largest displacements (mm) of motions, or times of collapse (s) of those that fall."""
        if self.measure == FELL:
            return np.array([m.time_of_collapse for m in motions if m.collapsed], dtype=float)
        return np.array([1e3 * self.case.peak(motion)[0] for motion in motions])


@dataclass(frozen=True, kw_only=True)
class Point(Precision):
    """Least, median and largest of what is measured of an ensemble, and the `resolved` median, between two bounds.

    Of `members` so many `collapsed`, others were `not_solved`; `seconds` of all, `step_ms` of one step.
    """

    measure: str
    way: str
    integrator: Integrator
    levels: int | None
    resolved: float
    resolved_low: float
    resolved_high: float
    resolved_members: int
    members: int = 0
    not_solved: int = 0
    least: float = np.nan
    median: float = np.nan
    most: float = np.nan
    collapsed: int | None = None
    steps: int | None = None
    step_ms: float = np.nan
    programs_per_step: float = np.nan
    integrator_share: float = np.nan
    imbalance: float = np.nan


def ensembles(quick: bool) -> Iterator[Point]:
    """A row for every case, way and time step: median, range, distance from the resolved median, and cost."""
    for shaken in cases(quick):
        resolved = shaken.sizes(members(shaken.case, DEFAULT, *shaken.resolved))
        for way, (steps, factors) in shaken.ways.items():
            for step in steps:
                yield measured(shaken, way, step, factors, resolved)


def cases(quick: bool) -> list[Shaken]:
    """Structures of many impacts, and stiff elastic ones that fall; quick: one.

    Second order has fewer members, and the triumphal arch only the time steps that take seconds.
    """
    springing = template("buttressed-arch").pushover_control("+x").point_m
    arch = Case(
        "buttressed arch, shaken, rigid", assembly("buttressed-arch"), "rigid", springing, 3.0, shaking(0.12)
    )
    if quick:
        few = QUICK_STEPS, QUICK
        return [Shaken(arch, {EULER: few, DEFAULT: few}, (4.0 * FINE, NINE))]
    wall = Case(
        "Ferris and Tin-Loi's wall 1, shaken, rigid", running_bond(), "rigid", (5 * 0.4, 6 * 0.175), 3.0,
        shaking(0.5),
    )  # fmt: skip
    soft = replace(
        wall, name="Ferris and Tin-Loi's wall 1, shaken, elastic", contacts="elastic", damping=DAMPING
    )
    every, most = (ALL_STEPS, NINE), (STEPS, NINE)
    ways = {
        EULER: every,
        UNHALVED: every,
        **dict.fromkeys(OTHERS, most),
        DEFAULT: every,
        SECOND: (STEPS, FIVE),
    }
    three = {EULER: every, DEFAULT: every, SECOND: every}
    return [
        Shaken(arch, ways, (FINE, MANY)),
        Shaken(
            wall,
            {EULER: most, UNHALVED: most, DEFAULT: most, SECOND: (STEPS[:2], FIVE)},
            (FINE, FIFTEEN),
        ),
        Shaken(soft, {EULER: most, DEFAULT: most, SECOND: most}, (FINE, FIFTEEN)),
        *(Shaken(stiff(arch, stiffness), three, (FINE, FIFTEEN), FELL) for stiffness in STIFF),
        triumphal(),
    ]


def stiff(case: Case, stiffness: float) -> Case:
    """The case with elastic joints (kN/m³)."""
    blocks = [
        replace(block, material=replace(block.material, normal_stiffness=stiffness))
        for block in case.model.blocks
    ]
    name = case.name.replace("rigid", f"k = {stiffness:.0e}".replace("e+0", "e"))
    return replace(case, name=name, model=Assembly(blocks), contacts="elastic", damping=DAMPING)


def triumphal() -> Shaken:
    """The triumphal arch in the first 0.75 s of a strong motion of 0.2 g."""
    record = 0.2 * strong_record(WINDOW)
    at = STEP * np.arange(len(record))
    case = Case(
        "triumphal arch, shaken, rigid", assembly("triumphal-arch"), "rigid",
        template("triumphal-arch").pushover_control("+x").point_m, 0.75, lambda times: np.interp(times, at, record),
    )  # fmt: skip
    few = (0.01, 0.005, 0.0025), FIVE
    return Shaken(case, {EULER: few, UNHALVED: few, OTHERS[0]: few, DEFAULT: few}, (0.00125, NINE))


def members(case: Case, way: Way, step: float, factors: Array) -> list[TimeHistory]:
    """The motions of a case shaken at some factors of its amplitude, those that are solved."""
    found = []
    for factor in factors:
        with suppress(ConvergenceError):
            found.append(scaled(case, float(factor)).run(step, way.integrator, way.tolerances))
    return found


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


def measured(shaken: Shaken, way: Way, step: float, factors: Array, resolved: Array) -> Point:
    """A row of ensembles; `resolved` (k,): what is measured of members at a time step that resolves the impacts."""
    case = shaken.case
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
        measure=shaken.measure,
        way=str(way),
        integrator=way.integrator,
        levels=way.levels,
        resolved=middle,
        resolved_low=low,
        resolved_high=high,
        resolved_members=len(resolved),
        members=len(motions),
        not_solved=len(factors) - len(motions),
        collapsed=sum(m.collapsed for m in motions),
    )
    if len(motions) <= row.not_solved:
        return replace(row, failed="most members are not solved")
    steps = sum(len(m.time) - 1 for m in motions)
    some = motions[len(motions) // 2]
    programs = history_programs(
        case.model, case.contacts, some, case.acceleration(step), max(len(some.time) // SAMPLES, 1)
    )
    each = float(np.mean([min(piqp(program) for _ in range(3)) for program in programs]))
    row = replace(
        row,
        steps=steps,
        seconds=seconds,
        step_ms=1e3 * seconds / steps,
        ratio=seconds / steps / each,
        programs_per_step=sum(m.programs for m in motions) / steps,
        integrator_share=float(np.median([m.energy.integrator_share for m in motions])),
        imbalance=max(m.energy.imbalance for m in motions),
    )
    found = shaken.sizes(motions)
    if not len(found):
        return replace(row, failed="no member collapses")
    median = float(np.median(found))
    return replace(
        row,
        least=float(found.min()),
        median=median,
        most=float(found.max()),
        error=abs(median / middle - 1.0),
    )


def summed_up(rows: Sequence[Point]) -> str:
    """Tables of ensembles: least, median and largest of what is measured, and ms a step; then the resolved medians."""

    def cell(row: Point) -> str:
        if row.failed is not None:
            return row.failed
        digits = 1 if row.measure == MOVED else 2
        three = " – ".join(f"{size:.{digits}f}" for size in (row.least, row.median, row.most))
        text = f"{three}; {number(row.step_ms)} ms"
        if row.collapsed:
            text += f"; {row.collapsed} of {row.members} collapse"
        if row.not_solved:
            text += f"; {row.not_solved} not solved"
        return f"**{text}**" if row.default else text

    lines = []
    for measure in dict.fromkeys(row.measure for row in rows):
        some = [row for row in rows if row.measure == measure]
        table = pivoted(some, ["case", "way"], ["value"], lambda row: f"{1e3 * row.value:.3g} ms", cell)
        lines.append(f"{measure}:\n\n{table}")
    lines += [
        f"{row.case}: resolved, the median {row.measure} is {row.resolved:.3g} of {row.resolved_members} members, "
        f"with {percent(CONFIDENCE)} confidence between {row.resolved_low:.3g} and {row.resolved_high:.3g}."
        for row in {row.case: row for row in rows}.values()
    ]
    return "\n\n".join(lines)
