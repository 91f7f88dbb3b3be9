"""P(collapse | level) of several records, against closed forms and scipy."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import log_ndtr
from scipy.stats import CensoredData, norm

from assessment.analyses.fragility import (
    RecordLevel,
    confidence,
    fit_levels,
    fit_stripes,
    over_records,
    samples_of_records,
)


def whole(count):
    return np.ones((1, count))


def test_levels_give_mean_and_root_mean_square_of_their_logarithms():
    levels = np.array([0.21, 0.34, 0.30, 0.55])
    fit = fit_levels(levels, np.zeros(4, bool), whole(4))
    assert fit.median[0] == pytest.approx(math.exp(np.log(levels).mean()))
    assert fit.beta[0] == pytest.approx(np.log(levels).std())


def test_what_withstood_is_a_lower_bound_as_scipy_has_it():
    levels, withstood = np.array([0.21, 0.34, 0.30, 0.55, 0.6, 0.4]), np.array([0, 0, 0, 0, 1, 1], bool)
    fit = fit_levels(levels, withstood, whole(6))
    mean, beta = norm.fit(CensoredData(np.log(levels[~withstood]), right=np.log(levels[withstood])))
    assert fit.median[0] == pytest.approx(math.exp(mean), rel=1e-4)
    assert fit.beta[0] == pytest.approx(beta, rel=1e-3)


def test_beta_is_that_of_the_levels_of_records_and_that_within_each_of_them():
    """0.2 and 0.4 g: ½ ln 2; within: the root of the mean square of 0.1 and 0.3, not of what withstood."""
    fit = over_records([RecordLevel("a", 0.2, False, 0.1), RecordLevel("b", 0.4, False, 0.3)])
    apart, within = math.log(2.0) / 2.0, math.sqrt(0.05)
    assert (fit.beta_record, fit.beta_ensemble) == pytest.approx((apart, within))
    assert fit.beta == pytest.approx(math.hypot(apart, within))
    more = over_records([RecordLevel("a", 0.2, False, 0.1), RecordLevel("b", 0.4, True, 0.3)])
    assert more.beta_ensemble == pytest.approx(0.1)


def test_equal_levels_beside_lower_bounds_are_a_distribution_all_the_same():
    """Two collapse at one level: the two that withstand three times of it widen it; half of it would not."""
    levels, withstood = np.array([0.9, 0.9, 2.6, 2.6]), np.array([0, 0, 1, 1], bool)
    fit = fit_levels(levels, withstood, whole(4))

    def minus_likelihood(x):
        return -2.0 * (
            norm.logpdf(math.log(0.9), x[0], math.exp(x[1])) + norm.logsf(math.log(2.6), x[0], math.exp(x[1]))
        )

    expected = minimize(
        minus_likelihood, (0.5, -0.5), method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-12}
    ).x
    assert fit.median[0] == pytest.approx(math.exp(expected[0]), rel=1e-4)
    assert fit.beta[0] == pytest.approx(math.exp(expected[1]), rel=1e-4)
    low = fit_levels(np.array([0.9, 0.9, 0.45]), np.array([0, 0, 1], bool), whole(3))
    assert low.median[0] == pytest.approx(0.9) and low.beta[0] == 0.0


def test_a_weight_counts_an_observation_as_often():
    levels, withstood = np.array([0.2, 0.3, 0.5]), np.array([False, False, True])
    twice = fit_levels(levels, withstood, np.array([[2.0, 1.0, 1.0]]))
    again = fit_levels(np.append(levels, 0.2), np.append(withstood, False), whole(4))
    assert twice.median == pytest.approx(again.median) and twice.beta == pytest.approx(again.beta)


def test_stripes_that_a_level_parts_have_no_dispersion_and_those_without_collapse_no_median():
    levels = np.array([0.1, 0.2, 0.4])
    outcomes = np.array([[0, 0, 1], [0, 0, 0], [1, 1, 1], [1, 0, 0]], bool)
    fit = fit_stripes(levels, outcomes, np.eye(4))
    assert fit.median[0] == pytest.approx(math.sqrt(0.08)) and fit.beta[0] == 0.0
    assert fit.median[1] == math.inf and fit.median[2] == 0.0
    assert math.isnan(fit.median[3])


def _fitted(levels, fell, of):
    """The fit of stripes of `of` records, so many of which collapse at each level."""
    collapsed = np.arange(of)[:, None] < np.array(fell)
    fit = fit_stripes(np.array(levels), collapsed, whole(of))
    return fit.median[0], fit.beta[0]


def test_stripes_of_any_levels_maximise_the_likelihood():
    """The reference is scipy.optimize.minimize on the likelihood, from several starts; where it has a maximum."""
    random, compared = np.random.default_rng(0), 0
    while compared < 30:
        levels = np.sort(np.exp(random.uniform(math.log(0.05), math.log(1.5), random.integers(2, 8))))
        of = int(random.integers(4, 22))
        capacity = np.exp(random.normal(math.log(0.35), random.uniform(0.05, 0.6), of))
        fell = (capacity[:, None] <= levels).sum(axis=0)
        if not ((fell > 0) & (fell < of)).sum() > 1 or len(set(fell)) == 1:
            continue

        x = np.log(levels)

        def minus_likelihood(c, x=x, fell=fell, of=of):
            z = (x - c[0]) / math.exp(c[1])
            return -(fell * log_ndtr(z) + (of - fell) * log_ndtr(-z)).sum()

        best = min(
            (
                minimize(minus_likelihood, [math.log(start), math.log(0.3)], method="Nelder-Mead",
                         options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 4000})
                for start in (0.1, 0.35, 1.0)
            ),
            key=lambda found: found.fun,
        )  # fmt: skip
        median, beta = _fitted(levels, fell, of)
        assert minus_likelihood([math.log(median), math.log(beta)]) <= best.fun + 1e-9
        assert (median, beta) == pytest.approx(np.exp(best.x), rel=1e-4)
        compared += 1


@pytest.mark.parametrize(
    ("levels", "fell", "of", "median"),
    [
        ([0.087, 0.237, 0.434, 1.474], [0, 0, 15, 19], 19, 0.434),
        ([0.074, 0.273, 0.334], [0, 0, 2], 17, 0.334),
        ([0.572, 1.112, 1.233], [19, 20, 20], 20, 0.572),
        ([0.2, 1.19, 1.2], [0, 0, 4], 6, 1.2),
        ([0.2, 0.4], [0, 6], 6, math.sqrt(0.08)),
    ],
)
def test_stripes_without_a_maximum_have_the_limit_of_ever_steeper_distributions(levels, fell, of, median):
    """One partial level x: with ln median = ln x − β z, Φ(z) the share at it, the likelihood grows as β falls.

    It has no maximum: p is 0 below, the share there and 1 above only for β → 0, when the median becomes x.
    """
    assert _fitted(levels, fell, of) == (pytest.approx(median, rel=1e-15), 0.0)
    k = next((k for k, count in enumerate(fell) if 0 < count < of), None)
    if k is None:
        return
    x, share = np.log(levels), np.array(fell) / of
    gained = []
    for beta in (0.2, 0.1, 0.05, 0.0005):
        z = (x - x[k]) / beta + norm.ppf(share[k])
        with np.errstate(all="ignore"):
            logs = np.where(share > 0, share * norm.logcdf(z), 0.0)
            logs += np.where(share < 1, (1 - share) * norm.logcdf(-z), 0.0)
        gained.append(logs.sum())
    highest = share[k] * math.log(share[k]) + (1 - share[k]) * math.log(1 - share[k])
    assert gained == sorted(gained) and gained[-1] == pytest.approx(highest, abs=1e-9)


@pytest.mark.parametrize(
    ("levels", "fell"),
    [([0.3], [5]), ([0.1, 0.2, 0.4], [3, 3, 3]), ([0.1, 0.2, 0.4], [5, 3, 1]), ([0.1, 0.2, 0.4], [1, 0, 0])],
    ids=["one level", "as many at each", "fewer above", "below alone"],
)
def test_stripes_whose_collapses_do_not_grow_have_no_median(levels, fell):
    assert all(math.isnan(value) for value in _fitted(levels, fell, 10))


def test_a_median_beyond_all_numbers_is_none():
    """22, 28, 25 of 28: 25 in the mean at the two lowest levels, which are nearly one, and 25 at the highest."""
    assert all(math.isnan(value) for value in _fitted([0.07801843, 0.07801913, 1.22054528], [22, 28, 25], 28))


def test_the_bootstrap_keeps_the_signs_of_a_record_together_and_is_the_same_at_every_run():
    record = np.array([0, 0, 1, 1, 2, 2])
    samples = samples_of_records(record)
    assert (samples[:, ::2] == samples[:, 1::2]).all() and (samples.sum(axis=1) == 6.0).all()
    assert (samples == samples_of_records(record)).all()


def test_the_bootstrap_covers_the_median_as_often_as_it_says():
    """Of 200 sets of 30 records the 95 % bounds hold the true median in 88-99 %."""
    random = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        levels = 0.3 * np.exp(0.4 * random.standard_normal(30))
        samples = samples_of_records(np.arange(30))
        low, high = confidence(fit_levels(levels, np.zeros(30, bool), samples).median)
        inside += low < 0.3 < high
    assert 176 <= inside <= 198
