"""Records: scale, window, resampling; response spectra against another integration; records made to a spectrum."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mechanics.errors import ConvergenceError
from mechanics.records import record as synthetic
from mechanics.records.record import Record, compatible_record, read_record, response_spectrum
from mechanics.types import GRAVITY

NOISE = Record(np.random.default_rng(3).normal(size=2001) * np.hanning(2001), 0.01, "noise")


def velocity_and_displacement(record):
    a, h = record.acceleration, record.time_step
    v = np.concatenate([[0.0], np.cumsum(a[1:] + a[:-1])]) * h / 2.0
    d = np.concatenate([[0.0], np.cumsum(v[:-1] * h + (2.0 * a[:-1] + a[1:]) * h**2 / 6.0)])
    return v, d


def test_a_scaled_record_keeps_its_name():
    scaled = NOISE.scaled(-2.5)
    assert (scaled.pga, scaled.name) == (pytest.approx(2.5 * NOISE.pga), "noise")


def test_window_keeps_the_samples_inside():
    part = NOISE.windowed(3.0, 7.005)
    assert np.array_equal(part.acceleration, NOISE.acceleration[300:701])
    assert np.array_equal(NOISE.windowed(0.0, NOISE.duration).acceleration, NOISE.acceleration)
    assert NOISE.windowed(0.005, 1.0).acceleration[0] == NOISE.acceleration[1]


@pytest.mark.parametrize(
    "window", [(-1.0, 5.0), (5.0, 5.0), (7.0, 3.0), (15.0, 22.0), (0.001, 0.009), (np.nan, 1.0)]
)
def test_windows_outside_the_record_are_refused(window):
    with pytest.raises(ValueError, match="window"):
        NOISE.windowed(*window)


def test_arias_window_of_a_constant_is_linear():
    record = Record(np.full(101, 0.2), 0.1, "constant")
    assert record.arias_window() == pytest.approx((0.5, 9.5))
    assert record.arias_window(0.0, 1.0) == pytest.approx((0.0, 10.0))
    one = Record(np.array([0.0, 0.3, 0.0]), 0.1, "one sample")  # half of its intensity on either side
    assert one.arias_window(0.0, 0.25) == pytest.approx((0.0, 0.05))


@given(low=st.floats(0.0, 0.45), high=st.floats(0.55, 1.0), factor=st.floats(0.1, 10.0))
@settings(max_examples=20)
def test_arias_window_holds_its_share(low, high, factor):
    start, end = NOISE.scaled(factor).arias_window(low, high)
    inside = (NOISE.time >= start) & (NOISE.time <= end)
    share = (NOISE.acceleration[inside] ** 2).sum() / (NOISE.acceleration**2).sum()
    assert share == pytest.approx(high - low, abs=0.02)


def test_arias_window_refusals():
    with pytest.raises(ValueError, match="fractions"):
        NOISE.arias_window(0.9, 0.1)
    with pytest.raises(ValueError, match="zero throughout"):
        Record(np.zeros(5), 0.1, "still").arias_window()


def test_the_strong_window_begins_before_anything_that_may_move():
    """A pulse of 8 % of the peak holds less than 0.1 % of the intensity, and overturns what stands to 5 %."""
    start, end = NOISE.strong_window()
    before = NOISE.time < start
    assert abs(NOISE.acceleration[before]).max() < 0.05 * NOISE.pga
    assert start <= NOISE.arias_window(1e-3)[0] and end == NOISE.arias_window()[1]
    pulse = np.where(abs(NOISE.time - 0.2) < 0.03, 0.08 * NOISE.pga, 0.0)
    shaken = Record(NOISE.acceleration + pulse, NOISE.time_step, "pulse first")
    assert shaken.arias_window(1e-3)[0] > 0.3 and shaken.strong_window()[0] == pytest.approx(0.18)
    assert shaken.scaled(7.0).strong_window() == pytest.approx(shaken.strong_window())
    weak = Record(np.r_[np.full(300, 0.04), 1.0, np.zeros(9)], 0.01, "weak, then strong")  # ∫a²: 0.48 of 1.48
    assert weak.strong_window()[0] == pytest.approx(0.01 * 1.48e-3 / 0.04**2, rel=2e-3)


@pytest.mark.parametrize("parts", [2, 7])
def test_refining_is_exact_and_undone_by_coarsening(parts):
    fine = NOISE.resampled(NOISE.time_step / parts)
    assert fine.acceleration[::parts] == pytest.approx(NOISE.acceleration, abs=1e-12)
    assert fine.duration == pytest.approx(NOISE.duration)
    for ours, theirs in zip(velocity_and_displacement(fine), velocity_and_displacement(NOISE), strict=True):
        assert ours[::parts] == pytest.approx(theirs, abs=1e-9)
    assert fine.resampled(NOISE.time_step).acceleration == pytest.approx(NOISE.acceleration, abs=1e-9)


@given(ratio=st.floats(1.01, 9.0))
@settings(max_examples=20)
def test_coarsening_keeps_final_velocity_and_displacement(ratio):
    coarse = NOISE.resampled(ratio * NOISE.time_step)
    end = coarse.duration
    time = np.append(NOISE.time[NOISE.time < end], end)  # the record up to there, to its last kink
    a, h = np.interp(time, NOISE.time, NOISE.acceleration), np.diff(time)
    v = np.append(0.0, np.cumsum((a[1:] + a[:-1]) * h / 2.0))
    d = np.sum(v[:-1] * h + (2.0 * a[:-1] + a[1:]) * h**2 / 6.0)
    velocity, displacement = velocity_and_displacement(coarse)
    assert velocity[-1] == pytest.approx(v[-1], abs=1e-9)
    assert displacement[-1] == pytest.approx(d, abs=1e-9)
    assert NOISE.duration - coarse.time_step < end <= NOISE.duration * (1.0 + 1e-9)


def test_a_broken_line_on_the_coarser_grid_is_reproduced():
    corners = np.array([0.0, 0.3, -0.2, 0.1, 0.4])
    record = Record(np.interp(np.arange(41) / 10.0, np.arange(5.0), corners), 0.1, "broken")
    assert record.resampled(1.0).acceleration == pytest.approx(corners, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: Record([0.0, np.inf], 0.1, ""), "acceleration"),
        (lambda: Record([0.0, 1.0], 0.0, ""), "time_step"),
        (lambda: NOISE.scaled(np.nan), "acceleration"),
        (lambda: NOISE.resampled(-0.1), "time_step"),
        (lambda: read_record("x", time_step=0.0), "time_step"),
    ],
)
def test_bad_arguments_are_named(call, name):
    with pytest.raises(ValueError, match=f"^{name} = "):
        call()


SHAKEN = 0.1 * np.random.default_rng(7).normal(size=40)
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
    expected = reference_displacement(SHAKEN, STEP, period, damping)
    S_a, S_d = response_spectrum(SHAKEN, STEP, period, damping)
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


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((np.array([0.0, np.nan]), 0.01, 1.0), "acceleration_g"),
        ((SHAKEN, 0.0, 1.0), "time_step"),
        ((SHAKEN, 0.01, [1.0, -1.0]), "periods"),
        ((SHAKEN, 0.01, 1.0, 1.0), "damping"),
    ],
)
def test_bad_arguments_of_a_spectrum_are_named(arguments, name):
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
