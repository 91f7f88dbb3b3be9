"""Processor time, and the baseline to which every time is a ratio.

The baseline is PIQP called once a step on freshly built sparse matrices, for the same program, in the same run: a
ratio carries over to other machines, and to a busy one, where seconds do not. Whatever its bed, a joint is there one of
two contact points at its ends, the least that PIQP can be given.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np

from mechanics import (
    Assembly,
    CollapseError,
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    State,
    TimeHistory,
    UnstableError,
)
from mechanics.kernels.law import SEGMENTS
from mechanics.model.assembly import Behaviour
from mechanics.procedures.pushdown import Pushdown
from mechanics.procedures.pushover import Pushover
from mechanics.program import Program
from mechanics.solvers import qp_piqp
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.types import GRAVITY, Array

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

Answer = TypeVar("Answer")


class Sized(Protocol):
    """A row of a structure of so many blocks."""

    @property
    def blocks(self) -> int | None:
        """Movable blocks."""


FAILURES = (CollapseError, ControlError, ConvergenceError, NoEquilibriumError, UnstableError)
"""What an analysis that does not succeed raises: a row says so."""

TOLERANCE = 1e-9  # of the baseline: what the statics ask of PIQP
SAMPLES = 20  # programs of a path that the baseline solves
ROUNDS, ENOUGH = 3, 1.5  # calls that take turns: least number of each, and least time in s


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
    seconds, *solves = in_turn(work, *(partial(qp_piqp.solve, ends_only(p), TOLERANCE) for p in programs))
    return seconds, float(np.mean(solves))


def piqp(program: Program) -> float:
    """Processor time (s) of PIQP on one program, its matrices built anew."""
    least = ends_only(program)
    return seconds_of(lambda: qp_piqp.solve(least, TOLERANCE))[0]


def ends_only(program: Program) -> Program:
    """The program with beds of one segment."""
    law = program.law.copy()
    law[:, SEGMENTS] = 1.0
    return replace(program, law=law)


def once_a_step(work: Callable[[], object], path: Pushdown | Pushover) -> tuple[float, float]:
    """Least processor time (s) of a static path, and its ratio to PIQP called once for each of its steps."""
    programs = path_programs(path)
    seconds, each = beside_piqp(work, programs)
    return seconds, seconds / len(path.steps) / each


def path_programs(path: Pushdown | Pushover) -> list[Program]:
    """Programs that lead from points of a path, SAMPLES or a few more, to the next ones."""
    every = max(len(path.steps) // SAMPLES, 1)
    programs = []
    for before, step in list(pairwise(path.steps))[::every]:
        model = step.system.model
        moved = step.state.positions - before.state.positions
        size = max(float(abs(moved[:, :2]).max()), 1e-6 * model.size)
        lateral, work = None, 0.0
        if isinstance(path, Pushover):
            lateral = model.lateral_load("+x")
            work = float((lateral * moved).sum())
        at = np.where(model.movable[:, None], before.state.positions, step.state.positions)
        problem = StepProblem(step.system, before.state, model.dead_load, size, lateral, work)
        programs.append(problem.pose(at, None)[0])
    return programs


def history_programs(
    model: Assembly, behaviour: Behaviour, motion: TimeHistory, acceleration: Array, every: int
) -> list[Program]:
    """The implicit Euler steps (paper, eq. 3) from every `every`-th state of a motion; accelerations (k,) in g."""
    step = float(motion.time[1])
    return [
        euler_step(
            model, behaviour, State(motion.positions[k], motion.velocities[k]), acceleration[k + 1], step
        )
        for k in range(0, len(motion.time) - 1, every)
    ]


def euler_step(
    model: Assembly, behaviour: Behaviour, state: State, acceleration: float, step: float = 0.005
) -> Program:
    """The program of an implicit Euler step (s) under a base acceleration in g (paper, eq. 3)."""
    speed = float(abs(state.velocities[:, :2]).max())
    size = max(GRAVITY * step**2, step * speed)
    system = static_system(model, behaviour).around(state.positions, size)
    inertia = model.mass / step**2
    load = model.dead_load - acceleration * GRAVITY * model.mass * (1.0, 0.0, 0.0)
    problem = StepProblem(system, state, load + step * inertia * state.velocities, size, mass=inertia)
    return problem.pose(state.positions, None)[0]


def exponent(rows: Sequence[Sized], column: str) -> float:
    """Of what a column holds, as a power of the number of blocks: the slope of a straight line in logarithms."""
    sizes = np.array([row.blocks for row in rows], dtype=float)
    return float(np.polyfit(np.log(sizes), np.log([getattr(row, column) for row in rows]), 1)[0])


def peak_memory() -> float:
    """The largest memory (MB) of this process so far, Python and its libraries included.

    NaN where the system does not count it.
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
