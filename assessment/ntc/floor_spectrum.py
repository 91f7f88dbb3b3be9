"""Spectra at height for mechanisms above the ground: Circolare 7/2019, C7.2.3, and Circolare 617/2009, C8A.4.

Each has the interface of `Spectrum`, so that a check takes it in the place of the spectrum at the ground. None is
anywhere below that one: a mechanism at height never bears more than it would at the ground. At the end how a demand
spectrum follows the ground acceleration up to the capacity: S_S, T_D and, with the return period, F0 and T_C* depend on
a_g, so the method must be declared (ζ_E).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import exp, log, sqrt
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from assessment.ntc.hazard import RETURN_PERIODS, HazardCurve
from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from assessment.ntc.tables import Trace, step, worked
from assessment.results.schema.model import Line
from mechanics.errors import is_between, require
from mechanics.messages import Message, message
from mechanics.types import GRAVITY, Array

_LOWER, _UPPER = 0.8, 1.1  # a, b of C7.2.3: bounds of the resonance plateau over T_k
_LAW_2019 = "Circolare 7/2019, C7.2.3"
_LAW_2009 = "Circolare 617/2009, C8A.4.2.3"


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of the building: period (s), participation γ_k, shape ψ_k at the mechanism's height, damping.

    Raises ArgumentError naming the field.
    """

    period: float
    gamma: float
    psi: float
    damping: float = 0.05

    def __post_init__(self) -> None:
        require(self.period > 0.0, "period", self.period, "positive, in s")
        must_be = "a fraction of critical: 0.05 for 5 %"
        require(is_between(self.damping, 0.0, 1.0), "damping", self.damping, must_be)


def fundamental_period(building_height: float) -> Line:
    """Return the step of T_1 = C_1 H^(3/4) (s), C_1 = 0.05, H (m) up to 40 (C7.3.3.2 [k])."""
    T_1 = 0.05 * float(building_height**0.75)
    return step("T_1", "0.05*H**0.75", T_1, "s", "Circolare 7/2019, C7.3.3.2", H=building_height)


def first_mode(
    period: float, storeys: int, height: float, building_height: float, damping: float = 0.05
) -> Mode:
    """Return the first mode (s, m): γ_1 = 3n/(2n+1), ψ_1 = z/H (Circolare 7/2019, C7.2.3). Raises ArgumentError."""
    require(storeys >= 1, "storeys", storeys, "a whole number ≥ 1")
    must_be = "from 0 to the building's height, in m"
    require(is_between(height, 0.0, building_height, "[]"), "height", height, must_be)
    require(building_height > 0.0, "building_height", building_height, "positive, in m")
    return Mode(period, 3.0 * storeys / (2.0 * storeys + 1.0), height / building_height, damping)


@dataclass(frozen=True)
class _OnGround:
    """A demand at height over a spectrum at the ground, which carries the hazard."""

    ground: ElasticSpectrum

    @property
    def ag(self) -> float:
        return self.ground.ag

    @property
    def S(self) -> float:
        return self.ground.S

    def with_damping(self, damping: float) -> Self:
        """Return the demand for an element of another damping (fraction of critical)."""
        return replace(self, ground=self.ground.with_damping(damping))


@dataclass(frozen=True)
class FloorSpectrum(_OnGround):
    """Floor spectrum S_eZ(T, ξ) = √Σ S_eZ,k² ≥ S_e(T, ξ) (Circolare 7/2019, C7.2.5–C7.2.10).

    `ground` carries the hazard and, in its damping, that of the element (ξ); `modes` the first mode first. That ξ_k
    enters A as a fraction and a_Z,k in % is inferred (A = 4.9 at 5 %). The circular writes S_eZ ≥ S_e for T > T_1; here
    it holds at every period [k], since the modes alone vanish towards the ground. Raises ArgumentError without a mode.
    """

    modes: tuple[Mode, ...]

    def __post_init__(self) -> None:
        require(len(self.modes) >= 1, "modes", self.modes, "one mode or more, the first mode first")

    @property
    def T_1(self) -> float:
        """Period of the first mode, s."""
        return self.modes[0].period

    def acceleration(self, T: ArrayLike) -> Array:
        """Return S_eZ(T), g; at T = 0 the largest acceleration of the floor a_Z(z) ≥ a_g S; T (s) of any shape."""
        return np.maximum(self._modes(T), self.ground.acceleration(T))[()]

    def displacement(self, T: ArrayLike) -> Array:
        """Return S_DeZ(T), m: the larger of the modes' S_eZ (T/2π)² and of the ground's S_De(T); T (s) of any shape."""
        T = np.asarray(T, dtype=float)
        modal = self._modes(T) * GRAVITY * (T / (2.0 * np.pi)) ** 2
        return np.maximum(modal, self.ground.displacement(T))[()]

    def largest_displacement(self, T_0: float, T: float) -> tuple[float, float]:
        """Return the demand at T (m) and the period (s) where it is.

        Circolare 7/2019, C8.7.1.2: for T > b T_1 not below the modes' S_eZ(T_1) b² T_1²/4π², the plateau's end; and
        never below the ground's largest displacement over [T_0, T].
        """
        candidates = [(float(self.displacement(T)), T), self.ground.largest_displacement(T_0, T)]
        if self._edge < T:
            plateau_end = float(self._modes(self.T_1)) * GRAVITY * (self._edge / (2.0 * np.pi)) ** 2
            candidates.append((plateau_end, self._edge))
        return max(candidates, key=lambda found: found[0])

    def demand_steps(self, T_0: float, T: float) -> Trace:
        """Return the calculation of largest_displacement(T_0, T) by hand."""
        demand, at = self.largest_displacement(T_0, T)
        if demand == float(self.displacement(T)):
            return self.steps(T)
        if at != self._edge:
            return self.ground.steps(at)
        modal = self._modes_steps(self.T_1)
        formula = f"S_eZ_mod*g*({_UPPER:g}*T_1)**2/(4*pi**2)"
        last = step("S_DeZ", formula, demand, "m", "Circolare 7/2019, C8.7.1.2")
        return worked(*self.ground.steps(self.T_1), *modal, last, g=GRAVITY, T_1=self.T_1)

    def steps(self, T: float) -> Trace:
        """Return S_eZ(T) and S_DeZ(T) by hand."""
        return worked(
            *self.ground.steps(T),
            *self._modes_steps(T),
            step("S_eZ", "max(S_eZ_mod, S_e)", float(self.acceleration(T)), "g", f"{_LAW_2019} (C7.2.5)"),
            step("S_DeZ", "max(S_eZ_mod*g*(T/(2*pi))**2, S_De)", float(self.displacement(T)), "m", _LAW_2019),
            g=GRAVITY,
            T=T,
        )

    @property
    def _edge(self) -> float:
        """End b T_1 of the first mode's plateau, s."""
        return _UPPER * self.T_1

    def _modes(self, T: ArrayLike) -> Array:
        """Return √Σ S_eZ,k²(T), g: the modes without the ground."""
        T = np.asarray(T, dtype=float)
        return np.sqrt(sum(self._modal(mode, T) ** 2 for mode in self.modes))

    def _modes_steps(self, T: float) -> Trace:
        """Return √Σ S_eZ,k²(T) by hand."""
        numbered = list(enumerate(self.modes, 1))
        lines = [line for k, mode in numbered for line in self._modal_steps(k, mode, T)]
        formula = f"sqrt({' + '.join(f'S_eZ_{k}**2' for k, _ in numbered)})"
        return worked(*lines, step("S_eZ_mod", formula, float(self._modes(T)), "g", f"{_LAW_2019} (C7.2.5)"))

    def _peak(self, mode: Mode) -> float:
        """Return a_Z,k (g): largest floor acceleration of a mode."""
        S_e = float(self.ground.with_damping(mode.damping).acceleration(mode.period))
        return S_e * abs(mode.gamma * mode.psi) * sqrt(1.0 + 0.0004 * (100.0 * mode.damping) ** 2)

    def _amplification(self, mode: Mode) -> float:
        """Return A = 1.1 ξ_k^−0.5 η(ξ), not below 1."""
        return max(1.0, 1.1 * self.ground.eta / sqrt(mode.damping))

    def _modal(self, mode: Mode, T: Array) -> Array:
        A, T_k = self._amplification(mode), mode.period
        below = 1.0 + (A - 1.0) * np.maximum(1.0 - T / (_LOWER * T_k), 0.0) ** 1.6
        above = 1.0 + (A - 1.0) * np.maximum(T / (_UPPER * T_k) - 1.0, 0.0) ** 1.2
        return np.asarray(A * self._peak(mode) / (below * above))

    def _modal_steps(self, k: int, mode: Mode, T: float) -> Trace:
        damped = self.ground.with_damping(mode.damping)
        own = {"gamma": mode.gamma, "psi": mode.psi, "xi_k": mode.damping, f"T_{k}": mode.period}
        formula = f"A_{k}*a_Z_{k}"
        if _LOWER * mode.period > T:
            formula += f"/(1 + (A_{k} - 1)*(1 - T/({_LOWER:g}*T_{k}))**1.6)"
        elif _UPPER * mode.period <= T:
            formula += f"/(1 + (A_{k} - 1)*(T/({_UPPER:g}*T_{k}) - 1)**1.2)"
        at_height = float(self._modal(mode, np.asarray(T)))
        peak = "S_ek*abs(gamma*psi)*sqrt(1 + 0.0004*(100*xi_k)**2)"
        return worked(
            _ground_step(damped, "S_e", mode.period).replace(symbol="S_ek"),
            step(f"a_Z_{k}", peak, self._peak(mode), "g", f"{_LAW_2019} (C7.2.7)"),
            step(f"A_{k}", "max(1, 1.1*eta/sqrt(xi_k))", self._amplification(mode), "", f"{_LAW_2019} (C7.2.8)"),
            step(f"S_eZ_{k}", formula, at_height, "g", f"{_LAW_2019} (C7.2.6)"),
            eta=self.ground.eta, T=T, **own,
        )  # fmt: skip


@dataclass(frozen=True)
class FloorSpectrum2009(_OnGround):
    """Demand at height of Circolare 617/2009, C8A.4.2 [k]: the larger of the ground's and of the floor's.

    At the floor S_e(T_1) ψ γ R and S_De(T_1) ψ γ (T/T_1)² R, R = 1/√((1 − T/T_1)² + 0.02 T/T_1).
    """

    mode: Mode

    def acceleration(self, T: ArrayLike) -> Array:
        """Return the larger of S_e(T) and S_e(T_1) ψ γ/√((1 − T/T_1)² + 0.02 T/T_1), g; T in s."""
        floor = self.ground.acceleration(self.mode.period) * self._amplification(T)
        return np.maximum(self.ground.acceleration(T), floor)[()]

    def displacement(self, T: ArrayLike) -> Array:
        """Return the larger of S_De(T) and S_De(T_1) ψ γ (T/T_1)²/√((1 − T/T_1)² + 0.02 T/T_1), m; T in s."""
        ratio = np.asarray(T, dtype=float) / self.mode.period
        floor = self.ground.displacement(self.mode.period) * self._amplification(T) * ratio**2
        return np.maximum(self.ground.displacement(T), floor)[()]

    def largest_displacement(self, T_0: float, T: float) -> tuple[float, float]:
        """Return the demand at T (m) and T, or the ground's largest over [T_0, T] and its period, if that is larger."""
        own = float(self.displacement(T)), T
        return max(own, self.ground.largest_displacement(T_0, T), key=lambda f: f[0])

    def demand_steps(self, T_0: float, T: float) -> Trace:
        """Return the calculation of largest_displacement(T_0, T) by hand."""
        at = self.largest_displacement(T_0, T)[1]
        return self.steps(T) if at == T else self.ground.steps(at)

    def steps(self, T: float) -> Trace:
        """Return the demand at height by hand."""
        T_1 = self.mode.period
        first, second = (_ground_step(self.ground, symbol, T_1) for symbol in ("S_e", "S_De"))
        resonance = "psi*gamma/sqrt((1 - T/T_1)**2 + 0.02*T/T_1)"
        by_displacement = f"max(S_De, S_De_1*(T/T_1)**2*{resonance})"
        return worked(
            *self.ground.steps(T),
            first.replace(symbol="S_e_1"),
            second.replace(symbol="S_De_1"),
            step("S_eZ", f"max(S_e, S_e_1*{resonance})", float(self.acceleration(T)), "g", _LAW_2009),
            step("S_DeZ", by_displacement, float(self.displacement(T)), "m", _LAW_2009),
            psi=self.mode.psi, gamma=self.mode.gamma, T=T, T_1=T_1,
        )  # fmt: skip

    def _amplification(self, T: ArrayLike) -> Array:
        ratio = np.asarray(T, dtype=float) / self.mode.period
        return self.mode.psi * self.mode.gamma / np.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)


def _ground_step(ground: ElasticSpectrum, symbol: str, T: float) -> Line:
    return next(line for line in ground.steps(T) if line.symbol == symbol)


Spectrum = ElasticSpectrum | RecordSpectrum | FloorSpectrum | FloorSpectrum2009
"""What a check takes as the demand."""
Demand = Callable[[Spectrum], float]
_LOW, *_, _HIGH = RETURN_PERIODS.tolist()


def spectrum_at_return_period(
    demand: Demand, capacity: float, spectrum: Spectrum, hazard: HazardCurve
) -> tuple[Spectrum, tuple[Message, ...]]:
    """Return the spectrum of the first return period whose demand is the capacity, and notes.

    demand maps a spectrum to an ordinate in the unit of capacity. Beyond 30–2475 years the spectrum of the
    nearest bound is returned, to be scaled, with a note. Raises ValueError for the spectrum of a record.
    """
    if (ground := ground_of(spectrum)) is None:
        raise ValueError('scaling = "return_period": must be "shape" where the spectrum is that of a record')

    def at(T_R: float) -> Spectrum:
        own = hazard.at(min(max(T_R, _LOW), _HIGH))
        there = replace(ground, ag=own.ag, F0=own.F0, Tc_star=own.Tc_star)
        return replace(spectrum, ground=there) if isinstance(spectrum, _OnGround) else there

    def excess(log_T_R: float) -> float:
        return demand(at(exp(log_T_R))) / capacity - 1.0

    knots = [log(T_R) for T_R in RETURN_PERIODS]
    over = [excess(knot) >= 0.0 for knot in knots]
    if over[0]:
        below = message("capacity below the hazard of 30 years: the shape of that return period is scaled")
        return at(_LOW), (below,)
    if not any(over):
        above = message("capacity above the hazard of 2475 years: the shape of that return period is scaled")
        return at(_HIGH), (above,)
    from scipy.optimize import brentq  # late: few projects need it, and it takes long to import

    k = over.index(True)
    return at(exp(float(brentq(excess, knots[k - 1], knots[k], xtol=1e-14, rtol=1e-14)))), ()


def ground_of(spectrum: Spectrum) -> ElasticSpectrum | None:
    """Return the spectrum at the ground; None for that of a record."""
    found = getattr(spectrum, "ground", spectrum)
    return found if isinstance(found, ElasticSpectrum) else None
