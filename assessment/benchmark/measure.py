"""Processor time, and the baseline to which every time is a ratio.

The baseline is PIQP called once a step on freshly built sparse matrices, for the same program, in the same run: a
ratio carries over to other machines, and to a busy one, where seconds do not.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from unittest.mock import patch

import numpy as np

from mechanics.block import Array
from mechanics.program import Program, Solution
from mechanics.solvers import interior_point
from mechanics.solvers.newton import Newton

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

Row = dict[str, Any]
"""A line of a table: what was measured, by column."""

Answer = TypeVar("Answer")

TOLERANCE = 1e-9  # of the baseline: what the statics ask of PIQP
SAMPLES = 20  # programs of a path that the baseline solves
ROUNDS, ENOUGH = 3, 1.5  # calls that take turns: at least so many of each, and for so many seconds


def seconds_of(work: Callable[[], Answer]) -> tuple[float, Answer]:
    """Processor time (s) of this process in one call, and what it returns."""
    began = time.process_time()
    answer = work()
    return time.process_time() - began, answer


def in_turn(*works: Callable[[], object]) -> Array:
    """The least processor time (s) of each of some calls (k,), which take turns.

    A machine may be slow for seconds at a time: all of them are so then, and their ratios stay. What holds it up for
    milliseconds is left out of short calls alone.
    """
    rounds: list[list[float]] = []
    while len(rounds) < ROUNDS or np.sum(rounds) < ENOUGH:
        rounds.append([seconds_of(work)[0] for work in works])
    least: Array = np.min(rounds, axis=0)
    return least


def beside_piqp(work: Callable[[], object], programs: Sequence[Program]) -> tuple[float, float]:
    """Least processor time (s) of a call and, in the mean over some programs, of PIQP: in turn, see there."""
    seconds, *solves = in_turn(work, *(partial(interior_point.solve, p, TOLERANCE) for p in programs))
    return seconds, float(np.mean(solves))


def piqp(program: Program) -> float:
    """Processor time (s) of PIQP on one program, its matrices built anew."""
    return seconds_of(lambda: interior_point.solve(program, TOLERANCE))[0]


def once_a_step(work: Callable[[], object], programs: Sequence[Program]) -> tuple[float, float]:
    """Least processor time (s) of a static path of these programs, and its ratio to PIQP called once for each."""
    seconds, each = beside_piqp(work, programs[:: max(len(programs) // SAMPLES, 1)])
    return seconds, seconds / len(programs) / each


@contextmanager
def programs_kept(every: int) -> Iterator[list[Program]]:
    """Every so manieth program that the time histories within solve."""
    programs: list[Program] = []
    solve = Newton.solve

    def kept(newton: Newton, program: Program, *near: Any) -> Solution | None:
        if newton.solved % every == 0:
            programs.append(replace(program, gap=program.gap.copy()))  # gaps are shifted in place
        return solve(newton, program, *near)

    with patch.object(Newton, "solve", kept):
        yield programs


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
    """The most memory (MB) that this process has come to hold, Python and its libraries included.

    NaN where the system does not tell.
    """
    status = Path("/proc/self/status")
    if status.is_file():  # getrusage also counts what the parent held as this process was made
        for line in status.read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM"):
                return float(line.split()[1]) / 1024.0
    if resource is None:
        return math.nan
    unit = 1.0 if sys.platform == "darwin" else 1024.0  # bytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1024.0**2
