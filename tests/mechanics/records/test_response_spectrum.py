"""Response spectra against an independent integration and limits; artificial records: spectrum, shape, rest, seeds."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mechanics.errors import ConvergenceError
from mechanics.records import record as synthetic
from mechanics.records.record import compatible_record, response_spectrum
from mechanics.types import GRAVITY

NOISE = 0.1 * np.random.default_rng(7).normal(size=40)
STEP = 0.02


def reference_displacement(a, time_step, period, damping):
    """Largest |u| of the oscillator by Runge-Kutta of order 8, interval by interval, and its free swing."""
    omega = 2.0 * np.pi / period
    corners = np.append(GRAVITY * a, 0.0)
    pieces = [(time_step, a0, (a1 - a0) / time_step) for a0, a1 in pairwise(corners)] + [(period, 0.0, 0.0)]
    state, largest = np.zeros(2), 0.0
    for length, a0, slope in pieces:
        solution = solve_ivp(
            lambda t, y, a0=a0, slope=slope: [
                y[1],
                -a0 - slope * t - 2.0 * damping * omega * y[1] - omega**2 * y[0],
            ],
            (0.0, length),
            state,
            method="DOP853",
            rtol=1e-9,
            atol=1e-13,
            dense_output=True,
        )
        largest = max(largest, np.abs(solution.sol(np.linspace(0.0, length, 300))[0]).max())
        state = solution.y[:, -1]
    return largest


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("period", [0.04, 3.0])  # whose peaks are near a sample, where the step is exact
def test_agrees_with_runge_kutta(period, damping):
    expected = reference_displacement(NOISE, STEP, period, damping)
    S_a, S_d = response_spectrum(NOISE, STEP, period, damping)
    assert S_d[0] == pytest.approx(expected, rel=2e-5)
    assert S_a[0] == pytest.approx((2.0 * np.pi / period) ** 2 * expected / GRAVITY, rel=2e-5)


def test_short_periods_give_the_peak_acceleration():
    a = np.sin(np.linspace(0.0, 6.0, 600)) * np.hanning(600)
    S_a, S_d = response_spectrum(a, 0.01, [0.0, 1e-3, 1e-2])
    assert S_a == pytest.approx(np.abs(a).max(), rel=1e-3)
    assert S_d[0] == 0.0


def test_long_periods_give_the_ground_displacement():
    """A sine of base acceleration leaves the ground at rest a t²/2π away; its reverse brings it back."""
    t = 0.001 * np.arange(1001)
    pulse = 0.2 * np.sin(2.0 * np.pi * t)
    a = np.concatenate([pulse, -pulse[1:]])  # out and back: at rest where it began
    expected = 0.2 * GRAVITY / (2.0 * np.pi)
    S_d = response_spectrum(a, 0.001, [300.0, 3000.0], damping=0.05)[1]
    assert S_d == pytest.approx(expected, rel=5e-3)
    assert S_d[1] == pytest.approx(expected, rel=5e-4)


def test_the_free_vibration_after_a_pulse_counts():
    """Short pulse: u = v/ω with v its impulse, reached a quarter period later."""
    S_d = response_spectrum([0.0, 0.1, 0.1, 0.0], 0.001, 2.0, damping=0.0)[1]
    assert S_d[0] == pytest.approx(0.0002 * GRAVITY / np.pi, rel=1e-4)


@given(factor=st.floats(-5.0, 5.0).filter(lambda x: abs(x) > 0.01), stretch=st.floats(0.1, 10.0))
@settings(max_examples=15)
def test_linear_in_the_record_and_similar_in_time(factor, stretch):
    periods = np.array([0.05, 0.3, 1.0, 4.0])
    S_a, S_d = response_spectrum(NOISE, STEP, periods)
    assert response_spectrum(factor * NOISE, STEP, periods)[0] == pytest.approx(abs(factor) * S_a, rel=1e-9)
    slow = response_spectrum(NOISE, stretch * STEP, stretch * periods)
    assert slow[0] == pytest.approx(S_a, rel=1e-6)
    assert slow[1] == pytest.approx(stretch**2 * S_d, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((np.array([0.0, np.nan]), 0.01, 1.0), "acceleration_g"),
        ((NOISE, 0.0, 1.0), "time_step"),
        ((NOISE, 0.01, [1.0, -1.0]), "periods"),
        ((NOISE, 0.01, 1.0, 1.0), "damping"),
    ],
)
def test_bad_arguments_are_named(arguments, name):
    with pytest.raises(ValueError, match=name):
        response_spectrum(*arguments)


def spectrum(T):
    """NTC 2018 §3.2.3.2.1 with a_g S = 0.3 g, F0 = 2.4, T_C = 0.45 s, T_D = 2.6 s."""
    linear = T / 0.15 * 2.4 + 1.0 - T / 0.15
    falling = 2.4 * 0.45 / np.maximum(T, 1e-9)
    return 0.3 * np.select([T < 0.15, T < 0.45, T < 2.6], [linear, 2.4 + 0.0 * T, falling], falling * 2.6 / T)


@pytest.fixture(scope="module")
def record():
    return compatible_record(spectrum, duration=25.0, time_step=0.02, seed=1)


def test_spectrum_is_matched_between_the_periods_it_was_fitted_at(record):
    T = np.geomspace(0.15, 2.0, 999)
    ratio = response_spectrum(record.acceleration, record.time_step, T)[0] / spectrum(T)
    assert ratio.min() > 0.89 and ratio.max() < 1.11
    assert record.pga == pytest.approx(0.3, rel=0.3)


def test_base_ends_at_rest_where_it_began(record):
    v = (
        np.concatenate([[0.0], np.cumsum(record.acceleration[1:] + record.acceleration[:-1])])
        * 0.01
        * 9.80665
    )
    d = np.concatenate([[0.0], np.cumsum(v[1:] + v[:-1])]) * 0.01
    assert abs(v[-1]) < 1e-9 * np.abs(v).max()
    assert abs(d[-1]) < 1e-3 * np.abs(d).max()
    assert np.abs(d).max() < 0.5


def test_amplitude_rises_stands_and_decays(record):
    rms = np.sqrt([(part**2).mean() for part in np.array_split(record.acceleration, 25)])
    plateau = rms[5:15].mean()
    assert rms[5:15].min() > 0.6 * plateau
    assert rms[0] < 0.3 * plateau and rms[-1] < 0.1 * plateau
    assert np.abs(record.acceleration[[0, -1]]).max() < 1e-12


def test_the_seed_makes_the_record():
    first, again, other = (
        compatible_record(spectrum, duration=20.0, time_step=0.02, seed=seed, tolerance=0.3).acceleration
        for seed in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.allclose(first, other)


def test_a_motion_that_comes_no_closer_is_refused(monkeypatch):
    """Every draw and all its corrections are tried: the spectrum is stuck at twice the target at some periods."""
    tried = []

    def stuck(acceleration, time_step, periods):
        tried.append(acceleration)
        return spectrum(periods) * np.where(periods < 1.0, 2.0, 1.0), None

    monkeypatch.setattr(synthetic, "response_spectrum", stuck)
    with pytest.raises(ConvergenceError, match=r"seed = 1: .*within 33.3% .*not 10.0%.*another seed"):
        compatible_record(spectrum, duration=6.0, time_step=0.02, seed=1, plateau=2.0)
    assert len(tried) == synthetic.ATTEMPTS * synthetic.ITERATIONS


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"time_step": 0.05}, "time_step"),
        ({"band": (0.5, 0.2)}, "band"),
        ({"spectrum": lambda T: 0.0 * T}, "spectrum"),
    ],
)
def test_bad_arguments_of_a_made_record_are_named(changes, name):
    arguments = {"spectrum": spectrum, "duration": 25.0, "time_step": 0.01, "seed": 1, **changes}
    with pytest.raises(ValueError, match=f"^{name} = "):
        compatible_record(**arguments)
