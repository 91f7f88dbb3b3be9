"""Lognormal fragility by maximum likelihood, and its bootstrap: samples of records side by side as weights.

Everywhere `weights` (s, n) counts how often each of n observations is in each of s samples. Levels in g.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr, ndtri

from mechanics.types import Array, Mask

SAMPLES, SEED = 1000, 2015
CONFIDENCE = 0.95
ROUNDS = 500  # of the expectation-maximisation
SETTLED = 1e-10  # of ln: what a round changes at the end
NARROWEST = 1e-6  # β that is none
WIDE = 0.1  # β that the expectation-maximisation begins with, at least: from none it would not move
NEWTON_STEPS, HALVINGS = 100, 40  # at most; about ten steps are taken, hardly one of them halved
DECREMENT = 1e-16  # of the log-likelihood of an observation: what a Newton step is to gain at the end
ROUNDING = 1e-12  # of a log-likelihood
UNALIKE = 1e-12  # covariance of shares and levels over that of the levels: below it they are not related


class Lognormal(NamedTuple):
    """Medians (s,) g and dispersions β (s,) of samples; NaN where a sample does not determine them."""

    median: Array
    beta: Array


@dataclass(frozen=True)
class Scatter:
    """Of a sample of m standard normal values: the mean of its range, and the variance of its smallest."""

    mean_range: float
    variance_of_smallest: float

    @classmethod
    def of(cls, members: int) -> Scatter:
        """Return them by quadrature (Tippett 1925)."""
        x = np.linspace(-9.0, 9.0, 6001)
        below = ndtr(x)
        mean_range = np.trapezoid(1.0 - below**members - (1.0 - below) ** members, x)
        density = members * np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi) * (1.0 - below) ** (members - 1)
        mean = np.trapezoid(x * density, x)
        return cls(float(mean_range), float(np.trapezoid((x - mean) ** 2 * density, x)))


def samples_of_records(record: Array) -> Array:
    """Weights (s, n) of SAMPLES samples of as many records as there are, with replacement, from a fixed seed.

    `record` (n,): which record each observation is of. Observations of one record stay together: they are no
    independent ones.
    """
    count = int(record.max()) + 1
    drawn = np.random.default_rng(SEED).multinomial(count, np.full(count, 1.0 / count), SAMPLES)
    return drawn[:, record].astype(float)


def fit_levels(level: Array, withstood: Mask, weights: Array) -> Lognormal:
    """Fit levels of collapse (n,), those `withstood` being lower bounds of theirs (right-censored).

    Without lower bounds: mean and root mean square (over n, by maximum likelihood) of the logarithms; equal levels have
    β = 0. With them by expectation-maximisation. Where all withstood there is no median.
    """
    x = np.log(level)
    total, fell = weights.sum(axis=1), weights @ (~withstood).astype(float)
    with np.errstate(all="ignore"):
        mean = weights @ (x * ~withstood) / fell
        spread = np.sqrt(np.maximum(weights @ (x**2 * ~withstood) / fell - mean**2, 0.0))
    mean, spread = np.where(fell > 0, mean, np.nan), np.where(fell > 0, spread, np.nan)
    some = (weights @ withstood.astype(float) > 0.0) & (fell > 0)
    if some.any():
        mean[some], spread[some] = _censored(
            x, withstood, weights[some], total[some], mean[some], np.maximum(spread[some], WIDE)
        )
    spread[spread < 2.0 * NARROWEST] = 0.0
    return Lognormal(np.exp(mean), spread)


def _censored(
    x: Array, withstood: Mask, weights: Array, total: Array, mean: Array, spread: Array
) -> tuple[Array, Array]:
    for _ in range(ROUNDS):
        z = (x - mean[:, None]) / spread[:, None]
        hazard = np.exp(-0.5 * z**2 - log_ndtr(-z)) / np.sqrt(2.0 * np.pi)
        first = np.where(withstood, mean[:, None] + spread[:, None] * hazard, x)
        second = np.where(
            withstood,
            mean[:, None] ** 2 + spread[:, None] ** 2 + spread[:, None] * (x + mean[:, None]) * hazard,
            x**2,
        )
        new = (weights * first).sum(axis=1) / total
        wide = np.sqrt(np.maximum((weights * second).sum(axis=1) / total - new**2, NARROWEST**2))
        done = np.abs(new - mean).max() + np.abs(wide - spread).max() < SETTLED
        mean, spread = new, wide
        if done:
            break
    return mean, spread


def fit_stripes(levels: Array, collapsed: Mask, weights: Array) -> Lognormal:
    """Fit the collapses (n, k) seen at levels (k,): binomial likelihood (Baker 2015, Earthquake Spectra 31(1), eq. 11).

    `levels` grow. With p = Φ(a + b ln level) the logarithm of the likelihood is concave in a and b. It has a maximum
    with b > 0 where the share of collapses grows with ln level (by regression), and some stand above the lowest level
    with a collapse (Silvapulle 1981, J. R. Stat. Soc. B 43(3)); its median is exp(−a/b), and β = 1/b.

    Without a maximum the limit of ever larger likelihoods counts, where it is a distribution. Collapses parted by a
    level, all above and none below: β = 0, and the geometric mean of the two levels around, of which no other median in
    between is less likely. All above and none below a level at which some collapse: β → 0, and the median → this level.
    Without collapse the median is ∞; where none stands, 0. Where the collapses do not grow with the level, or there is
    one level of which a share collapses, neither is told.
    """
    x, total = np.log(levels), weights.sum(axis=1)
    fell = weights @ collapsed.astype(float)
    stood = total[:, None] - fell
    median, beta = np.full(len(weights), np.nan), np.full(len(weights), np.nan)
    none, all_ = (fell == 0.0).all(axis=1), (stood == 0.0).all(axis=1)
    median[none], median[all_] = np.inf, 0.0
    first = (fell > 0.0).argmax(axis=1)
    last = len(levels) - 1 - (stood > 0.0)[:, ::-1].argmax(axis=1)
    steep = ~(none | all_) & (last <= first) & (len(levels) > 1)
    median[steep], beta[steep] = np.sqrt(levels[first] * levels[last])[steep], 0.0
    away = x - x.mean()
    grows = fell @ away > UNALIKE * total * (away @ away)
    rest = ~(none | all_ | steep) & grows
    if rest.any():
        median[rest], beta[rest] = _most_likely(x, fell[rest], stood[rest])
    return Lognormal(median, beta)


def _most_likely(x: Array, fell: Array, stood: Array) -> tuple[Array, Array]:
    """Return medians (s,) and β (s,) of the most likely a + b x; at x (k,), ln g, `fell` and `stood` (s, k) so many.

    Newton's method with halved steps, from b = 0 on. NaN where it does not converge, or the median is no number.
    """
    middle, width = x.mean(), x.std()
    u, total = (x - middle) / width, (fell + stood).sum(axis=1)
    a, b = ndtri(fell.sum(axis=1) / total), np.zeros(len(fell))
    done = np.zeros(len(fell), dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            eta = a[:, None] + b[:, None] * u
            up, down = _ratio(eta), _ratio(-eta)
            slope, curvature = fell * up - stood * down, fell * up * (eta + up) + stood * down * (down - eta)
            sum_, about = curvature.sum(axis=1), curvature @ u / curvature.sum(axis=1)
            away = u - about[:, None]
            slope_a, slope_b = slope.sum(axis=1), (slope * away).sum(axis=1)
            by_b = slope_b / (curvature * away**2).sum(axis=1)
            by_a = slope_a / sum_ - about * by_b
            done = slope_a**2 / sum_ + slope_b * by_b <= DECREMENT * total
            if done.all():
                break
            part = _part(a, b, by_a, by_b, u, fell, stood)
            a, b = a + np.where(done, 0.0, part * by_a), b + np.where(done, 0.0, part * by_b)
        beta = width / b
        median = np.exp(middle - a * beta)
    found = done & (b > 0.0) & (median > 0.0) & (median < np.inf)
    return np.where(found, median, np.nan), np.where(found, beta, np.nan)


def _part(a: Array, b: Array, by_a: Array, by_b: Array, u: Array, fell: Array, stood: Array) -> Array:
    """Return the part (s,) of a step, halved as long as it makes the likelihood smaller."""

    def log_likelihood(part: Array) -> Array:
        eta = (a + part * by_a)[:, None] + (b + part * by_b)[:, None] * u
        return np.asarray((fell * log_ndtr(eta) + stood * log_ndtr(-eta)).sum(axis=1))

    before = log_likelihood(np.zeros(len(a)))
    least, part = before - ROUNDING * abs(before), np.ones(len(a))
    for _ in range(HALVINGS):
        falls = log_likelihood(part) < least
        if not falls.any():
            break
        part[falls] *= 0.5
    return part


def _ratio(eta: Array) -> Array:
    """Return φ/Φ at `eta`, by the scaled complementary error function: accurate far out, too."""
    with np.errstate(over="ignore"):
        return np.asarray(np.sqrt(2.0 / np.pi) / erfcx(-eta / np.sqrt(2.0)))


def confidence(values: Array) -> list[float | None]:
    """Return the bounds between which CONFIDENCE of the samples (s,) lie; None where that is not bounded."""
    half = 0.5 * (1.0 - CONFIDENCE)
    known = values[~np.isnan(values)]
    if not known.size:
        return [None, None]
    low, high = np.quantile(known, [half, 1.0 - half], method="nearest")
    return [float(each) if each < np.inf else None for each in (low, high)]
