"""The program: its certificate, its solvers against each other, and what it says where there is no solution."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog

from mechanics import Assembly, Block, ConvergenceError, Material, NoEquilibriumError, limit_analysis, solvers
from mechanics.kernels.joint import H, U
from mechanics.kernels.law import BED, FRICTION, SEGMENTS, SHEAR, SLID, STRENGTH
from mechanics.model.contacts import rows
from mechanics.program import Program, Solution, bed_gaps, certify
from mechanics.solvers import interior, lp_highs, qp_piqp, solve
from mechanics.steps.equilibrium import closed_program, rest
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from tests.support.drawn_projects import drawn
from tests.support.steps import euler_step, posed, shaken, static_step
from tests.support.structures import (
    block_on_base,
    built,
    column,
    on_base,
    rectangle,
    running_bond,
)

SLIGHT = 1e-3
KINDS = ("rigid", "elastic", "points", "crushing", "crushing bed", "dynamic")


def problem_of(kind: str) -> tuple[Program, Solution]:
    """A program of each kind and its solution."""
    strength = 60.0 if kind.startswith("crushing") else np.inf
    model = column(0.5, 1.5, 3, 1e5, strength=strength, segments=4 if kind == "points" else None)
    if kind == "dynamic":
        program, layout = euler_step(model, "elastic", shaken(model, 1), 0.3)
    elif kind in ("rigid", "crushing"):
        closed = closed_program(model, model.initial).pushed(model, model.lateral_load("+x"))
        program, layout = closed.program, closed.layout
    else:
        system = static_system(model, "elastic")
        load = model.dead_load + 0.08 * model.lateral_load("+x")
        program, layout = posed(StepProblem(system, model.initial, load, 1e-3))
    return program, solve(program, layout)[0]


@pytest.fixture(scope="module", params=KINDS)
def solved(request):
    return problem_of(request.param)


def certificate(solved, forces=0.0, alpha=0.0, displacement=0.0):
    program, s = solved
    return certify(program, s.forces + forces, s.alpha + alpha, s.displacement + displacement)


def test_a_solution_is_certified(solved):
    program, solution = solved
    assert solution.certificate.worst(program.step) < 1e-8
    assert certificate(solved) == solution.certificate


def test_a_force_at_the_end_of_its_joint_and_one_beyond(solved):
    """|P| ≤ hN, and less where the strength is finite: what is beyond is outside by the whole of it."""
    program, solution = solved
    half, n = program.places[:, H], solution.forces[:, 0]
    most = half * (n - n**2 / (2.0 * half * program.law[:, STRENGTH]))
    for joint in range(len(half)):
        for sign in (-1.0, 1.0):
            edge = solution.forces.copy()
            edge[joint, 1] = sign * most[joint]
            found = certify(program, edge, solution.alpha, solution.displacement)
            assert found.cone < 1e-7
            edge[joint, 1] += sign * 2.0 * half[joint] * SLIGHT * program.weight
            found = certify(program, edge, solution.alpha, solution.displacement)
            assert found.cone == pytest.approx(SLIGHT, rel=0.01)


def test_a_force_outside_the_friction_cone(solved):
    program, solution = solved
    for sign in (-1.0, 1.0):
        wrong = solution.forces.copy()
        wrong[1, 2] = sign * (program.law[1, FRICTION] * wrong[1, 0] + SLIGHT * program.weight)
        found = certify(program, wrong, solution.alpha, solution.displacement)
        assert found.cone == pytest.approx(SLIGHT, rel=1e-6)


def test_tension(solved):
    wrong = solved[1].forces.copy()
    wrong[0] = -SLIGHT * solved[0].weight, 0.0, 0.0
    assert certify(solved[0], wrong, 0.0, solved[1].displacement).cone >= 0.5 * SLIGHT


def test_a_slip_under_less_than_friction_does_work(solved):
    program, solution = solved
    aside = np.zeros_like(solution.displacement)
    aside[0::3] = program.step
    sticks = abs(solution.forces[0, 2]) < 0.9 * program.law[0, FRICTION] * solution.forces[0, 0]
    assert sticks
    assert certificate(solved, displacement=aside).complementarity > SLIGHT


def test_a_wrong_multiplier_and_a_wrong_work():
    solved = problem_of("rigid")
    program, solution = solved
    assert certificate(solved, alpha=SLIGHT).equilibrium == pytest.approx(SLIGHT, rel=0.6)
    wrong = certificate(solved, displacement=SLIGHT * solution.displacement)
    assert wrong.work == pytest.approx(SLIGHT * program.work / (program.weight * program.step), rel=1e-3)


@pytest.mark.parametrize("what", ["bed", "segments", "strength", "shear", "slid", "gap", "load"])
def test_a_solution_of_another_program_is_none_of_this_one(what):
    """The law, the geometry and the loads are recomputed from the program, whatever a solver solved."""
    program, solution = problem_of("crushing bed" if what == "strength" else "points")
    law, places, load = program.law.copy(), program.places.copy(), program.load.copy()
    if what == "bed":
        law[:, BED] *= 1.1
    elif what == "segments":
        law[:, SEGMENTS] = 0
    elif what == "strength":
        law[:, STRENGTH] *= 0.8
    elif what == "shear":
        law[:, SHEAR] += 1e-3 * program.step
    elif what == "slid":
        law[:, SLID] += 0.1 * program.step
    elif what == "gap":
        places[:, U] += 0.1 * program.step
    else:
        load *= 1.001
    other = replace(program, law=law, places=places, load=load)
    assert certify(other, solution.forces, solution.alpha, solution.displacement).worst(program.step) > 1e-6


@pytest.mark.parametrize("entry", ["equilibrium", "cone", "complementarity", "penetration", "work"])
def test_the_worst_residual_counts_and_survives_joining(entry):
    program, solution = problem_of("rigid")
    poor = replace(solution.certificate, **{entry: 1.0})
    assert poor.worst(program.step) >= 0.01
    assert (
        getattr(solution.certificate.joined(poor), entry)
        == getattr(poor.joined(solution.certificate), entry)
        == 1.0
    )


# --- solvers of different kinds


def tangent_cuts(model: Assembly, direction: str) -> float:
    """α of rigid joints that crush, by linear programs: N₁, N₂ ≥ κN² by its tangents where it is violated."""
    program = closed_program(model, model.initial).pushed(model, model.lateral_load(direction)).program
    count, half, b = len(program.law), program.places[:, H], rows(program.places)
    kappa = 1.0 / (4.0 * half * program.law[:, STRENGTH])
    ends = np.stack([b[:, 0] - half[:, None] * b[:, 1], b[:, 0] + half[:, None] * b[:, 1], b[:, 2]], axis=1)
    moving = np.broadcast_to((program.dof >= 0)[:, None, :], ends.shape)
    at = np.broadcast_to(program.dof[:, None, :], ends.shape)[moving]
    col = np.broadcast_to(np.arange(3 * count).reshape(-1, 3, 1), ends.shape)[moving]
    balance = sparse.csr_matrix((ends[moving], (at, col)), shape=(len(program.load), 3 * count))
    balance = sparse.hstack([balance, program.lateral[:, None]]).tocsr()
    cuts, bounds = [], []
    for k in range(count):
        for sign in (1.0, -1.0):
            cut = np.zeros(3 * count + 1)
            cut[3 * k : 3 * k + 3] = -program.law[k, FRICTION], -program.law[k, FRICTION], sign
            cuts.append(cut)
            bounds.append(0.0)
    free = [(0.0, None), (0.0, None), (None, None)] * count + [(None, None)]
    most = np.r_[np.zeros(3 * count), -1.0]
    sharp = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    for _ in range(20):
        rows_of = sparse.csr_matrix(np.array(cuts))
        found = linprog(most, rows_of, bounds, balance, -program.load, free, "highs-ds", options=sharp).x
        forces = found[:-1].reshape(-1, 3)
        n = forces[:, 0] + forces[:, 1]
        short = kappa[:, None] * n[:, None] ** 2 - forces[:, :2]
        if short.max() < 1e-8 * program.weight:
            return float(found[-1])
        for k, end in np.argwhere(short > 1e-10 * program.weight):
            cut = np.zeros(3 * count + 1)
            cut[3 * k : 3 * k + 2] = 2.0 * kappa[k] * n[k]
            cut[3 * k + end] -= 1.0
            cuts.append(cut)
            bounds.append(kappa[k] * n[k] ** 2)
    raise AssertionError(f"the cuts leave {short.max():.2g} kN")


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_crushing_by_linear_programs(direction):
    model = drawn("buttressed_arch", 1.0, 41.5)
    assert limit_analysis(model, direction).alpha == pytest.approx(tangent_cuts(model, direction), abs=1e-7)


def onset(model: Assembly) -> Program:
    """The program of its first motion towards +x by Coulomb's law."""
    pushed = closed_program(model, model.initial).pushed(model, model.lateral_load("+x"))
    return interior.with_dilation(pushed.program, 0.0)


def test_what_presses_with_infinite_friction_does_not_slide():
    """A block between two supports: slides down both faces had forces, T of ten thousand times N."""
    stone = Material(20.0, np.inf)
    names = ("left", None, "right")
    boxes = [rectangle(left, 0.0, left + 1.0, 1.0) for left in (-1.0, 0.0, 1.0)]
    model = Assembly([Block(box, 1.0, stone, support=name) for box, name in zip(boxes, names, strict=True)])
    flowing = np.array([[False, False, True, False], [False, False, False, True]])
    assert lp_highs.least_multiplier(qp_piqp.StandardForm.of(onset(model)), flowing) is None


def test_a_gap_counts_however_small_it_is_beside_the_motion():
    """A needle of 0.2 mm by 1 m rocks: its base opens by 4·10⁻⁴ of what its centroid moves."""
    free = np.ones((1, 4), dtype=bool)
    found = lp_highs.mechanism_of(onset(block_on_base(2e-4, 1.0)), free, 1.0 * free)
    assert found is not None and found[1].tolist() == [[False, True, False, False]]


@pytest.mark.parametrize("name", ["places", "load", "law"])
def test_a_number_that_is_not_finite_is_no_solution(name):
    program, layout = static_step(block_on_base(), "rigid")
    broken = replace(program, **{name: np.full_like(getattr(program, name), np.nan)})
    with pytest.raises((ValueError, ConvergenceError)):
        solve(broken, layout)


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_a_solution_near_another_takes_fewer_iterations_than_one_from_nowhere(behaviour):
    model = running_bond(5, 6, stiffness=1e6)
    program, layout = static_step(model, behaviour)
    _, iterate = solve(program, layout)
    assert iterate is not None
    near = replace(program, load=program.load * 1.001)
    cold = interior.run(near, layout, interior.cold(near), 1e-8)[1]
    warm = interior.run(near, layout, iterate.warm(near, 1e-3), 1e-8)[1]
    assert cold.accepted and warm.accepted
    assert warm.iterations < cold.iterations


# --- no solution


def failing(*_):
    """A run of the method of our own that ends nowhere."""
    return None, interior.IterationEnd(False, False, 1, np.inf, np.inf, np.inf)


def test_not_converged_is_told_from_infeasible(monkeypatch):
    """Solvers that give up on a program that has a solution: no mechanical statement is made of it."""
    program, layout = static_step(running_bond(3, 3), "rigid")
    monkeypatch.setattr(interior, "run", failing)
    monkeypatch.setattr(solvers, "least_acceleration", lambda *_: (0.0, None))
    monkeypatch.setattr(solvers, "_second_opinions", lambda _: iter([None, None]))
    with pytest.raises(ConvergenceError, match="equilibrium exists"):
        solve(program, layout)


def test_what_balances_the_loads_decides_where_the_auxiliary_program_does_not(monkeypatch):
    program, layout = static_step(running_bond(3, 3), "rigid")
    good, _ = solve(program, layout)

    def undecided(*_):
        raise ConvergenceError("least acceleration was not solved")

    monkeypatch.setattr(interior, "run", failing)
    monkeypatch.setattr(solvers, "least_acceleration", undecided)
    assert solve(program, layout)[0].alpha == pytest.approx(good.alpha, abs=1e-7)
    monkeypatch.setattr(solvers, "_second_opinions", lambda _: iter([None]))
    with pytest.raises(ConvergenceError, match="least acceleration"):
        solve(program, layout)


def test_a_poor_answer_is_solved_again_by_another_solver(monkeypatch):
    program, layout = static_step(running_bond(3, 3), "rigid")
    good, _ = solve(program, layout)
    calls = []

    def poor(*_, **__):
        calls.append(1)
        return 1.01 * good.forces, good.alpha, good.displacement

    monkeypatch.setattr(interior, "run", failing)
    monkeypatch.setattr(qp_piqp, "solve", poor)
    monkeypatch.setattr(solvers, "least_acceleration", lambda *_: (0.0, None))
    # α is known to the sum of the products over the work: four a joint, of which the mean was accepted
    exact = 4.0 * len(program.places) * solvers.ACCEPTED * program.weight * program.step / program.work
    assert solve(program, layout)[0].alpha == pytest.approx(good.alpha, abs=exact)
    assert len(calls) == 2


def wedged():
    """A block between two walls that cannot give way."""
    return built(
        Material(18.0, 0.7, 1e6), (0, 0, 1, 1), base=(-2, -1, 3, 0), left=(-1, 0, 0, 1), right=(1, 0, 2, 1)
    )


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_a_wedged_block_has_no_mechanism(direction):
    with pytest.raises(NoEquilibriumError, match="wedges"):
        limit_analysis(wedged(), direction)


# --- elastic joints


@pytest.mark.parametrize("share", [0.1, 1.0, 3.0])
def test_shear_displacement_of_a_joint_with_tangential_stiffness(share):
    """Far from sliding and tipping: u = H/(k_t A), the joint's rotation aside; unloaded, the block comes back."""
    k_t = share * 1e6
    model = on_base(Material(18.0, 0.7, 1e6, k_t), (-1, -1, 2), (0, 0, 1, 0.02))
    system = static_system(model, "elastic")
    start = rest(system, model.initial)
    load = model.dead_load + 0.1 * model.lateral_load("+x")
    pushed = find_equilibrium(StepProblem(system, start.state, load, 1e-6), start.state.positions)
    slid = pushed.state.positions[1, 0] - start.state.positions[1, 0]
    assert slid == pytest.approx(0.1 * model.weight / k_t, rel=2e-2)
    assert pushed.state.shear.sum() != 0.0
    back = find_equilibrium(StepProblem(system, pushed.state, model.dead_load, 1e-6), pushed.state.positions)
    assert back.state.positions[1, 0] == pytest.approx(start.state.positions[1, 0], abs=1e-3 * slid)


def test_a_joint_rigid_in_shear_keeps_no_shear():
    model = block_on_base()
    assert rest(static_system(model, "elastic"), model.initial).state.shear is None


def test_a_raised_force_of_an_elastic_end_does_not_change_what_its_gap_misses():
    """Where a bed opens, a little force at its open end closes it by much: the gap beside it grows by as much."""
    model = on_base(Material(18.0, 0.7, 1e6), (-1, -1, 2), (0, 0, 1, 1))
    system = static_system(model, "elastic")
    program, _ = posed(StepProblem(system, model.initial, model.dead_load, 1e-3))
    forces = program.weight * np.array([[1e-6, 1.0, 0.0]])
    near = interior.Iterate(forces, np.full((1, 4), 1e-4), 0.0, np.zeros(3))
    begun = near.warm(program, 1e-3)
    assert begun.forces[0, 0] > 100.0 * forces[0, 0]
    before, after = (
        each.gaps[:, :2] + bed_gaps(each.forces[:, :2], program.places[:, H], program.law)
        for each in (near, begun)
    )
    assert before[0, 0] == pytest.approx(after[0, 0], rel=1e-9)
    assert begun.gaps[0, 0] > 2.0 * near.gaps[0, 0]
    # the other end yields less: its gap is the least
    assert begun.gaps[0, 1] == pytest.approx(1e-3 * program.step)
