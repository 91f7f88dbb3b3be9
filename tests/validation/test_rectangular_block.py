"""Rigid and elastic rectangular block on a rigid base, against closed forms.

α(θ) = tan(arctan(B/H) − θ): the multiplier at which a block of breadth B and height H, leaning by θ, turns on about
its toe; zero where the centroid stands over the toe. Elastic joint: Winkler bed in no tension, full contact up to
e = l/6 with M = k d l³/12 · φ; beyond, contact over 3(l/2 − e).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mechanics import limit_analysis, pushover
from tests.support.structures import block_on_base

BREADTH, HEIGHT = 0.2, 1.0
SLENDERNESS = np.arctan(BREADTH / HEIGHT)


def rigid_curve():
    return pushover(block_on_base(BREADTH, HEIGHT), (BREADTH, HEIGHT), increment=0.005)


def test_multiplier_at_onset():
    assert limit_analysis(block_on_base(BREADTH, HEIGHT)).alpha == pytest.approx(0.2, abs=1e-9)


def test_monolithic_leaf():
    """0.5 × 3.9 m, μ = 0.58 [computed independently: B/H = 0.128205]."""
    assert limit_analysis(block_on_base(0.5, 3.9, friction=0.58)).alpha == pytest.approx(0.128205, abs=5e-7)


def test_sliding_governs_where_friction_is_low():
    assert limit_analysis(block_on_base(BREADTH, HEIGHT, friction=0.15)).alpha == pytest.approx(
        0.15, abs=1e-9
    )


def test_every_point_of_the_curve_is_the_closed_form():
    curve = rigid_curve()
    lean = np.array([-state.positions[1, 2] for state in curve.states])
    np.testing.assert_allclose(curve.multiplier, np.tan(SLENDERNESS - lean), atol=1e-6)


def test_the_top_corner_moves_by_the_sine_of_the_lean():
    curve = rigid_curve()
    lean = np.array([-state.positions[1, 2] for state in curve.states])
    np.testing.assert_allclose(curve.displacement, np.sin(lean) * HEIGHT, atol=1e-8)


@pytest.mark.parametrize(("d", "literature"), [(0.05, 0.146), (0.10, 0.092), (0.15, 0.037), (0.18, 0.005)])
def test_literature_curve_lies_within_its_distance_from_the_closed_form(d, literature):
    """Sequential analyses in the literature print these; the exact curve is 0.1485, 0.0976, 0.0469, 0.0164.

    They lie below the closed form by up to 0.0115, as a pivot that moves inwards by 6 mm would; the program is held
    to the closed form, and here only to that difference.
    """
    curve = rigid_curve()
    ours = float(np.interp(d, curve.displacement, curve.multiplier))
    assert ours == pytest.approx(np.tan(SLENDERNESS - np.arcsin(d / HEIGHT)), abs=2e-5)
    assert 0.0 < ours - literature < 0.0116


def test_the_curve_ends_with_the_centroid_over_the_toe():
    curve = rigid_curve()
    assert curve.reached_zero
    assert curve.displacement[-1] == pytest.approx(HEIGHT * np.sin(SLENDERNESS), abs=1e-6)


def test_the_increment_does_not_change_the_curve():
    coarse = pushover(block_on_base(BREADTH, HEIGHT), (BREADTH, HEIGHT), increment=0.02)
    lean = np.array([-state.positions[1, 2] for state in coarse.states])
    np.testing.assert_allclose(coarse.multiplier, np.tan(SLENDERNESS - lean), atol=1e-6)


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


def test_the_elastic_peak_approaches_the_rigid_multiplier_as_stiffness_grows():
    def peak(stiffness: float) -> float:
        model = block_on_base(BREADTH, HEIGHT, stiffness=stiffness)
        return float(pushover(model, (BREADTH, HEIGHT), contacts="elastic", increment=0.002).multiplier.max())

    peaks = [peak(stiffness) for stiffness in (1e6, 1e7, 1e8)]
    assert all(low < high < 0.2 for low, high in pairwise(peaks))
    assert peaks[-1] == pytest.approx(0.2, rel=0.05)
