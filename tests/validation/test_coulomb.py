"""Friction that does not dilate: a wedge between two supports, walls of Ferris and Tin-Loi (2001)."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover
from tests.support.structures import block_on_base, running_bond

SLOPE = np.radians(20.0)  # of the wedge's faces from vertical


def wedge(friction: float) -> Assembly:
    """A voussoir, 1 m wide at the foot, between two supports."""
    stone, out = Material(20.0, friction), 0.4 * np.tan(SLOPE)
    return Assembly(
        [
            Block([[-0.5, 0.0], [0.5, 0.0], [0.5 + out, 0.4], [-0.5 - out, 0.4]], 1.0, stone),
            Block([[-1.5, 0.0], [-0.5, 0.0], [-0.5 - out, 0.4], [-1.5, 0.4]], 1.0, stone, support="left"),
            Block([[0.5, 0.0], [1.5, 0.0], [1.5, 0.4], [0.5 + out, 0.4]], 1.0, stone, support="right"),
        ]
    )


@pytest.mark.parametrize("increment", [0.001, 0.005])
@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_wedge_goes_down_along_its_faces(friction: float, increment: float) -> None:
    """dz = −δ/(2 tan φ), H/W = (cos φ − μ sin φ)/(2 (sin φ + μ cos φ))."""
    model = wedge(friction)
    path = pushdown(model, "right", (0.02, 0.0), increment=increment, sliding="coulomb")
    down = path.states[-1].positions[0, 1] - model.initial.positions[0, 1]
    assert down == pytest.approx(-0.02 / (2.0 * np.tan(SLOPE)), rel=3e-4)
    sin, cos = np.sin(SLOPE), np.cos(SLOPE)
    thrust = (cos - friction * sin) / (2.0 * (sin + friction * cos))
    assert abs(path.reaction[-1, 0]) / model.weight == pytest.approx(thrust, rel=1e-6)


def test_the_wall_of_ferris_and_tin_loi_without_dilation() -> None:
    """Wall 1: 0.64286 associative, 0.63982 without; the multiplier is not unique."""
    assert limit_analysis(running_bond()).alpha == pytest.approx(0.64286, abs=1e-5)
    assert limit_analysis(running_bond(), sliding="coulomb").alpha == pytest.approx(0.63982, rel=5e-4)


def test_where_nothing_slides_both_laws_agree() -> None:
    block = block_on_base()
    one, other = (limit_analysis(block, sliding=sliding).alpha for sliding in ("associative", "coulomb"))
    assert one == pytest.approx(other, rel=1e-12)


def test_a_curve_begins_at_the_multiplier_of_its_own_law() -> None:
    wall = running_bond(2, 5)
    curve = pushover(wall, (0.4, 0.875), "+x", "rigid", 0.002, sliding="coulomb", until=0.9)
    assert curve.multiplier[0] == pytest.approx(limit_analysis(wall, sliding="coulomb").alpha, rel=1e-9)
