"""Elastic response spectra of a base acceleration that is linear between its samples.

SciPy's filter does the recursion; its coefficients, exact for such an acceleration at any time step, are computed here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import require
from mechanics.types import GRAVITY, Array

STEPS_PER_PERIOD = (
    20  # with a parabola through the highest sample: 0.02 % of a sine's peak, 0.2 % under white noise
)
FINEST = 40  # subdivisions of a sampling interval: all that periods down to half of it need


def response_spectrum(
    acceleration_g: ArrayLike, time_step: float, periods: ArrayLike, damping: float = 0.05
) -> tuple[Array, Array]:
    """Pseudo-acceleration S_a (m,), g, and relative displacement S_d (m,), m, at the `periods` (m,), s.

    `acceleration_g` (n,) in g at `time_step` (s); `damping` is a fraction of critical. The oscillators start
    at rest with the first sample and their response at the samples is exact for an acceleration linear in
    between (Nigam and Jennings 1969). The base stops with the record (its acceleration falls to zero in one
    further step) and the free vibration that follows counts, so that a short pulse gets its full spectrum.
    Where a period spans fewer than twenty samples the intervals are subdivided. A period of zero gives the
    peak acceleration. Raises ValueError naming the argument.
    """
    a = np.asarray(acceleration_g, dtype=float)
    T = np.atleast_1d(np.asarray(periods, dtype=float))
    require(
        a.ndim == 1 and a.size > 1 and bool(np.isfinite(a).all()), "acceleration_g", a.shape, "finite, (n,)"
    )
    require(0.0 < time_step < np.inf, "time_step", time_step, "positive, in s")
    require(
        T.ndim == 1 and bool((np.isfinite(T) & (T >= 0.0)).all()), "periods", periods, "zero or more, in s"
    )
    require(0.0 <= damping < 1.0, "damping", damping, "a fraction of critical in [0, 1)")

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
