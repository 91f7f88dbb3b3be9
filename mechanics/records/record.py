"""Ground motion records: read, scaled, cut, resampled; their response spectra, and records made to follow one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solveh_banded

from mechanics.errors import ConvergenceError, RecordError, is_between, require
from mechanics.messages import message, visible
from mechanics.records.formats import parse_record
from mechanics.types import GRAVITY, Array

HIGHEST_CREDIBLE_PGA = 10.0  # g; beyond it the unit is wrong
LOWEST_PGA = 1e-9  # g; below it nothing moves
QUIET = 0.05  # of the PGA: what rests below 20 times its own activation rests under less
SAME_TIME = 1e-6  # of a time step: times closer than this are one


@dataclass(frozen=True, eq=False)
class Record:
    """Base acceleration (n,) in g, linear between samples `time_step` (s) apart; `name` for reports.

    The first sample is at time 0. `unit`: that of the file it was read from, whose values were converted. Raises
    ArgumentError naming the argument.
    """

    acceleration: Array
    time_step: float
    name: str
    unit: str = "g"

    def __post_init__(self) -> None:
        a = np.array(self.acceleration, dtype=float)
        require(a.ndim == 1 and a.size > 1, "acceleration", a.shape, "two or more samples, (n,), in g")
        require(bool(np.isfinite(a).all()), "acceleration", "nan or inf", "finite")
        require(is_between(self.time_step, 0.0, np.inf), "time_step", self.time_step, "positive, in s")
        a.flags.writeable = False
        object.__setattr__(self, "acceleration", a)

    @property
    def pga(self) -> float:
        """Peak ground acceleration, g."""
        return float(np.abs(self.acceleration).max())

    @property
    def duration(self) -> float:
        """Time of the last sample, s."""
        return (self.acceleration.size - 1) * self.time_step

    @cached_property
    def time(self) -> Array:
        """Times of the samples (n,), s."""
        return self.time_step * np.arange(self.acceleration.size, dtype=float)

    def scaled(self, factor: float) -> Record:
        """Return the record with its accelerations multiplied by `factor`."""
        return replace(self, acceleration=factor * self.acceleration)

    def windowed(self, start: float, end: float) -> Record:
        """Return the samples from `start` to `end` (s, both included), unchanged; ArgumentError where none are."""
        require(
            0.0 <= start < end <= self.duration + SAME_TIME * self.time_step,
            "window",
            (start, end),
            f"within 0 and {self.duration:g} s, the duration of {self.name}, start before end",
        )
        first = int(np.ceil(start / self.time_step - SAME_TIME))
        last = int(np.floor(end / self.time_step + SAME_TIME))
        require(
            last > first, "window", (start, end), f"two or more samples, {self.time_step:g} s apart, long"
        )
        return replace(self, acceleration=self.acceleration[first : last + 1])

    def arias_window(self, low: float = 0.05, high: float = 0.95) -> tuple[float, float]:
        """Find the times (s) where ∫a²dt, by trapezoids, reaches fractions `low` and `high` of its total."""
        require(0.0 <= low < high <= 1.0, "low, high", (low, high), "fractions, low before high")
        require(self.pga > 0.0, "acceleration", 0.0, "other than zero throughout to have a strong part")
        squared = self.acceleration**2
        intensity = np.concatenate([[0.0], np.cumsum(squared[:-1] + squared[1:])])
        start, end = np.interp([low, high], intensity / intensity[-1], self.time)
        return float(start), float(end)

    def strong_window(self) -> tuple[float, float]:
        """Find the times (s) from which the motion is worth following and until which it is strong.

        It begins at 0.1 % of the Arias intensity, or where |a| first reaches 5 % of the PGA if that is earlier; it ends
        at 95 %. From 5 % on a scaled record would lack pulses that set a structure rocking. Raises as arias_window.
        """
        start, end = self.arias_window(1e-3, 0.95)
        first = int(np.argmax(np.abs(self.acceleration) >= QUIET * self.pga))
        return min(start, first * self.time_step), end

    def resampled(self, time_step: float) -> Record:
        """Return the record at another time step (s); a rest shorter than one step is dropped from its end.

        To a smaller step by linear interpolation; to a larger one by the broken line closest to the record in the mean
        square, which keeps velocity and displacement, folds nothing back and undoes a refinement exactly. Its peak may
        differ: scale the record first. Raises ArgumentError for a step that is not positive, or longer than the record.
        """
        require(is_between(time_step, 0.0, np.inf), "time_step", time_step, "positive, in s")
        if abs(time_step - self.time_step) < SAME_TIME * self.time_step:
            return self
        steps = int(np.floor(self.duration / time_step + SAME_TIME))
        require(steps > 0, "time_step", time_step, f"below the duration of {self.name}, {self.duration:g} s")
        if time_step < self.time_step:
            a = np.interp(time_step * np.arange(steps + 1), self.time, self.acceleration)
        else:
            a = self._projected(time_step, steps)
        return replace(self, acceleration=a, time_step=time_step)

    def _projected(self, h: float, steps: int) -> Array:
        """Least-squares broken line on the grid of step h: mass matrix of its hats, times h/6: 1 4 1."""
        time = h * np.arange(steps + 1, dtype=float)
        velocity, displacement = self._integrals(time)
        moments = np.empty(steps + 1)  # ∫ a(t) hat_k(t) dt: by parts, differences of the displacement
        moments[0] = displacement[1] / h
        moments[1:-1] = np.diff(displacement, 2) / h
        moments[-1] = velocity[-1] - (displacement[-1] - displacement[-2]) / h
        mass = np.full((2, steps + 1), h / 6.0)
        mass[0] = 4.0 * h / 6.0
        mass[0, [0, -1]] = 2.0 * h / 6.0
        return solveh_banded(mass, moments, lower=True)

    def _integrals(self, time: Array) -> tuple[Array, Array]:
        """Velocity and displacement at `time` (k,), of the acceleration in its own unit, from rest; exact."""
        a, dt = self.acceleration, self.time_step
        v = np.concatenate([[0.0], np.cumsum(a[:-1] + a[1:])]) * dt / 2.0
        d = np.concatenate([[0.0], np.cumsum(v[:-1] * dt + (2.0 * a[:-1] + a[1:]) * dt**2 / 6.0)])
        k = np.minimum((time / dt + SAME_TIME).astype(int), a.size - 2)
        t = time - k * dt
        slope = (a[k + 1] - a[k]) / dt
        return v[k] + t * (a[k] + t * slope / 2.0), d[k] + t * (v[k] + t * (a[k] / 2.0 + t * slope / 6.0))


def read_record(path: str | Path, time_step: float | None = None) -> Record:
    """Read an accelerogram; accelerations come in g, whatever the unit of the file, and its name is the file's.

    The format is recognised by its content: ESM and ITACA .ASC, PEER .AT2, K-NET (less the mean of the counts), CESMD
    V2 of one channel, five-column ITACA records, and text with columns of times and accelerations, among others that a
    heading names, as in `time [ms], acceleration [m/s²]`, or of accelerations alone, `time_step` (s) apart; without a
    heading in s and g. Raises RecordError naming file, line and remedy, for a peak above 10 g too.
    """
    path = Path(path)
    require(time_step is None or 0.0 < time_step < np.inf, "time_step", time_step, "positive, in s, or None")
    acceleration, step, unit = parse_record(path, time_step)
    record = Record(acceleration, step, path.stem, unit)
    if np.ptp(acceleration) < LOWEST_PGA:
        raise RecordError(
            f"{visible(str(path))}: every sample is {acceleration[0]:g} g; a record must move: get the file again"
        )
    if record.pga > HIGHEST_CREDIBLE_PGA:
        peak = f"peak of {record.pga:.4g} g; the unit is not {unit}: name it in the heading"
        raise RecordError(f"{visible(str(path))}: {peak}")
    return record


# with a parabola through the highest sample: 0.02 % of a sine's peak, 0.2 % under white noise
STEPS_PER_PERIOD = 20
FINEST = 40  # subdivisions of a sampling interval: all that periods down to half of it need


def response_spectrum(
    acceleration_g: ArrayLike, time_step: float, periods: ArrayLike, damping: float = 0.05
) -> tuple[Array, Array]:
    """Pseudo-acceleration S_a (m,), g, and relative displacement S_d (m,), m, at the `periods` (m,), s.

    `acceleration_g` (n,) in g at `time_step` (s); `damping` is a fraction of critical. Exact at the samples for an
    acceleration linear in between (Nigam and Jennings 1969); the free vibration after the record counts, intervals are
    subdivided below twenty samples a period. A period of zero gives the peak. Raises ValueError naming the argument.
    """
    a = np.asarray(acceleration_g, dtype=float)
    T = np.atleast_1d(np.asarray(periods, dtype=float))
    known = a.ndim == 1 and a.size > 1 and bool(np.isfinite(a).all())
    require(known, "acceleration_g", a.shape, "finite, (n,)")
    require(is_between(time_step, 0.0, np.inf), "time_step", time_step, "positive, in s")
    known = T.ndim == 1 and bool((np.isfinite(T) & (T >= 0.0)).all())
    require(known, "periods", periods, "zero or more, in s")
    require(is_between(damping, 0.0, 1.0, "[)"), "damping", damping, "a fraction of critical in [0, 1)")

    S_a, S_d = np.full(T.size, np.abs(a).max()), np.zeros(T.size)
    vibrating = np.flatnonzero(T)
    omega = 2.0 * np.pi / T[vibrating]
    parts = np.ceil(STEPS_PER_PERIOD * time_step / T[vibrating] - 1e-9).clip(1, FINEST).astype(int)
    for m in np.unique(parts):
        group = parts == m
        S_d[vibrating[group]] = _peaks(GRAVITY * a, time_step, int(m), omega[group], damping)
    S_a[vibrating] = omega**2 * S_d[vibrating] / GRAVITY
    return S_a, S_d


def _peaks(a: Array, time_step: float, parts: int, omega: Array, damping: float) -> Array:
    """Largest |u| (m,), m, under base acceleration `a` (n,), m/s², with each interval cut in `parts`."""
    from scipy.signal import lfilter  # late: it takes as long to import as all else that a static run needs

    h = time_step / parts
    rest = int(np.ceil(np.pi / omega.min() / time_step)) + 2  # half a period: the first swing is the largest
    a = np.concatenate([a, np.zeros(rest)])
    if parts > 1:
        a = np.interp(np.arange((a.size - 1) * parts + 1) / parts, np.arange(a.size), a)
    peaks = [_peak(lfilter(b, c, a, zi=a[0] * z)[0]) for b, c, z in _recursion(omega * h, damping)]
    return h**2 * np.array(peaks)


def _recursion(omega_h: Array, damping: float) -> list[tuple[Array, Array, Array]]:
    """Write the exact step as a recursion on the displacement alone, one (b, c, z) per oscillator.

    c₀u(k+2) + c₁u(k+1) + c₂u(k) = b₀a(k+2) + b₁a(k+1) + b₂a(k), time in steps; z is the state of
    scipy.signal.lfilter, per unit of first sample, for which u = u' = 0 there. With λ = ω(−ξ + i√(1−ξ²)) the
    response to an impulse is h(t) = Im e^λt / Im λ, to a step and a ramp of the base −Im φ₁ and −Im φ₂ over
    Im λ, φ₁ = (e^λ − 1)/λ, φ₂ = (φ₁ − 1)/λ, which stay accurate for long periods where real forms cancel.
    """
    pole = omega_h * complex(-damping, np.sqrt(1.0 - damping**2))
    decay, phi1 = np.exp(pole), np.expm1(pole) / pole
    impulse, slope = decay.imag / pole.imag, (pole * decay).imag / pole.imag  # u, u' after a step: A₀₁, A₁₁
    constant, constant_rate = -phi1.imag / pole.imag, -impulse
    ramp, ramp_rate = -((phi1 - 1.0) / pole).imag / pole.imag, constant
    p, p_rate = constant - ramp, constant_rate - ramp_rate  # of a(k) in u(k+1) and u'(k+1); ramp: of a(k+1)
    b1 = p - slope * ramp + impulse * ramp_rate
    b = np.stack([ramp, b1, impulse * p_rate - slope * p], axis=1)
    c = np.stack([np.ones(pole.size), -2.0 * decay.real, np.abs(decay) ** 2], axis=1)
    z = np.stack([-ramp, p - b1], axis=1)
    return list(zip(b, c, z, strict=True))


def _peak(u: Array) -> float:
    """Largest |u| of a smooth sampled curve (n,), by the parabola through the highest sample."""
    k = int(np.abs(u).argmax())
    if k in (0, u.size - 1) or u[k] == 0.0:
        return abs(float(u[k]))
    before, highest, after = np.sign(u[k]) * u[k - 1 : k + 2]
    curvature = 2.0 * highest - before - after
    return float(highest + (after - before) ** 2 / (8.0 * curvature)) if curvature > 0.0 else float(highest)


ATTEMPTS, ITERATIONS = 10, 30  # draws of phases for one seed, corrections of each
LONGEST = 5.0  # s; longer waves would only add drift
SHORTEST = 0.03  # s; shorter waves hardly change a spectrum that tends to the peak acceleration
PERIODS = 640  # from the shortest to the longest, 0.8 % apart: valleys of a record's spectrum are sharp
ENOUGH = 0.75  # of the tolerance: a motion this close is not corrected further
STRONGEST_CORRECTION = 2.0  # of an amplitude in one iteration
FAINT = 0.1  # of the plateau's intensity: below it, corrections may not spread the motion towards the ends


def compatible_record(
    spectrum: Callable[[Array], Array],
    duration: float,
    time_step: float,
    seed: int,
    *,
    plateau: float = 10.0,
    band: tuple[float, float] = (0.15, 2.0),
    tolerance: float = 0.10,
    name: str = "artificial",
) -> Record:
    """Generate a record whose 5 % damped pseudo-acceleration spectrum is within `tolerance` of `spectrum`.

    `spectrum` gives S_a (m,), g, at periods (m,), s, matched over the `band` (s). The amplitude grows to a `plateau`
    (s) and decays after it, a third and two thirds of the remaining time. The base ends at rest and without
    displacement. The same `seed` gives the same record. Random phases get the amplitudes of the spectrum, corrected
    again and again by the ratio of target to computed spectrum (SIMQKE, Gasparini and Vanmarcke 1976); phases that do
    not settle are drawn anew. NTC 2018 §3.2.3.6 [k] wants a plateau of 10 s, 25 s in all. Raises ValueError naming the
    argument, ConvergenceError where no motion comes within the tolerance.
    """
    require(is_between(time_step, 0.0, 0.02, "(]"), "time_step", time_step, "positive and at most 0.02 s")
    require(is_between(duration, 5.0, np.inf, "[)"), "duration", duration, "at least 5 s")
    require(
        is_between(plateau, 0.0, duration, "(]"),
        "plateau",
        plateau,
        "positive and at most the duration, in s",
    )
    require(SHORTEST <= band[0] < band[1] <= LONGEST, "band", band, f"within {SHORTEST} and {LONGEST} s")
    require(is_between(tolerance, 0.0, 1.0), "tolerance", tolerance, "a fraction below 1")
    periods = np.geomspace(SHORTEST, LONGEST, PERIODS)
    target = np.asarray(spectrum(periods), dtype=float)
    fine = target.shape == periods.shape and bool((np.isfinite(target) & (target > 0.0)).all())
    require(fine, "spectrum", target, "a positive acceleration in g for each period")
    time = time_step * np.arange(round(duration / time_step) + 1, dtype=float)
    intensity = _intensity(time, plateau)
    spacing = periods[1] / periods[0]  # the first periods outside the band count too: no gap at its ends
    matched = (periods > band[0] / spacing) & (periods < band[1] * spacing)
    frequency = np.fft.rfftfreq(time.size, time_step)
    passed = (frequency > 1.0 / LONGEST) & (frequency < 1.0 / SHORTEST)
    period = 1.0 / frequency.clip(1.0 / LONGEST, 1.0 / SHORTEST)
    amplitude = passed * np.interp(period, periods, target) * np.sqrt(period)
    random = np.random.default_rng(seed)
    for _ in range(ATTEMPTS):
        phase = random.uniform(0.0, 2.0 * np.pi, frequency.size)
        motion = intensity * np.fft.irfft(amplitude * np.exp(1j * phase), time.size)
        best, error = motion, np.inf
        for _ in range(ITERATIONS):
            motion = _at_rest(motion, intensity, time)
            ratio = response_spectrum(motion, time_step, periods)[0] / target
            level = 0.5 * float(ratio[matched].min() + ratio[matched].max())
            motion, ratio = motion / level, ratio / level  # as far above the target as below it
            worst = float(np.abs(ratio[matched] - 1.0).max())
            if worst < error:
                best, error = motion, worst
            if error < ENOUGH * tolerance:
                break
            correction = 1.0 / ratio.clip(1.0 / STRONGEST_CORRECTION, STRONGEST_CORRECTION)
            motion = np.fft.irfft(np.fft.rfft(motion) * np.interp(period, periods, correction), time.size)
            motion *= np.minimum(intensity / FAINT, 1.0)
        if error <= tolerance:
            return Record(best, time_step, name)
    missed = message(
        "seed = {seed}: the last motion is within {error:.1%} of the spectrum, not {tolerance:.1%}; "
        "try another seed, a longer plateau or a wider tolerance",
        seed=seed,
        error=error,
        tolerance=tolerance,
    )
    raise ConvergenceError(missed)


def _intensity(time: Array, plateau: float) -> Array:
    """Shape in time (n,): cosine rise, plateau of one, cosine decay."""
    rise = (time[-1] - plateau) / 3.0
    if rise < time[1]:
        return np.ones(time.size)
    before = (rise - time).clip(0.0) / rise
    after = (time - rise - plateau).clip(0.0) / (2.0 * rise)
    return np.cos(0.5 * np.pi * before) ** 2 * np.cos(0.5 * np.pi * after) ** 2


def _at_rest(a: Array, intensity: Array, time: Array) -> Array:
    """Subtract a line, shaped in time as the motion is, so that it ends without velocity and displacement."""
    shapes = np.stack([intensity, intensity * time])
    weights = np.full(time.size, time[1])
    weights[[0, -1]] /= 2.0
    end = np.stack([weights, weights * (time[-1] - time)])  # velocity and displacement at the end
    line: Array = np.linalg.solve(end @ shapes.T, end @ a) @ shapes
    return a - line
