"""Motions of many impacts, which converge as distributions only: ensembles of members at amplitudes within 1 %."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np

from assessment.benchmark.dynamics import Case, peak, shaking
from assessment.benchmark.measure import FAILURES, Row, history_programs, piqp
from assessment.benchmark.structures import assembly, running_bond, template
from mechanics import TimeHistory
from mechanics.procedures import time_history as histories
from mechanics.procedures.time_history import RESOLVED, Integrator
from mechanics.steps.dynamic_system import Halving
from mechanics.types import Array

AMPLITUDES = np.linspace(0.99, 1.01, 9)
QUICK = AMPLITUDES[::4]
STEPS, QUICK_STEPS = (0.01, 0.005, 0.0025, 0.00125), (0.005,)  # s
FINE = 0.0003125  # s: of the resolved ensemble
DEFAULT_STEP = 0.005
SAMPLES = 5  # programs of an ensemble that PIQP solves


@dataclass(frozen=True, slots=True)
class Way:
    """How a motion is integrated: `levels` down to which Moreau and Jean's steps are halved, None with the others."""

    integrator: Integrator
    levels: int | None = None

    def __str__(self) -> str:
        return self.integrator if self.levels is None else f"{self.integrator}, {self.levels} levels"


DEFAULT = Way("moreau-jean", RESOLVED.levels)
WAYS = (
    Way("implicit-euler"),
    *(Way("moreau-jean", levels) for levels in (0, 2, 4, RESOLVED.levels, 8)),
    Way("second-order"),
)
QUICK_WAYS = (WAYS[0], DEFAULT)


def ensembles(quick: bool) -> Iterator[Row]:
    """A row for every case, way and time step: median, range, distance from the resolved median, and cost."""
    for case in cases(quick):
        factors = QUICK if quick else AMPLITUDES
        try:
            resolved = float(np.median([m for m, _ in members(case, DEFAULT, _finest(quick), factors)]))
        except FAILURES as error:
            yield {"case": case.name, "parameter": "time step", "way": str(DEFAULT), "value": _finest(quick),
                   "default": False, "failed": str(error)}  # fmt: skip
            continue
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


def members(case: Case, way: Way, step: float, factors: Array) -> list[tuple[float, TimeHistory]]:
    """Largest displacement (m) and motion of a case shaken at some factors of its amplitude."""
    found = []
    with halved(way.levels):
        for factor in factors:
            motion = scaled(case, float(factor)).run(step, way.integrator)
            found.append((peak(motion, case.after)[0], motion))
    return found


def scaled(case: Case, factor: float) -> Case:
    """The case with its base motion multiplied by a factor."""
    from dataclasses import replace

    record: Callable[[Array], Array] = case.record
    return replace(case, record=lambda times: factor * record(times))


def measured(case: Case, way: Way, step: float, factors: Array, resolved: float) -> Row:
    """A row of ensembles; `resolved` (m): the median of members at a time step that resolves the impacts."""
    row: Row = {
        "case": case.name,
        "parameter": "time step",
        "value": step,
        "way": str(way),
        "integrator": way.integrator,
        "levels": way.levels,
        "default": step == DEFAULT_STEP and way == DEFAULT,
        "resolved_m": resolved,
    }
    began = time.process_time()
    try:
        found = members(case, way, step, factors)
    except FAILURES as error:
        return row | {"failed": str(error)}
    seconds = time.process_time() - began
    peaks, motions = [p for p, _ in found], [m for _, m in found]
    steps = sum(len(m.time) - 1 for m in motions)
    middle = motions[len(motions) // 2]
    programs = history_programs(
        case.model, case.contacts, middle, case.acceleration(step), max(len(middle.time) // SAMPLES, 1)
    )
    each = float(np.mean([min(piqp(program) for _ in range(3)) for program in programs]))
    median = float(np.median(peaks))
    return row | {
        "members": len(peaks),
        "least_m": min(peaks),
        "median_m": median,
        "most_m": max(peaks),
        "error": abs(median / resolved - 1.0),
        "collapsed": sum(m.collapsed for m in motions),
        "steps": steps,
        "seconds": seconds,
        "step_ms": 1e3 * seconds / steps,
        "ratio": seconds / steps / each,
        "programs_per_step": sum(m.programs for m in motions) / steps,
        "integrator_share": float(np.median([m.energy.integrator_share for m in motions])),
        "imbalance": max(m.energy.imbalance for m in motions),
    }


@contextmanager
def halved(levels: int | None) -> Iterator[None]:
    """Have Moreau and Jean's steps within halved down to so many levels; None: as the program does."""
    chosen = RESOLVED if levels is None else Halving(levels, RESOLVED.share)
    with patch.object(histories, "RESOLVED", chosen):
        yield


def millimetres(rows: Sequence[Row]) -> str:
    """A table of ensembles: least, median and largest displacement in mm, and ms a step."""
    from assessment.benchmark.table import number, pivoted

    def cell(row: Row) -> str:
        if "failed" in row:
            return "fails"
        three = " – ".join(f"{1e3 * row[key]:.1f}" for key in ("least_m", "median_m", "most_m"))
        text = f"{three}; {number(row['step_ms'])} ms"
        return f"**{text}**" if row["default"] else text

    return pivoted(rows, ["case", "way"], ["value"], lambda row: f"{1e3 * row['value']:g} ms", cell)
