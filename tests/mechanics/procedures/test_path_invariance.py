"""Why a capacity curve ends, and where, does not depend on units, origin or weight."""

from __future__ import annotations

import re

import pytest

from mechanics import Assembly, pushover
from tests.support.structures import in_frame, running_bond

FRAME = (1000.0, (137.3, -41.9), 37.0)  # length, origin (m), weight
TURNING = {  # columns, courses, length and height of a brick (m), friction
    "low": (3, 3, 0.40, 0.175, 3.16),
    "falls before α = 0": (2, 5, 0.28, 0.16, 0.9),
}
SLIDING = {
    "rocks in the end": (2, 4, 0.29, 0.129, 0.869),
    "slides on its base": (3, 3, 0.531, 0.182, 0.63),
}


def ended(model: Assembly, length: float, sliding: str) -> tuple[str, bool, bool, float]:
    """The reason for the end of a curve without its numbers, whether that is a collapse, and where, per length."""
    curve = pushover(model, model.blocks[-1].centroid, "+x", "rigid", 0.1 * model.size, sliding=sliding)
    reason = re.sub(r"\d[\d.e+-]*", "#", re.sub(r"\(.*\)", "", curve.end))
    return reason, curve.reached_zero, curve.lost, curve.displacement[-1] / length


@pytest.mark.parametrize("name", TURNING)
def test_walls_that_only_turn_end_at_the_same_displacement(name):
    wall = running_bond(*TURNING[name])
    expected = ended(wall, 1.0, "associative")
    found = ended(in_frame(wall, *FRAME), FRAME[0], "associative")
    assert found[:3] == expected[:3]
    assert found[3] == pytest.approx(expected[3], rel=1e-6)


@pytest.mark.parametrize(("name", "sliding"), list(zip(SLIDING, ("coulomb", "associative"), strict=True)))
def test_walls_that_slide_end_for_the_same_reason(name, sliding):
    wall = running_bond(*SLIDING[name])
    expected = ended(wall, 1.0, sliding)
    assert ended(in_frame(wall, *FRAME), FRAME[0], sliding)[:3] == expected[:3]
