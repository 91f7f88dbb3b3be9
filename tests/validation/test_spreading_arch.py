"""A semicircular arch of 26 voussoirs whose supports part: the spread at which it falls.

Values computed independently: ultimate spread 0.0354, 0.1134 and 0.2962 at t/R = 0.12, 0.15 and 0.20, of the mean
radius, friction 0.7.
"""

import pytest

from mechanics import pushdown
from tests.support.structures import semicircular_arch


@pytest.mark.parametrize(("thickness", "expected"), [(0.12, 0.0354), (0.15, 0.1134), (0.20, 0.2962)])
def test_ultimate_spread(thickness, expected):
    model = semicircular_arch(26, thickness, friction=0.7)
    path = pushdown(model, "right", (0.001, 0.0), increment=0.004, to_collapse=True)
    assert path.ultimate == pytest.approx(expected, abs=3e-4)
