"""The Newton solver against the interior point method of PIQP, and its loops against each other."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, State
from mechanics.block import GRAVITY
from mechanics.program import Program, certify
from mechanics.solvers import kernels, solve
from mechanics.solvers.newton import ACCEPTED, Newton
from tests.structures import arch_on_piers, block_on_base, running_bond

MODELS = {"block": block_on_base(), "wall": running_bond(3, 3), "arch": arch_on_piers(voussoirs=7, courses=3)}


def a_step(
    model: Assembly, behaviour: str, state: State, acceleration: float, step: float = 0.005
) -> Program:
    """The program of an implicit Euler step (paper, eq. 3)."""
    contacts, movable = model.contacts(behaviour), model.movable
    rows = model.kinematics(behaviour, state.positions)
    load = model.dead_load - acceleration * GRAVITY * model.mass * (1.0, 0.0, 0.0)
    mass = model.mass[movable].ravel() / step**2
    return Program(
        dof=np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1),
        normal=rows.normal,
        tangent=rows.tangent,
        gap=np.stack([rows.gap, np.zeros(len(contacts))], axis=1),
        friction=contacts.friction,
        compliance=np.zeros((len(contacts), 2)) if behaviour == "rigid" else 1.0 / contacts.stiffness,
        load=load[movable].ravel() + mass * step * state.velocities[movable].ravel(),
        lateral=None,
        work=0.0,
        mass=mass,
        weight=model.weight / movable.sum(),
        size=model.size,
        step=max(GRAVITY * step**2, step * abs(state.velocities[:, :2]).max()),
    )


def newton_for(model: Assembly, program: Program, loops: ModuleType = kernels) -> Newton:
    return Newton(program.dof, model.initial.positions[model.movable, :2], loops)


def shaken(model: Assembly, seed: int) -> State:
    """Blocks a little out of place and moving."""
    rng = np.random.default_rng(seed)
    size = model.movable[:, None] * model.size * np.array([1.0, 1.0, 1.0 / model.size])
    move = rng.standard_normal((2, len(model.blocks), 3)) * size
    return State(model.initial.positions + 1e-5 * move[0], 1e-2 * move[1])


@settings(deadline=None, max_examples=40)
@given(
    name=st.sampled_from(sorted(MODELS)),
    behaviour=st.sampled_from(["rigid", "elastic"]),
    seed=st.integers(0, 10**6),
    acceleration=st.floats(-1.0, 1.0),
)
def test_agrees_with_the_reference_solver(name: str, behaviour: str, seed: int, acceleration: float) -> None:
    model = MODELS[name]
    program = a_step(model, behaviour, shaken(model, seed), acceleration)
    reference = solve(program)
    found = newton_for(model, program).solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
    assert found is not None
    assert found.certificate.worst(program.step) <= ACCEPTED
    again = certify(program, found.forces, 0.0, found.displacement)
    assert again.worst(program.step) == pytest.approx(found.certificate.worst(program.step), abs=1e-9)
    difference = found.displacement - reference.displacement
    # in the energy norm, whose square the duality gap bounds
    assert program.mass is not None
    assert np.sqrt(difference @ (program.mass * difference)) < 0.02 * np.sqrt(
        program.weight * program.step * len(program.load)
    )


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_compiled_loops_give_the_same_results(behaviour: str) -> None:
    compiled = pytest.importorskip("mechanics.solvers.compiled")
    model = MODELS["arch"]
    for seed in range(3):
        program = a_step(model, behaviour, shaken(model, seed), 0.3)
        answers = [
            newton_for(model, program, loops).solve(
                program, np.zeros(len(program.load)), np.zeros_like(program.gap)
            )
            for loops in (kernels, compiled)
        ]
        assert answers[0].displacement == pytest.approx(answers[1].displacement, abs=1e-7 * program.step)


def test_geometry_of_the_loops_is_that_of_the_contacts() -> None:
    compiled = pytest.importorskip("mechanics.solvers.compiled")
    model = MODELS["arch"]
    contacts, x = model.contacts("rigid"), shaken(model, 1).positions
    exact = model.kinematics("rigid", x)
    for loops in (kernels, compiled):
        gap, normal, tangent = (np.empty((len(contacts), n)) for n in (2, 6, 6))
        loops.geometry(contacts.a, contacts.b, contacts.p, contacts.q, contacts.n, x, gap, normal, tangent)
        assert gap[:, 0] == pytest.approx(exact.gap, abs=1e-14)
        assert gap[:, 1] == pytest.approx(exact.slide, abs=1e-14)
        assert normal == pytest.approx(exact.normal, abs=1e-14)
        assert tangent == pytest.approx(exact.tangent, abs=1e-14)


def test_band_is_narrow_and_known_states_need_one_factorisation() -> None:
    model = running_bond(6, 6)
    program = a_step(model, "rigid", model.initial, 0.0)
    newton = newton_for(model, program)
    assert newton.band.shape[1] <= 3 * 16, "reverse Cuthill–McKee: courses of at most 7 bricks"
    first = newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
    before = newton.factorisations
    newton.solve(program, np.zeros(len(program.load)), first.forces)
    assert newton.factorisations - before <= 2
    assert newton.repeated == 1


def test_no_contacts_at_all() -> None:
    program = a_step(MODELS["block"], "rigid", MODELS["block"].initial, 0.1).take(np.zeros(0, dtype=np.intp))
    newton = newton_for(MODELS["block"], program)
    found = newton.solve(program, np.zeros(3), np.zeros((0, 2)))
    assert found.displacement == pytest.approx(program.load / program.mass)
