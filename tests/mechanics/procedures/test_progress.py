"""What procedures tell of how far they are: shares that grow to 1, before they are finished."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mechanics import pushdown, pushover, time_history
from mechanics.procedures.time_history import HISTORY
from mechanics.progress import listening, stretch, tell
from tests.support.structures import column

STEP = 0.005


def told(procedure):
    """Return what a procedure tells."""
    found: list[float] = []
    with listening(found.append):
        procedure(column(0.5, 2.0, 1, 1e6))
    return found


def test_a_time_history_tells_the_share_of_its_record():
    wave = 0.05 * np.sin(2.0 * np.pi * STEP * np.arange(5 * HISTORY.chunk + 1))
    assert told(lambda model: time_history(model, wave, STEP)) == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])


def test_a_pushdown_tells_the_share_of_its_movement():
    found = told(lambda model: pushdown(model, "base", (0.0, -0.04), increment=0.01))
    assert found == pytest.approx([0.25, 0.5, 0.75, 1.0])


def test_a_pushdown_up_to_collapse_tells_that_as_much_again_is_to_come():
    """How far collapse is is what is sought."""
    found = told(lambda model: pushdown(model, "base", rotation=0.01, increment=0.005, to_collapse=True))
    assert 0.0 < found[0] < 0.5 and len(found) > 5
    assert found[1:] == [0.5] * (len(found) - 1)


@pytest.mark.parametrize(("contacts", "until"), [("rigid", 0.0), ("rigid", 0.5), ("elastic", 0.0)])
def test_a_pushover_tells_how_far_the_multiplier_has_come_down(contacts, until):
    """The curve of a block that rocks is nearly a line: equal steps are nearly equal shares."""
    found = told(lambda model: pushover(model, (0.5, 2.0), "+x", contacts, 0.05, until=until))
    assert len(found) >= 5 and found[-1] == pytest.approx(1.0, abs=0.15)
    assert all(one <= other for one, other in pairwise(found))
    if contacts == "rigid":
        assert np.diff(found[:-1]) == pytest.approx(found[0], rel=0.05)


def test_a_pushover_that_rises_tells_so_from_its_first_step_on():
    """It told 0 up to the peak, of which no time left follows."""
    model, found = column(0.5, 2.0, 4, 1e4), []
    with listening(found.append):
        curve = pushover(model, (0.5, 2.0), "+x", "elastic", 0.01)
    assert len(found) == len(curve.multiplier) - 1 and curve.peak > 5
    rise, fall = found[: curve.peak], found[curve.peak :]
    assert all(one < other for one, other in pairwise(rise)) and all(0.05 < share < 0.15 for share in rise)
    assert fall[-1] == pytest.approx(1.0, abs=0.01)


def test_a_part_counts_as_its_stretch_of_the_whole():
    found: list[float] = []
    with listening(found.append):
        tell(0.1)
        with stretch(0.2, 0.6):
            tell(0.5)
            with stretch(0.5, 1.0):
                tell(0.5)
        tell(7.0)
    tell(0.9)
    assert found == pytest.approx([0.1, 0.4, 0.5, 1.0])
