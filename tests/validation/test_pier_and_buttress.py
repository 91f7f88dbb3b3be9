"""A pier and a buttress beside it, both seated: a mechanism that the geometry lets begin, and not go on.

Pushed to the buttress both turn by θ about their toes, and their upright faces slide on each other. That is a flow: of
first order no joint but these opens or slides. But the buttress's face then lies w₂(1 − cos θ) within the pier's: the
buttress must slide out on its bed, however little, and friction acts there in full. Closed forms, with N the force
between the faces at a height z, friction μN on both, W the weights, w widths, h heights (1: pier, 2: buttress):

    pier, about its toe       α W₁h₁/2 − W₁w₁/2 − N z = 0
    buttress, about its toe   α W₂h₂/2 − W₂w₂/2 + N z − μN w₂ = 0
    onset                     z = h₂, the bed holds the buttress
    peak                      μ(W₂ + μN) = αW₂ + N, it slides on its bed
"""

import pytest

from mechanics import Assembly, Material, limit_analysis, pushover
from tests.support.contact_dynamics import farthest
from tests.support.structures import on_base

# w₁, h₁, w₂, h₂, μ
SHAPES = [(0.5, 2.0, 0.4, 1.5, 0.5), (0.5, 3.0, 0.5, 2.0, 0.4), (0.4, 2.4, 0.4, 2.0, 0.3)]


def built(w1: float, h1: float, w2: float, h2: float, mu: float, stiffness: float | None = None) -> Assembly:
    """Pier and buttress on one base."""
    stone = Material(20.0, mu) if stiffness is None else Material(20.0, mu, stiffness)
    return on_base(stone, (-w1 - 0.5, -0.3, w2 + 0.5), (-w1, 0.0, 0.0, h1), (0.0, 0.0, w2, h2))


def onset_and_peak(w1: float, h1: float, w2: float, h2: float, mu: float) -> tuple[float, float]:
    """The multipliers by the closed forms."""
    pier, buttress, share = w1 * h1, w2 * h2, 1.0 - mu * w2 / h2
    onset = (buttress * w2 + share * pier * w1) / (buttress * h2 + share * pier * h1)
    slides = mu * w2 * buttress / (1.0 - mu**2)
    peak = (pier * w1 + buttress * w2 + 2.0 * slides * mu) / (pier * h1 + buttress * h2 + 2.0 * slides)
    return onset, peak


@pytest.mark.parametrize("shape", SHAPES)
def test_the_curve_rises_from_the_least_flow_to_what_goes_on(shape: tuple[float, ...]) -> None:
    """The peak within 1 mm of the onset, and lower by no more than the geometry takes in that: 5 · 10⁻⁴."""
    onset, peak = onset_and_peak(*shape)
    model = built(*shape)
    assert limit_analysis(model).alpha == pytest.approx(onset, rel=1e-6)
    curve = pushover(model, direction="+x", increment=0.001, until=0.99)
    assert curve.alpha_onset == pytest.approx(onset, rel=1e-6)
    assert curve.alpha_0 == pytest.approx(peak, rel=5e-4)
    assert curve.alpha_0 < peak * (1.0 + 1e-6) and curve.displacement[curve.peak] < 1e-3


def test_elastic_joints_approach_the_peak_as_they_get_stiffer() -> None:
    """What they yield lets the faces overlap: 1.0 % less at 10⁹ kN/m³, a third of that at thirty times as much."""
    _, peak = onset_and_peak(*SHAPES[0])
    missing = [
        1.0 - pushover(built(*SHAPES[0], k), direction="+x", contacts="elastic", until=0.99).alpha_0 / peak
        for k in (1e9, 3e10)
    ]
    assert missing[0] < 2e-2 and 0.0 < missing[1] < 0.4 * missing[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_contact_dynamics_stands_above_the_onset_and_falls_above_the_peak(shape: tuple[float, ...]) -> None:
    """Steps of 0.5 ms: in longer ones the faces overlap, and it moves on."""
    onset, peak = onset_and_peak(*shape)
    model = built(*shape)
    assert 0.98 * peak > onset
    assert farthest(model, 0.98 * peak, 2.0, 5e-4) < 1e-2
    assert farthest(model, 1.02 * peak, 2.0, 5e-4) > 0.2
