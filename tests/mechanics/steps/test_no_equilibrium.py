"""A step whose loads no joint forces balance has no equilibrium, and none is found."""

import numpy as np
import pytest

from assessment.benchmark.structures import rectangle
from mechanics import Assembly, Block, ConvergenceError, Material, NoEquilibriumError
from mechanics.solvers import imbalance
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from tests.support.steps import posed

FRICTION = 0.3


def on_an_incline(angle, contacts):
    """A step of a block on a plane inclined by an angle, rad."""
    stone = Material(18.0, FRICTION, 1e6)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, sin], [-sin, cos]])
    plane = Block(np.array(rectangle(-1.0, -0.2, 1.0, 0.0)) @ turn, 1.0, stone, support="plane")
    block = Block(np.array(rectangle(-0.2, 0.0, 0.2, 0.3)) @ turn, 1.0, stone)
    model = Assembly([plane, block])
    return StepProblem(static_system(model, contacts), model.initial, model.dead_load, 1e-4)


@pytest.mark.parametrize(("contacts", "steeper"), [("rigid", 0.01), ("rigid", 0.2), ("elastic", 0.2)])
def test_a_block_on_a_plane_steeper_than_friction_would_start_to_move(contacts, steeper):
    """Gauss's principle: along the edge of the cone of friction, with (sin θ − μ cos θ)/√(1 + μ²) of gravity."""
    angle = np.arctan(FRICTION) + steeper
    along = (np.sin(angle) - FRICTION * np.cos(angle)) / np.hypot(1.0, FRICTION)
    steepest = along * np.cos(angle - np.arctan(FRICTION))  # its larger component, x
    problem = on_an_incline(angle, contacts)
    assert imbalance(*posed(problem)) == pytest.approx(steepest, rel=1e-3)
    with pytest.raises((NoEquilibriumError, ConvergenceError)):
        find_equilibrium(problem, problem.start.positions)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_on_a_plane_less_steep_it_stands(contacts):
    problem = on_an_incline(np.arctan(FRICTION) - 0.01, contacts)
    assert find_equilibrium(problem, problem.start.positions).certificate.equilibrium < 1e-6
