"""The triumphal arch of Portioli et al., §7, its geometry assumed: what was not fitted against Table 1.

The template's dimensions were searched for so that, as drawn, α0 = 0.074 and d_0 = 380 mm come out; e* and Γ* of the
mechanism at α0 were left free. The paper prints 0.75 and 0.66. Settled nothing was fitted: what comes out is a
prediction for an arch like the paper's, for which the paper prints α0 = 0.067 and d_0 = 313 mm. It is of one member of
the ensemble, in the project's own increments, by the sliding with dilation that is the paper's.
"""

from functools import cache

import pytest

from assessment.ntc.capacity_curve import mechanism_participation
from mechanics import limit_analysis, pushdown, pushover
from tests.support.drawn_projects import drawn, tables


@cache
def onset():
    return limit_analysis(drawn("triumphal_arch"), sliding="associative")


def control():
    """The top outer edge of the right wall, which is pushed towards +x."""
    return next(p["point_m"] for p in tables("triumphal_arch")["control"] if p["name"] == "C1")


@cache
def settled(until: float = 0.0):
    """α0 and d_0 (m) after the movement of the right support, towards +x, rigid joints, down to `until` of the peak."""
    model, (movement,) = drawn("triumphal_arch"), tables("triumphal_arch")["settlements"]
    moved = pushdown(
        model, movement["support"], movement["displacement_m"], increment=movement["increment_m"],
        sliding="associative",
    )  # fmt: skip
    increment = tables("triumphal_arch")["pushover"]["increment_m"]
    curve = pushover(model, control(), "+x", "rigid", increment, moved.final, until, sliding="associative")
    return float(curve.multiplier.max()), float(curve.displacement[-1])


def participation():
    """e* and Γ* of the mechanism at α0, as drawn, towards +x."""
    model, found, point = drawn("triumphal_arch"), onset(), control()
    block = model.block_at(point)
    u, _, turned = found.mechanism[block]
    control_dx = u - turned * (point[1] - model.blocks[block].centroid[1])
    shares = mechanism_participation(model, found.mechanism, control_dx)
    return shares.e_star, shares.gamma_star


def test_the_onset_is_the_one_that_was_fitted():
    assert onset().alpha == pytest.approx(0.074, abs=0.0005)
