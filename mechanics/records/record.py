"""Ground motion records: read, scale, cut, resample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.linalg import solveh_banded

from mechanics.errors import RecordError, is_between, require
from mechanics.messages import visible
from mechanics.records.formats import parse_record
from mechanics.types import Array

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

    def compressed(self, time_factor: float) -> Record:
        """Return the same accelerations `time_factor` times as fast: √10 for a model at 1:10 (similitude)."""
        require(is_between(time_factor, 0.0, np.inf), "time_factor", time_factor, "positive")
        return replace(self, time_step=self.time_step / time_factor)

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
