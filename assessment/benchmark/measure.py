"""Processor time, and the baseline to which every time is a ratio.

The baseline is PIQP called once a step on freshly built sparse matrices, for the same program, in the same run: a
ratio carries over to other machines, and to a busy one, where seconds do not.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from unittest.mock import patch

import numpy as np

from mechanics.program import Program, Solution
from mechanics.solvers import interior_point
from mechanics.solvers.newton import Newton

Row = dict[str, Any]
"""A line of a table: what was measured, by column."""

Answer = TypeVar("Answer")

TOLERANCE = 1e-9  # of the baseline: what the statics ask of PIQP
SAMPLES = 20  # programs of a path that the baseline solves
ENOUGH = 0.3  # s: a call is repeated so long, twice at least, and the quickest counts
AGAIN = 5  # so often every program of the baseline


def seconds_of(work: Callable[[], Answer]) -> tuple[float, Answer]:
    """Processor time (s) of this process in one call, and what it returns."""
    began = time.process_time()
    answer = work()
    return time.process_time() - began, answer


def best(work: Callable[[], Answer]) -> tuple[float, Answer]:
    """The least processor time (s) of some calls, and what the last one returns."""
    least, answer = seconds_of(work)
    spent, calls = least, 1
    while calls < 2 or spent < ENOUGH:
        seconds, answer = seconds_of(work)
        least, spent, calls = min(least, seconds), spent + seconds, calls + 1
    return least, answer


def piqp(program: Program) -> float:
    """Processor time (s) of PIQP on one program, its matrices built anew."""
    return seconds_of(lambda: interior_point.solve(program, TOLERANCE))[0]


def once_a_step(programs: Sequence[Program]) -> float:
    """Processor time (s) of PIQP called once for each program of a static path, from a sample of them."""
    sample = programs[:: max(len(programs) // SAMPLES, 1)]
    return len(programs) / len(sample) * sum(min(piqp(p) for _ in range(AGAIN)) for p in sample)


@dataclass
class Beside:
    """What PIQP took beside time histories: `spent` (s) on `sampled` of the `solves` programs."""

    spent: float = 0.0
    sampled: int = 0
    solves: int = 0

    @property
    def each(self) -> float:
        """Processor time (s) of PIQP on one program, in the mean; NaN where none was sampled."""
        return self.spent / self.sampled if self.sampled else float("nan")


@contextmanager
def piqp_beside(every: int) -> Iterator[Beside]:
    """Have PIQP solve every so manieth program of the time histories within, too."""
    beside, solve = Beside(), Newton.solve

    def both(newton: Newton, program: Program, *near: Any) -> Solution | None:
        beside.solves += 1
        if beside.solves % every == 0:
            beside.spent += piqp(program)
            beside.sampled += 1
        return solve(newton, program, *near)

    with patch.object(Newton, "solve", both):
        yield beside


@contextmanager
def newtons_laid_out() -> Iterator[list[Newton]]:
    """The solvers of the time histories within, which count their factorisations."""
    newtons: list[Newton] = []
    lay_out = Newton.__post_init__

    def noted(newton: Newton) -> None:
        lay_out(newton)
        newtons.append(newton)

    with patch.object(Newton, "__post_init__", noted):
        yield newtons


def exponent(rows: Sequence[Row], column: str) -> float:
    """Of what a column holds, as a power of the number of blocks: the slope of a straight line in logarithms."""
    return float(np.polyfit(np.log([r["blocks"] for r in rows]), np.log([r[column] for r in rows]), 1)[0])


def peak_memory() -> float:
    """The most memory (MB) that this process has come to hold, Python and its libraries included."""
    status = Path("/proc/self/status")
    if status.is_file():  # getrusage also counts what the parent held as this process was made
        for line in status.read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM"):
                return float(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
