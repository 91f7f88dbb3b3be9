"""Return period of a capacity, within and beyond the hazard, by hand."""

import numpy as np
import pytest

from assessment.ntc.hazard import HazardCurve, capacity_return_period, stated

VALUES = np.column_stack([np.geomspace(0.05, 0.5, 9), np.linspace(2.4, 2.5, 9), np.linspace(0.27, 0.35, 9)])
CURVE = HazardCurve("hand-made", VALUES, VALUES[None], np.zeros(1))


def test_law_by_hand():
    """T_R,D = 475 years, PGA_C/PGA_D = 0.5: 0.5^(1/0.41) = exp(−0.693147/0.41) = exp(−1.690603) = 0.184408.

    T_R,C = 475·0.184408 = 87.594 years; without a curve nothing bounds it: ratio 2 gives 475/0.184408 = 2575.8 years.
    """
    found = capacity_return_period(0.1, 0.15, 0.30, 475.0, None)
    assert found.result == pytest.approx(87.594, rel=1e-5)
    beyond = capacity_return_period(0.4, 0.60, 0.30, 475.0, None)
    assert beyond.result == pytest.approx(2575.8, rel=1e-5)
    assert (stated(beyond.result), stated(found.result)) == ("> 2475", None)
    assert capacity_return_period(0.1, 0.15, 0.30, None, None) is None


def test_the_curve_counts_within_its_bounds():
    """Between the nine return periods the curve; a_g = 0.6 g lies above its 0.5 g, 0.04 g below its 0.05 g.

    Above: T_R,D = 975, ratio 2: 975/0.184408 = 5287.2 years; T_R,D = 475, ratio 1.1: 599 years is back inside: 2475.
    Below: T_R,D = 50, ratio 0.5: 9.2204 years; ratio 0.9: 38.7 is back inside: 30.
    """
    assert capacity_return_period(0.2, 0.2, 0.1, 475.0, CURVE).result == CURVE.return_period(0.2)
    assert capacity_return_period(0.6, 0.6, 0.3, 975.0, CURVE).result == pytest.approx(5287.2, rel=1e-5)
    assert capacity_return_period(0.6, 0.33, 0.3, 475.0, CURVE).result == 2475.0
    below = capacity_return_period(0.04, 0.04, 0.08, 50.0, CURVE).result
    assert (below, stated(below)) == (pytest.approx(9.2204, rel=1e-5), "< 30")
    assert capacity_return_period(0.04, 0.045, 0.05, 50.0, CURVE).result == 30.0
    assert capacity_return_period(0.6, 0.6, 0.3, None, CURVE).result == 2475.0
