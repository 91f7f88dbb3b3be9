"""Lognormal fragility by maximum likelihood, and its bootstrap: samples of records side by side as weights.

Everywhere `weights` (s, n) counts how often each of n observations is in each of s samples. Levels in g.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, ndtr

from mechanics.types import Array, Mask

SAMPLES, SEED = 1000, 2015
CONFIDENCE = 0.95
ROUNDS = 500  # of the expectation-maximisation; of Fisher's scoring a tenth
SETTLED = 1e-10  # of ln: what a round changes at the end
NARROWEST = 1e-6  # β that is none
WIDE = 0.1  # β that the expectation-maximisation begins with, at least: from none it would not move
STEP = 1.0  # of Fisher's scoring, at most, in ln of the median and of β


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

    By Fisher's scoring on ln of the median and of β. A sample whose collapses are parted by a level, all above and
    none below, has β = 0 and the geometric mean of the two levels around it. A sample without collapse, or where none
    stands, has no median: ∞, or 0; one whose collapses do not grow with the level has neither.
    """
    x, total = np.log(levels), weights.sum(axis=1)
    share = weights @ collapsed.astype(float) / total[:, None]
    median, beta = np.full(len(weights), np.nan), np.full(len(weights), np.nan)
    none, all_ = (share == 0.0).all(axis=1), (share == 1.0).all(axis=1)
    median[none], median[all_] = np.inf, 0.0
    parted = ((share == 0.0) | (share == 1.0)).all(axis=1) & (np.diff(share) >= 0.0).all(axis=1)
    parted &= ~none & ~all_
    first = share[parted].argmax(axis=1)
    median[parted], beta[parted] = np.exp(0.5 * (x[first] + x[first - 1])), 0.0
    slope = (share * (x - x.mean())).sum(axis=1)
    rest = ~(none | all_ | parted) & (slope > 0.0)
    if rest.any():
        median[rest], beta[rest] = _scored(x, share[rest], total[rest])
    return Lognormal(median, beta)


def _scored(x: Array, share: Array, total: Array) -> tuple[Array, Array]:
    """Return medians and β of samples with `share` (s, k) of `total` (s,) observations collapsed at x (k,), ln g."""
    mean, log_beta = np.full(len(share), x.mean()), np.full(len(share), np.log(max(0.2, 0.5 * np.ptp(x))))
    for _ in range(ROUNDS // 10):
        beta = np.exp(log_beta)
        z = (x - mean[:, None]) / beta[:, None]
        p = ndtr(z).clip(1e-12, 1.0 - 1e-12)
        density = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
        gradient = np.stack([-density / beta[:, None], -density * z], axis=-1)  # of p, in mean and ln β
        variance = p * (1.0 - p)
        score = np.einsum("s,sk,ski->si", total, (share - p) / variance, gradient)
        information = np.einsum("s,sk,ski,skj->sij", total, 1.0 / variance, gradient, gradient)
        information += 1e-12 * np.eye(2)
        step = np.linalg.solve(information, score[..., None])[..., 0].clip(-STEP, STEP)
        mean, log_beta = mean + step[:, 0], log_beta + step[:, 1]
        if np.abs(step).max() < SETTLED:
            break
    return np.exp(mean), np.exp(log_beta)


def confidence(values: Array) -> list[float | None]:
    """Return the bounds between which CONFIDENCE of the samples (s,) lie; None where that is not bounded."""
    half = 0.5 * (1.0 - CONFIDENCE)
    known = values[~np.isnan(values)]
    if not known.size:
        return [None, None]
    low, high = np.quantile(known, [half, 1.0 - half], method="nearest")
    return [float(each) if each < np.inf else None for each in (low, high)]
