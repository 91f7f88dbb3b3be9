"""NTC 2018 spectra against hand-computed numbers; record spectra against independent integration."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from mechanics.records.record import response_spectrum

PERIODS = [0.05, 0.25, 1.0, 3.0]
BY_HAND = {
    "A": [0.42500, 0.600, 0.18000, 0.05200],
    "B": [0.43505, 0.696, 0.29221, 0.08442],
    "C": [0.48511, 0.804, 0.37680, 0.10885],
    "D": [0.49002, 0.900, 0.61619, 0.17801],
    "E": [0.46098, 0.804, 0.44898, 0.12971],
}


@pytest.mark.parametrize("soil", BY_HAND)
def test_hand_computed_ordinates(soil):
    """a_g = 0.25 g, F0 = 2.4, T_C* = 0.30 s, T1, 5 %: F0 a_g = 0.6, T_D = 4·0.25 + 1.6 = 2.6 s, η = 1.

    soil  S_S                    C_C                        T_C      T_B      plateau = 0.25·S·2.4
    A     1                      1                          0.30000  0.10000  0.600
    B     1.40 − 0.40·0.6 = 1.16  1.10·0.3^−0.20 = 1.39949   0.41985  0.13995  0.696
    C     1.70 − 0.60·0.6 = 1.34  1.05·0.3^−0.33 = 1.56221   0.46866  0.15622  0.804
    D     2.40 − 1.50·0.6 = 1.50  1.25·0.3^−0.50 = 2.28218   0.68465  0.22822  0.900
    E     2.00 − 1.10·0.6 = 1.34  1.15·0.3^−0.40 = 1.86144   0.55843  0.18614  0.804

    T = 0.05: a_g S + (plateau − a_g S)·0.05/T_B, e.g. B: 0.29 + 0.406·0.35727 = 0.43505
    T = 0.25: plateau; T = 1: plateau·T_C, e.g. B: 0.696·0.41985 = 0.29221
    T = 3: plateau·T_C·2.6/9, e.g. D: 0.9·0.68465·0.288889 = 0.17801
    """
    spectrum = ElasticSpectrum(ag=0.25, F0=2.4, Tc_star=0.30, soil=soil)
    np.testing.assert_allclose(spectrum.acceleration(PERIODS), BY_HAND[soil], atol=6e-6)
    short = np.array(PERIODS)
    displacement = np.array(BY_HAND[soil]) * 9.80665 * (short / (2 * np.pi)) ** 2
    np.testing.assert_allclose(spectrum.displacement(short), displacement, rtol=1e-4)


@pytest.mark.parametrize(
    ("soil", "low", "high"),
    [("A", 1.0, 1.0), ("B", 1.0, 1.2), ("C", 1.0, 1.5), ("D", 0.9, 1.8), ("E", 1.0, 1.6)],
)
def test_bounds_of_the_stratigraphic_coefficient(soil, low, high):
    strong, weak = ElasticSpectrum(0.9, 2.5, 0.3, soil), ElasticSpectrum(0.01, 2.5, 0.3, soil)
    np.testing.assert_array_equal([strong.S_S, weak.S_S], [low, high])


def test_topography_and_damping():
    base = ElasticSpectrum(0.2, 2.5, 0.3)
    for name, factor in {"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4}.items():
        assert ElasticSpectrum(0.2, 2.5, 0.3, "A", name).acceleration(0.7) == pytest.approx(
            factor * base.acceleration(0.7)
        )
    assert base.with_damping(0.10).eta == pytest.approx((10 / 15) ** 0.5)
    assert base.with_damping(0.90).eta == 0.55
    assert base.with_damping(0.10).acceleration(0.0) == pytest.approx(base.acceleration(0.0))


def test_displacement_at_long_periods():
    """Soil A: T_E = 4.5 s, d_g = 0.025·0.25·9.80665·0.3·2.6 = 0.0478074 m; midway: d_g (1 + 2.4)/2."""
    spectrum = ElasticSpectrum(0.25, 2.4, 0.30)
    d_g = 0.025 * 0.25 * 9.80665 * 0.3 * 2.6
    assert d_g == pytest.approx(0.0478074, abs=1e-7)
    np.testing.assert_allclose(spectrum.displacement([7.25, 10.0, 20.0]), [1.7 * d_g, d_g, d_g], rtol=1e-12)
    largest, at = spectrum.largest_displacement(0.5, 12.0)
    assert at == 4.5
    assert largest == pytest.approx(spectrum.displacement(4.5))
    assert spectrum.largest_displacement(0.5, 2.0) == (pytest.approx(spectrum.displacement(2.0)), 2.0)


@given(
    ag=st.floats(0.02, 0.5), F0=st.floats(2.2, 3.0), Tc_star=st.floats(0.15, 0.6),
    soil=st.sampled_from("ABCDE"), damping=st.floats(0.02, 0.3),
)  # fmt: skip
def test_branches_join_and_displacement_grows(ag, F0, Tc_star, soil, damping):
    spectrum = ElasticSpectrum(ag, F0, Tc_star, soil, damping=damping)
    for joint in (spectrum.T_B, spectrum.T_C, spectrum.T_D):
        before, after = spectrum.acceleration([joint * (1 - 1e-9), joint * (1 + 1e-9)])
        assert before == pytest.approx(after, rel=1e-6)
    grid = np.linspace(0.0, spectrum.T_E, 400)
    assert (np.diff(spectrum.displacement(grid)) > -1e-12).all()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"soil": "F"}, "soil"), ({"topography": "T5"}, "topography"), ({"ag": 0.0}, "ag"),
        ({"F0": float("nan")}, "F0"), ({"Tc_star": -0.3}, "Tc_star"), ({"damping": 5.0}, "damping"),
        ({"ag": "0.1"}, "ag"), ({"damping": None}, "damping"), ({"F0": True}, "F0"),
        ({"soil": ["B"]}, "soil"),
    ],
)  # fmt: skip
def test_wrong_parameters_are_named(change, named):
    with pytest.raises(ValueError, match=named):
        ElasticSpectrum(**({"ag": 0.2, "F0": 2.4, "Tc_star": 0.3} | change))
    with pytest.raises(ValueError, match="T = "):
        ElasticSpectrum(0.2, 2.4, 0.3).acceleration(-1.0)


RECORD = np.random.default_rng(7).normal(0.0, 0.1, 60)  # g; starts and ends away from zero
STEP = 0.02


def test_record_spectrum_is_that_of_the_mechanics():
    spectrum, periods = RecordSpectrum(RECORD, STEP, 0.08), np.linspace(0.0, 4.0, 41)
    S_e, S_De = response_spectrum(RECORD, STEP, periods, 0.08)
    assert spectrum.ag == np.abs(RECORD).max()
    np.testing.assert_array_equal(spectrum.acceleration(periods), S_e)
    np.testing.assert_array_equal(spectrum.displacement(periods.reshape(-1, 1)), S_De.reshape(-1, 1))


def test_largest_displacement_of_a_record():
    spectrum = RecordSpectrum(RECORD, STEP)
    largest, at = spectrum.largest_displacement(0.5, 3.0)
    assert 0.5 <= at <= 3.0
    assert largest >= max(spectrum.displacement([0.5, 3.0]))
    assert largest == pytest.approx(spectrum.displacement(np.linspace(0.5, 3.0, 400)).max(), rel=5e-3)
