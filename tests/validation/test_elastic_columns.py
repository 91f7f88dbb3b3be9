"""Columns on exact elastic beds: the largest multiplier.

Values of an independent code, in closed form over one no-tension bed a joint:
b × h in m, unit weight 20 kN/m³, k in kN/m³; they do not depend on friction while nothing slides.
"""

import numpy as np
import pytest

from mechanics import pushover
from tests.support.structures import column

COLUMNS = [
    (0.5, 3.0, 1, 2e4, 0.06671),
    (0.5, 3.0, 1, 2e5, 0.12026),
    (0.5, 3.0, 6, 1e5, 0.10145),
    (0.5, 3.0, 6, 1e6, 0.1383),
]


@pytest.mark.parametrize(("width", "height", "blocks", "stiffness", "expected"), COLUMNS)
@pytest.mark.parametrize("friction", [0.6, np.inf])
def test_largest_multiplier(width, height, blocks, stiffness, expected, friction):
    model = column(width, height, blocks, stiffness, friction)
    curve = pushover(model, (width, height), contacts="elastic", increment=0.005, until=0.9)
    assert curve.multiplier.max() == pytest.approx(expected, rel=0.003)


@pytest.mark.parametrize("segments", [1, 4, 16])
def test_points_are_too_strong_by_less_the_more_there_are(segments):
    """One segment on a soft joint: 2.3 times; the paper's beds are the same element with springs at points."""
    model = column(0.5, 3.0, 1, 2e4, segments=segments)
    curve = pushover(model, (0.5, 3.0), contacts="elastic", increment=0.005, until=0.9)
    over = curve.multiplier.max() / 0.06671 - 1.0
    assert {1: 1.0, 4: 0.05, 16: 0.0}[segments] < over < {1: 1.6, 4: 0.6, 16: 0.06}[segments]
