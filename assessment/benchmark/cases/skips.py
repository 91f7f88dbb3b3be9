"""What is not computed because a scene does not need it: the same answer with and without, and what it saves.

Each skip is done twice, as the program does it and as it would without: the difference of the answers is zero where
the skip is exact, and otherwise of the size that the skip is held to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from unittest.mock import patch

import numpy as np

from assessment.analyses.dynamic.bracket import find_collapse
from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.dynamics import DAMPING, pulse, shaking
from assessment.benchmark.cases.structures import assembly, block_on_base, template
from assessment.benchmark.measure import in_turn
from assessment.benchmark.table import Row
from assessment.ntc.capacity.curve_fit import SECANT_SHARE
from assessment.project.catalogue.record import RECORD
from mechanics import TimeHistory, pushover, time_history
from mechanics.errors import NoEquilibriumError
from mechanics.kernels.dynamics.motion import GAPS, SPRING
from mechanics.kernels.dynamics.program import COLD
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures import time_history as histories
from mechanics.procedures.collapse import TURNED
from mechanics.procedures.mirror import Mirror
from mechanics.procedures.pushover import Pushover
from mechanics.procedures.time_history import HISTORY, HistoryTolerances
from mechanics.records.record import read_record
from mechanics.steps.dynamic_system import DynamicSystem, Motion, Recorded
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.static_step import StepProblem
from mechanics.types import GRAVITY, Array

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.runtime.cache import Store

STEP, LONG_STEP = 0.005, 0.02  # s
# a rigid program's start shows in the motion: 9e-4 to 7e-3 of it over 100 to 150 steps
STARTED = 1e-2
CLOSE = 1e-4  # of the size of an answer: what a skip that is not exact is held to
WINDOWED = 0.02  # and a part of a record in place of the whole
ARCH_PGA, BLOCK_PGA = 0.02, 0.17  # g
LOWEST, HIGHEST, RESOLVED = 0.3, 1.2, 0.05  # g: of the search for a collapse


@dataclass(frozen=True, eq=False)
class Skip:
    """`done` and `without` give the same numbers, within `tolerance` of the largest, and count what they do, `of`.

    Tolerance 0: to the last bit; infinite: the skip is not exact, and made only where the user asks for it.
    """

    name: str
    of: str
    done: Callable[[], tuple[Array, int]]
    without: Callable[[], tuple[Array, int]]
    tolerance: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Saved(Row):
    """What a skip saves: counts and processor time (s) with and without it; the difference of the two answers."""

    counted: str
    count: int
    count_without: int
    seconds: float
    seconds_without: float
    saves: float
    difference: float
    tolerance: float


def skips(quick: bool) -> Iterator[Saved]:
    """A row for every skip; quick: the same, since all of it takes seconds."""
    for skip in all_skips():
        skip.done()  # what is imported and compiled once
        (answer, count), (whole, count_without) = skip.done(), skip.without()
        seconds, seconds_without = in_turn(skip.done, skip.without)
        yield Saved(
            case=skip.name,
            counted=skip.of,
            count=count,
            count_without=count_without,
            seconds=seconds,
            seconds_without=seconds_without,
            saves=1.0 - seconds / seconds_without,
            difference=difference(answer, whole),
            tolerance=skip.tolerance,
        )


def difference(answer: Array, whole: Array) -> float:
    """The largest difference of two answers, relative to the largest number of the second."""
    return float(abs(answer - whole).max() / abs(whole).max())


def all_skips() -> list[Skip]:
    """One for every item of what a scene may not need."""
    return [
        Skip(
            "a stage that no key asks for", "analyses", partial(stages, ("pushover",)), partial(stages, None)
        ),
        unchanged(),
        Skip("a direction that mirrors the other", "curves", one_way, both_ways, CLOSE),
        Skip("a rigid curve once α = 0", "points", curve_to_zero, curve_beyond, CLOSE),
        Skip(
            "an elastic curve past its peak",
            "points",
            partial(elastic_curve, PAST_PEAK),
            partial(elastic_curve, 0.0),
        ),
        Skip("a history once collapse is certain", "steps", fallen, fallen_on),
        Skip("a record outside its Arias window, arch", "steps", *window_of(ARCH_PGA), WINDOWED),
        Skip("a record outside its Arias window, rocking block", "steps", *window_of(BLOCK_PGA), np.inf),
        Skip(
            "scale factors that bisection rules out",
            "histories",
            bisection,
            every_level,
            1.01 * RESOLVED / LOWEST,
        ),
        Skip("cold starts of a step's program", "iterations", started_near, started_cold, STARTED),
    ]


def stages(only: tuple[str, ...] | None, store: Store | None = None) -> tuple[Array, int]:
    """Multiplier and displacement capacity of the block template as drawn, from some of its stages or all."""
    from assessment.project.structure.model import build_model
    from assessment.results.schema.part import known
    from assessment.workflow.selection import select
    from assessment.workflow.stages import run

    project = select(_with_history(template("block")), only)
    outcome = run(project, build_model(project), 1, store)
    pushed = [known(curves.rigid) for curves in outcome.results.states["original"].pushover.values()]
    return np.array([[rigid.alpha_0, rigid.d_0_m] for rigid in pushed]), outcome.computed


def _with_history(project: Project) -> Project:
    from assessment.project.schema import HistoryTable

    history = HistoryTable(
        record=RECORD, contacts="elastic", damping_ratio=0.05, window_s=(4.0, 6.0), time_step_s=STEP
    )
    assert project.pushover is not None
    coarse = project.pushover.model_copy(update={"increment_m": 5.0 * project.pushover.increment_m})
    return project.model_copy(update={"history": (history,), "settlements": (), "pushover": coarse})


def unchanged() -> Skip:
    """A second run over the store of a first one."""
    from assessment.runtime.cache import Store

    folder = TemporaryDirectory(prefix="assesto-benchmark-")

    def done() -> tuple[Array, int]:
        return stages(None, Store(Path(folder.name)))

    return Skip("a stage whose inputs have not changed", "analyses", done, partial(stages, None))


def one_way() -> tuple[Array, int]:
    """Multipliers and displacement capacities of the buttressed arch in both directions, one of them by reflection."""
    curve, mirror = _curve(), Mirror.of(assembly("buttressed-arch"), "rigid")
    image = None if mirror is None else mirror.pushover(curve)
    assert image is not None
    return _capacities(curve, image), 1


def both_ways() -> tuple[Array, int]:
    """The same, each direction computed."""
    return _capacities(_curve("+x"), _curve("-x")), 2


def _capacities(*curves: Pushover) -> Array:
    return np.array([[curve.multiplier[0], curve.displacement[-1]] for curve in curves])


def curve_to_zero() -> tuple[Array, int]:
    """α_0 and d_0 of the buttressed arch, whose curve ends at α = 0."""
    curve = _curve()
    return np.array([curve.multiplier[0], curve.displacement[-1]]), len(curve.displacement)


def curve_beyond() -> tuple[Array, int]:
    """The same from a curve that goes on, to twice the displacement if it can: where it crosses zero for good."""
    curve, model = _curve(), assembly("buttressed-arch")
    lateral, control = model.lateral_load("+x"), template("buttressed-arch").pushover_control("+x").point_m
    block = model.block_at(control)
    displacement, multiplier, step = [*curve.displacement[:-1]], [*curve.multiplier[:-1]], curve.steps[-2]
    moved = step.state.positions - curve.states[-3].positions
    while displacement[-1] < 2.0 * curve.displacement[-1]:
        work, size = float((lateral * moved).sum()), float(abs(moved[:, :2]).max())
        last, guess = step.state, step.state.positions + moved
        problem = StepProblem(step.system.around(guess, size), last, model.dead_load, size, lateral, work)
        try:
            step = find_equilibrium(problem, guess, step)
        except NoEquilibriumError:
            break
        moved = step.state.positions - last.positions
        displacement.append(float(model.point_displacement(control, block, step.state.positions)[0]))
        multiplier.append(step.alpha)
    down = int(np.argmax(np.array(multiplier) < 0.0))
    crossing = np.interp(0.0, multiplier[down - 1 : down + 1][::-1], displacement[down - 1 : down + 1][::-1])
    rises_again = max(multiplier[down:]) > 0.0
    return np.array([multiplier[0], np.inf if rises_again else crossing]), len(displacement)


def elastic_curve(until: float) -> tuple[Array, int]:
    """Where the elastic curve of the buttressed arch has two fifths of its peak, and its peak."""
    curve = _curve(contacts="elastic", until=until)
    rising = slice(0, curve.peak + 1)
    secant = np.interp(
        SECANT_SHARE, curve.multiplier[rising] / curve.multiplier[curve.peak], curve.displacement[rising]
    )
    return np.array([secant, curve.multiplier[curve.peak]]), len(curve.displacement)


def _curve(way: Direction = "+x", contacts: Behaviour = "rigid", until: float = 0.0) -> Pushover:
    project = template("buttressed-arch")
    assert project.pushover is not None
    control, increment = project.pushover_control(way).point_m, project.pushover.increment_m
    return pushover(assembly("buttressed-arch"), control, way, contacts, increment, until=until)


def fallen() -> tuple[Array, int]:
    """The motion of a block up to its collapse, and that it collapses."""
    motion = _overturning()
    return np.append(motion.positions[:, 1].ravel(), motion.collapsed), len(motion.time) - 1


def fallen_on() -> tuple[Array, int]:
    """The same of the whole record: up to where the block has turned by 1 rad, and that it lies at the end."""
    with patch.object(histories, "collapse", lambda *_: ""):
        motion = _overturning()
    turned = abs(motion.positions[:, 1, 2])
    lies = float(turned[-1] > TURNED)
    upto = int(np.argmax(turned > TURNED)) + 1
    return np.append(motion.positions[:upto, 1].ravel(), lies), len(motion.time) - 1


def _overturning() -> TimeHistory:
    record = 0.4 * pulse(1.0, 1.0)(_times(2000))
    return time_history(block_on_base(), record, STEP, "rigid")


def window_of(pga: float) -> tuple[Callable[[], tuple[Array, int]], Callable[[], tuple[Array, int]]]:
    """The largest displacement of the arch, or the rocking block, in the Arias window of a record, and in all of it.

    What rocks is sensitive to all that shakes it, the weak beginning too.
    """

    def peak(windowed: bool) -> tuple[Array, int]:
        record = read_record(template("triumphal-arch").folder / RECORD).resampled(LONG_STEP)
        record = record.scaled(pga / record.pga)
        if windowed:
            record = record.windowed(*record.arias_window())
        model, control = block_on_base(0.6, 4.2, stiffness=1e5), (0.6, 4.2)
        if pga == ARCH_PGA:
            model, control = (
                assembly("buttressed-arch"),
                template("buttressed-arch").pushover_control("+x").point_m,
            )
        motion = time_history(
            model, record.acceleration, LONG_STEP, "elastic", control=control, damping_ratio=DAMPING
        )
        assert motion.displacement is not None
        return abs(motion.displacement).max(keepdims=True), len(motion.time) - 1

    return partial(peak, True), partial(peak, False)


def bisection() -> tuple[Array, int]:
    """The least PGA at which a pulse overturns a block, by bisection."""
    runs: list[float] = []

    def collapses(level: float) -> bool:
        runs.append(level)
        return _overturns(level)

    collapse = find_collapse(collapses, collapses, 0.3, HIGHEST, RESOLVED).collapse
    assert collapse is not None
    return np.array([collapse]), len(runs)


def every_level() -> tuple[Array, int]:
    """The same by running every level up to the highest, as far apart as bisection resolves."""
    levels = np.arange(LOWEST, HIGHEST + 0.5 * RESOLVED, RESOLVED)
    fall = [level for level in levels if _overturns(level)]
    return np.array([min(fall)]), len(levels)


def _overturns(level: float) -> bool:
    record = level * pulse(1.0, 0.5)(_times(200))
    return time_history(block_on_base(), record, STEP, "rigid").collapsed


def started_near() -> tuple[Array, int]:
    """A motion of the buttressed arch, each step of which begins at the last one."""
    motion = _shaken()
    return _way(motion), motion.iterations


def started_cold() -> tuple[Array, int]:
    """The same history, every program with a cold start."""
    march = DynamicSystem.march

    def forgetful(system: DynamicSystem, motion: Motion, base: Array, step: float) -> Recorded:
        speed, joints = float(abs(motion.blocks[1, :, :2]).max()), motion.joints
        joints[:, :GAPS] = COLD * system.system.weight * np.array([1.0, 1.0, 0.0])
        joints[:, GAPS:SPRING] = COLD * max(GRAVITY * step**2, speed * step)
        return march(system, motion, base, step)

    with patch.object(DynamicSystem, "march", forgetful):
        motion = _shaken(HistoryTolerances(chunk=1))
    return _way(motion), motion.iterations


def _shaken(tolerances: HistoryTolerances = HISTORY) -> TimeHistory:
    """The arch with rigid joints, whose programs the interior point solves; those of elastic ones are Newton's."""
    wave = shaking(0.2)(_times(150))
    return time_history(
        assembly("buttressed-arch"), wave, STEP, "rigid", integrator="implicit-euler", tolerances=tolerances
    )


def _way(motion: TimeHistory) -> Array:
    moved: Array = (motion.positions - motion.positions[0])[::10].ravel()
    return moved


def _times(count: int) -> Array:
    times: Array = STEP * np.arange(count, dtype=float)
    return times
