"""A settled state whose multiplier falls and rises again: a block that leans on a wall, and loads that are held.

A block b × h leans on a wall at a distance g at φ = arcsin(g/h), past its balance β = arctan(b/h). Pushed off the wall
it turns about one corner: α = tan(φ − β) at first, and 0 at the balance, where it falls back on its foot. There a push
needs b/h; but what falls there under a held load rocks on over the other corner (Housner 1963).
"""

import math

import numpy as np
import pytest

from mechanics import pushover, time_history
from tests.support.leaning_block import GAP, B, H, leaning

BALANCE = math.atan(B / H)


@pytest.fixture(scope="module")
def settled():
    """The block, its state against the wall, and its lean."""
    model, state = leaning(0.9, 0.3, -GAP)
    lean = -float(state.positions[2, 2])
    assert lean == pytest.approx(math.asin(GAP / H), rel=1e-3)  # its foot may have slid a little
    return model, state, lean


def test_a_curve_ends_where_it_falls_under_the_load_that_moved_it(settled):
    model, state, lean = settled
    curve = pushover(model, (0.0, H), "-x", increment=0.01, state=state)
    assert curve.alpha_0 == pytest.approx(math.tan(lean - BALANCE), rel=1e-4)
    way = B * (math.cos(BALANCE) - math.cos(lean)) + H * (math.sin(lean) - math.sin(BALANCE))
    assert curve.displacement[-1] == pytest.approx(way, rel=1e-4)
    assert curve.reached_zero


@pytest.mark.parametrize(("share", "falls"), [(0.9, False), (1.1, True)])
def test_a_motion_under_a_load_that_is_held_agrees(settled, share, falls):
    model, state, lean = settled
    time = np.arange(0.0, 9.0, 0.005)
    load = share * math.tan(lean - BALANCE) * np.clip(time / 6.0, 0.0, 1.0)
    assert time_history(model, load, 0.005, contacts="rigid", state=state).collapsed is falls
