"""Records: scale, window, time scale, resampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.records.record import Record, read_record

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
