"""Elastic response spectra of records, and artificial records whose spectrum follows a given one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, is_between, require
from mechanics.messages import message
from mechanics.records.record import Record
from mechanics.types import GRAVITY, Array

STEPS_PER_PERIOD = (
    20  # with a parabola through the highest sample: 0.02 % of a sine's peak, 0.2 % under white noise
)
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
    shape: Array = np.cos(0.5 * np.pi * before) ** 2 * np.cos(0.5 * np.pi * after) ** 2
    return shape


def _at_rest(a: Array, intensity: Array, time: Array) -> Array:
    """Subtract a line, shaped in time as the motion is, so that it ends without velocity and displacement."""
    shapes = np.stack([intensity, intensity * time])
    weights = np.full(time.size, time[1])
    weights[[0, -1]] /= 2.0
    end = np.stack([weights, weights * (time[-1] - time)])  # velocity and displacement at the end
    line: Array = np.linalg.solve(end @ shapes.T, end @ a) @ shapes
    return a - line
