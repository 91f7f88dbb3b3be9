"""Elastic response spectra: of NTC 2018 (§3.2.3.2) and of a recorded ground motion, with one interface.

`ag` in g, to which every ordinate is proportional when the shape is kept; `S` between a_g and the acceleration at the
surface; S_e in g and S_De in m over periods (s) of any shape.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from assessment.ntc.tables import Trace, datum, step, worked
from mechanics.errors import is_between, require, require_positive
from mechanics.records import response_spectrum
from mechanics.types import GRAVITY, Array

# Tab. 3.2.IV: S_S = upper ≥ first − slope F0 a_g ≥ lower, C_C = factor T_C*^exponent
_STRATIGRAPHY = {  # soil: (lower, first, slope, upper)
    "A": (1.0, 1.0, 0.0, 1.0),
    "B": (1.0, 1.4, 0.4, 1.2),
    "C": (1.0, 1.7, 0.6, 1.5),
    "D": (0.9, 2.4, 1.5, 1.8),
    "E": (1.0, 2.0, 1.1, 1.6),
}
_PERIOD_FACTOR = {
    "A": (1.0, 0.0), "B": (1.10, -0.20), "C": (1.05, -0.33), "D": (1.25, -0.50), "E": (1.15, -0.40),
}  # fmt: skip
_TOPOGRAPHY = {"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4}  # Tab. 3.2.V
_LONG_PERIOD = {"A": 4.5, "B": 5.0, "C": 6.0, "D": 6.0, "E": 6.0}  # T_E, s, Tab. 3.2.VII [k]
_FRACTION = "a fraction of critical: 0.05 for 5 %"
_T_F = 10.0  # s, Tab. 3.2.VII [k]


@dataclass(frozen=True)
class ElasticSpectrum:
    """Elastic horizontal spectrum of NTC 2018, §3.2.3.2.1 (acceleration) and §3.2.3.2.3 (displacement).

    ag in g, Tc_star in s, soil A–E, topography T1–T4, damping as a fraction of critical. The coefficients
    S_S, C_C and S_T are those of Tab. 3.2.IV–V; the branches, T_D and the displacement branch above T_E
    are not compared with the text [k]. Raises ValueError naming the argument.
    """

    ag: float
    F0: float
    Tc_star: float
    soil: str = "A"
    topography: str = "T1"
    damping: float = 0.05

    def __post_init__(self) -> None:
        require_positive(self, ag="positive, in g", F0="positive", Tc_star="positive, in s")
        require(self.soil in list(_STRATIGRAPHY), "soil", self.soil, "one of A, B, C, D, E")
        require(self.topography in list(_TOPOGRAPHY), "topography", self.topography, "one of T1, T2, T3, T4")
        require(is_between(self.damping, 0.0, 1.0, "[)"), "damping", self.damping, _FRACTION)

    @property
    def S_S(self) -> float:
        """Stratigraphic amplification, Tab. 3.2.IV."""
        lower, first, slope, upper = _STRATIGRAPHY[self.soil]
        return min(upper, max(lower, first - slope * self.F0 * self.ag))

    @property
    def S_T(self) -> float:
        """Topographic amplification, Tab. 3.2.V."""
        return _TOPOGRAPHY[self.topography]

    @property
    def S(self) -> float:
        """S = S_S S_T."""
        return self.S_S * self.S_T

    @property
    def C_C(self) -> float:
        """Period factor, Tab. 3.2.IV."""
        factor, exponent = _PERIOD_FACTOR[self.soil]
        return factor * float(self.Tc_star**exponent)

    @property
    def eta(self) -> float:
        """Damping correction η = √(10/(5+ξ)) ≥ 0.55, ξ in %."""
        return max(0.55, sqrt(10.0 / (5.0 + 100.0 * self.damping)))

    @property
    def T_C(self) -> float:
        """Start of the constant-velocity branch, s."""
        return self.C_C * self.Tc_star

    @property
    def T_B(self) -> float:
        """Start of the plateau, s."""
        return self.T_C / 3.0

    @property
    def T_D(self) -> float:
        """Start of the constant-displacement branch, s."""
        return 4.0 * self.ag + 1.6

    @property
    def T_E(self) -> float:
        """End of the constant-displacement branch, s [k]."""
        return _LONG_PERIOD[self.soil]

    @property
    def ground_displacement(self) -> float:
        """d_g = 0.025 a_g S T_C T_D, m (§3.2.3.3) [k]."""
        return 0.025 * self.ag * GRAVITY * self.S * self.T_C * self.T_D

    def acceleration(self, T: ArrayLike) -> Array:
        """S_e(T), g, for periods T (s) of any shape."""
        T = _periods(T)
        T_B, T_C, T_D = self.T_B, self.T_C, self.T_D
        rise = T / T_B + (1.0 - T / T_B) / (self.eta * self.F0)
        positive = np.maximum(T, T_B)
        fall = np.select([T < T_B, T < T_C, T < T_D], [rise, 1.0, T_C / positive], T_C * T_D / positive**2)
        return (self.ag * self.S * self.eta * self.F0 * fall)[()]

    def displacement(self, T: ArrayLike) -> Array:
        """S_De(T) = S_e(T) (T/2π)² up to T_E, then falling to d_g at T_F = 10 s (§3.2.3.2.3), m."""
        T = _periods(T)
        share = np.clip((T - self.T_E) / (_T_F - self.T_E), 0.0, 1.0)
        amplified = self.F0 * self.eta
        long = self.ground_displacement * (amplified + (1.0 - amplified) * share)
        short = self.acceleration(T) * GRAVITY * (T / (2.0 * np.pi)) ** 2
        return np.where(self.T_E < T, long, short)[()]

    def largest_displacement(self, T_0: float, T: float) -> tuple[float, float]:
        """Return max S_De over [T_0, T] (m) and its period (s): at T, or at T_E where T lies beyond it."""
        at = np.array([T, min(max(self.T_E, T_0), T), min(T_0, T)])
        return largest_at(self, at)

    def with_damping(self, damping: float) -> Self:
        """Return the spectrum at another damping (fraction of critical)."""
        return replace(self, damping=damping)

    def demand_steps(self, T_0: float, T: float) -> Trace:
        """Return the calculation of largest_displacement(T_0, T) by hand."""
        return self.steps(self.largest_displacement(T_0, T)[1])

    def steps(self, T: float) -> Trace:
        """Return how S_e(T) and S_De(T) follow from a_g, F0, T_C*, soil and topography."""
        known = {"T": T, "g": GRAVITY, "T_E": self.T_E, "T_F": _T_F}
        return worked(*self.parameter_steps(), *self._ordinates(T), **known)

    def parameter_steps(self) -> Trace:
        """Return the parameters of the spectrum by hand."""
        low, first, slope, high = _STRATIGRAPHY[self.soil]
        factor, exponent = _PERIOD_FACTOR[self.soil]
        table = f"NTC 2018, Tab. 3.2.IV, {self.soil}"
        law = "NTC 2018, §3.2.3.2.1"
        return worked(
            datum("a_g", self.ag, "g", "NTC 2018, §3.2"),
            datum("F_0", self.F0, "", "NTC 2018, §3.2"),
            datum("T_C_star", self.Tc_star, "s", "NTC 2018, §3.2"),
            step("S_S", f"min({high:g}, max({low:g}, {first:g} - {slope:g}*F_0*a_g))", self.S_S, "", table),
            datum("S_T", self.S_T, "", f"NTC 2018, Tab. 3.2.V, {self.topography}"),
            step("S", "S_S*S_T", self.S, "", "NTC 2018, eq. 3.2.3"),
            step("C_C", f"{factor:g}*T_C_star**({exponent:g})", self.C_C, "", table),
            step("T_C", "C_C*T_C_star", self.T_C, "s", law),
            step("T_B", "T_C/3", self.T_B, "s", law),
            step("T_D", "4*a_g + 1.6", self.T_D, "s", law),
            step("eta", "max(0.55, sqrt(10/(5 + 100*xi)))", self.eta, "", law),
            xi=self.damping,
        )

    def _ordinates(self, T: float) -> Trace:
        S_e, S_De, law = float(self.acceleration(T)), float(self.displacement(T)), "NTC 2018, §3.2.3.2.3"
        formula = "a_g*S*eta*F_0"
        if self.T_B > T:
            formula += "*(T/T_B + (1 - T/T_B)/(eta*F_0))"
        elif self.T_C <= T < self.T_D:
            formula += "*T_C/T"
        elif self.T_D <= T:
            formula += "*T_C*T_D/T**2"
        first = step("S_e", formula, S_e, "g", "NTC 2018, §3.2.3.2.1")
        if self.T_E >= T:
            return first, step("S_De", "S_e*g*(T/(2*pi))**2", S_De, "m", law)
        long = "d_g*(F_0*eta + (1 - F_0*eta)*(min(T, T_F) - T_E)/(T_F - T_E))"
        d_g = step("d_g", "0.025*a_g*g*S*T_C*T_D", self.ground_displacement, "m", "NTC 2018, §3.2.3.3")
        return first, d_g, step("S_De", long, S_De, "m", law)


@dataclass(frozen=True, eq=False)
class RecordSpectrum:
    """Elastic response spectrum of a record: `acceleration_g` (n,) in g at steps of `time_step` (s).

    The ordinates are those of `mechanics.records.response_spectrum`. Raises ValueError naming the argument.
    """

    acceleration_g: ArrayLike
    time_step: float
    damping: float = 0.05

    def __post_init__(self) -> None:
        a = np.array(self.acceleration_g, dtype=float)
        fine = a.ndim == 1 and a.size >= 2 and bool(np.isfinite(a).all()) and bool(a.any())
        require(fine, "acceleration_g", a.shape, "two or more finite values, in g, not all zero")
        require_positive(self, time_step="positive, in s")
        require(is_between(self.damping, 0.0, 1.0, "[)"), "damping", self.damping, _FRACTION)
        a.flags.writeable = False
        object.__setattr__(self, "acceleration_g", a)

    @cached_property
    def ag(self) -> float:
        """Peak ground acceleration, g."""
        return float(np.abs(self.acceleration_g).max())

    @property
    def S(self) -> float:
        """1: a record is already that of its own ground."""
        return 1.0

    def acceleration(self, T: ArrayLike) -> Array:
        """Pseudo-acceleration S_e(T) = (2π/T)² S_De(T), g; at T = 0 the peak ground acceleration."""
        return self._ordinates(T)[0]

    def displacement(self, T: ArrayLike) -> Array:
        """S_De(T), m: the largest relative displacement of the oscillator; 0 at T = 0."""
        return self._ordinates(T)[1]

    def largest_displacement(self, T_0: float, T: float) -> tuple[float, float]:
        """Return max S_De over [T_0 or T/100, T] (m) and its period (s), at 200 periods in geometric progression."""
        at = np.geomspace(min(max(T_0, T / 100.0), T), T, 200)
        return largest_at(self, at)

    def with_damping(self, damping: float) -> Self:
        """Return the spectrum of the same record at another damping (fraction of critical)."""
        return replace(self, damping=damping)

    def demand_steps(self, T_0: float, T: float) -> Trace:
        """Return the ordinates of the record at the period of the largest displacement in [T_0, T]."""
        return self.steps(self.largest_displacement(T_0, T)[1])

    def steps(self, T: float) -> Trace:
        """Return the ordinates at T: S_e is a datum (time integration), S_De follows from it."""
        S_e, S_De = float(self.acceleration(T)), float(self.displacement(T))
        return worked(
            datum("PGA", self.ag, "g", "record"),
            datum("T", T, "s", "record: period looked at"),
            datum("xi", self.damping, "", "record: damping"),
            datum("S_e", S_e, "g", "record: exact integration of the oscillator"),
            step("S_De", "S_e*g*(T/(2*pi))**2", S_De, "m", "NTC 2018, §3.2.3.2.3"),
            g=GRAVITY,
        )

    def _ordinates(self, T: ArrayLike) -> tuple[Array, Array]:
        """Return S_e(T), g, and S_De(T), m, for periods T (s) of any shape."""
        T = _periods(T)
        shaking = np.asarray(self.acceleration_g)
        S_e, S_De = response_spectrum(shaking, self.time_step, T.ravel(), self.damping)
        return S_e.reshape(T.shape)[()], S_De.reshape(T.shape)[()]


def largest_at(spectrum: ElasticSpectrum | RecordSpectrum, periods: Array) -> tuple[float, float]:
    """Return the largest S_De at the periods (k,) s, in m, and the first period that has it, s."""
    ordinates = spectrum.displacement(periods)
    k = int(np.argmax(ordinates))
    return float(ordinates[k]), float(periods[k])


def _periods(T: ArrayLike) -> Array:
    periods = np.asarray(T, dtype=float)
    require(bool((periods >= 0.0).all()), "T", T, "zero or positive, in s")
    return periods
