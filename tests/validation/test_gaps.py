"""Two piers side by side with a gap between them: each turns by itself, at b/h, until they meet.

A gap wider than the tolerance of the drawing bears nothing. Piers that do not touch have the multiplier of one, b/h
(less by what the gap takes off one of them); piers in contact have more, and the elastic ones more yet.
"""

import pytest

from mechanics import Assembly, Material, limit_analysis, pushover
from tests.support.structures import on_base

B, H = 0.6, 3.0


def piers(gap: float) -> Assembly:
    """A base and two piers b × h, the second narrower by the gap (m) before it."""
    stone = Material(20.0, 0.6, normal_stiffness=1e6)
    return on_base(stone, (-1.0, -0.4, 2.5), (0.0, 0.0, B, H), (B + gap, 0.0, 2 * B, H))


@pytest.mark.parametrize("tolerances", [1.05, 1.9])
def test_piers_with_a_gap_have_the_multiplier_of_one(tolerances):
    """Gaps up to twice the tolerance were closed: α_0 0.26 for 0.199, and piers that stayed apart pressed."""
    gap = tolerances * piers(0.0).joint_tolerance
    model = piers(gap)
    for direction in ("+x", "-x"):
        narrower = (B - gap) / H
        assert limit_analysis(model, direction).alpha == pytest.approx(narrower, rel=1e-6)
        curve = pushover(model, direction=direction, increment=0.01, until=0.5)
        assert narrower - 1e-6 < curve.alpha_0 < B / H + 1e-6


def test_elastic_piers_with_a_gap_have_the_peak_of_one():
    gap = 1.4 * piers(0.0).joint_tolerance
    alone = Assembly(piers(gap).blocks[:2])
    one, two = (
        pushover(model, (0.0, H), contacts="elastic", increment=0.004, until=0.5).alpha_0
        for model in (alone, piers(gap))
    )
    assert two == pytest.approx(one, rel=0.01)
    assert pushover(piers(0.0), (0.0, H), contacts="elastic", increment=0.004, until=0.5).alpha_0 > 1.3 * one
