"""The elastic curve found twice: under a growing multiplier and under a growing work of the loads."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import load_control, pushdown, pushover
from tests.structures import arch_on_piers, block_on_base

BLOCK = (lambda: block_on_base(segments=4), (0.2, 1.0), 0.01)
ARCH = (
    lambda: arch_on_piers(stiffness=1e6, segments=1, friction=2.0),
    (0.85, 0.8),
    0.01,
)  # no sliding, no path dependence


@pytest.mark.parametrize(("make", "control", "increment"), [BLOCK, ARCH])
def test_load_control_ends_at_the_peak_that_work_control_passes_through(make, control, increment):
    model = make()
    peak = pushover(model, control, contacts="elastic", increment=0.0005).multiplier.max()
    path = load_control(model, control, increment=increment)
    assert path.bracket <= increment / 32
    # the points of work control lie beside the very peak, by less than a hundredth of it
    assert path.multiplier[-1] <= 1.01 * peak
    assert path.multiplier[-1] + path.bracket >= 0.99 * peak


@pytest.mark.parametrize(("make", "control", "increment"), [BLOCK, ARCH])
def test_both_rising_branches_are_the_same_curve(make, control, increment):
    model = make()
    work = pushover(model, control, contacts="elastic", increment=0.0005)
    load = load_control(model, control, increment=0.2 * increment)
    checked = work.multiplier[: work.peak] < 0.75 * work.multiplier.max()
    assert checked.sum() >= 4
    at, expected = work.multiplier[: work.peak][checked], work.displacement[: work.peak][checked]
    found = np.interp(at, load.multiplier, load.displacement)
    np.testing.assert_allclose(found, expected, atol=0.005 * expected.max())


def test_a_settled_state_is_taken_up():
    model = arch_on_piers(stiffness=1e6)
    moved = pushdown(model, "right", (0.01, -0.01), increment=0.002, contacts="elastic")
    before = load_control(model, (0.85, 0.8), increment=0.01).multiplier[-1]
    after = load_control(model, (0.85, 0.8), increment=0.01, state=moved.final).multiplier[-1]
    assert 0.0 < after < before
