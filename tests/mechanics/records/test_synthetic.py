"""Artificial records: spectrum, shape in time, rest at the end, seeds."""

import numpy as np
import pytest

from mechanics.errors import ConvergenceError
from mechanics.records import spectrum as synthetic
from mechanics.records.spectrum import compatible_record, response_spectrum


def spectrum(T):
    """NTC 2018 §3.2.3.2.1 with a_g S = 0.3 g, F0 = 2.4, T_C = 0.45 s, T_D = 2.6 s."""
    linear = T / 0.15 * 2.4 + 1.0 - T / 0.15
    falling = 2.4 * 0.45 / np.maximum(T, 1e-9)
    return 0.3 * np.select([T < 0.15, T < 0.45, T < 2.6], [linear, 2.4 + 0.0 * T, falling], falling * 2.6 / T)


@pytest.fixture(scope="module")
def record():
    return compatible_record(spectrum, duration=25.0, time_step=0.01, seed=1)


def test_spectrum_is_matched_between_the_periods_it_was_fitted_at(record):
    T = np.geomspace(0.15, 2.0, 999)
    ratio = response_spectrum(record.acceleration, record.time_step, T)[0] / spectrum(T)
    assert ratio.min() > 0.89 and ratio.max() < 1.11
    assert record.pga == pytest.approx(0.3, rel=0.3)


def test_base_ends_at_rest_where_it_began(record):
    v = (
        np.concatenate([[0.0], np.cumsum(record.acceleration[1:] + record.acceleration[:-1])])
        * 0.005
        * 9.80665
    )
    d = np.concatenate([[0.0], np.cumsum(v[1:] + v[:-1])]) * 0.005
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
def test_bad_arguments_are_named(changes, name):
    arguments = {"spectrum": spectrum, "duration": 25.0, "time_step": 0.01, "seed": 1, **changes}
    with pytest.raises(ValueError, match=f"^{name} = "):
        compatible_record(**arguments)
