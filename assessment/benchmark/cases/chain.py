"""Whole analyses: the static chain of the triumphal arch, and commands from the shell and back."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.structures import assembly, template
from assessment.benchmark.measure import FAILURES, ROUNDS, once_a_step
from assessment.benchmark.table import Row
from assessment.project.structure.model import build_model
from assessment.runtime.processes.garbage import collect_rarely
from assessment.workflow.selection import select
from assessment.workflow.stages import run
from mechanics import ConvergenceError, pushdown, pushover
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures import step_control
from mechanics.procedures.mirror import Mirror
from mechanics.procedures.pushdown import Pushdown
from mechanics.procedures.pushover import Pushover

WAYS: tuple[Direction, ...] = ("+x", "-x")
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")


@dataclass(frozen=True, kw_only=True)
class Analysis(Row):
    """An analysis, or `whole` chains and commands: processor time and time elapsed (s).

    Of the `attempts` at a step so many were `unsolved`: the step was halved then.
    """

    whole: bool = False
    steps: int | None = None
    attempts: int | None = None
    unsolved: int | None = None
    seconds: float = math.nan
    ratio: float = math.nan
    elapsed_s: float = math.nan


def chain(quick: bool) -> Iterator[Analysis]:
    """Pushdown, rigid and elastic pushover of both states and directions, one by one and together; whole commands."""
    names = ("buttressed-arch",) if quick else ("buttressed-arch", "triumphal-arch")
    for name in names:
        yield from analyses(name)
        yield side_by_side(name)
    yield from commands(quick)


def analyses(name: str) -> Iterator[Analysis]:
    """Processor time of every analysis of a template on one processor; last, of all together."""
    project, model = template(name), assembly(name)
    (table,) = project.settlements
    assert project.pushover is not None
    assert table.increment_m is not None
    increment, spoken = project.pushover.increment_m, name.replace("-", " ")
    rows: list[Analysis] = []
    for contacts in CONTACTS:
        mirror = Mirror.of(model, contacts)
        settle = partial(
            pushdown, model, table.support, table.displacement_m, 0.0, table.increment_m, contacts
        )
        row, path = _row(f"{spoken}, pushdown, {contacts}", settle)
        rows.append(row)
        yield row
        for title in ("original", "settled"):
            if title == "settled" and not isinstance(path, Pushdown):
                continue
            state = path.final if title == "settled" and isinstance(path, Pushdown) else None
            curve: object = None
            for way in WAYS:
                control = project.pushover_control(way).point_m
                until = PAST_PEAK if contacts == "elastic" else 0.0
                push: Callable[[], object] = partial(
                    pushover, model, control, way, contacts, increment, state, until
                )
                if state is None and isinstance(curve, Pushover) and mirror and mirror.pushover(curve):
                    push = partial(mirror.pushover, curve)
                row, curve = _row(f"{spoken}, {title}, pushover {way}, {contacts}", push)
                rows.append(row)
                yield row
    solved = [row for row in rows if row.failed is None]
    failed = len(rows) - len(solved)
    total = sum(row.seconds for row in solved)
    baseline = sum(row.seconds / row.ratio for row in solved)
    yield Analysis(
        case=f"{spoken}, static chain",
        whole=True,
        steps=sum(row.steps or 0 for row in solved),
        attempts=sum(row.attempts or 0 for row in rows),
        unsolved=sum(row.unsolved or 0 for row in rows),
        seconds=total,
        ratio=total / baseline,
        failed=f"{failed} of {len(rows)}, and what depends on them" if failed else None,
    )


def _row(case: str, work: Callable[[], object]) -> tuple[Analysis, object]:
    """A row, and what the work returns."""
    count = Counter[str]()
    try:
        with counting(count):
            path = work()
    except FAILURES as error:
        return Analysis(
            case=case, failed=str(error), attempts=count["attempts"], unsolved=count["unsolved"]
        ), None
    assert isinstance(path, Pushdown | Pushover)
    seconds, ratio = once_a_step(work, path)
    row = Analysis(
        case=case,
        steps=len(path.steps),
        attempts=count["attempts"],
        unsolved=count["unsolved"],
        seconds=seconds,
        ratio=ratio,
    )
    return row, path


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


def side_by_side(name: str) -> Analysis:
    """Time elapsed of the same analyses on all processors, from the drawing to the curves: the least of some."""
    runs = []
    for _ in range(ROUNDS):
        done = subprocess.run(
            [sys.executable, "-m", __name__, name], check=True, capture_output=True, text=True
        )
        runs.append(float(done.stdout))
    case = f"{name.replace('-', ' ')}, static chain, from the drawing, on all processors"
    return Analysis(case=case, whole=True, elapsed_s=min(runs))


def _elapsed(name: str) -> float:
    """Time elapsed (s) in a process of its own, where nothing has been loaded but the analyses themselves."""
    collect_rarely()  # as the command
    project = select(template(name), ("pushdown", "pushover"))
    (table,) = project.settlements
    settlements = (table.model_copy(update={"to_collapse": False}),)
    project = project.model_copy(update={"settlements": settlements})
    began = time.perf_counter()
    run(project, build_model(project))
    return time.perf_counter() - began


def commands(quick: bool) -> Iterator[Analysis]:
    """Processor time and time elapsed of whole commands."""
    yield _command("assesto --help", "--help")
    if not quick:
        folder = template("buttressed-arch").folder
        with TemporaryDirectory() as out:
            yield _command("assesto run, buttressed arch, to the PDF", "run", str(folder), "--out", out)
            yield _command("assesto run again, nothing changed", "run", str(folder), "--out", out)
            assert (Path(out) / "report.html").is_file()


def _command(case: str, *arguments: str) -> Analysis:
    before, began = _children(), time.perf_counter()
    subprocess.run([sys.executable, "-m", "assessment.cli", *arguments], check=True, capture_output=True)
    elapsed = time.perf_counter() - began
    return Analysis(case=case, whole=True, seconds=_children() - before, elapsed_s=elapsed)


def _children() -> float:
    """Processor time (s) of finished child processes; Windows does not count it: 0."""
    used = os.times()
    return used.children_user + used.children_system


if __name__ == "__main__":
    print(_elapsed(sys.argv[1]))
