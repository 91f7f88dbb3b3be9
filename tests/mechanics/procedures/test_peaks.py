"""α0 of a settled state lies where an open joint closes, wherever the steps of its curve end."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import limit_analysis, pushdown, pushover
from mechanics.procedures import limit_in, static_theorem
from mechanics.procedures.peaks import may_peak
from mechanics.procedures.pushover import PUSHOVER
from tests.support.drawn_projects import drawn, tables

CROWN = tables("arch_campaign")["control"][0]["point_m"]


def spread(movement):
    """Return the arch of the campaign at rest, its right support moved out (m)."""
    model = drawn("arch_campaign")
    return model, pushdown(model, "destro", (movement, 0.0), increment=0.003).final


def test_alpha_0_falls_as_the_movement_grows_and_is_that_of_the_mirror_image():
    """By steps of 3 mm it was 0.220, 0.221, 0.222, 0.223, 0.209 from 24 to 48 mm: where the step ended.

    The arch as drawn is its own mirror image, and so are the two states that it may settle into; a push towards +x
    takes it from one to the other, or the other way.
    """
    found = []
    for movement in (0.018, 0.030, 0.042):
        model, state = spread(movement)
        own, image = (pushover(model, CROWN, side, increment=0.003, state=state) for side in ("+x", "-x"))
        assert len(own.crossed) != len(image.crossed) and own.multiplier.max() == pytest.approx(
            image.multiplier.max(), rel=2.0 * PUSHOVER.closing
        )
        found.append(own.multiplier.max())
    assert limit_analysis(drawn("arch_campaign")).alpha > found[0]
    np.testing.assert_allclose(np.diff(found), np.mean(np.diff(found)), rtol=0.1)
    assert found[-1] < found[0]


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_the_point_added_is_an_equilibrium_and_two_programs_find_its_multiplier(direction):
    model, state = spread(0.03)
    curve = pushover(model, CROWN, direction, increment=0.003, state=state)
    at, alpha = curve.states[curve.peak], curve.multiplier[curve.peak]
    assert curve.formed == curve.peak > 0
    assert limit_in(model, direction, at).alpha == pytest.approx(alpha, rel=1e-6)
    assert static_theorem(model, direction, at) == pytest.approx(alpha, rel=1e-6)
    assert curve.certificates[curve.peak].equilibrium < 1e-8
    assert curve.steps[curve.peak - 1].state is at
    moved = curve.displacement - curve.displacement[curve.peak]
    assert 0.0 < moved[curve.peak + 1] < 0.003 and (np.diff(curve.displacement) > 0.0).all()
    assert len({len(curve.states), len(curve.steps) + 1, len(curve.certificates), len(curve.multiplier)}) == 1


def test_alpha_may_be_largest_where_the_fall_behind_a_point_carried_back_exceeds_all_points():
    """1 mm behind the point at 2 mm α has fallen by 0.01: it may have been 0.22 in the 2 mm before."""
    displacement = np.array([0.0, 2.0, 3.0, 4.0])
    assert may_peak(np.array([0.1, 0.2, 0.19, 0.18]), displacement, 1e-3) == [(pytest.approx(0.22), 1)]
    assert may_peak(np.array([0.21, 0.2, 0.19, 0.18]), displacement, 1e-3) == [(pytest.approx(0.22), 1)]
    assert may_peak(np.array([0.1, 0.11, 0.12, 0.2]), displacement, 1e-3) == [(pytest.approx(0.2), 3)]
    assert may_peak(np.array([0.25, 0.2, 0.19, 0.18]), displacement, 1e-3) == []
    assert may_peak(np.array([0.1, 0.1005, 0.1002, 0.0999]), displacement, 1e-3) == []
