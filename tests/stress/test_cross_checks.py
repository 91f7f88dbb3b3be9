"""Solvers of different kinds against each other on random assemblies, and random paths (paper, eqs 2–5).

Of each 4, one of a kind, and 200 with ASSESTO_STRESS=long.
"""

import numpy as np
import pytest

from mechanics import pushdown
from mechanics.errors import CollapseError
from mechanics.program import Program, Solution, certify
from mechanics.solvers import lp_highs, qp_piqp, solve
from mechanics.steps.equilibrium import closed_program
from tests.mechanics.procedures.test_statics_properties import arch, within_cones
from tests.stress.corpus import assemblies
from tests.stress.test_stress import LONG
from tests.support.steps import euler_step, shaken, static_step

COUNT = 200 if LONG else 4


def second_opinion(program: Program) -> Solution:
    answer = qp_piqp.solve(program, 1e-12, 200)
    assert answer is not None
    return Solution(*answer, certify(program, *answer))


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
