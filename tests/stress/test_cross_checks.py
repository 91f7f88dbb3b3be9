"""Solvers of different kinds against each other on random assemblies, and random paths (paper, eqs 2–5).

Of each 4, one of a kind, and 200 with ASSESTO_STRESS=long.
"""

from collections import Counter
from collections.abc import Callable
from importlib import import_module
from unittest.mock import patch

import numpy as np
import pytest

from mechanics import Assembly, pushdown, pushover
from mechanics.errors import (
    CollapseError,
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    UnstableError,
)
from mechanics.program import certify
from mechanics.solvers import lp_highs, solve
from mechanics.steps.equilibrium import closed_program
from tests.mechanics.procedures.test_statics_properties import arch, within_cones
from tests.mechanics.solvers.test_program import second_opinion
from tests.stress.corpus import assemblies
from tests.stress.test_stress import LONG
from tests.support.steps import euler_step, shaken, static_step

COUNT = 200 if LONG else 4
step_control = import_module("mechanics.procedures.step_control")


def test_multipliers():
    """Rigid, α by PIQP, HiGHS and the method of our own."""
    for number, model in assemblies(COUNT):
        closed = closed_program(model, model.initial).pushed(model, model.lateral_load("+x"))
        found, _ = solve(closed.program, closed.layout)
        highs = lp_highs.solve(closed.program)
        assert highs is not None
        assert certify(closed.program, *highs).worst(closed.program.step) < 1e-7, number
        assert found.alpha == pytest.approx(highs[1], abs=1e-7), number
        assert found.alpha == pytest.approx(second_opinion(closed.program).alpha, abs=1e-7), number


def test_elastic_steps():
    """By PIQP and the method of our own."""
    for number, model in assemblies(COUNT, segments=5):
        program, layout = static_step(model, "elastic")
        found, iterate = solve(program, layout)
        assert iterate is not None, "not by the second opinion itself"
        expected = second_opinion(program)
        # the curve of a soft bed is flat: forces go with the root of the energy that is left
        assert found.alpha == pytest.approx(expected.alpha, abs=2e-5), number
        move = abs(found.displacement - expected.displacement).max()
        assert move < 0.15 * program.step, number  # both certified: along it the program is nearly flat


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_time_steps(behaviour):
    """Displacements in the energy norm, per that of what the loads do alone."""
    rng = np.random.default_rng(12)
    for number, model in assemblies(COUNT, segments=4):
        program, layout = euler_step(model, behaviour, shaken(model, number), rng.uniform(-1.0, 1.0))
        found, iterate = solve(program, layout)
        assert iterate is not None and program.mass is not None
        apart = found.displacement - second_opinion(program).displacement
        free = float(program.load @ (program.load / program.mass))
        assert np.sqrt(apart @ (program.mass * apart) / free) < 5e-5, number


@pytest.mark.parametrize("seed", range(COUNT))
def test_on_random_paths_flat_supports_carry_no_more_than_friction(seed):
    """Of random assemblies, supports moved by random amounts."""
    rng = np.random.default_rng(seed)
    model = next(iter(assemblies(1, seed)))[1] if seed % 2 else arch()
    names = sorted({b.support for b in model.blocks if b.support})
    way, behaviour = model.size * rng.uniform(-0.1, 0.1, 2), ("rigid", "elastic")[seed // 2 % 2]
    increment = abs(way).max() / 4
    try:
        path = pushdown(model, names[seed % len(names)], way, increment=increment, contacts=behaviour)
    except CollapseError as collapse:
        path = collapse.path
    fixed = ~model.movable
    for step in path.steps:
        within_cones(model, step)
        held = fixed[step.contacts.a] | fixed[step.contacts.b]
        n, t = step.forces[held, 0], step.forces[held, 2]
        assert (abs(t) <= step.contacts.friction[held] * n + 1e-6 * model.weight).all()


def counted(model: Assembly) -> Counter[str]:
    """What becomes of a settlement and of two pushes of an assembly, and of the steps on their way."""
    found: Counter[str] = Counter()
    find = step_control.find_equilibrium

    def watched(*arguments: object) -> object:
        found["steps"] += 1
        try:
            return find(*arguments)
        except ConvergenceError:
            found["attempts failed"] += 1
            raise
        except NoEquilibriumError:
            found["no equilibrium"] += 1
            raise

    def path(run: Callable[[], object]) -> object:
        found["paths"] += 1
        try:
            return run()
        except CollapseError as collapse:
            found["lost"] += 1
            return collapse.path
        except ConvergenceError:
            found["not solved"] += 1
        except (UnstableError, NoEquilibriumError, ValueError):
            found["refused"] += 1
        return None

    support = next(b.support for b in model.blocks if b.support)
    top = max((b for b in model.blocks if b.support is None), key=lambda b: float(b.polygon[:, 1].max()))
    control, size = top.centroid, model.size
    with patch.object(step_control, "find_equilibrium", watched):
        way = (0.05 * size, -0.05 * size)
        moved = path(lambda: pushdown(model, support, way, increment=0.0125 * size, contacts="elastic"))
        for state in (None, getattr(moved, "final", None)):
            path(lambda state=state: pushover(model, control, "+x", "elastic", 0.02 * size, state, until=0.5))
    return found


def test_exact_beds_need_no_points():
    """A path in a hundred at most is not solved, and a step in a hundred has to be tried again in shorter ones."""
    found = Counter[str]()
    for _, model in assemblies(3):
        found += counted(model)
    assert found["paths"] == 9
    assert found["not solved"] <= 0.01 * found["paths"]
    assert found["attempts failed"] <= 0.01 * found["steps"]


def same_peak(model: Assembly) -> float:
    """By how much 32 points are stronger than the exact bed, of the exact one's largest multiplier."""
    top = max((b for b in model.blocks if b.support is None), key=lambda b: float(b.polygon[:, 1].max()))
    peaks = [
        pushover(
            Assembly(model.blocks, segments), top.centroid, "+x", "elastic", 0.01 * model.size, until=0.9
        ).multiplier.max()
        for segments in (None, 32)
    ]
    return float(np.diff(peaks)[0] / peaks[0])


def test_peaks_of_points_lie_above_those_of_the_exact_bed():
    """By little, and where joints do not slide: 32 segments are stiffer by 2/32² in rotation."""
    over = []
    for _, model in assemblies(3):
        try:
            over.append(same_peak(model))
        except (ControlError, NoEquilibriumError, UnstableError):
            continue
    assert np.median(over) < 0.02 and min(over) > -0.01
