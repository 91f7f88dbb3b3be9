"""Capacity of a mechanism: participation e*, Γ* and the capacity curve a*(d*).

Circolare 7/2019, C8.7.1.2; Portioli et al., §7.1.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from assessment.ntc.curve_fit import CapacityError, CurveFit
from assessment.ntc.tables import CONFIDENCE_FACTOR, Trace, datum, step, worked
from mechanics import Assembly
from mechanics.errors import is_between, require
from mechanics.messages import message
from mechanics.types import GRAVITY, Array

_LAW = "Circolare 7/2019, C8.7.1.2"
AGAINST = 0.1  # of ΣP|δ|: the most that may move against the rest; e* tends to zero, Γ* and a* to infinity at a half


@dataclass(frozen=True, slots=True)
class Participation:
    """e* and Γ* of a mechanism, with the sums they come from: weights P in kN, displacements as δ/δ_C."""

    e_star: float
    gamma_star: float
    weight: float
    first_moment: float
    second_moment: float

    @classmethod
    def of(cls, weight: float, first: float, second: float) -> Self:
        """Return e* = (ΣPδ)²/(ΣP ΣPδ²) and Γ* = ΣPδ²/ΣPδ of ΣP, ΣPδ and ΣPδ²."""
        return cls(first**2 / (weight * second), second / first, weight, first, second)

    def steps(self) -> Trace:
        """Return e* and Γ* by hand from the three sums over the moving weights, with δ_C = 1."""
        sums = "sum over the weights that move, δ_C = 1"
        return worked(
            datum("Sigma_P", self.weight, "kN", sums),
            datum("Sigma_P_delta", self.first_moment, "kN", sums),
            datum("Sigma_P_delta_2", self.second_moment, "kN", sums),
            step("e_star", "Sigma_P_delta**2/(Sigma_P*Sigma_P_delta_2)", self.e_star, "", _LAW),
            step("Gamma_star", "Sigma_P_delta_2/Sigma_P_delta", self.gamma_star, "", _LAW),
        )


def participation(
    weights: ArrayLike, dx: ArrayLike, control_dx: float, moving: ArrayLike | None = None, still: float = 1e-6
) -> Participation:
    """Return e* = (ΣPδ)²/(ΣP ΣPδ²) and Γ* = ΣPδ²/(δ_C ΣPδ) of a mechanism (Circolare C8.7.1.2; paper §7.1).

    weights (b,), kN, with the loads of the blocks; dx (b,), control_dx: virtual horizontal displacements in a common
    unit. Of blocks that stay still none counts in ΣP: `moving` (b,) says which move, by default those with |dx| > still
    · max|dx|. Raises CapacityError where nothing moves, or not the control point, or it or weights against the rest.
    """
    P, delta = np.asarray(weights, dtype=float), np.asarray(dx, dtype=float)
    require(P.ndim == 1 and P.shape == delta.shape, "dx", delta.shape, f"one value per weight: {P.shape}")
    require(bool((P >= 0.0).all()), "weights", P.min(initial=0.0), "zero or positive, in kN")
    largest = np.abs(delta).max(initial=0.0)
    takes_part = np.abs(delta) > still * largest if moving is None else np.asarray(moving, dtype=bool)
    P, delta = P[takes_part], delta[takes_part]
    ahead, back = (float(P @ np.maximum(way * delta, 0.0)) for way in (1.0, -1.0))
    if ahead + back == 0.0:
        raise CapacityError(message("e*, Γ*: no weight moves horizontally in the mechanism"))
    if (share := min(ahead, back) / (ahead + back)) > AGAINST:  # whatever the control point
        raise CapacityError(message("e*, Γ*: {share:.0f} % of ΣP|δ| goes against the rest: parts rock against each "
                                    "other, no single oscillator stands for them", share=100.0 * share))  # fmt: skip
    if abs(control_dx) <= still * largest:
        raise CapacityError(message("Γ*: the control point does not move horizontally; choose one on a block of the "
                                    "mechanism"))  # fmt: skip
    weight, first, second = float(P.sum()), (ahead - back) / control_dx, float(P @ (delta / control_dx) ** 2)
    if first <= 0.0:
        raise CapacityError(message("Γ*: the control point moves against the moving weights; choose one that moves "
                                    "with the mechanism"))  # fmt: skip
    return Participation.of(weight, first, second)


def mechanism_participation(model: Assembly, mechanism: Array, control_dx: float) -> Participation:
    """Return e* and Γ* of virtual displacements (b, 3), with the seismic mass that each moving block carries."""
    weights = np.array([block.mass * GRAVITY for block in model.blocks])
    return participation(weights, mechanism[:, 0], control_dx, model.taking_part(mechanism))


def mass_share(model: Assembly, mechanism: Array) -> float:
    """Return e* of virtual displacements (b, 3), which does not depend on a control point. Raises CapacityError."""
    along = float(model.lateral_load("+x")[:, 0] @ mechanism[:, 0])
    return mechanism_participation(model, mechanism, float(np.copysign(abs(mechanism).max(), along))).e_star


@dataclass(frozen=True)
class Activation:
    """The onset of motion that a linear check asks for: multiplier α and e* of the first mechanism; its `source`."""

    alpha: float
    e_star: float
    source: str = "limit analysis in the configuration of the state"


@dataclass(frozen=True, eq=False)
class CapacityCurve:
    """Capacity of the equivalent oscillator: a* (k,) in g over d* (k,) in m, with the fit it comes from.

    a* = α/(e* F_C) (in g), d* = d Γ*; the confidence factor is applied here alone. `confidence_source`: the
    paragraph that F_C follows from. `activation`: what activates the first mechanism.
    """

    fit: CurveFit
    e_star: float
    gamma_star: float
    confidence_factor: float
    confidence_source: str
    activation: Activation

    @cached_property
    def displacement(self) -> Array:
        """d* (k,), m."""
        return self.fit.displacement * self.gamma_star

    @cached_property
    def acceleration(self) -> Array:
        """a* (k,), g."""
        return self.fit.multiplier / (self.e_star * self.confidence_factor)

    @property
    def a_0_star(self) -> float:
        """Acceleration that activates the first mechanism, g."""
        return self.activation.alpha / (self.activation.e_star * self.confidence_factor)

    @property
    def a_y_star(self) -> float | None:
        """Acceleration at the end of the elastic branch, g."""
        return None if self.fit.alpha_y is None else self.fit.alpha_y / (self.e_star * self.confidence_factor)

    @property
    def d_y_star(self) -> float | None:
        """Displacement at the end of the elastic branch, m."""
        return None if self.fit.d_y is None else self.fit.d_y * self.gamma_star

    @property
    def d_0_star(self) -> float | None:
        """Displacement where the capacity vanishes, m."""
        return None if self.fit.d_0 is None else self.fit.d_0 * self.gamma_star

    @property
    def T_0(self) -> float | None:
        """Period of the elastic branch, T_0 = 2π √(d_y*/a_y*), s; None where the curve is rigid."""
        if self.d_y_star is None or self.a_y_star is None:
            return None
        return 2.0 * pi * sqrt(self.d_y_star / (self.a_y_star * GRAVITY))

    def a_star(self, d_star: float) -> float:
        """Return a* (g) at d* (m) on the curve."""
        return float(np.interp(d_star, self.displacement, self.acceleration))

    def steps(self) -> Trace:
        """Return α0*, a_y*, T_0 and d_0* by hand."""
        fit, first, F_C = self.fit, self.activation, self.confidence_factor
        e, Gamma = self.e_star, self.gamma_star
        own = first.e_star == e  # of the mechanism of the curve, or of another one that moves before
        alpha, e_act = ("alpha_0", "e_star") if own else ("alpha_act", "e_star_act")
        lines = [
            datum("e_star", e, "", _LAW),
            datum("Gamma_star", Gamma, "", _LAW),
            datum("F_C", F_C, "", self.confidence_source),
            datum(alpha, first.alpha, "", first.source),
            *([] if own else [datum(e_act, first.e_star, "", first.source)]),
            step("a_0_star", f"{alpha}/({e_act}*F_C)", self.a_0_star, "g", _LAW),
        ]
        if fit.d_0 is not None and self.d_0_star is not None:
            why = "equilibrium lost before α = 0" if fit.drops else "α = 0"
            lines += [
                datum("d_0", fit.d_0, "m", f"{fit.source}: {why}"),
                step("d_0_star", "d_0*Gamma_star", self.d_0_star, "m", _LAW),
            ]
        if fit.alpha_y is not None and fit.d_y is not None:
            source = f"{_LAW}; Portioli et al., §7.1"
            lines += [
                *fit.steps,
                step("a_y_star", "alpha_y/(e_star*F_C)", fit.alpha_y / (e * F_C), "g", _LAW),
                step("d_y_star", "d_y*Gamma_star", fit.d_y * Gamma, "m", _LAW),
                step("T_0", "2*pi*sqrt(d_y_star/(a_y_star*g))", self.T_0 or 0.0, "s", source),
            ]
        return worked(*lines, g=GRAVITY)


def capacity_curve(
    fit: CurveFit, e_star: float, gamma_star: float, confidence_factor: float = 1.0,
    confidence_source: str = CONFIDENCE_FACTOR, activation: Activation | None = None,
) -> CapacityCurve:  # fmt: skip
    """Return the capacity curve d* = d Γ*, a* = α/(e* F_C): the confidence factor divides once, here.

    `confidence_source`: the paragraph that F_C follows from; `activation`: default, the curve's own mechanism at α0.
    Raises ValueError naming the argument.
    """
    activation, F_C = activation or Activation(fit.alpha_0, e_star, fit.source), confidence_factor
    for name, share in (("e_star", e_star), ("activation.e_star", activation.e_star)):
        require(is_between(share, 0.0, 1.0 + 1e-9, "(]"), name, share, "above 0 and at most 1")
    require(is_between(gamma_star, 0.0, np.inf), "gamma_star", gamma_star, "positive")
    require(is_between(F_C, 1.0, np.inf, "[)"), "confidence_factor", F_C, "1 or more (1.35, 1.20, 1)")
    return CapacityCurve(fit, e_star, gamma_star, confidence_factor, confidence_source, activation)
