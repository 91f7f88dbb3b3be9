"""The interior-point method of the statics against PIQP, and what it follows: the geometry of a step."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mechanics import limit_analysis, pushdown, pushover
from mechanics.equilibrium import rest
from mechanics.program import Neighbour, certify
from mechanics.solvers import central_path, solve
from mechanics.solvers.elimination import PADDING, Elimination
from mechanics.static_step import find_step, programs
from tests.structures import arch_on_piers, running_bond, semicircular_arch

ROOT = Path(__file__).parents[1]
WALL = running_bond(8, 10)
ARCH = semicircular_arch(21, 0.2, friction=0.8, segments=3)


def neighbour(program):
    """The solution of the program with a tenth less of dead load."""
    found = solve(replace(program, load=0.9 * program.load))
    return Neighbour(found.forces, program.opening(found.forces, found.displacement), found.alpha)


def unaware(program):
    """A neighbour that knows no more than that all contacts carry something and open a little."""
    carried = np.column_stack([np.full(len(program.gap), program.weight), np.zeros(len(program.gap))])
    return Neighbour(carried, np.abs(carried) * program.step / program.weight, 0.0)


@pytest.mark.parametrize("lateral", [False, True])
@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
@pytest.mark.parametrize("model", [WALL, ARCH, arch_on_piers()], ids=["wall", "arch", "arch on piers"])
def test_it_solves_a_program_as_piqp_does(model, behaviour, lateral):
    load = model.lateral_load("+x") if lateral else None
    size = 1e-3
    pose = programs(model, behaviour, model.initial, model.dead_load, size, load, 0.2 * size * model.weight)
    there = pose(model.initial.positions)

    solution = central_path.solve(there, Elimination.of(there.dof), neighbour(there))
    assert solution is not None
    expected = solve(there)
    certificate = certify(there, solution.forces, solution.alpha, solution.displacement)
    assert certificate.worst(size) <= central_path.MOST
    assert certificate.equilibrium <= 1e-8
    assert solution.alpha == pytest.approx(expected.alpha, abs=1e-6)
    # the forces of a redundant structure and the mechanism of a symmetrical one are not unique; the work is
    assert there.load @ solution.displacement == pytest.approx(
        there.load @ expected.displacement, rel=1e-5, abs=1e-6 * size * model.weight
    )


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_a_step_followed_and_a_step_of_programs_are_the_same(behaviour, monkeypatch):
    model, control = running_bond(5, 6, friction=3.0), (2.0, 1.05)  # no sliding, no path dependence
    for module in ("mechanics.static_step", "mechanics.solvers"):
        monkeypatch.setattr(f"{module}.suits_central_path", lambda contacts: False)
    apart = pushover(model, control, contacts=behaviour, increment=0.01)
    monkeypatch.undo()
    monkeypatch.setattr("mechanics.static_step.LARGE", 0)
    followed = pushover(model, control, contacts=behaviour, increment=0.01)
    alone = 1 if behaviour == "elastic" else 2  # with the limit analysis of the configuration
    assert sum(step.solves == alone for step in followed.steps) > 0.6 * len(followed.steps)
    assert sum(step.solves > 1 for step in apart.steps) > 0.7 * len(apart.steps)
    along = np.linspace(0.0, 0.5 * min(path.displacement[-1] for path in (apart, followed)), 20)
    alpha = [np.interp(along, path.displacement, path.multiplier) for path in (apart, followed)]
    np.testing.assert_allclose(alpha[1], alpha[0], atol=2e-3 * max(apart.multiplier))


def test_a_followed_step_is_an_equilibrium_of_its_own_geometry(monkeypatch):
    monkeypatch.setattr("mechanics.static_step.LARGE", 0)
    model = arch_on_piers(stiffness=1e6)
    path = pushdown(model, "right", (0.02, -0.02), increment=0.004, contacts="elastic")
    followed = [pair for pair in zip(path.states[1:], path.steps[2:], strict=False) if pair[1].solves == 1]
    assert len(followed) > 2
    for before, step in followed:
        pose = programs(model, "elastic", before, model.dead_load, 0.004)
        there = pose(step.state.positions)
        still = np.zeros(len(there.load))
        # the geometry is followed to 3e-4 of the step, of which the change of arms is a few hundredths
        assert certify(there, step.forces, step.alpha, still).equilibrium <= 2e-5


def test_where_nothing_stands_no_step_is_followed():
    model = semicircular_arch(21, 0.05)  # thinner than 0.1075: no thrust line fits in
    size = 1e-3
    pose = programs(model, "rigid", model.initial, model.dead_load, size)
    there = pose(model.initial.positions)
    layout = Elimination.of(there.dof)
    assert central_path.solve(there, layout, unaware(there)) is None
    assert central_path.follow(lambda x: there, layout, unaware(there)) is None


def test_a_neighbour_saves_iterations(monkeypatch):
    load = WALL.lateral_load("+x")
    limit = limit_analysis(WALL)
    size = 0.002
    start = rest(WALL, "elastic", WALL.initial)
    counts = []
    advance = central_path.loops.advance

    def counted(*arguments):
        counts.append(1)
        return advance(*arguments)

    monkeypatch.setattr(central_path.loops, "advance", counted)
    monkeypatch.setattr("mechanics.static_step.LARGE", 0)
    pushed = [
        find_step(
            WALL, "elastic", start.state, start.state.positions,
            WALL.dead_load + share * limit.alpha * load, size, last=start,
        )
        for share in (0.3, 0.3001)
    ]  # fmt: skip
    counts.clear()
    again = find_step(
        WALL, "elastic", start.state, pushed[0].state.positions, WALL.dead_load + 0.3001 * limit.alpha * load,
        size, last=pushed[0],
    )  # fmt: skip
    near = len(counts)
    program = programs(WALL, "elastic", start.state, WALL.dead_load + 0.3001 * limit.alpha * load, size)
    counts.clear()
    central_path.follow(
        lambda x: program(_moved(start.state.positions, x)),
        Elimination.of(program(start.state.positions).dof),
        unaware(program(start.state.positions)),
    )
    assert again.solves == 1
    assert near < len(counts)
    assert again.state.positions == pytest.approx(pushed[1].state.positions, abs=1e-6)


def _moved(positions, x):
    moved = positions.copy()
    moved[WALL.movable] += x.reshape(-1, 3)
    return moved


def test_the_band_holds_every_pair_of_touching_blocks():
    program = programs(WALL, "rigid", WALL.initial, WALL.dead_load, 1e-3)(WALL.initial.positions)
    layout = Elimination.of(program.dof)
    assert sorted(layout.order) == list(range(len(program.load)))
    assert np.array_equal(layout.order[layout.back], np.arange(len(program.load)))
    both = layout.row[(layout.row >= 0).all(axis=1)]
    assert abs(both[:, 0] - both[:, 1]).max() + 3 + PADDING == layout.places < len(program.load) / 2


def test_a_program_near_another_takes_no_other_solver(monkeypatch):
    model = running_bond(8, 10)
    pose = programs(
        model, "rigid", model.initial, model.dead_load, 1e-3, model.lateral_load("+x"), 1e-3 * model.weight
    )
    program = pose(model.initial.positions)
    expected = solve(program)
    monkeypatch.setattr("mechanics.solvers.interior_point.solve", None)
    found = solve(program, expected.neighbour(program), Elimination.of(program.dof))
    assert found.alpha == pytest.approx(expected.alpha, abs=1e-7)
    assert found.certificate.worst(program.step) <= central_path.MOST


def test_a_geometry_that_goes_to_and_fro_is_followed_no_longer():
    """The rest of the way is gone in one geometry: certified there, and its displacements are told."""
    size, posed = 1e-3, []
    load = WALL.dead_load + 0.1 * WALL.lateral_load("+x")
    there = programs(WALL, "elastic", WALL.initial, load, size)(WALL.initial.positions)

    def pose(x):
        posed.append(replace(there, gap=there.gap + (-1) ** len(posed) * size * np.array([0.0, 0.5])))
        return posed[-1]

    _, solution = central_path.follow(pose, Elimination.of(there.dof), neighbour(there))
    certificate = certify(posed[-1], solution.forces, solution.alpha, solution.displacement)
    assert certificate.worst(size) <= central_path.MOST
    assert abs(solution.displacement).max() > 1e-2 * size
    assert len(posed) > central_path.STALLED


def test_what_is_loaded_is_what_a_model_needs():
    """A process that makes ready has nothing more to load or compile for its first check under self-weight."""
    code = (
        "from mechanics.equilibrium import check_self_weight\n"
        "from mechanics.solvers import central_path, compiled_interior_step as loops\n"
        "from tests.structures import running_bond\n"
        "def loaded():\n"
        "    return [loop.signatures for loop in (loops.advance, loops.measured, loops.restore)]\n"
        "central_path.load()\n"
        "ready = loaded()\n"
        "check_self_weight(running_bond(8, 10))\n"
        "assert [len(each) for each in ready] == [1, 1, 1], ready\n"
        "assert loaded() == ready\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
