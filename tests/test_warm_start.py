"""Where an interior point solve of the dynamics begins: off the cone by as much as solutions change."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics.solvers import newton
from mechanics.solvers.compiled import changed
from mechanics.solvers.newton import ACCEPTED
from mechanics.solvers.warm_start import FORCES, GAPS, WarmStart
from tests.steps import euler_step
from tests.structures import running_bond
from tests.test_newton import counted, newton_for, shaken

WEIGHT, STEP = 2.0, 0.005
BEARS, OPEN = 4.0 * WEIGHT, 0.6 * STEP


def kept(*solutions, newest=1.0):
    start = WarmStart(newest)
    for s, z in solutions:
        start.keep(np.array(s), np.array(z), WEIGHT, STEP)
    return start


def test_changes_are_those_of_all_rays():
    """Of four rays one opens and one closes: half change sides, by 4 weights and 0.6 steps."""
    s, z = np.array([[BEARS, 0.0], [0.0, BEARS]]), np.array([[0.0, OPEN], [OPEN, 0.0]])
    before, apart = np.array([[BEARS, BEARS], [0.0, 0.0]]), np.array([[0.0, 0.0], [OPEN, OPEN]])
    sides, forces, gaps = changed(s, z, before, apart, WEIGHT, STEP)
    assert sides == 0.5
    assert forces == pytest.approx(4.0 * np.sqrt(0.5), rel=1e-12)
    assert gaps == pytest.approx(0.6 * np.sqrt(0.5), rel=1e-12)


def test_it_keeps_off_by_what_has_changed():
    """Forces by √(share of the rays that changed sides) times their change, gaps by theirs, within limits."""
    s, z = [[BEARS, 0.0], [0.0, BEARS]], [[0.0, 0.005 * STEP], [0.005 * STEP, 0.0]]
    start = kept(([[BEARS, BEARS], [0.0, 0.0]], [[0.0, 0.0], [0.005 * STEP] * 2]), (s, z))
    assert start.forces == pytest.approx(np.sqrt(0.5) * 4.0 * np.sqrt(0.5), rel=1e-12)
    assert start.gaps == pytest.approx(0.005 * np.sqrt(0.5), rel=1e-12)
    along, apart = start.begin(2, WEIGHT, STEP)
    assert along.min() == start.forces * WEIGHT and along.max() == BEARS
    assert apart.min() == start.gaps * STEP and apart.max() == 0.005 * STEP


def test_forces_that_change_without_changing_sides_move_it_no_farther():
    """Those of a redundant rigid joint are anybody's guess."""
    start = kept(([[BEARS, BEARS]], [[0.0, 0.0]]), ([[2.0 * BEARS, 0.1 * BEARS]], [[0.0, 0.0]]))
    assert (start.forces, start.gaps) == (FORCES, GAPS[0])


def test_the_first_solution_and_one_that_failed_leave_the_default():
    start = kept(([[BEARS, 0.0]], [[0.0, OPEN]]))
    assert (start.forces, start.gaps) == (FORCES, GAPS[1])
    start.keep(np.array([[0.0, BEARS]]), np.array([[OPEN, 0.0]]), WEIGHT, STEP)
    assert start.forces > FORCES
    start.forget()
    along, apart = start.begin(1, WEIGHT, STEP)
    assert (along == FORCES * WEIGHT).all() and (apart == GAPS[1] * STEP).all()


def test_a_poor_solution_is_a_better_start_than_none(monkeypatch):
    """Thrown away, it leaves the next solve to begin from nothing, which fails again where joints hardly hold."""
    model = running_bond(3, 3)
    program = euler_step(model, "elastic", shaken(model, 1), 0.3)
    solver, calls, interior = newton_for(model, program), [], newton.interior

    def poor(*arguments):
        calls.append(interior(*arguments))
        return calls[-1][0], (1e3 * ACCEPTED * program.weight, 0.0, 0.0, 0.0)

    monkeypatch.setattr(newton, "interior", poor)
    assert solver.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap)) is not None
    assert len(calls) == 2
    assert solver.start.last is not None


def test_what_rings_is_begun_from_the_mean():
    start = kept(([[BEARS, 0.0]], [[0.0, OPEN]]), ([[0.0, BEARS]], [[OPEN, 0.0]]), newest=0.25)
    assert start.last is not None
    along, apart = start.last
    assert along == pytest.approx(np.array([[0.75, 0.25]]) * BEARS)
    assert apart == pytest.approx(np.array([[0.25, 0.75]]) * OPEN)


def test_it_takes_fewer_iterations_than_one_that_always_keeps_off_as_much(monkeypatch):
    wall = running_bond(14, 14, stiffness=1e7)
    adapted, _ = counted(wall, 0.5, "elastic")
    keep = WarmStart.keep

    def alike(start, *solution):
        keep(start, *solution)
        start.forces, start.gaps = FORCES, GAPS[1]

    monkeypatch.setattr(WarmStart, "keep", alike)
    always, _ = counted(wall, 0.5, "elastic")
    assert adapted < 0.95 * always
