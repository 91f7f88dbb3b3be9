"""A curve ends where α is zero, where nothing holds it, or where it leans; no multiplier is overwritten."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, pushover, time_history
from tests.support.random_masonry import random_masonry
from tests.support.structures import rectangle

SLENDER = 0.5 / 3.0  # width over height


def beside(height: float, friction: float = 0.6) -> Assembly:
    """A wall 0.5 m wide and 3 m high, 0.10 m from a support of some height."""
    stone = Material(20.0, friction, 1e6)
    return Assembly(
        [
            Block(rectangle(-2.0, -0.3, 2.0, 0.0), 1.0, stone, support="ground"),
            Block(rectangle(0.0, 0.0, 0.5, 3.0), 1.0, stone),
            Block(rectangle(0.6, 0.0, 1.0, height), 1.0, stone, support="neighbour"),
        ]
    )


@pytest.mark.parametrize("seed", (6, 9))
def test_a_curve_that_ends_at_zero_is_at_zero(seed):
    """Where it says α = 0 the last multiplier is, to 1e-6 of the peak, whatever the increment."""
    model = random_masonry(seed)
    for increment in (0.012, 0.005):
        curve = pushover(model, increment=increment)
        last = curve.multiplier[-1]
        assert curve.reached_zero == (abs(last) <= 1e-6 * curve.multiplier.max()), str(curve.end)


@pytest.mark.parametrize("friction", [0.6, np.inf])
def test_wall_beside_support(friction):
    """They can touch at θ = 1/3 only: α0 = b/h, and the wall is spent when its centre stands above its edge."""
    curve = pushover(beside(0.3, friction), increment=0.01)
    assert curve.multiplier[0] == pytest.approx(SLENDER, rel=1e-9)
    assert curve.displacement[-1] == pytest.approx(3.0 * np.sin(np.arctan(SLENDER)), rel=1e-6)
    assert curve.reached_zero


def test_a_motion_passes_a_low_neighbour_that_it_does_not_meet():
    """Until they can touch, at tan θ = 1/3, it is that of the wall alone; friction of an open joint held it before."""
    motions = []
    for blocks in (beside(0.3, np.inf).blocks, beside(0.3, np.inf).blocks[:2]):
        model = Assembly(blocks)
        tilted = model.rotated(1, (0.5, 0.0), -0.9 * np.arctan(SLENDER))
        motions.append(time_history(model, np.full(401, -0.1), 0.0025, "rigid", tilted, control=(0.5, 3.0)))
    met, alone = motions
    turned = -met.positions[:, 1, 2]
    free = turned < np.arctan(0.1 / 0.3) - 0.005
    assert turned[free].max() > np.arctan(SLENDER) and not free.all()
    assert met.displacement[free] == pytest.approx(alone.displacement[free], abs=1e-6)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize("sliding", ["coulomb", "associative"])
def test_a_wall_that_leans_on_a_neighbour_rests(contacts, sliding):
    """What the push presses on a support has no largest multiplier: the curve ends by that name, before it rises."""
    curve = pushover(beside(2.0), increment=0.01, contacts=contacts, sliding=sliding)
    assert "leans" in str(curve.end)
    assert not curve.lost
    assert not curve.reached_zero
    assert curve.multiplier.max() <= SLENDER * (1.0 + 1e-9)
    # touched at 0.10 m of the height of 2 m: 0.15 m at the top
    assert curve.displacement[-1] == pytest.approx(0.15, abs=0.0101)
