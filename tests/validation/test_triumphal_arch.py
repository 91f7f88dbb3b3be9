"""The triumphal arch of Portioli et al., §7, its geometry assumed: what was not fitted, as drawn, against Table 1.

The template's dimensions were searched for so that α0 = 0.074 and d_0 = 380 mm come out; e* and Γ* of the mechanism at
α0 were left free. The paper prints 0.75 and 0.66.
"""

import pytest

from assessment.ntc.capacity.curve import mechanism_participation
from mechanics import limit_analysis
from tests.support.drawn_projects import drawn, tables


def participation():
    """e* and Γ* of the mechanism at α0, as drawn, towards +x."""
    model, found = drawn("triumphal_arch"), limit_analysis(drawn("triumphal_arch"))
    point = next(p["point_m"] for p in tables("triumphal_arch")["control"] if p["name"] == "C1")
    block = model.block_at(point)
    u, _, turned = found.mechanism[block]
    control_dx = u - turned * (point[1] - model.blocks[block].centroid[1])
    shares = mechanism_participation(model, found.mechanism, control_dx)
    return shares.e_star, shares.gamma_star


def test_participation_is_near_the_papers():
    e_star, gamma_star = participation()
    assert e_star == pytest.approx(0.75, rel=0.02)
    assert gamma_star == pytest.approx(0.66, rel=0.02)


def test_the_onset_is_the_one_that_was_fitted():
    assert limit_analysis(drawn("triumphal_arch")).alpha == pytest.approx(0.074, abs=0.0005)
