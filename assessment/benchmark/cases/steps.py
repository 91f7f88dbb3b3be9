"""The time that a step of a history takes, where in it, and how it grows with the number of blocks."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any
from unittest.mock import patch

import numpy as np

from assessment.benchmark.cases.dynamics import INTEGRATORS
from assessment.benchmark.cases.structures import (
    arch_on_piers,
    assembly,
    block_on_base,
    running_bond,
    template,
)
from assessment.benchmark.measure import FAILURES, exponent, history_programs, peak_memory, piqp
from assessment.benchmark.table import Row
from assessment.project.catalogue.record import RECORD
from mechanics import Assembly, TimeHistory, time_history
from mechanics.model.assembly import Behaviour
from mechanics.procedures import time_history as histories
from mechanics.procedures.time_history import HistoryTolerances, Integrator
from mechanics.program import Program
from mechanics.records.record import read_record
from mechanics.steps.dynamic_system import DynamicSystem
from mechanics.types import Array

STEP, WINDOW = 0.005, (4.0, 11.0)  # s: of the artificial record that comes with every template
QUICK_WINDOW = (4.0, 5.0)
WALLS = ((9, 10), (18, 19), (31, 32), (54, 55))
QUICK_WALLS = ((6, 6), (9, 10), (14, 14))
SHARE = 0.07  # of the record, for the walls
BLOCK = 20  # steps of a block
SAMPLES = 20  # programs that PIQP solves
ROUNDS, ENOUGH, QUICK = 6, 8.0, 0.0  # at least; and s of a row


@dataclass(frozen=True, kw_only=True)
class StepTime(Row):
    """Time of a step, ms, of it in compiled steps (`march_ms`), and PIQP's; counts; largest memory, MB."""

    blocks: int | None = None
    joints: int | None = None
    contacts: Behaviour
    integrator: Integrator | None = None
    step_ms: float = np.nan
    march_ms: float = np.nan
    piqp_ms: float = np.nan
    ratio: float = np.nan
    rounds: int | None = None
    steps: int | None = None
    programs_per_step: float = np.nan
    iterations_per_step: float = np.nan
    halvings: int | None = None
    cold: int | None = None
    collapsed: bool | None = None
    peak_memory_MB: float = np.nan


def steps(quick: bool) -> Iterator[StepTime]:
    """A row for every case, contact behaviour and integrator."""
    record = strong_record(QUICK_WINDOW if quick else WINDOW)
    for name, model, pga, share in cases(quick):
        shaking = pga * record[: round(share * len(record))]
        for contacts, integrators in INTEGRATORS.items():
            for integrator in integrators:
                yield measured(name, model, shaking, contacts, integrator, QUICK if quick else ENOUGH)


def growth(quick: bool) -> Iterator[StepTime]:
    """A row for every wall, implicit Euler; and the exponent of the time of a step over the number of blocks."""
    record = strong_record(WINDOW)
    record = 0.55 * record[: round(SHARE * len(record))]

    def wall(columns: int, courses: int, contacts: Behaviour) -> StepTime:
        model = running_bond(columns, courses, stiffness=1e7)
        enough = QUICK if quick else ENOUGH
        return measured(f"wall {columns} × {courses}", model, record, contacts, "implicit-euler", enough)

    for contacts in INTEGRATORS:
        rows = [wall(*size, contacts) for size in (QUICK_WALLS if quick else WALLS)]
        yield from rows
        solved = [row for row in rows if row.failed is None]
        if len(solved) > 1:
            yield StepTime(case="exponent", contacts=contacts, step_ms=exponent(solved, "step_ms"))


def strong_record(window: tuple[float, float]) -> Array:
    """Accelerations (k,) of unit peak, STEP apart: a part of the artificial record of the templates, in s."""
    record = read_record(template("triumphal-arch").folder / RECORD).resampled(STEP).windowed(*window)
    return record.acceleration / record.pga


def cases(quick: bool) -> list[tuple[str, Assembly, float, float]]:
    """Name, structure, PGA in g and share of the record."""
    some = [
        ("2 blocks", block_on_base(0.6, 4.2, stiffness=1e6), 0.3, 1.0),
        ("buttressed arch", assembly("buttressed-arch"), 0.03, 1.0),
        ("arch on piers", arch_of_67_blocks(), 0.05, 1.0),
    ]
    if quick:
        return some
    return [
        *some,
        ("wall 18 × 19", running_bond(18, 19, stiffness=1e7), 0.55, 1.0),
        ("triumphal arch", assembly("triumphal-arch"), 0.2, SHARE),
    ]


def arch_of_67_blocks() -> Assembly:
    """An arch of 2 m on piers, of which two blocks are supports."""
    return arch_on_piers(
        radius=2.0,
        thickness=0.3,
        voussoirs=27,
        pier_height=2.0,
        pier_width=0.8,
        courses=19,
        friction=0.65,
        stiffness=1e6,
        depth=0.5,
        unit_weight=18.0,
    )


def measured(
    case: str, model: Assembly, record: Array, contacts: Behaviour, integrator: Integrator, enough: float
) -> StepTime:
    """Milliseconds a step, their ratio to PIQP once a step, and the counts that do not depend on the clock.

    The motion, and PIQP on some of its programs, evenly spaced, are repeated in turn until they have taken `enough`
    seconds. Of each block of its steps, and of each program, the quickest counts: what else the machine does meanwhile
    is left out of both.
    """
    run = partial(time_history, model, record, STEP, contacts, integrator=integrator)
    row = StepTime(
        case=case,
        blocks=int(model.movable.sum()),
        joints=len(model.contacts),
        contacts=contacts,
        integrator=integrator,
    )
    try:
        motion = run()
    except FAILURES as error:
        return replace(row, failed=str(error))
    programs = _programs(model, contacts, motion, record)
    blocks: list[Array] = []
    solved: list[list[float]] = []
    began = time.perf_counter()
    while len(blocks) < ROUNDS or time.perf_counter() - began < enough:
        blocks.append(_blocks(run))
        solved.append([piqp(program) for program in programs])
    n = len(motion.time) - 1
    inside, outside = np.min(blocks, axis=0).T
    step = 1e3 * float(inside.sum() + outside.sum()) / n
    each = 1e3 * float(np.min(solved, axis=0).mean())
    return replace(
        row,
        step_ms=step,
        march_ms=1e3 * float(inside.sum()) / n,
        piqp_ms=each,
        ratio=step / each,
        rounds=len(blocks),
        steps=n,
        programs_per_step=motion.programs / n,
        iterations_per_step=motion.iterations / n,
        halvings=motion.halvings,
        cold=motion.cold,
        collapsed=motion.collapsed,
        peak_memory_MB=peak_memory(),
    )


def _programs(model: Assembly, contacts: Behaviour, motion: TimeHistory, record: Array) -> list[Program]:
    every = max((len(motion.time) - 1) // SAMPLES, 1)
    return history_programs(model, contacts, motion, record, every)


def _blocks(run: Callable[..., TimeHistory]) -> Array:
    """Time (s) of a motion in blocks of at most BLOCK steps (k, 2): inside its compiled steps, and between them.

    Without the state at rest from which it begins.
    """
    march, settled = DynamicSystem.march, histories._settled
    times: list[tuple[float, float]] = []
    last = time.perf_counter()

    def at_rest(*arguments: Any) -> Any:
        nonlocal last
        state = settled(*arguments)
        last = time.perf_counter()
        return state

    def marching(*arguments: Any) -> Any:
        nonlocal last
        began = time.perf_counter()
        part = march(*arguments)
        ended = time.perf_counter()
        times.append((ended - began, began - last))
        last = ended
        return part

    with (
        patch.object(histories, "_settled", at_rest),
        patch.object(DynamicSystem, "march", marching),
    ):
        run(tolerances=HistoryTolerances(chunk=BLOCK))
    times.append((0.0, time.perf_counter() - last))
    return np.array(times)
