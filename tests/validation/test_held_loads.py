"""A settled state whose multiplier falls and rises again: a block that leans on a wall, and loads that are held.

A block b × h leans on a wall at a distance g at φ = arcsin(g/h), past its balance β = arctan(b/h). Pushed off the wall
it turns about one corner: α = tan(φ − β) at first, and 0 at the balance, where it falls back on its foot. There a push
needs b/h; but what falls there under a held load rocks on over the other corner (Housner 1963).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from mechanics import Assembly, Block, Following, Material, pushover, time_history
from tests.support.structures import rectangle

B, H, GAP = 0.30, 1.20, 0.36
BALANCE = math.atan(B / H)


@pytest.fixture(scope="module")
def leaning():
    """The block, its state after its foot has tilted until it fell against the wall, and gone back, and its lean."""
    stone, smooth = Material(20.0, 0.9), Material(20.0, 0.3)
    model = Assembly(
        [
            Block(rectangle(-0.5, -0.3, B + GAP, 0.0), 1.0, stone, support="foot"),
            Block(rectangle(B + GAP, -0.3, B + GAP + 0.4, 2.0), 1.0, smooth, support="wall"),
            Block(rectangle(0.0, 0.0, B, H), 1.0, stone),
        ]
    )
    follow = Following(model, support="foot")
    follow.to((0.0, 0.0), rotation=-0.26)
    state = follow.to((0.0, 0.0), rotation=0.0)
    lean = -float(state.positions[2, 2])
    assert lean == pytest.approx(math.asin(GAP / H), rel=1e-3)  # its foot may have slid a little
    return model, state, lean


def test_a_curve_ends_where_it_falls_under_the_load_that_moved_it(leaning):
    model, state, lean = leaning
    curve = pushover(model, (0.0, H), "-x", increment=0.01, state=state)
    assert curve.alpha_0 == pytest.approx(math.tan(lean - BALANCE), rel=1e-4)
    way = B * (math.cos(BALANCE) - math.cos(lean)) + H * (math.sin(lean) - math.sin(BALANCE))
    assert curve.displacement[-1] == pytest.approx(way, rel=1e-4)
    assert curve.reached_zero


@pytest.mark.parametrize(("share", "falls"), [(0.9, False), (1.1, True)])
def test_a_motion_under_a_load_that_is_held_agrees(leaning, share, falls):
    model, state, lean = leaning
    time = np.arange(0.0, 9.0, 0.005)
    load = share * math.tan(lean - BALANCE) * np.clip(time / 6.0, 0.0, 1.0)
    assert time_history(model, load, 0.005, contacts="rigid", state=state).collapsed is falls
