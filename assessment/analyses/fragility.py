"""P(collapse | level): of one record, of several by maximum likelihood, and the value of NTC 2018 §7.3.5.

Of one record: between the largest level that stands below all collapses and the lowest collapse P grows from 0 to 1,
evenly in ln level. Where the structure stands at a higher level again, collapse comes in bands, and P is the probit in
ln level that is most likely. Of several records: their 50 % levels are lognormal, with the dispersion β_record; that of
the levels of one record, β_ensemble, is the root of the mean square of their own β, and β² = β_record² + β_ensemble².

Everywhere `weights` (s, n) counts how often each of n observations is in each of s samples of the bootstrap. Levels in
g, or in the unit of another measure.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtri

from assessment.ntc.tables import ENOUGH
from mechanics.types import Array, Mask

PROBABILITIES = (0.16, 0.5, 0.84)
BAND = (0.01, 0.05, 0.1, 0.16, 0.3, 0.5, 0.7, 0.84, 0.9, 0.95, 0.99)
INFORMATION = 1.806  # ∫ φ²/(Φ(1 − Φ)): of levels evenly spaced by δ, of m in Φ((x − m)/β), times β δ
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


@dataclass(frozen=True)
class Observed:
    """What the levels (g) of one record show: `probable` of PROBABILITIES; `beta` of the probit, 0: no band met."""

    safe: float  # largest level that stands below the lowest collapse, 0: none
    lowest: float | None = None  # level that collapses, None: none
    probable: tuple[float, float, float] | None = None
    beta: float = 0.0
    capacity: float | None = None
    certain: float | None = None  # from it all levels collapse, None: not reached
    stands: tuple[float, ...] = ()  # levels above the lowest collapse that stand
    gap: tuple[float, float] | None = None  # the two levels that are widest apart with none run between
    spacing: float = 0.0  # of ln level, around the lowest collapse

    @property
    def middle(self) -> float | None:
        """The 50 % level."""
        return self.probable[1] if self.probable else None

    def known_to(self, beta: float) -> float:
        """Return the standard deviation of ln of the 50 % level where collapse scatters by β."""
        return math.sqrt(max(beta, self.beta) * self.spacing / INFORMATION + self.spacing**2 / 12.0)


def observed(levels: Sequence[float], fallen: Sequence[bool]) -> Observed:
    """Return what outcomes at levels show; 16 % in the lowest bracket, or of the probit if lower, is the `capacity`."""
    runs = sorted(zip(levels, fallen, strict=True))
    falls = [level for level, fell in runs if fell]
    standing = [level for level, fell in runs if not fell]
    if not falls:
        return Observed(safe=max(standing, default=0.0), gap=_gap(levels))
    low = falls[0]
    safe = max((level for level in standing if level < low), default=0.0)
    # in ln level; above no level at all, of the level itself
    bracket = [safe ** (1.0 - p) * low**p if safe else p * low for p in PROBABILITIES]
    stands = tuple(level for level in standing if level > low)
    certain = next((level for level in falls if not stands or level > stands[-1]), None)
    probable, beta = bracket, 0.0
    if stands:
        growing, fell = zip(*runs, strict=True)
        fit = fit_stripes(np.array(growing), np.array([fell]), np.ones((1, 1)))
        median, beta = float(fit.median[0]), float(fit.beta[0])
        known = 0.0 < median < math.inf and beta > 0.0
        probable = [median * math.exp(beta * float(ndtri(p))) for p in PROBABILITIES] if known else bracket
        beta = beta if known else 0.0
    return Observed(
        safe=max((level for level in standing if level < min(bracket[0], probable[0])), default=0.0), lowest=low,
        probable=(probable[0], probable[1], probable[2]), beta=beta, capacity=min(bracket[0], probable[0]),
        certain=certain, stands=stands, gap=_gap([x for x in levels if certain is None or x <= certain]),
        spacing=math.log(low / safe) if safe else 1.0,
    )  # fmt: skip


def _gap(levels: Sequence[float]) -> tuple[float, float] | None:
    """Return the neighbouring levels that are widest apart, in ln."""
    return max(pairwise(sorted(levels)), key=lambda pair: pair[1] / pair[0], default=None)


class Standard(NamedTuple):
    """Mean and lowest PGA at collapse of some records (g), None: undecided, and which of them counts by the `rule`.

    A rule of None: fewer records than §7.3.5 asks for.
    """

    mean: float | None
    lowest: float | None
    rule: str | None

    @property
    def pga(self) -> float | None:
        """The PGA that counts, g; of too few records the lowest, which is no value of the standard."""
        return self.mean if self.rule == "mean" else self.lowest


@dataclass(frozen=True)
class RecordLevel:
    """The 50 % `level` of a record of one sign, a lower bound where it `withstood`, and β of its levels."""

    record: str
    level: float
    withstood: bool
    beta: float


@dataclass(frozen=True)
class Dispersion:
    """Median (g) and β of a fragility, β of the records and within them; 95 % ranges, None of fewer than ENOUGH.

    `band`: of the probabilities of BAND the 95 % bounds of the level at which they are reached; none without ranges.
    """

    median: float
    beta: float
    beta_record: float
    beta_ensemble: float
    median_range: list[float | None] | None
    beta_range: list[float | None] | None
    band: tuple[tuple[float, float, float], ...] = ()

    @property
    def probable(self) -> tuple[float, float]:
        """Levels of 16 and 84 %."""
        low, _, high = (self.median * math.exp(self.beta * float(ndtri(p))) for p in PROBABILITIES)
        return low, high


def over_records(levels: Sequence[RecordLevel]) -> Dispersion | None:
    """Return the fragility of several records by maximum likelihood; None where all withstood."""
    level = np.array([each.level for each in levels])
    withstood = np.array([each.withstood for each in levels], bool)
    own, fell = np.array([each.beta for each in levels]) ** 2, np.where(withstood, 0.0, 1.0)

    def fitted(weights: Array) -> tuple[Array, ...]:
        fit = fit_levels(level, withstood, weights)
        with np.errstate(invalid="ignore", divide="ignore"):
            within = np.sqrt((weights @ (own * fell)) / (weights @ fell))
        return fit.median, np.hypot(fit.beta, within), fit.beta, within

    return _dispersion(fitted, [each.record for each in levels])


def over_stripes(levels: Sequence[float], shares: Array, records: Sequence[str]) -> Dispersion | None:
    """Return the fragility of the `shares` (n, k) of motions of the `records` (n,) that collapse at k levels.

    None where they determine no median. The β is that of the records: within one of them it is not told apart.
    """

    def fitted(weights: Array) -> tuple[Array, ...]:
        fit = fit_stripes(np.array(levels), shares, weights)
        return fit.median, fit.beta, fit.beta, np.zeros(len(weights))

    return _dispersion(fitted, records)


def _dispersion(fitted: Callable[[Array], tuple[Array, ...]], records: Sequence[str]) -> Dispersion | None:
    """Return what is `fitted` to all observations, each of a record, and the ranges of the bootstrap."""
    if not records:
        return None
    median, beta, beta_record, within = (float(value[0]) for value in fitted(np.ones((1, len(records)))))
    if not (0.0 < median < math.inf and math.isfinite(beta)):
        return None
    weights = samples_of_records(records)
    if weights is None:
        return Dispersion(median, beta, beta_record, within, None, None)
    medians, betas, *_ = fitted(weights)
    band = []
    for p in BAND:
        with np.errstate(all="ignore"):
            low, high = confidence(medians * np.exp(betas * float(ndtri(p))))
        if low is not None and high is not None:
            band.append((p, low, high))
    ranges = confidence(medians), confidence(betas)
    return Dispersion(median, beta, beta_record, within, *ranges, tuple(band))


class Lognormal(NamedTuple):
    """Medians (s,) g and dispersions β (s,) of samples; NaN where a sample does not determine them."""

    median: Array
    beta: Array


def samples_of_records(records: Sequence[str]) -> Array | None:
    """Return weights (s, n) of SAMPLES samples with replacement, from a fixed seed; None of fewer than ENOUGH.

    `records` (n,): of each observation; those of one stay together, being no independent ones.
    """
    names = list(dict.fromkeys(records))
    if (count := len(names)) < ENOUGH:
        return None
    drawn = np.random.default_rng(SEED).multinomial(count, np.full(count, 1.0 / count), SAMPLES)
    return drawn[:, [names.index(record) for record in records]].astype(float)


def fit_levels(level: Array, withstood: Mask, weights: Array) -> Lognormal:
    """Fit levels (n,) of collapse by maximum likelihood, those `withstood` being lower bounds (right-censored).

    Without lower bounds mean and root mean square of the logarithms, with them by expectation-maximisation.
    """
    x = np.log(level)
    total, fell = weights.sum(axis=1), weights @ (~withstood).astype(float)
    with np.errstate(all="ignore"):
        mean = weights @ (x * ~withstood) / fell
        spread = np.sqrt(np.maximum(weights @ (x**2 * ~withstood) / fell - mean**2, 0.0))
    # where all withstood there is no median
    mean, spread = np.where(fell > 0, mean, np.nan), np.where(fell > 0, spread, np.nan)
    some = (weights @ withstood.astype(float) > 0.0) & (fell > 0)
    if some.any():
        own = weights[some], total[some], mean[some], np.maximum(spread[some], WIDE)
        mean[some], spread[some] = _censored(x, withstood, *own)
    spread[spread < 2.0 * NARROWEST] = 0.0  # levels are equal
    return Lognormal(np.exp(mean), spread)


def _censored(
    x: Array, withstood: Mask, weights: Array, total: Array, mean: Array, spread: Array
) -> tuple[Array, Array]:
    for _ in range(ROUNDS):
        z = (x - mean[:, None]) / spread[:, None]
        hazard = np.exp(-0.5 * z**2 - log_ndtr(-z)) / np.sqrt(2.0 * np.pi)
        first = np.where(withstood, mean[:, None] + spread[:, None] * hazard, x)
        beyond = mean[:, None] ** 2 + spread[:, None] ** 2 + spread[:, None] * (x + mean[:, None]) * hazard
        second = np.where(withstood, beyond, x**2)
        new = (weights * first).sum(axis=1) / total
        wide = np.sqrt(np.maximum((weights * second).sum(axis=1) / total - new**2, NARROWEST**2))
        done = np.abs(new - mean).max() + np.abs(wide - spread).max() < SETTLED
        mean, spread = new, wide
        if done:
            break
    return mean, spread


def fit_stripes(levels: Array, collapsed: Array | Mask, weights: Array) -> Lognormal:
    """Fit the collapses (n, k) seen at growing levels (k,): binomial likelihood (Baker 2015, Earthquake Spectra 31(1)).

    With p = Φ(a + b ln level) it has a maximum with b > 0 where the share of collapses grows with ln level, and some
    stand above the lowest level with a collapse (Silvapulle 1981, J. R. Stat. Soc. B 43(3)): median exp(−a/b), β = 1/b.
    Else the limit of ever larger likelihoods counts: collapses parted by a level, β = 0 and the geometric mean of the
    two levels around; all above and none below a level, β → 0 and this level; without collapse the median is ∞, where
    none stands 0. Both are NaN where collapses do not grow with the level, or a share collapses at the only one.
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
    rest = ~(none | all_ | steep) & (fell @ away > UNALIKE * total * (away @ away))
    if rest.any():
        median[rest], beta[rest] = _most_likely(x, fell[rest], stood[rest])
    return Lognormal(median, beta)


def _most_likely(x: Array, fell: Array, stood: Array) -> tuple[Array, Array]:
    """Return medians and β (s,) of the most likely a + b x (k,) by Newton's method; (s, k) `fell` and `stood`."""
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
