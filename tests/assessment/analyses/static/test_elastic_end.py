"""Where the elastic curve limits the displacement capacity."""

import pytest

from assessment.analyses.checks.capacity import _elastic_end
from assessment.results.schema.static import ElasticPush
from tests.support.typed import made


def curve(last: float, lost: bool = False, reached_zero: bool = False):
    points = {"displacement_m": [0.0, -0.01, -0.02], "multiplier": [0.0, 0.1, last]}
    return made(ElasticPush, {"curve": points, "lost": lost, "reached_zero": reached_zero})


@pytest.mark.parametrize(
    ("elastic", "end"),
    [
        (curve(0.02), None),  # cut below a quarter of the peak, on purpose
        (curve(0.02, lost=True), 0.02),
        (curve(0.0, reached_zero=True), 0.02),
        (curve(0.05, lost=True), 0.02),
        (curve(0.05), 0.02),  # undecided: no equilibrium is known beyond it
        (None, None),
    ],
)
def test_an_elastic_curve_limits_where_nothing_is_known_beyond_it(elastic, end):
    assert _elastic_end(elastic) == end
