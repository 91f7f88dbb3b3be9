"""A settled state whose multiplier falls and rises again: a block that leans on a wall, and loads that are held.

A block b × h leans on a wall at a distance g at φ = arcsin(g/h), past its balance β = arctan(b/h). Pushed off the wall
it turns about one corner: α = tan(φ − β) at first, and 0 at the balance, where it falls back on its foot. There a push
needs b/h; but what falls there under a held load rocks on over the other corner (Housner 1963).
"""

import math

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, pushdown, pushover, time_history
from tests.support.leaning_block import GAP, B, H, leaning
from tests.support.structures import rectangle

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


@pytest.fixture(scope="module")
def portal():
    """Two piers of four blocks and a lintel, its right support let down by 0.45 of what it bears, and its curve."""
    stone, piers = Material(20.0, 0.65), (0.0, 2.5)
    feet = [Block(rectangle(x, -0.5, x + 0.5, 0.0), 1.0, stone, support=f"{x:g}") for x in piers]
    shafts = [
        Block(rectangle(x, 0.5 * k, x + 0.5, 0.5 * k + 0.5), 1.0, stone) for x in piers for k in range(4)
    ]
    model = Assembly([*feet, *shafts, Block(rectangle(0.0, 2.0, 3.0, 2.5), 1.0, stone)])
    state = pushdown(model, "2.5", (0.0, -0.2025), increment=0.01).final
    return model, pushover(model, direction="+x", state=state, increment=0.01)


def test_a_curve_that_rises_behind_a_trough_goes_on_and_its_first_peak_counts(portal):
    """It ended in the trough, at a tenth of the displacement from which it comes back when it is let go."""
    _, curve = portal
    trough = curve.multiplier[curve.peak : int(curve.multiplier.argmax())].min()
    assert trough < 0.9 * curve.alpha_0 < 0.9 * 0.7 * curve.multiplier.max()
    assert curve.reached_zero
    assert curve.displacement[-1] > 20.0 * curve.displacement[curve.peak]


@pytest.mark.parametrize(("share", "falls"), [(0.97, False), (1.03, True)])
def test_the_first_peak_is_what_the_portal_bears_held(portal, share, falls):
    """The base is accelerated to the left: what stands on it is pushed to the right."""
    model, curve = portal
    load = -share * curve.alpha_0 * np.clip(np.arange(0.0, 12.0, 0.005) / 6.0, 0.0, 1.0)
    motion = time_history(model, load, 0.005, contacts="rigid", state=curve.states[0])
    assert motion.collapsed is falls


def test_what_is_pushed_beyond_the_trough_comes_back_when_it_is_let_go(portal):
    model, curve = portal
    far = int(np.searchsorted(curve.displacement, 0.9 * curve.displacement[-1]))
    motion = time_history(model, np.zeros(400), 0.005, contacts="rigid", state=curve.states[far])
    assert not motion.collapsed
