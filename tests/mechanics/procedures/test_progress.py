"""What procedures tell of how far they are: shares that grow to 1, before they are finished."""

from itertools import pairwise

import numpy as np
import pytest

from mechanics import pushdown, pushover, time_history
from mechanics.procedures.motion_start import HISTORY
from mechanics.progress import listening
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


@pytest.mark.parametrize(("contacts", "until"), [("rigid", 0.0), ("rigid", 0.5), ("elastic", 0.0)])
def test_a_pushover_tells_how_far_the_multiplier_has_come_down(contacts, until):
    """The curve of a block that rocks is nearly a line: equal steps are nearly equal shares."""
    found = told(lambda model: pushover(model, (0.5, 2.0), "+x", contacts, 0.05, until=until))
    assert len(found) >= 5 and found[-1] == pytest.approx(1.0, abs=0.15)
    assert all(one <= other for one, other in pairwise(found))
    if contacts == "rigid":
        assert np.diff(found[:-1]) == pytest.approx(found[0], rel=0.05)
