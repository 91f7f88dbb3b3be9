"""Campaigns: what a combination takes in this process, in processes side by side, and on a Dask cluster of them.

And on a cluster of many workers, simulated: what searches take and what is sent is measured, and which of them waits
for which is as in a campaign.
"""

from __future__ import annotations

import heapq
import pickle
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from assessment.analyses.dynamic.ensemble import Scatter
from assessment.analyses.dynamic.response import Setting
from assessment.benchmark.cases.dynamics import shaking
from assessment.benchmark.cases.structures import assembly, template
from assessment.benchmark.table import Row
from assessment.project.motions import BaseMotion
from assessment.project.schema import MotionTable
from assessment.runtime.cache import packed
from assessment.runtime.processes.pool import cores
from assessment.runtime.tasks import From, Workers
from assessment.studies.campaign.search import Combination, Reach, level_found, search_collapse
from mechanics import pushdown
from mechanics.records import Record

STEP, DURATION = 0.005, 3.0  # s, of the records
STRENGTH = 0.3  # g
REACH = Reach(max_scale=5.0, tolerance=0.05)
SINGLE = Scatter(1, 0.05)
SHARES, RECORDS, SIGNS = 5, 20, 2  # of the campaign that is simulated: 200 combinations
SIMULATED = (4, 16)  # workers
LINK = 1.25e7  # bytes/s in and out of the machine that asks: 100 Mbit/s
DISPATCH = 1e-3  # s that the scheduler takes for a task, one after the other: the figure of Dask's manual


@dataclass(frozen=True, kw_only=True)
class Engine(Row):
    """What an engine takes for the searches of so many combinations; `ideal`: the least `ratio`.

    `equal`: whether the results are those of this process; of a combination `sent_kB` and `returned_kB`, in the mean.
    """

    workers: int
    combinations: int
    motions: int
    elapsed_s: float
    motions_per_minute: float
    ratio: float
    ideal: float
    sent_kB: float | None = None
    returned_kB: float | None = None
    equal: bool | None = True


def campaigns(quick: bool) -> Iterator[Engine]:
    """Elapsed time of some searches on an arch by each engine; `ratio`: of a combination to that in this process.

    Each engine has computed one search in every process before it is timed. The results are the same. Of a simulated
    cluster, a campaign of SHARES, RECORDS and SIGNS, which take what they took in this process, in turn.
    """
    tasks = _tasks(2 if quick else 8)
    most = cores()
    alone, expected = _timed(Workers(1), tasks, 1)
    yield _row("this process", 1, expected, alone, alone)
    yield from _simulated_rows(tasks, expected)
    for count in sorted({2, most} if most > 1 else {2}):
        yield _compared(f"{count} processes", count, Workers(count), tasks, expected, alone)
    try:
        from distributed import LocalCluster  # late: few installations have it
    except ImportError:
        return
    start: Any = LocalCluster
    options: dict[str, Any] = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with start(n_workers=most, processes=True, **options) as cluster:
        workers = Workers(scheduler=cluster.scheduler_address)
        yield _compared(f"Dask, {most} workers", most, workers, tasks, expected, alone)


def _tasks(count: int) -> list[tuple[Any, ...]]:
    """Searches as drawn and settled, by both signs, with a number of records: sines of 1 to 3 Hz that grow and end."""
    project, model = template("arch"), assembly("arch")
    (table,) = project.settlements
    settled = pushdown(model, table.support, table.displacement_m, increment=table.increment_m or 0.0).final
    setting = Setting(MotionTable(contacts="rigid"), project.control[0])
    at = np.arange(0.0, DURATION, STEP)
    tasks: list[tuple[Any, ...]] = []
    for frequency in np.linspace(1.0, 3.0, count):
        first = len(tasks)
        for (start, sign), neighbour in zip(
            product((model.initial, settled), (1.0, -1.0)), neighbours_of(2, 1, SIGNS), strict=True
        ):
            record = Record(sign * shaking(STRENGTH, frequency)(at), STEP, f"{frequency:.3g} Hz")
            motion = BaseMotion(record, record, record.pga, 1.0)
            near = None if neighbour is None else From(first + neighbour, level_found)
            tasks.append((model, motion, setting, start, SINGLE, REACH, (), near))
    return tasks


def _timed(workers: Workers, tasks: list[tuple[Any, ...]], count: int) -> tuple[float, list[Combination]]:
    titles = [task[1].name for task in tasks]
    with workers:
        workers.each("warm", search_collapse, tasks[:1] * count, titles[:1] * count, False)
        began = time.perf_counter()
        found = workers.each("campaign", search_collapse, tasks, titles, False)
        return time.perf_counter() - began, found


def _compared(
    name: str,
    count: int,
    workers: Workers,
    tasks: list[tuple[Any, ...]],
    expected: list[Combination],
    alone: float,
) -> Engine:
    seconds, found = _timed(workers, tasks, count)
    row = _row(name, count, found, seconds, alone)
    return replace(row, equal=[_levels(each) for each in found] == [_levels(each) for each in expected])


def _levels(found: Combination) -> tuple[object, ...]:
    """What a combination is but for the time that it took."""
    return found.judged, found.reason, found.runs, found.points


def _simulated_rows(tasks: Sequence[tuple[Any, ...]], found: Sequence[Combination]) -> Iterator[Engine]:
    """Rows of clusters that are simulated; `sent_kB`, `returned_kB`: of a combination, in the mean."""
    sent = [len(pickle.dumps(task)) for task in tasks]
    returned = [len(packed(each).encode()) for each in found]
    each = 2 * SIGNS  # measured of a record: of all shares but the first the same
    neighbours = neighbours_of(SHARES, RECORDS, SIGNS)
    shaken = [
        each * record % len(found) + SIGNS * min(share, 1) + sign
        for share, record, sign in product(range(SHARES), range(RECORDS), range(SIGNS))
    ]
    work = [
        Task(found[k].seconds, sent[k], returned[k], after)
        for k, after in zip(shaken, neighbours, strict=True)
    ]
    alone = sum(task.seconds for task in work)
    many = [found[k] for k in shaken]
    for count in SIMULATED:
        row = _row(f"{count} workers, simulated", count, many, simulated(work, count), alone)
        yield replace(
            row,
            ideal=1.0 / count,
            equal=None,
            sent_kB=float(np.mean(sent)) / 1e3,
            returned_kB=float(np.mean(returned)) / 1e3,
        )


@dataclass(frozen=True, slots=True)
class Task:
    """What a task of a simulated cluster takes (s), its bytes, and the number of the one whose result it needs."""

    seconds: float
    sent: int = 0
    returned: int = 0
    after: int | None = None


def neighbours_of(shares: int, records: int, signs: int) -> list[int | None]:
    """The number of each search's neighbour, None: it has none; in the order of a campaign: shares, records, signs.

    A search begins in the bracket of the same record and sign at the share before, at the first share in that of the
    record's first sign.
    """
    found: list[int | None] = []
    for share, _, sign in product(range(shares), range(records), range(signs)):
        number = len(found)
        if share:
            found.append(number - records * signs)
        else:
            found.append(number - sign if sign else None)
    return found


def simulated(work: Sequence[Task], workers: int) -> float:
    """Time (s) of tasks on `workers`: each is sent when it may be, in order, and computed by the first free worker.

    All pass one link, the scheduler gives out one task after the other; a worker waits for what it is to compute, a
    task for the result of the one that it comes after to be back.
    """
    free = [0.0] * workers
    out = back = 0.0
    sending, ending = 0, 1  # what happens, in the order of time
    events = [(0.0, sending, number) for number, task in enumerate(work) if task.after is None]
    followers: dict[int, list[int]] = {}
    for number, task in enumerate(work):
        if task.after is not None:
            followers.setdefault(task.after, []).append(number)
    while events:
        now, kind, number = heapq.heappop(events)
        task = work[number]
        if kind == sending:
            out = max(out, now) + DISPATCH + task.sent / LINK
            ended = max(heapq.heappop(free), out) + task.seconds
            heapq.heappush(free, ended)
            heapq.heappush(events, (ended, ending, number))
        else:
            back = max(back, now) + task.returned / LINK
            for follower in followers.get(number, ()):
                heapq.heappush(events, (back, sending, follower))
    return back


def _row(name: str, count: int, found: list[Combination], seconds: float, alone: float) -> Engine:
    motions = sum(each.runs for each in found)
    return Engine(
        case=name,
        workers=count,
        combinations=len(found),
        motions=motions,
        elapsed_s=seconds,
        motions_per_minute=60.0 * motions / seconds,
        ratio=seconds / alone,
        ideal=1.0 / min(count, cores()),
    )
