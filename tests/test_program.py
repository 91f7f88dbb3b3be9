"""The program: its certificate, its solvers against each other, and what it says where there is no solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import (
    Assembly,
    Block,
    ConvergenceError,
    Material,
    NoEquilibriumError,
    UnstableError,
    limit_analysis,
    solvers,
)
from mechanics.equilibrium import check_self_weight, closed_program, rest
from mechanics.program import certify
from mechanics.solvers import imbalance, interior_point, linear, solve
from mechanics.static_step import assemble, find_step
from tests.structures import arch_on_piers, block_on_base, rectangle, running_bond, semicircular_arch

SLIGHT = 1e-3
WEIGHT = 18.0 * 0.2  # kN, of the single block


@pytest.fixture(scope="module")
def solved():
    model = running_bond(columns=3, courses=3)
    program = closed_program(model, model.initial, model.lateral_load("+x"))[0]
    return program, solve(program)


def certificate(solved, forces=0.0, alpha=0.0, displacement=0.0):
    program, s = solved
    return certify(program, s.forces + forces, s.alpha + alpha, s.displacement + displacement)


def test_a_solution_is_certified(solved):
    program, solution = solved
    assert solution.certificate.worst(program.step) < 1e-8
    assert certificate(solved) == solution.certificate


def test_a_wrong_force_is_out_of_equilibrium(solved):
    wrong = np.zeros_like(solved[1].forces)
    wrong[5, 0] = SLIGHT * solved[0].weight
    assert certificate(solved, forces=wrong).equilibrium > 0.1 * SLIGHT


def test_a_wrong_multiplier_is_out_of_equilibrium(solved):
    assert certificate(solved, alpha=SLIGHT).equilibrium == pytest.approx(SLIGHT, rel=0.6)


def test_a_moment_is_out_of_equilibrium_too():
    model = block_on_base()
    program = closed_program(model, model.initial)[0]
    found = solve(program)
    arm = np.where(program.dof[:, 2] >= 0, program.normal[:, 2], 0.0)
    shift = np.zeros_like(found.forces)
    shift[[arm.argmin(), arm.argmax()], 0] = -0.1, 0.1  # the same resultant, elsewhere
    wrong = certify(program, found.forces + shift, 0.0, found.displacement)
    assert wrong.equilibrium == pytest.approx(0.1 * 0.2 / program.size / program.weight, rel=1e-6)


def test_a_force_outside_the_friction_cone(solved):
    program, solution = solved
    k = int(np.argmax(solution.forces[:, 0]))
    wrong = np.zeros_like(solution.forces)
    wrong[k, 1] = program.friction[k] * solution.forces[k, 0] * 2.0 + SLIGHT * program.weight
    assert certificate(solved, forces=wrong).cone >= SLIGHT


def test_tension(solved):
    wrong = np.zeros_like(solved[1].forces)
    wrong[:, 0] = -(solved[1].forces[:, 0].max() + SLIGHT * solved[0].weight)
    assert certificate(solved, forces=wrong).cone >= SLIGHT


def test_interpenetration(solved):
    program, solution = solved
    down = np.zeros_like(solution.displacement)
    down[1] = -program.step
    assert certificate(solved, displacement=down).penetration > 0.5 * program.step


def test_a_force_across_an_open_joint_does_work(solved):
    program, solution = solved
    up = np.zeros_like(solution.displacement)
    up[1::3] = program.step
    assert certificate(solved, displacement=up).complementarity > SLIGHT


def test_work_of_the_wrong_size(solved):
    wrong = certificate(solved, displacement=SLIGHT * solved[1].displacement)
    program = solved[0]
    assert wrong.work == pytest.approx(SLIGHT * program.work / (program.weight * program.step), rel=1e-3)


@pytest.mark.parametrize("entry", ["equilibrium", "cone", "complementarity", "penetration", "work"])
def test_the_worst_residual_counts_and_survives_joining(solved, entry):
    good = solved[1].certificate
    poor = replace(good, **{entry: 1.0})
    assert poor.worst(solved[0].step) >= 0.01
    assert getattr(good.joined(poor), entry) == getattr(poor.joined(good), entry) == 1.0


lengths = st.floats(0.2, 0.6)


@settings(max_examples=12, deadline=None)
@given(
    columns=st.integers(1, 4),
    courses=st.integers(1, 5),
    length=lengths,
    height=st.floats(0.1, 0.4),
    friction=st.floats(0.3, 1.0),
    full_on_top=st.booleans(),
    direction=st.sampled_from(["+x", "-x"]),
)
def test_interior_point_and_simplex_agree_on_walls(
    columns, courses, length, height, friction, full_on_top, direction
):
    model = running_bond(columns, courses, length, height, friction, full_on_top=full_on_top)
    _both_agree(model, direction)


@settings(max_examples=6, deadline=None)
@given(voussoirs=st.integers(5, 20), thickness=st.floats(0.13, 0.4), direction=st.sampled_from(["+x", "-x"]))
def test_interior_point_and_simplex_agree_on_arches(voussoirs, thickness, direction):
    _both_agree(semicircular_arch(voussoirs, thickness, friction=0.7), direction)


def _both_agree(model, direction):
    program = closed_program(model, model.initial, model.lateral_load(direction))[0]
    by_piqp, by_highs = interior_point.solve(program, 1e-9), linear.solve(program)
    assert by_piqp is not None
    assert by_highs is not None
    assert by_piqp[1] == pytest.approx(by_highs[1], abs=1e-7)
    assert certify(program, *by_highs).worst(program.step) < 1e-8
    assert solve(program).alpha == pytest.approx(by_highs[1], abs=1e-7)


def test_simplex_refuses_what_is_not_linear():
    model = block_on_base()
    program = assemble(model, "elastic", model.initial, model.initial.positions, model.dead_load, 1e-3)
    with pytest.raises(ValueError, match="not linear"):
        linear.solve(program)


@pytest.mark.parametrize("name", ["gap", "load", "normal", "friction"])
def test_a_number_that_is_not_finite_is_refused(solved, name):
    broken = np.full_like(getattr(solved[0], name), np.nan)
    with pytest.raises(ValueError, match="not finite"):
        interior_point.solve(replace(solved[0], **{name: broken}), 1e-9)


def slope(angle, friction):
    """A flat block on a plane that rises to the right at `angle` (rad)."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    stone = Material(18.0, friction, 1e6)
    base = Block(np.array(rectangle(-1, -0.2, 2, 0)) @ turn, 1.0, stone, support="base")
    return Assembly([base, Block(np.array(rectangle(0, 0, 1, 0.2)) @ turn, 1.0, stone)])


@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_infeasible_is_said_where_friction_is_too_small_for_the_slope(angle):
    check_self_weight(slope(angle, 1.001 * np.tan(0.3)))
    model = slope(angle, 0.99 * np.tan(0.3))
    with pytest.raises(NoEquilibriumError, match="start to move"):
        solve(closed_program(model, model.initial)[0])
    with pytest.raises(UnstableError, match="own weight"):
        check_self_weight(model)


def test_imbalance_is_the_acceleration_down_the_slope():
    # Gauss's principle with associative friction: the block leaves along the edge of the cone of motions,
    # at right angles to the friction cone's: g (sin a cos f − cos a sin f), f the friction angle
    angle, friction = 0.6, 0.3
    model = slope(angle, friction)
    escape = np.sin(angle - np.arctan(friction))
    found = imbalance(closed_program(model, model.initial)[0])
    direction = angle - np.arctan(friction)
    assert found == pytest.approx(escape * max(abs(np.cos(direction)), abs(np.sin(direction))), rel=1e-6)


@pytest.mark.parametrize("model", [block_on_base(), running_bond(), arch_on_piers()])
def test_imbalance_is_zero_where_gravity_is_carried(model):
    assert imbalance(closed_program(model, model.initial)[0]) < 1e-7


def test_not_converged_is_told_from_infeasible(monkeypatch, solved):
    # solvers that give up on a program that has a solution: no mechanical statement is made of it
    program = solved[0]
    monkeypatch.setattr(solvers, "suits_central_path", lambda contacts: False)
    monkeypatch.setattr(solvers, "_attempts", lambda _: iter([lambda: None, lambda: None]))
    with pytest.raises(ConvergenceError, match="equilibrium exists"):
        solve(program)


def test_what_balances_the_loads_decides_where_the_auxiliary_program_does_not(monkeypatch, solved):
    program, good = solved

    def undecided(*_):
        raise ConvergenceError("least acceleration was not solved")

    monkeypatch.setattr(solvers, "_by_central_path", lambda *_: None)
    monkeypatch.setattr(solvers, "imbalance", undecided)
    for by_central_path in (
        True,
        False,
    ):  # the auxiliary program is asked before the first attempt of PIQP, or after it
        monkeypatch.setattr(solvers, "suits_central_path", lambda contacts, first=by_central_path: first)
        monkeypatch.setattr(solvers, "_attempts", lambda _, wait=by_central_path: late(good, 1 - wait))
        assert solve(program).alpha == pytest.approx(good.alpha, abs=1e-9)
        monkeypatch.setattr(solvers, "_attempts", lambda _: iter([lambda: None, lambda: None]))
        with pytest.raises(ConvergenceError, match="least acceleration"):
            solve(program)


def late(solution, failures):
    """Attempts of which the first ones fail."""
    yield from [lambda: None] * failures
    yield lambda: (solution.forces, solution.alpha, solution.displacement)


def test_a_poor_answer_is_solved_again_by_another_solver(monkeypatch, solved):
    program, good = solved
    calls = []

    def poor(*_, **__):
        calls.append(1)
        return 1.01 * good.forces, good.alpha, good.displacement

    monkeypatch.setattr(solvers, "suits_central_path", lambda contacts: False)
    monkeypatch.setattr(interior_point, "solve", poor)
    monkeypatch.setattr(solvers, "imbalance", lambda *_: 0.0)
    assert solve(program).alpha == pytest.approx(good.alpha, abs=1e-9)
    assert len(calls) == 2


def wedged():
    """A block between two walls that cannot give way."""
    stone = Material(18.0, 0.7, 1e6)
    return Assembly(
        [
            Block(rectangle(-2, -1, 3, 0), 1.0, stone, support="base"),
            Block(rectangle(-1, 0, 0, 1), 1.0, stone, support="left"),
            Block(rectangle(1, 0, 2, 1), 1.0, stone, support="right"),
            Block(rectangle(0, 0, 1, 1), 1.0, stone),
        ]
    )


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_a_wedged_block_has_no_mechanism(direction):
    with pytest.raises(NoEquilibriumError, match="wedges"):
        limit_analysis(wedged(), direction)


@pytest.mark.parametrize("share", [0.1, 1.0, 3.0])
def test_shear_displacement_of_a_joint_with_tangential_stiffness(share):
    # far from sliding and tipping: u = H/(k_t A), the joint's rotation aside
    k_t = share * 1e6
    stone = Material(18.0, 0.7, 1e6, k_t)
    model = Assembly(
        [
            Block(rectangle(-1, -1, 2, 0), 1.0, stone, support="base"),
            Block(rectangle(0, 0, 1, 0.02), 1.0, stone),
        ],
        8,
    )
    start = rest(model, "elastic", model.initial)
    lateral = 0.1 * model.lateral_load("+x")
    pushed = find_step(model, "elastic", start.state, start.state.positions, model.dead_load + lateral, 1e-6)
    slid = pushed.state.positions[1, 0] - start.state.positions[1, 0]
    assert slid == pytest.approx(0.1 * model.weight / (k_t * 1.0), rel=2e-2)
    assert pushed.state.shear.sum() != 0.0
    # the joint remembers its shear: unloaded, the block comes back
    back = find_step(model, "elastic", pushed.state, pushed.state.positions, model.dead_load, 1e-6)
    assert back.state.positions[1, 0] == pytest.approx(start.state.positions[1, 0], abs=1e-3 * slid)


def test_a_joint_rigid_in_shear_keeps_no_shear():
    assert rest(block_on_base(), "elastic", block_on_base().initial).state.shear is None


def test_compression_of_an_elastic_joint_under_gravity():
    model = block_on_base(stiffness=1e5)
    step = rest(model, "elastic", model.initial)
    assert model.initial.positions[1, 1] - step.state.positions[1, 1] == pytest.approx(
        WEIGHT / (1e5 * 0.2), rel=1e-6
    )
    assert step.penetration < 1e-12
