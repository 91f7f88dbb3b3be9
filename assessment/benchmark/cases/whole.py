"""Whole analyses: the static chain of a template, and commands from the shell and back."""

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

from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.structures import assembly, pushed, settled, template
from assessment.benchmark.measure import FAILURES, Case, children, rows_of
from assessment.benchmark.table import Row
from assessment.project.structure.model import build_model
from assessment.runtime.process import collect_rarely
from assessment.workflow.run import select
from assessment.workflow.stages import run
from mechanics import ConvergenceError
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


if __name__ == "__main__":
    print(elapsed(sys.argv[1]))
