"""What stands and what does not: faces that nothing presses, inclines steeper than friction, walls without any."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import (
    Assembly,
    Block,
    CollapseError,
    ConvergenceError,
    Material,
    NoEquilibriumError,
    UnstableError,
    limit_analysis,
    pushdown,
    pushover,
)
from mechanics.solvers import least_acceleration, solve
from mechanics.steps import equilibrium as rests
from mechanics.steps import geometry_iteration as module
from mechanics.steps import unpressed
from mechanics.steps.equilibrium import check_self_weight, closed_program
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from tests.support.random_masonry import random_masonry
from tests.support.steps import posed
from tests.support.structures import arch_on_piers, on_base, rectangle, running_bond

STONE = Material(20.0, 0.84, 1e6)


def between_walls(*blocks: Block) -> Assembly:
    walls = [
        Block(rectangle(-1.0, -1.0, 0.0, 2.0), 1.0, STONE, support="left"),
        Block(rectangle(1.8, -1.0, 2.8, 2.0), 1.0, STONE, support="right"),
    ]
    return Assembly([*blocks, *walls])


BEAM = Block(rectangle(0.0, 0.0, 1.8, 0.8), 1.0, STONE)
BED = Block(rectangle(0.0, -1.0, 1.8, -0.03), 1.0, STONE, support="bed")


def test_a_beam_between_walls_hangs_by_self_stress_alone():
    """By limit analysis it stands; elastic joints have no force on faces that nothing presses, however stiff."""
    model = between_walls(BEAM)
    assert unpressed(model).tolist() == [0]
    assert unpressed(between_walls(BEAM, BED)).tolist() == [0], "30 mm above its bed"
    for stiffness in (1e5, 1e7):
        stiff = Material(20.0, 0.84, stiffness)
        soft = Assembly([Block(b.vertices, 1.0, stiff, support=b.support) for b in model.blocks])
        with pytest.raises(UnstableError, match="by friction of faces that nothing presses"):
            pushover(soft, (0.9, 0.6), "+x", "elastic", 0.005)


def test_siblings_of_a_beam_between_walls():
    """A row with upright joints, keystones that nothing wedges; a beam whose thrust is lost as a wall goes away."""
    row = [Block(rectangle(0.6 * k, 0.0, 0.6 * (k + 1), 0.8), 1.0, STONE) for k in range(3)]
    assert unpressed(between_walls(*row)).tolist() == [0, 1, 2]
    with pytest.raises(CollapseError):
        pushdown(between_walls(BEAM), "right", (0.01, 0.0), increment=0.001)


def test_what_weight_presses_together_is_not_named():
    model = random_masonry(3)
    limit_analysis(model)
    assert not len(unpressed(model))


def test_walls_and_arches_stand_pressed_by_their_weight():
    for model in (running_bond(), arch_on_piers(voussoirs=7, courses=3)):
        assert not len(unpressed(model))
    wall, loose = running_bond(3, 3), np.array([0.02, 0.0])
    held = Block(wall.blocks[-1].vertices + loose, 0.1, STONE)
    assert not len(unpressed(Assembly([*wall.blocks[:-1], held])))


@pytest.mark.parametrize("count", [10, 100])
def test_no_block_of_a_tall_stack_is_named(count: int):
    """The beds of the probe yielded by 10⁻⁴ of a block a block above: 68 of 100 sank as if they fell."""
    stack = ((0.0, 0.3 * k, 0.6, 0.3 * (k + 1)) for k in range(count))
    assert not len(unpressed(on_base(STONE, (-2.0, -0.5, 3.0), *stack)))


FRICTION = 0.3


def on_an_incline(angle: float, friction: float = FRICTION) -> Assembly:
    """A flat block on a support whose face rises to the right by an angle (rad)."""
    stone, turn = (
        Material(18.0, friction, 1e6),
        np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]),
    )
    plane = Block(np.array(rectangle(-1.0, -0.2, 2.0, 0.0)) @ turn, 1.0, stone, support="plane")
    return Assembly([plane, Block(np.array(rectangle(0.0, 0.0, 1.0, 0.2)) @ turn, 1.0, stone)])


def step(model: Assembly, contacts: str) -> StepProblem:
    return StepProblem(static_system(model, contacts), model.initial, model.dead_load, 1e-4)


@pytest.mark.parametrize(("contacts", "steeper"), [("rigid", 0.01), ("rigid", 0.2), ("elastic", 0.2)])
def test_a_block_on_a_plane_steeper_than_friction_would_start_to_move(contacts, steeper):
    """Gauss's principle: along the edge of the cone of friction, with (sin θ − μ cos θ)/√(1 + μ²) of gravity."""
    angle = np.arctan(FRICTION) + steeper
    along = (np.sin(angle) - FRICTION * np.cos(angle)) / np.hypot(1.0, FRICTION)
    steepest = along * np.cos(angle - np.arctan(FRICTION))  # its larger component, x
    problem = step(on_an_incline(angle), contacts)
    assert least_acceleration(*posed(problem))[0] == pytest.approx(
        steepest, rel=1e-3 if contacts == "elastic" else 1e-6
    )
    with pytest.raises((NoEquilibriumError, ConvergenceError)):
        find_equilibrium(problem, problem.start.positions)


@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_infeasible_is_said_where_friction_is_too_small_for_the_slope(angle):
    check_self_weight(on_an_incline(angle, 1.001 * np.tan(0.3)))
    model = on_an_incline(angle, 0.99 * np.tan(0.3))
    closed = closed_program(model, model.initial)
    with pytest.raises(NoEquilibriumError, match="start to move"):
        solve(closed.program, closed.layout)
    with pytest.raises(UnstableError, match="own weight"):
        check_self_weight(model)


@pytest.mark.parametrize("angle", [3e-6, 1e-4])
def test_a_block_slides_off_a_slope_that_is_steeper_than_its_friction(angle: float) -> None:
    """Without friction by g sin θ, of which next to nothing is taken for none."""
    with pytest.raises(UnstableError, match=f"start to move with {angle:.2g} g"):
        check_self_weight(on_an_incline(angle, 0.0))
    check_self_weight(on_an_incline(angle, 1.001 * angle))


@pytest.mark.parametrize("friction", [0.0, 1e-6])
def test_a_wall_with_next_to_no_friction_stands(friction: float) -> None:
    """Vertical forces carry it, at the bounds of friction."""
    check_self_weight(running_bond(3, 4, friction=friction))


@pytest.mark.parametrize("fails", ["is not solved", "loses its joints", "is worse"])
def test_an_equilibrium_is_kept_where_the_program_that_would_better_it_fails(fails, monkeypatch):
    """Of 1e-7; what balances to 1e-9 may lie a metre in other blocks."""
    model = running_bond(2, 2, stiffness=1e6)
    problem = StepProblem(static_system(model, "elastic"), model.initial, model.dead_load, 1e-3 * model.size)
    solve_round, judged, seen = module._solve_round, module.certified, []

    def another_round(*given):
        if fails == "is not solved" and seen:
            raise ConvergenceError("no")
        return solve_round(*given)

    def rough(*given):
        found = judged(*given)
        seen.append(found)
        wrong = {"equilibrium": 1e-7} if len(seen) == 1 else {"equilibrium": 1e-9, "penetration": 1.0}
        return replace(found, certificate=replace(found.certificate, **wrong))

    monkeypatch.setattr(module, "_solve_round", another_round)
    monkeypatch.setattr(module, "certified", rough)
    if fails == "loses its joints":
        monkeypatch.setattr(module, "_other_contacts", lambda *_: np.zeros(0, dtype=int) if seen else None)
    found = find_equilibrium(problem, model.initial.positions)
    assert found.certificate.equilibrium == 1e-7


def test_a_light_block_does_not_let_a_state_stand_on_fewer_joints(monkeypatch):
    """0.025 g of the mean block were allowed where one block weighed a thousandth of it."""
    model = on_base(STONE, (-1.0, -1.0, 3.0), (0.0, 0.0, 1.0, 1.0), (2.0, 0.0, 2.02, 0.02))
    state = replace(model.initial, carrying=np.ones(len(model.contacts), dtype=bool))
    found = {0.02: False, 1e-5: True}
    for acceleration, stands in found.items():
        monkeypatch.setattr(
            rests,
            "least_acceleration",
            lambda program, _, a=acceleration: (a, np.zeros((len(program.law), 3))),
        )
        if stands:
            check_self_weight(model, state)
        else:
            with pytest.raises(UnstableError):
                check_self_weight(model, state)
