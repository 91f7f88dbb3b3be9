"""Limit analysis by a linear program written apart: closed forms, and the multipliers of limit_analysis."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import ArgumentError, limit_analysis, pushdown, pushover
from mechanics.procedures import limit_in, static_theorem
from mechanics.solvers.lp_point_forces import PointForces
from tests.support.drawn_projects import drawn, tables
from tests.support.structures import arch_on_piers, block_on_base, column, running_bond, semicircular_arch


def test_a_block_rocks_at_b_over_h_or_slides_at_mu():
    """0.2 × 1.0 m: α = min(B/H, μ)."""
    assert static_theorem(block_on_base(friction=0.6)) == pytest.approx(0.2, rel=1e-9)
    assert static_theorem(block_on_base(friction=0.15), "-x") == pytest.approx(0.15, rel=1e-9)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize(
    "model",
    [arch_on_piers(), column(0.5, 1.0, 4, friction=0.3), semicircular_arch(15, 0.2), running_bond()],
    ids=["turns", "slides", "arch", "wall"],
)
def test_as_drawn_it_is_the_multiplier_of_limit_analysis(model, direction):
    assert static_theorem(model, direction) == pytest.approx(
        limit_analysis(model, direction, sliding="associative").alpha, rel=1e-8
    )


def test_in_a_settled_state_whose_hinges_have_opened():
    model = arch_on_piers()
    state = pushdown(model, "right", (0.02, -0.02), increment=0.002).final
    expected = limit_in(model, "-x", state).alpha
    assert expected < 0.95 * limit_analysis(model, "-x").alpha  # the settlement counts
    assert static_theorem(model, "-x", state) == pytest.approx(expected, rel=1e-6)


def test_where_sliding_has_lifted_blocks_the_forces_act_at_the_corners_that_touch():
    """The tuff panel, whose joints slide in the settlement and lift by it; midway of the gaps α is 5e-5 off."""
    model, movement = drawn("tuff_panel"), tables("tuff_panel")["settlements"][0]
    moved = pushdown(
        model,
        movement["support"],
        movement["displacement_m"],
        increment=movement["increment_m"],
        sliding="associative",
    )
    control = tables("tuff_panel")["control"][0]["point_m"]
    path = pushover(model, control, "+x", "rigid", 0.002, moved.final, 0.95, sliding="associative")
    at = path.states[path.peak]
    expected = limit_in(model, "+x", at, "associative").alpha
    assert path.peak > 0 and static_theorem(model, "+x", at) == pytest.approx(expected, rel=1e-6)
    assert path.multiplier[path.peak] == pytest.approx(expected, rel=2e-3)  # docs/accuracy.md


def test_joints_that_crush_make_no_linear_program():
    with pytest.raises(ArgumentError, match="crush"):
        static_theorem(column(0.5, 1.0, 2, strength=100.0))


def test_every_force_acts_on_both_blocks_and_balances():
    """Unit forces at (1, 2) m along the normal (0, 1) and the tangent (1, 0) on a block centred at (0.5, 1.5)."""
    points = PointForces(
        a=np.array([1]),
        b=np.array([0]),
        normal=np.array([[0.0, 1.0]]),
        friction=np.array([0.5]),
        joint=np.array([0]),
        pressure_at=np.array([[1.0, 2.0]]),
        friction_at=np.array([[1.0, 2.0]]),
        most=np.array([np.inf]),
    )
    centroids = np.array([[0.0, 0.0], [0.5, 1.5]])
    matrix = points.equilibrium(centroids, np.array([True, True]), 1.0).toarray()
    on_a, on_b = matrix[3:], matrix[:3]
    assert on_a.T.tolist() == [[0.0, 1.0, 0.5], [1.0, 0.0, -0.5]]
    assert on_b[:2] == pytest.approx(-on_a[:2])
    assert on_b[2].tolist() == [-1.0, 2.0]
