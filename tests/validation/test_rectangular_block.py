"""Rigid and elastic rectangular block on a rigid base, against closed forms.

α(θ) = tan(arctan(B/H) − θ): the multiplier at which a block of breadth B and height H, leaning by θ, turns on about
its toe; zero where the centroid stands over the toe. Elastic joint: Winkler bed in no tension, full contact up to
e = l/6 with M = k d l³/12 · φ; beyond, contact over 3(l/2 − e).
"""

import numpy as np
import pytest

from mechanics import pushover
from tests.support.structures import block_on_base

BREADTH, HEIGHT = 0.2, 1.0
SLENDERNESS = np.arctan(BREADTH / HEIGHT)


@pytest.mark.parametrize("increment", [0.005, 0.02])
def test_every_point_of_the_curve_is_the_closed_form(increment):
    """The top corner moves by the sine of the lean, until the centroid stands over the toe."""
    curve = pushover(block_on_base(BREADTH, HEIGHT), (BREADTH, HEIGHT), increment=increment)
    lean = np.array([-state.positions[1, 2] for state in curve.states])
    np.testing.assert_allclose(curve.multiplier, np.tan(SLENDERNESS - lean), atol=1e-6)
    np.testing.assert_allclose(curve.displacement, np.sin(lean) * HEIGHT, atol=1e-8)
    assert curve.reached_zero and curve.multiplier[0] == pytest.approx(BREADTH / HEIGHT, abs=1e-9)


# --- elastic joint

WIDTH, DEPTH, STIFFNESS = 1.0, 1.0, 1e8
WEIGHT = 18.0 * 1.0 * 4.0


def rising_branch(segments: int | None = None):
    """Multiplier and lean of the points before the peak, each an equilibrium of its own."""
    model = block_on_base(WIDTH, 4.0, stiffness=STIFFNESS, segments=segments)
    curve = pushover(model, (WIDTH, 4.0), contacts="elastic", increment=0.05)
    lean = np.array([-state.positions[1, 2] for state in curve.states])
    rising = slice(1, curve.peak)
    return curve.multiplier[rising], lean[rising]


def winkler(multiplier: float, lean: float, segments: float = np.inf) -> float:
    """Rotation under the eccentricity e = (α + φ) H/2 of the weight and the load, the lean's own lever included."""
    e = multiplier * 2.0 + lean * 2.0
    if e <= WIDTH / 6.0:
        return WEIGHT * e / (STIFFNESS * DEPTH * WIDTH**3 / 12.0 * (1.0 + 2.0 / segments**2))
    contact = 3.0 * (WIDTH / 2.0 - e)
    return 2.0 * WEIGHT / (STIFFNESS * DEPTH * contact**2)


def test_the_rotation_is_that_of_the_winkler_bed():
    """In full contact and beyond l/6, where the contact shrinks to an eighth of the joint."""
    multiplier, lean = rising_branch()
    checked = multiplier < 0.225
    assert (multiplier[checked] > 0.2).any()
    expected = [winkler(a, phi) for a, phi in zip(multiplier[checked], lean[checked], strict=True)]
    np.testing.assert_allclose(lean[checked], expected, rtol=3e-3)


def test_the_error_of_the_stiffness_falls_with_the_square_of_the_segments():
    """k l²/12 · (1 + 2/m²): the lean in full contact is exactly that much too small."""
    for segments in (1, 2, 4, 8):
        multiplier, lean = rising_branch(segments)
        full = multiplier < 0.04
        expected = [winkler(a, phi, segments) for a, phi in zip(multiplier[full], lean[full], strict=True)]
        np.testing.assert_allclose(lean[full], expected, rtol=1e-3)
