"""What is not computed because a scene does not need it: the same answer with and without, and what it saves.

Each skip is done twice, as the program does it and as it would without: the difference of the answers is zero where
the skip is exact, and otherwise of the size that the skip is held to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.motions import DAMPING, STEP, pulse
from assessment.benchmark.cases.structures import assembly, block_on_base, pushed, template
from assessment.benchmark.measure import in_turn
from assessment.benchmark.table import Row
from assessment.ntc.curve_fit import SECANT_SHARE
from assessment.project.catalogue.new_project import RECORD
from assessment.project.schema import HistoryTable
from assessment.project.structure.model import build_model
from assessment.results.schema.part import known
from assessment.runtime.cache import Store
from assessment.workflow.run import select
from assessment.workflow.stages import run
from mechanics import TimeHistory, time_history
from mechanics.procedures import time_history as histories
from mechanics.procedures.collapse import TURNED
from mechanics.procedures.mirror import Mirror
from mechanics.procedures.pushover import Pushover
from mechanics.types import Array

ARCH = "buttressed-arch"
CLOSE = 1e-4  # of the size of an answer: what a skip that is not exact is held to

Answer = tuple[Array, int]
"""Numbers, and how much was computed for them."""


class Skip(NamedTuple):
    """`done` and `without` give the same numbers, within `tolerance` of the largest, and count what they do, `of`.

    Tolerance 0: to the last bit.
    """

    name: str
    of: str
    done: Callable[[], Answer]
    without: Callable[[], Answer]
    tolerance: float = 0.0


def skips(quick: bool) -> Iterator[Row]:
    """A row for every skip; quick: the same, since all of it takes seconds."""
    for skip in all_skips():
        skip.done()  # what is imported and compiled once
        (answer, count), (whole, more) = skip.done(), skip.without()
        seconds, seconds_without = map(float, in_turn(skip.done, skip.without))
        row: Row = {"case": skip.name, "counted": skip.of, "count": count, "count_without": more}
        row |= {"seconds": seconds}
        row |= {"seconds_without": seconds_without, "saves": 1.0 - seconds / seconds_without}
        yield row | {"difference": difference(answer, whole), "tolerance": skip.tolerance}


def difference(answer: Array, whole: Array) -> float:
    """The largest difference of two answers, relative to the largest number of the second."""
    return float(abs(answer - whole).max() / abs(whole).max())


def all_skips() -> list[Skip]:
    """One for every item of what a scene may not need."""
    folder = TemporaryDirectory(prefix="assesto-benchmark-")
    return [
        Skip("a stage that no key asks for", "analyses", partial(stages, ("pushover",)), stages),
        Skip("a stage whose inputs have not changed", "analyses", lambda: stages(None, folder), stages),
        Skip("a direction that mirrors the other", "curves", one_way, both_ways, CLOSE),
        Skip("an elastic curve past its peak", "points", partial(elastic, PAST_PEAK), partial(elastic, 0.0)),
        Skip("a history once collapse is certain", "steps", fallen, fallen_on),
    ]


def stages(only: tuple[str, ...] | None = None, folder: TemporaryDirectory[str] | None = None) -> Answer:
    """Multiplier and displacement capacity of the block template as drawn, from some of its stages or all."""
    project = template("block")
    own = {"record": RECORD, "contacts": "elastic", "damping_ratio": DAMPING, "window_s": (4.0, 6.0)}
    history = HistoryTable.model_validate(own | {"time_step_s": STEP})
    assert project.pushover is not None
    coarse = project.pushover.model_copy(update={"increment_m": 5.0 * project.pushover.increment_m})
    asked = {"history": (history,), "settlements": (), "pushover": coarse}
    project = select(project.model_copy(update=asked), only)
    outcome = run(project, build_model(project), 1, Store(Path(folder.name)) if folder else None)
    curves = [known(each.rigid) for each in outcome.results.states["original"].pushover.values()]
    return np.array([[rigid.alpha_0, rigid.d_0_m] for rigid in curves]), outcome.computed


def one_way() -> Answer:
    """Multipliers and displacement capacities of the buttressed arch in both directions, one of them by reflection."""
    curve, mirror = pushed(ARCH), Mirror.of(assembly(ARCH), "rigid")
    assert mirror is not None
    return _capacities(curve, known(mirror.pushover(curve))), 1


def both_ways() -> Answer:
    """The same, each direction computed."""
    return _capacities(pushed(ARCH, "+x"), pushed(ARCH, "-x")), 2


def _capacities(*curves: Pushover) -> Array:
    return np.array([[curve.multiplier[0], curve.displacement[-1]] for curve in curves])


def elastic(until: float) -> Answer:
    """Where the elastic curve of the buttressed arch has two fifths of its peak, and its peak."""
    curve = pushed(ARCH, contacts="elastic", until=until)
    rising, peak = slice(0, curve.peak + 1), curve.multiplier[curve.peak]
    secant = np.interp(SECANT_SHARE, curve.multiplier[rising] / peak, curve.displacement[rising])
    return np.array([secant, peak]), len(curve.displacement)


def _overturning() -> TimeHistory:
    return time_history(block_on_base(), 0.4 * pulse(1.0, 1.0)(STEP * np.arange(2000.0)), STEP, "rigid")


def fallen() -> Answer:
    """The motion of a block up to its collapse, and that it collapses."""
    motion = _overturning()
    return np.append(motion.positions[:, 1].ravel(), motion.collapsed), len(motion.time) - 1


def fallen_on() -> Answer:
    """The same of the whole record: up to where the block has turned by 1 rad, and that it lies at the end."""
    with patch.object(histories, "collapse", lambda *_: ""):
        motion = _overturning()
    turned = abs(motion.positions[:, 1, 2])
    upto = int(np.argmax(turned > TURNED)) + 1
    return np.append(motion.positions[:upto, 1].ravel(), turned[-1] > TURNED), len(motion.time) - 1
