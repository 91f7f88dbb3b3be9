"""Whether gravity is carried where the forces that carry it have no interior: decided by a linear program."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Assembly, Block, Material
from mechanics.errors import UnstableError
from mechanics.steps.equilibrium import check_self_weight
from tests.support.structures import rectangle, running_bond


def on_a_slope(angle: float, friction: float) -> Assembly:
    """A block on a support whose face rises by an angle (rad)."""
    stone = Material(20.0, friction)
    c, s = np.cos(angle), np.sin(angle)

    def turned(x0: float, z0: float, x1: float, z1: float) -> np.ndarray:
        return np.array(rectangle(x0, z0, x1, z1)) @ np.array([[c, s], [-s, c]])

    return Assembly(
        [
            Block(turned(-1.0, -0.2, 2.0, 0.0), 1.0, stone, support="base"),
            Block(turned(0.0, 0.0, 1.0, 0.5), 1.0, stone),
        ]
    )


@pytest.mark.parametrize("friction", [0.0, 1e-6])
def test_a_wall_with_next_to_no_friction_stands(friction: float) -> None:
    """Vertical forces carry it, at the bounds of friction."""
    check_self_weight(running_bond(3, 4, friction=friction))


@pytest.mark.parametrize("angle", [3e-6, 1e-4])
def test_a_block_slides_off_a_slope_that_is_steeper_than_its_friction(angle: float) -> None:
    """Without friction by g sin θ, of which next to nothing is taken for none."""
    with pytest.raises(UnstableError, match=f"start to move with {angle:.2g} g"):
        check_self_weight(on_a_slope(angle, 0.0))
    check_self_weight(on_a_slope(angle, 1.001 * angle))
