"""Capacity curves under both laws of sliding: how far the end of a curve hangs on increments, units and rounding."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from assessment.analyses.static.ensemble import ENSEMBLE, shaken_corners
from assessment.benchmark.cases.structures import assembly, in_frame, running_bond, template
from assessment.benchmark.measure import FAILURES, seconds_of
from assessment.benchmark.table import Row
from mechanics import Assembly, limit_analysis, pushover
from mechanics.procedures.pushover import Pushover
from mechanics.steps.static_system import Sliding

LAWS: tuple[Sliding, ...] = ("associative", "coulomb")
FACTORS = tuple(np.linspace(*ENSEMBLE.increments, 5))  # of the increment
COARSENESS = (0.5, 0.7, 1.0, 1.4, 2.0)  # times the increment: cost and scatter at each
SEEDS = range(3)  # of moved corners


@dataclass(frozen=True, eq=False)
class Case:
    """A structure pushed towards +x at a point (m), in increments (m)."""

    name: str
    model: Assembly
    control: tuple[float, float]
    increment: float

    def run(self, law: Sliding) -> Pushover:
        """Return the capacity curve by a law of sliding."""
        return pushover(self.model, self.control, "+x", "rigid", self.increment, sliding=law)


def cases(quick: bool) -> list[Case]:
    """Walls that slide, an arch that only turns, and one that does both; quick: two walls."""
    wall, small = running_bond(), running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False)
    top = small.blocks[-1].centroid
    walls = [
        Case("wall of 13 blocks", small, (float(top[0]), float(top[1])), 0.005),
        Case("Ferris and Tin-Loi's wall 1", wall, (5 * 0.4, 6 * 0.175), 0.005),
    ]
    if quick:
        return walls
    second = running_bond(5, 10)  # inferred from its multiplier: tests/validation/test_masonry_wall.py
    walls.append(Case("Ferris and Tin-Loi's wall 2", second, (5 * 0.4, 10 * 0.175), 0.005))
    arches = []
    for name in ("buttressed-arch", "triumphal-arch"):
        push = template(name).pushover
        assert push is not None
        control = template(name).pushover_control("+x").point_m
        arches.append(Case(name.replace("-", " "), assembly(name), control, push.increment_m))
    return walls + arches


@dataclass(frozen=True, kw_only=True)
class Ends(Row):
    """α_0 under a law of sliding, and least, median and largest end (m) of the curves of all variants solved.

    `factor`: of the increment, with corners moved by rounding; None: all variants.
    """

    law: Sliding
    factor: float | None = None
    blocks: int
    alpha: float
    least_m: float = np.nan
    median_m: float = np.nan
    most_m: float = np.nan
    variants: int
    not_solved: int
    seconds: float = np.nan


def sliding(quick: bool) -> Iterator[Ends]:
    """A row for each case and law: α_0, where the curve ends over its variants, and time a curve.

    Then one for each coarseness of the increment, whose variants are corners moved by rounding.
    """
    for case in cases(quick):
        for law in LAWS:
            yield measured(case, law, variants(case))
            for factor in COARSENESS:
                some = rounded(replace(case, increment=factor * case.increment))
                yield replace(measured(case, law, some), factor=factor)


def variants(case: Case) -> list[tuple[float, Case]]:
    """Return variants that a capacity must not depend on, with their units of length: first the case itself.

    Other increments, corners moved by rounding, other units of length, another origin and another unit of weight.
    """
    x, z = case.control

    def framed(length: float, origin: tuple[float, float], weight: float) -> tuple[float, Case]:
        control = (length * x + origin[0], length * z + origin[1])
        return length, replace(
            case,
            model=in_frame(case.model, length, origin, weight),
            control=control,
            increment=length * case.increment,
        )

    return [
        (1.0, case),
        *((1.0, replace(case, increment=factor * case.increment)) for factor in FACTORS if factor != 1.0),
        *rounded(case)[1:],
        framed(1000.0, (0.0, 0.0), 1.0),
        framed(1.0, (137.3, -41.9), 1.0),
        framed(1.0, (0.0, 0.0), 37.0),
    ]


def rounded(case: Case) -> list[tuple[float, Case]]:
    """The case itself, and with corners moved by rounding, as variants are given."""
    return [(1.0, case), *((1.0, replace(case, model=shaken_corners(case.model, seed))) for seed in SEEDS)]


def measured(case: Case, law: Sliding, tried: Sequence[tuple[float, Case]]) -> Ends:
    """A row of the table: least, median and largest end (m) of the curves of all variants that are solved."""
    alpha = limit_analysis(case.model, sliding=law).alpha
    ends, seconds, failed = [], [], 0
    for length, variant in tried:
        try:
            taken, curve = seconds_of(partial(variant.run, law))
        except FAILURES:
            failed += 1
            continue
        seconds.append(taken)
        ends.append(float(curve.displacement[-1]) / length)
    blocks = int(case.model.movable.sum())
    row = Ends(case=case.name, law=law, blocks=blocks, alpha=alpha, variants=len(tried), not_solved=failed)
    if not ends:
        return replace(row, failed="no variant is solved")
    return replace(
        row,
        least_m=min(ends),
        median_m=float(np.median(ends)),
        most_m=max(ends),
        seconds=float(np.median(seconds)),
    )
