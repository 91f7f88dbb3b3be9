"""Whole analyses: the static chain of a template, commands from the shell and back, what a scene does not need."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from assessment.analyses.states import PAST_PEAK
from assessment.benchmark.measure import FAILURES, Case, Row, in_turn, rows_of
from assessment.benchmark.motions import DAMPING, STEP, pulse
from assessment.benchmark.structures import assembly, block_on_base, pushed, settled, template
from assessment.ntc.curve_fit import SECANT_SHARE
from assessment.project.catalogue.new_project import RECORD
from assessment.project.model import build_model
from assessment.project.schema import HistoryTable
from assessment.results.schema.part import known
from assessment.runtime.cache import Store
from assessment.workflow.run import select
from assessment.workflow.stages import run
from mechanics import time_history
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures import time_history as histories
from mechanics.procedures.collapse import TURNED
from mechanics.procedures.mirror import Mirror
from mechanics.types import Array

WAYS: tuple[Direction, ...] = ("+x", "-x")
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")


def chain(quick: bool) -> Iterator[Row]:
    """Pushdown, rigid and elastic pushover of both states and directions, one by one and together; whole commands."""
    for name in ("buttressed-arch",) if quick else ("buttressed-arch", "triumphal-arch"):
        yield from analyses(name)
        with TemporaryDirectory() as out:
            arguments = ("run", str(template(name).folder), "--out", out)
            statics = (*arguments, "--only", "pushdown,pushover", "--no-report", "--fresh")
            yield command(f"assesto run, {name.replace('-', ' ')}, statics", *statics)
            if not quick:
                yield command(f"assesto run, {name.replace('-', ' ')}, to the PDF", *arguments)
                yield command("assesto run again, nothing changed", *arguments)
    yield command("assesto --help", "--help")


def analyses(name: str) -> Iterator[Row]:
    """Every analysis of a template on one processor; last, of all together."""
    rows: list[Row] = []
    for contacts in CONTACTS:
        mirror, paths = Mirror.of(assembly(name), contacts), dict[str, Any]()
        for title, way in [("pushdown", None), *product(("original", "settled"), WAYS)]:
            if title == "settled" and "pushdown" not in paths:
                continue
            work = partial(_path, name, title, way, contacts, paths, mirror)
            full = f"{title}, pushover {way}" if way else title
            with suppress(*FAILURES):
                paths[full] = work(1.0)
            rows += rows_of(Case(f"{name.replace('-', ' ')}, {full}, {contacts}", work))
            yield rows[-1]
    solved = [row for row in rows if row.get("failed") is None]
    total: Row = {field: sum(row.get(field, 0) for row in rows) for field in ("steps", "seconds")}
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


def command(case: str, *arguments: str) -> Row:
    """Processor time and time elapsed of a whole command."""
    before = os.times()
    subprocess.run([sys.executable, "-m", "assessment.cli", *arguments], check=True, capture_output=True)
    _, _, user, system, elapsed = (now - then for now, then in zip(os.times(), before, strict=True))
    return {"case": case, "whole": True, "seconds": user + system, "elapsed_s": elapsed}


ARCH = "buttressed-arch"
CLOSE = 1e-4  # of the size of an answer: what a skip that is not exact is held to

Answer = tuple[Array, int]  # numbers, and how much was computed for them


class Skip(NamedTuple):
    """`answer(True)`, with the skip, gives the numbers of `answer(False)`, and both count what they do, `of`.

    Within `tolerance` of the largest number; 0: to the last bit.
    """

    name: str
    of: str
    answer: Callable[[bool], Answer]
    tolerance: float = 0.0


def skips(quick: bool) -> Iterator[Row]:
    """A row for every skip; quick: the same, since all of it takes seconds."""
    for skip in all_skips():
        skip.answer(True)  # what is imported and compiled once
        (answer, count), (whole, more) = map(skip.answer, (True, False))
        seconds, alone = map(float, in_turn(partial(skip.answer, True), partial(skip.answer, False)))
        row: Row = {"case": skip.name, "counted": skip.of, "count": count, "count_without": more}
        row |= {"seconds": seconds, "seconds_without": alone, "saves": 1.0 - seconds / alone}
        yield row | {"difference": difference(answer, whole), "tolerance": skip.tolerance}


def difference(answer: Array, whole: Array) -> float:
    """The largest difference of two answers, relative to the largest number of the second."""
    return float(abs(answer - whole).max() / abs(whole).max())


def all_skips() -> list[Skip]:
    """One for every item of what a scene may not need."""
    folder = TemporaryDirectory(prefix="assesto-benchmark-")
    return [
        Skip("a stage that no key asks for", "analyses", lambda on: stages(("pushover",) if on else None)),
        Skip("a stage of unchanged inputs", "analyses", lambda on: stages(None, folder if on else None)),
        Skip("a direction that mirrors the other", "curves", ways, CLOSE),
        Skip("an elastic curve past its peak", "points", lambda on: elastic(PAST_PEAK if on else 0.0)),
        Skip("a history once collapse is certain", "steps", fallen),
    ]


def stages(only: tuple[str, ...] | None = None, folder: TemporaryDirectory[str] | None = None) -> Answer:
    """Multiplier and displacement capacity of the block template as drawn, from some of its stages or all."""
    project = template("block")
    own = {"record": RECORD, "contacts": "elastic", "damping_ratio": DAMPING, "window_s": (4.0, 6.0)}
    history = HistoryTable.model_validate(own | {"time_step_s": STEP})
    pushover = known(project.pushover)
    coarse = pushover.model_copy(update={"increment_m": 5.0 * pushover.increment_m})
    asked = {"history": (history,), "settlements": (), "pushover": coarse}
    project = select(project.model_copy(update=asked), only)
    outcome = run(project, build_model(project), 1, Store(Path(folder.name)) if folder else None)
    curves = [known(each.rigid) for each in outcome.results.states["original"].pushover.values()]
    return np.array([[rigid.alpha_0, rigid.d_0_m] for rigid in curves]), outcome.computed


def ways(mirrored: bool) -> Answer:
    """Multipliers and displacement capacities of the buttressed arch in both directions, one of them by reflection."""
    curve = pushed(ARCH)
    image = known(Mirror.of(assembly(ARCH), "rigid")).pushover(curve) if mirrored else pushed(ARCH, "-x")
    both = [[each.multiplier[0], each.displacement[-1]] for each in (curve, known(image))]
    return np.array(both), 1 if mirrored else 2


def elastic(until: float) -> Answer:
    """Where the elastic curve of the buttressed arch has two fifths of its peak, and its peak."""
    curve = pushed(ARCH, contacts="elastic", until=until)
    rising, peak = slice(0, curve.peak + 1), curve.multiplier[curve.peak]
    secant = np.interp(SECANT_SHARE, curve.multiplier[rising] / peak, curve.displacement[rising])
    return np.array([secant, peak]), len(curve.displacement)


def fallen(ends: bool) -> Answer:
    """The motion of a block up to where it has turned by 1 rad, and that it lies; `ends`: at its collapse."""
    with nullcontext() if ends else patch.object(histories, "collapse", lambda *_: ""):
        motion = time_history(block_on_base(), 0.4 * pulse(1.0, 1.0)(STEP * np.arange(2000.0)), STEP, "rigid")
    turned = abs(motion.positions[:, 1, 2])
    upto = len(turned) if ends else int(np.argmax(turned > TURNED)) + 1
    lies = motion.collapsed if ends else turned[-1] > TURNED
    return np.append(motion.positions[:upto, 1].ravel(), lies), len(motion.time) - 1
