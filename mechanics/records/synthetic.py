"""Artificial records whose response spectrum follows a given one, such as the NTC elastic spectrum."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mechanics.errors import ConvergenceError, require
from mechanics.messages import Message, message
from mechanics.records.record import Record
from mechanics.records.response_spectrum import response_spectrum
from mechanics.types import Array

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

    `spectrum` gives S_a (m,), g, at periods (m,), s; it is matched over the `band` of periods (s). The
    amplitude grows to a `plateau` (s) of constant intensity and decays after it, a third and two thirds of
    the remaining time; plateau = duration makes a stationary record. The base ends at rest and without
    displacement. The same `seed` gives the same record. NTC 2018 §3.2.3.6 [k] wants a
    plateau of 10 s or more, 25 s or more in all, and the mean of the records at no period more than 10 % below the
    spectrum for 0.15-2 s (or 0.15 s to twice the structure's period).

    Random phases are given the amplitudes of the spectrum and a shape in time; the amplitudes are corrected
    by the ratio of target to computed spectrum, again and again (as SIMQKE, Gasparini and Vanmarcke 1976).
    Phases that do not settle are drawn anew. Raises ValueError naming the argument, ConvergenceError where
    no motion comes within the tolerance.
    """
    require(0.0 < time_step <= 0.02, "time_step", time_step, "positive and at most 0.02 s")
    require(5.0 <= duration < np.inf, "duration", duration, "at least 5 s")
    require(0.0 < plateau <= duration, "plateau", plateau, "positive and at most the duration, in s")
    require(SHORTEST <= band[0] < band[1] <= LONGEST, "band", band, f"within {SHORTEST} and {LONGEST} s")
    require(0.0 < tolerance < 1.0, "tolerance", tolerance, "a fraction below 1")
    periods = np.geomspace(SHORTEST, LONGEST, PERIODS)
    target = np.asarray(spectrum(periods), dtype=float)
    require(
        target.shape == periods.shape and bool((np.isfinite(target) & (target > 0.0)).all()),
        "spectrum",
        target,
        "a positive acceleration in g for each period",
    )
    time = time_step * np.arange(round(duration / time_step) + 1, dtype=float)
    intensity = _intensity(time, plateau)
    spacing = periods[1] / periods[0]  # the first periods outside the band count too: no gap at its ends
    matched = (periods > band[0] / spacing) & (periods < band[1] * spacing)
    random = np.random.default_rng(seed)
    error = np.inf
    for _ in range(ATTEMPTS):
        motion, error = _matched(
            random,
            time=time,
            intensity=intensity,
            periods=periods,
            target=target,
            matched=matched,
            tolerance=tolerance,
        )
        if error <= tolerance:
            return Record(motion, time_step, name)
    raise ConvergenceError(_missed(seed, error, tolerance))


def _missed(seed: int, error: float, tolerance: float) -> Message:
    return message(
        "seed = {seed}: the last motion is within {error:.1%} of the spectrum, not {tolerance:.1%}; "
        "try another seed, a longer plateau or a wider tolerance",
        seed=seed,
        error=error,
        tolerance=tolerance,
    )


def _matched(
    random: np.random.Generator,
    *,
    time: Array,
    intensity: Array,
    periods: Array,
    target: Array,
    matched: NDArray[np.bool_],
    tolerance: float,
) -> tuple[Array, float]:
    """Correct one draw of phases: the best motion (n,), g, and its largest relative error where `matched`."""
    frequency = np.fft.rfftfreq(time.size, time[1])
    passed = (frequency > 1.0 / LONGEST) & (frequency < 1.0 / SHORTEST)
    period = 1.0 / frequency.clip(1.0 / LONGEST, 1.0 / SHORTEST)
    phase = random.uniform(0.0, 2.0 * np.pi, frequency.size)
    amplitude = passed * np.interp(period, periods, target) * np.sqrt(period)
    motion = intensity * np.fft.irfft(amplitude * np.exp(1j * phase), time.size)

    best, error = motion, np.inf
    for _ in range(ITERATIONS):
        motion = _at_rest(motion, intensity, time)
        ratio = response_spectrum(motion, float(time[1]), periods)[0] / target
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
    return best, error


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
