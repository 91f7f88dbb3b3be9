"""Limit analysis of ever larger running-bond walls: processor time and memory, each wall in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from assessment.benchmark.cases.structures import running_bond
from assessment.benchmark.measure import exponent, in_turn, peak_memory, piqp, seconds_of
from assessment.benchmark.table import Row
from mechanics import Assembly, limit_analysis
from mechanics.solvers import lp_highs
from mechanics.steps.equilibrium import closed_program

WALLS = {100: (10, 10), 300: (17, 17), 1000: (31, 31), 3000: (55, 54), 10000: (100, 100)}
QUICK = 1000  # blocks of the largest wall then
COMPARED = 400  # blocks of the largest wall that HiGHS also solves
REPEATED = 3000  # blocks of the largest wall that is measured more than once
FITTED = 200  # blocks from which the exponent is fitted


@dataclass(frozen=True, kw_only=True)
class Wall(Row):
    """Time (s) of building a wall and of its limit analysis, memory (MB), α_0 and its residual; what HiGHS finds."""

    blocks: int | None = None
    joints: int | None = None
    building_s: float = np.nan
    seconds: float
    ratio: float = np.nan
    memory_MB: float = np.nan
    alpha: float = np.nan
    certificate: float = np.nan
    error: float = np.nan
    highs_s: float = np.nan


def walls(quick: bool) -> Iterator[Wall]:
    """A row for every wall; last, the exponent of time over the number of blocks."""
    rows = []
    for blocks, size in WALLS.items():
        if not quick or blocks <= QUICK:
            rows.append(apart(*size))
            yield rows[-1]
    yield Wall(
        case=f"exponent, from {FITTED} blocks",
        seconds=exponent([row for row in rows if (row.blocks or 0) >= FITTED], "seconds"),
    )


def apart(columns: int, courses: int) -> Wall:
    """The row of a wall, measured in another process."""
    done = subprocess.run(
        [sys.executable, "-m", __name__, str(columns), str(courses)],
        check=True,
        capture_output=True,
        text=True,
    )
    return Wall(**json.loads(done.stdout))


def measured(columns: int, courses: int) -> Wall:
    """Processor time of building the model and of limit analysis, its check under self-weight included.

    HiGHS is the reference of walls that it solves in seconds.
    """
    limit_analysis(running_bond(8, 8))  # what is imported and compiled once
    building, model = seconds_of(lambda: running_bond(columns, courses))
    seconds, limit = seconds_of(lambda: limit_analysis(model))
    memory = peak_memory()
    blocks = int(model.movable.sum())
    program = closed_program(model, model.initial).pushed(model, model.lateral_load("+x")).program
    if blocks <= REPEATED:
        seconds, baseline = in_turn(lambda: limit_analysis(model), lambda: piqp(program))
    else:
        baseline = piqp(program)
    error, highs = _by_highs(model, limit.alpha) if blocks <= COMPARED else (np.nan, np.nan)
    return Wall(
        case=f"wall {columns} × {courses}",
        blocks=blocks,
        joints=len(model.contacts),
        building_s=building,
        seconds=float(seconds),
        ratio=float(seconds / baseline),
        memory_MB=memory,
        alpha=limit.alpha,
        certificate=limit.certificate.worst(1e-3 * model.size),
        error=error,
        highs_s=highs,
    )


def _by_highs(model: Assembly, alpha: float) -> tuple[float, float]:
    """The relative difference from the multiplier that HiGHS finds, and its time (s)."""
    program = closed_program(model, model.initial).pushed(model, model.lateral_load("+x")).program
    seconds, answer = seconds_of(lambda: lp_highs.solve(program))
    assert answer is not None
    return abs(alpha / answer[1] - 1.0), seconds


if __name__ == "__main__":
    print(json.dumps(asdict(measured(int(sys.argv[1]), int(sys.argv[2])))))
