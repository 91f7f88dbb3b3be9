"""The Newton solver against the interior point method of PIQP, and its loops against their definitions."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, State, time_history
from mechanics.assembly import Behaviour
from mechanics.block import Array
from mechanics.program import Program, certify
from mechanics.solvers import compiled, solve
from mechanics.solvers.elimination import PADDING
from mechanics.solvers.kernels import OPEN
from mechanics.solvers.newton import ACCEPTED, Newton
from mechanics.time_history import Integrator
from tests import reference_loops
from tests.steps import euler_step
from tests.structures import arch_on_piers, block_on_base, running_bond
from tests.test_dissection import dense

MODELS = {"block": block_on_base(), "wall": running_bond(3, 3), "arch": arch_on_piers(voussoirs=7, courses=3)}


def newton_for(model: Assembly, program: Program) -> Newton:
    return Newton(program.dof, model.initial.positions[model.movable, :2])


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
    program = euler_step(model, behaviour, shaken(model, seed), acceleration)
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


def test_geometry_is_that_of_its_definition_and_of_the_contacts() -> None:
    model = MODELS["arch"]
    contacts, x = model.contacts("rigid"), shaken(model, 1).positions
    exact = model.kinematics("rigid", x)
    gap, normal, tangent = (np.empty((len(contacts), n)) for n in (2, 6, 6))
    where = contacts.a, contacts.b, contacts.p, contacts.q, contacts.n
    compiled.geometry(*where, x, gap, normal, tangent)
    for gap_and_slide, *rows in (
        reference_loops.geometry(*where, x),
        (np.stack([exact.gap, exact.slide], axis=1), exact.normal, exact.tangent),
    ):
        assert gap == pytest.approx(gap_and_slide, abs=1e-14)
        assert normal == pytest.approx(rows[0], abs=1e-14)
        assert tangent == pytest.approx(rows[1], abs=1e-14)


def posed(model: Assembly, seed: int) -> tuple[tuple[Any, ...], Newton, Array, Array]:
    """Rows, gaps, friction and a compliance of the contact points of a shaken model, and displacements (m,)."""
    program = euler_step(model, "elastic", shaken(model, seed), 0.5)
    newton, rng = newton_for(model, program), np.random.default_rng(seed)
    compliance = program.compliance + rng.uniform(0.0, 1e-6, program.compliance.shape)
    x = 1e-3 * model.size * rng.standard_normal(len(program.load))
    gap = program.gap + 1e-3 * model.size * rng.standard_normal(program.gap.shape)
    law = newton.row, program.normal, program.tangent, gap, program.friction, compliance
    assert program.mass is not None
    return law, newton, program.mass[newton.order], x


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", sorted(MODELS))
def test_contact_law_and_residuals_are_those_of_their_definitions(name: str, seed: int) -> None:
    law, _, mass, x = posed(MODELS[name], seed)
    c = len(law[0])
    state, forces, total = np.zeros(c, np.intp), np.empty((c, 2)), np.empty_like(x)
    changes = compiled.contact_law(*law, x, state, forces, total)
    expected = reference_loops.contact_law(*law, x)
    assert forces == pytest.approx(expected[0], rel=1e-12, abs=1e-12 * abs(expected[0]).max())
    assert (state == expected[1]).all() and changes == (state != OPEN).sum()
    assert total == pytest.approx(expected[2], rel=1e-12, abs=1e-10 * abs(expected[0]).max())
    rest = law, mass, total, x, forces + 1.0, 0.7
    found, defined = (loops.residuals(*law, *rest[1:]) for loops in (compiled, reference_loops))
    assert found == pytest.approx(defined, rel=1e-12)


@pytest.mark.parametrize("name", sorted(MODELS))
def test_contacts_that_keep_their_states_are_springs(name: str) -> None:
    """Their forces are those of the law where its states are theirs; the matrix is the derivative of M̄x − A₀c."""
    law, newton, mass, x = posed(MODELS[name], 4)
    row, normal, tangent, _, friction, compliance = law
    forces, state, _ = reference_loops.contact_law(*law, x)
    assert len(set(state)) > 1
    kept, totals = np.empty_like(forces), []
    move = np.random.default_rng(5).standard_normal(len(x))
    for at in (x, x + move):
        totals.append(np.empty_like(x))
        compiled.repeat_forces(*law, at, state, kept, totals[-1])
        if at is x:
            assert kept == pytest.approx(forces, rel=1e-12, abs=1e-12 * abs(forces).max())
    compiled.repeat_matrix(
        row, normal, tangent, friction, compliance, mass, state, newton.stored, newton.pattern
    )
    change = mass * move - (totals[1] - totals[0])
    assert dense(newton.stored, newton.row, newton.pattern) @ move == pytest.approx(
        change, rel=1e-9, abs=1e-9 * abs(change).max()
    )


def test_band_is_narrow_and_known_states_need_one_factorisation() -> None:
    model = running_bond(6, 6)
    program = euler_step(model, "rigid", model.initial, 0.0)
    newton = newton_for(model, program)
    assert newton.pattern.places <= 3 * 16 + PADDING, "reverse Cuthill–McKee: courses of at most 7 bricks"
    first = newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
    before = newton.factorisations
    newton.solve(program, np.zeros(len(program.load)), first.forces)
    assert newton.factorisations - before <= 2
    assert newton.repeated == 1


def test_no_contacts_at_all() -> None:
    program = euler_step(MODELS["block"], "rigid", MODELS["block"].initial, 0.1).take(
        np.zeros(0, dtype=np.intp)
    )
    newton = newton_for(MODELS["block"], program)
    found = newton.solve(program, np.zeros(3), np.zeros((0, 2)))
    assert found.displacement == pytest.approx(program.load / program.mass)


def random_models(count: int) -> list[tuple[Assembly, State]]:
    """Small walls, arches and blocks of random shape, friction and stiffness, out of place and moving."""
    rng = np.random.default_rng(7)
    models = []
    for seed in range(count):
        friction, stiffness = rng.uniform(0.05, 1.5), 10.0 ** rng.uniform(4.0, 8.0)
        kind = seed % 3
        if kind == 0:
            columns, courses = rng.integers(1, 4, 2)
            model = running_bond(int(columns), int(courses), friction=friction, stiffness=stiffness)
        elif kind == 1:
            model = arch_on_piers(
                voussoirs=int(rng.integers(3, 8)), courses=int(rng.integers(1, 4)), friction=friction,
                stiffness=stiffness, segments=int(rng.integers(1, 3)),
            )  # fmt: skip
        else:
            model = block_on_base(rng.uniform(0.1, 2.0), rng.uniform(0.1, 4.0), friction, stiffness)
        models.append((model, shaken(model, seed)))
    return models


def test_a_corpus_of_random_assemblies_agrees_with_the_reference_solver(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The optima of 300 programs to 1e-7, the solver being asked for more than a step of a history needs."""
    monkeypatch.setattr("mechanics.solvers.newton.ACCEPTED", 1e-9)
    rng = np.random.default_rng(8)
    for number, (model, state) in enumerate(random_models(150)):
        for behaviour in ("rigid", "elastic"):
            program = euler_step(model, behaviour, state, rng.uniform(-1.0, 1.0))
            assert program.mass is not None
            reference = solve(program)
            newton = newton_for(model, program)
            found = newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
            assert found is not None and found.certificate.worst(program.step) <= 1e-8, number
            energies = []
            for answer in (found, reference):
                inertia = program.mass * answer.displacement
                energies.append(
                    0.5 * float(inertia @ answer.displacement)
                    + 0.5 * float((program.compliance * answer.forces**2).sum())
                    + float((program.gap * answer.forces).sum())
                )
            size = max(
                0.5 * float(program.load @ (program.load / program.mass)), program.weight * program.step
            )
            assert abs(energies[0] - energies[1]) <= 1e-7 * size, (number, behaviour)


def test_the_line_search_finds_the_minimum_along_a_direction() -> None:
    """The slope there, that of the energy, is zero, or still negative where the whole step is taken."""
    model = MODELS["wall"]
    program = euler_step(model, "elastic", shaken(model, 3), 0.5)
    assert program.mass is not None
    newton = newton_for(model, program)
    rows = (newton.row, program.normal, program.tangent)
    compliance = program.compliance + np.array([0.0, 1e-6])
    mass, load = program.mass[newton.order], program.load[newton.order]
    law = (program.gap, program.friction, compliance)
    x = np.zeros_like(mass)

    def downhill(at: Array) -> Array:
        return load + reference_loops.contact_law(*rows, *law, at)[2] - mass * at

    first = downhill(x)
    for length in (0.5, 3.0, 30.0):
        dx = length * first / mass
        share = compiled.line_search(*rows, *law, mass, load, x, dx)
        slope = downhill(share * dx) @ dx
        assert (share == 1.0 and slope > 0.0) or abs(slope) <= 0.1 * (first @ dx)


def test_sweeps_order_a_wall_by_its_courses() -> None:
    """Courses of 18 whole bricks or 19 with the halves: no brick is farther than a course from those it touches."""
    model = running_bond(18, 19)
    contacts = model.contacts("rigid")
    newton = Newton(
        np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1),
        model.initial.positions[model.movable, :2],
    )
    assert newton.pattern.places <= 3 * 20 + PADDING, "reverse Cuthill–McKee has 3 · 28"


def counted(
    model: Assembly, amplitude: float, behaviour: Behaviour, integrator: Integrator = "implicit-euler"
) -> tuple[float, float]:
    """Factorisations a step, and share of the steps that repeat contact states, under a growing sine."""
    t = 0.005 * np.arange(120)
    record = amplitude * np.minimum(t / 0.3, 1.0) * np.sin(2.0 * np.pi * 3.0 * t)
    scenes: list[Newton] = []
    kept = Newton.__post_init__

    def noted(newton: Newton) -> None:
        kept(newton)
        scenes.append(newton)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Newton, "__post_init__", noted)
        motion = time_history(model, record, 0.005, behaviour, integrator=integrator)
    newton = scenes[-1]
    assert motion.resolved == 0
    return newton.factorisations / newton.solved, newton.repeated / newton.solved


@pytest.mark.parametrize(
    ("model", "amplitude", "behaviour", "most", "repeated"),
    [
        (block_on_base(0.6, 4.2, stiffness=1e6), 0.25, "elastic", 2.2, 0.8),
        (block_on_base(0.6, 4.2, stiffness=1e6), 0.25, "rigid", 2.5, 0.95),
        (arch_on_piers(), 0.04, "rigid", 1.3, 0.95),
        (arch_on_piers(), 0.04, "elastic", 7.0, 0.15),
        (running_bond(6, 6, stiffness=1e7), 0.5, "elastic", 5.0, 0.3),
        (running_bond(6, 6, stiffness=1e7), 0.5, "rigid", 3.0, 0.75),
    ],
    ids=lambda value: f"{len(value.blocks)} blocks" if isinstance(value, Assembly) else str(value),
)
def test_factorisations_per_step(
    model: Assembly, amplitude: float, behaviour: Behaviour, most: float, repeated: float
) -> None:
    factorisations, share = counted(model, amplitude, behaviour)
    assert factorisations <= most
    assert share >= repeated


def test_midpoint_steps_start_from_the_mean_of_the_last_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces of elastic joints ring from step to step: their mean is nearer to the next ones than the last are."""
    ringing, _ = counted(arch_on_piers(), 0.04, "elastic", "second-order")
    monkeypatch.setattr(sys.modules["mechanics.time_history"], "RINGING", 1.0)
    last, _ = counted(arch_on_piers(), 0.04, "elastic", "second-order")
    assert ringing < 0.9 * last


def test_steps_at_rest_need_one_factorisation() -> None:
    """Where no contact changes state the last states are right at once."""
    factorisations, share = counted(running_bond(6, 6, stiffness=1e7), 0.0, "rigid")
    assert factorisations < 1.2
    assert share > 0.98
