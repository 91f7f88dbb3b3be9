"""Whole analyses: the static chain of a template, commands from the shell and back, and the engines of campaigns."""

from __future__ import annotations

import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import product
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np

from assessment.analyses.dynamic.histories import Scatter
from assessment.analyses.dynamic.scan import Reach, Scan, scan
from assessment.analyses.dynamic.time_history import Setting
from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.motions import shaking
from assessment.benchmark.cases.structures import assembly, pushed, settled, template
from assessment.benchmark.measure import FAILURES, Case, children, rows_of
from assessment.benchmark.table import Row
from assessment.project.motions import BaseMotion
from assessment.project.schema import MotionTable
from assessment.project.structure.model import build_model
from assessment.runtime.pool import cores
from assessment.runtime.process import collect_rarely
from assessment.runtime.tasks import From, Workers
from assessment.studies.campaign.scans import level_found
from assessment.workflow.run import select
from assessment.workflow.stages import run
from mechanics import ConvergenceError, Record
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures import step_control
from mechanics.procedures.mirror import Mirror

WAYS: tuple[Direction, ...] = ("+x", "-x")
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")


def chain(quick: bool) -> Iterator[Row]:
    """Pushdown, rigid and elastic pushover of both states and directions, one by one and together; whole commands."""
    for name in ("buttressed-arch",) if quick else ("buttressed-arch", "triumphal-arch"):
        yield from analyses(name)
        elapsed = [float(_python("-m", __name__, name)) for _ in range(3)]
        title = f"{name.replace('-', ' ')}, static chain, from the drawing, on all processors"
        yield {"case": title, "whole": True, "elapsed_s": min(elapsed)}
    yield command("assesto --help", "--help")
    if not quick:
        with TemporaryDirectory() as out:
            arguments = ("run", str(template("buttressed-arch").folder), "--out", out)
            yield command("assesto run, buttressed arch, to the PDF", *arguments)
            yield command("assesto run again, nothing changed", *arguments)


def analyses(name: str) -> Iterator[Row]:
    """Every analysis of a template on one processor; last, of all together."""
    rows: list[Row] = []
    for contacts in CONTACTS:
        mirror, paths = Mirror.of(assembly(name), contacts), dict[str, Any]()
        for title, way in [("pushdown", None), *product(("original", "settled"), WAYS)]:
            if title == "settled" and "pushdown" not in paths:
                continue
            work = partial(_path, name, title, way, contacts, paths, mirror)
            count, full = Counter[str](), f"{title}, pushover {way}" if way else title
            with counting(count), suppress(*FAILURES):
                paths[full] = work(1.0)
            case = Case(f"{name.replace('-', ' ')}, {full}, {contacts}", work)
            rows += (row | count for row in rows_of(case))
            yield rows[-1]
    solved = [row for row in rows if row.get("failed") is None]
    summed = ("steps", "attempts", "unsolved", "seconds")
    total: Row = {field: sum(row.get(field, 0) for row in rows) for field in summed}
    total["ratio"] = total["seconds"] / sum(row["seconds"] / row["ratio"] for row in solved)
    lost = len(rows) - len(solved)
    failed = f"{lost} of {len(rows)}, and what depends on them" if lost else None
    yield {"case": f"{name.replace('-', ' ')}, static chain", "whole": True, "failed": failed} | total


def _path(
    name: str, title: str, way: Direction | None, contacts: Behaviour, paths: dict[str, Any], mirror: Mirror | None,
    _: float,
) -> Any:  # fmt: skip
    """The movement of a template, or its curve as drawn or settled; as drawn towards −x by reflection if exact."""
    if way is None:
        return settled(name, contacts)
    other = paths.get("original, pushover +x") if way == "-x" and title == "original" else None
    if mirror and other and (image := mirror.pushover(other)):
        return image
    state = paths["pushdown"].final if title == "settled" else None
    return pushed(name, way, contacts, 1.0, state, None, PAST_PEAK if contacts == "elastic" else 0.0)


@contextmanager
def counting(count: Counter[str]) -> Iterator[None]:
    """Count the attempts at a step of what is analysed meanwhile, and those that are not solved, into `count`."""
    find: Callable[..., Any] = vars(step_control)["find_equilibrium"]
    count.update(attempts=0, unsolved=0)

    def watched(*arguments: Any) -> Any:
        count["attempts"] += 1
        try:
            return find(*arguments)
        except ConvergenceError:
            count["unsolved"] += 1
            raise

    with patch.object(step_control, "find_equilibrium", watched):
        yield


def elapsed(name: str) -> float:
    """Time elapsed (s) of the same analyses on all processors, from the drawing, in a process of its own."""
    collect_rarely()  # as the command
    project = select(template(name), ("pushdown", "pushover"))
    settlements = (project.settlements[0].model_copy(update={"to_collapse": False}),)
    project = project.model_copy(update={"settlements": settlements})
    began = time.perf_counter()
    run(project, build_model(project))
    return time.perf_counter() - began


def command(case: str, *arguments: str) -> Row:
    """Processor time and time elapsed of a whole command."""
    before, began = children(), time.perf_counter()
    _python("-m", "assessment.cli", *arguments)
    taken = {"seconds": children() - before, "elapsed_s": time.perf_counter() - began}
    return {"case": case, "whole": True, **taken}


def _python(*arguments: str) -> str:
    return subprocess.run([sys.executable, *arguments], check=True, capture_output=True, text=True).stdout


def campaigns(quick: bool) -> Iterator[Row]:
    """Elapsed time of some searches on an arch by each engine; `ratio`: of a combination to that in this process.

    Each engine has computed one search in every process before it is timed; `ideal`: the least ratio; `equal`: whether
    the results are those of this process.
    """
    tasks, most, first = _tasks(2 if quick else 8), cores(), list[tuple[float, list[Scan]]]()

    def measured(name: str, count: int, workers: Workers) -> Row:
        titles = [task[1].name for task in tasks]
        with workers:
            workers.each("warm", scan, tasks[:1] * count, titles[:1] * count, False)
            began = time.perf_counter()
            found = workers.each("campaign", scan, tasks, titles, False)
            seconds = time.perf_counter() - began
        first.append((seconds, found))
        alone, expected = first[0]
        motions = sum(each.counts.motions for each in found if each.counts)
        equal = [(one.reason, one.points) for one in found] == [(one.reason, one.points) for one in expected]
        return {
            "case": name, "workers": count, "combinations": len(found), "motions": motions, "elapsed_s": seconds,
            "motions_per_minute": 60.0 * motions / seconds, "ratio": seconds / alone,
            "ideal": 1.0 / min(count, cores()), "equal": equal,
        }  # fmt: skip

    yield measured("this process", 1, Workers(1))
    for count in sorted({2, max(most, 2)}):
        yield measured(f"{count} processes", count, Workers(count))
    with suppress(ImportError):
        from distributed import LocalCluster  # late: few installations have it

        options: dict[str, Any] = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
        with LocalCluster(n_workers=most, processes=True, **options) as cluster:  # type: ignore[no-untyped-call]
            workers = Workers(scheduler=cluster.scheduler_address)
            yield measured(f"Dask, {most} workers", most, workers)


def _tasks(count: int) -> list[tuple[Any, ...]]:
    """Searches as drawn and settled, by both signs, with a number of records: sines of 1 to 3 Hz that grow and end.

    The other sign begins in the bracket of the first one, and the settled state in that of the same sign as drawn.
    """
    model, step = assembly("arch"), 0.005
    setting = Setting(MotionTable(contacts="rigid"), template("arch").control[0])
    states, at = (model.initial, settled("arch", "rigid").final), np.arange(0.0, 3.0, step)
    tasks: list[tuple[Any, ...]] = []
    for frequency in np.linspace(1.0, 3.0, count):
        first = len(tasks)
        for (start, sign), before in zip(product(states, (1.0, -1.0)), (None, 0, 0, 1), strict=True):
            record = Record(sign * shaking(0.3, frequency)(at), step, f"{frequency:.3g} Hz")
            motion = BaseMotion(record, record, record.pga, 1.0)
            near = None if before is None else From(first + before, level_found)
            tasks.append((model, motion, setting, start, Scatter(1, 0.05), Reach(max_scale=5.0), near))
    return tasks


if __name__ == "__main__":
    print(elapsed(sys.argv[1]))
