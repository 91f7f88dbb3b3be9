"""Capacity of a mechanism: idealised pushover curves, participation e*, Γ*, the capacity curve a*(d*).

The rigid branch with, or without, an elastic branch before it: Portioli et al., §7.1 (trilinear); NTC 2018, C7.3.4.2
(equal area); Circolare 7/2019, C8.7.1.2.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from math import pi, sqrt
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from assessment.ntc.tables import CONFIDENCE_FACTOR, Trace, datum, step, worked
from assessment.results.schema.model import Line
from mechanics import Assembly
from mechanics.errors import is_between, require
from mechanics.messages import Message, SaidError, message
from mechanics.types import GRAVITY, Array

SWAY = 0.01  # of the displacement at the peak: as hinges of a settled state close, the control point may sway back
DROP = 1e-8  # of d_0: a last piece of the rigid branch that is shorter is vertical
SECANT_SHARE = 0.4  # of α_u: where the secant stiffness is taken
YIELD_SHARE = 0.9  # of α_u: plateau of the trilinear curve
_PAPER = "Portioli et al., §7.1"


class CapacityError(SaidError, ValueError):
    """The pushover curves do not define a capacity; the message names it and the reason."""


Curve = tuple[ArrayLike, ArrayLike]


@dataclass(frozen=True, eq=False)
class Way:
    """Displacements (k,) m of the control point, and d*/Γ* (k,) m of the blocks that move, `equivalent` to them.

    A control point near a hinge, or one that others slide past, is no measure of the blocks.
    """

    control: Array
    equivalent: Array

    def blocks(self, displacement: ArrayLike) -> Array:
        """Return d*/Γ* (m) for displacements of the control point (m)."""
        return _carried_on(displacement, self.control, self.equivalent)

    def control_point(self, equivalent: ArrayLike) -> Array:
        """Return the displacements of the control point (m) for d*/Γ* (m)."""
        return _carried_on(equivalent, self.equivalent, self.control)

    def curve(self, elastic: Curve) -> Curve:
        """Return an elastic curve over d*/Γ*."""
        return self.blocks(elastic[0]), elastic[1]


def _carried_on(value: ArrayLike, at: Array, found: Array) -> Array:
    """Interpolate between points; below the first one a value stays, beyond the last one it is in proportion."""
    x, at = np.asarray(value, dtype=float), np.maximum.accumulate(at)
    beyond = x * found[-1] / at[-1] if at[-1] > 0.0 else x
    return np.where(x <= at[0], x, np.where(x > at[-1], beyond, np.interp(x, at, found)))


@dataclass(frozen=True, eq=False)
class CurveFit:
    """An idealised pushover curve: multiplier (k,) over the displacement (k,) of the control point, m."""

    model: str  # "trilinear", "bilinear" or "none" (rigid branch alone: no elastic values)
    alpha_0: float  # multiplier at the onset of the rigid mechanism
    d_0: float | None  # where the rigid branch reaches 0; None: not reached
    alpha_u: float | None  # peak of the elastic curve
    alpha_y: float | None  # end of the elastic branch: (d_y, alpha_y)
    d_y: float | None
    displacement: Array
    multiplier: Array
    notes: tuple[Message, ...] = ()
    steps: Trace = ()  # how they were found
    source: str = "pushover, rigid contacts"  # where alpha_0 and d_0 come from
    # where the structure with elastic contacts has no equilibrium any more (m of the control point); None: not known
    elastic_end: float | None = None
    way: Way | None = None  # where displacement and d_0 are those of the blocks, not of the control point

    @property
    def drops(self) -> bool:
        """Whether the rigid branch ends at d_0 with a vertical drop: equilibrium is lost before α = 0."""
        if self.d_0 is None or len(self.displacement) < 2:
            return False
        return float(np.diff(self.displacement)[-1]) <= DROP * self.d_0 and float(self.multiplier[-2]) > 0.0


def fit_rigid(rigid: Curve) -> CurveFit:
    """Return the rigid branch alone (displacement (k,) m, multiplier (k,)), cut where it reaches 0."""
    d, alpha, d_0 = _rigid_branch(rigid)
    return CurveFit("none", float(alpha[0]), d_0, None, None, None, d, alpha)


def yield_point(elastic: Curve) -> tuple[float, float]:
    """Return (d_y m, α_y) of the paper's curve (§7.1): 0.9 α_u on the secant at 0.4 α_u, if no rigid branch cuts it."""
    secant, alpha_u, _ = _rising_branch(elastic)
    return YIELD_SHARE / SECANT_SHARE * secant, YIELD_SHARE * alpha_u


def fit_curve(model: str, rigid: Curve, elastic: Curve | None = None) -> CurveFit:
    """Return the curve of the project's `model` from curves (displacement (k,) m, multiplier (k,)).

    "none": the rigid branch alone. "trilinear" (§7.1 of the paper): secant at 0.4 α_u, plateau 0.9 α_u, rigid branch to
    d_0. "bilinear": the plateau α_y ≤ α_u gives the curve the area that the elastic one has up to its meeting with the
    rigid branch (NTC 2018, C7.3.4.2, carried over to mechanisms [k]). No fit lies above the rigid branch: where the
    secant meets it below the plateau, that point is (d_y, α_y), with a note. Raises CapacityError without an elastic
    curve, for α0 ≤ 0, or where the elastic curve does not rise with the control point; ArgumentError for the model.
    """
    require(model in {"trilinear", "bilinear", "none"}, "model", model, "trilinear, bilinear or none")
    if model == "none":
        return fit_rigid(rigid)
    d, alpha, d_0 = _rigid_branch(rigid)
    secant, alpha_u, (d_e, alpha_e) = _rising_branch(elastic)
    found = partial(_idealised, model, (d, alpha, d_0), secant, alpha_u)
    if model == "trilinear":
        return found(YIELD_SHARE * alpha_u)
    grid = np.union1d(np.union1d(d, d_e[d_e < d[-1]]), np.linspace(0.0, d[-1], 2001))
    branch = np.interp(grid, d, alpha)
    target = float(np.trapezoid(np.minimum(np.interp(grid, d_e, alpha_e), branch), grid))

    def excess(alpha_y: float) -> float:
        fit = found(alpha_y, target)
        return float(np.trapezoid(fit.multiplier, fit.displacement) - target)

    if excess(alpha_u) <= 0.0:
        return found(alpha_u, None, message("no plateau below α_u has the area of the curve: α_y = α_u"))
    from scipy.optimize import brentq  # late: few fits need it, and it takes long to import

    return found(float(brentq(excess, 1e-9 * alpha_u, alpha_u, xtol=1e-14)), target)


def _branch(curve: Curve, name: str) -> tuple[Array, Array]:
    d, alpha = (np.array(values, dtype=float) for values in curve)
    same = d.ndim == 1 and d.shape == alpha.shape and d.size >= 2
    require(same, name, (d.shape, alpha.shape), "displacement (k,) and multiplier (k,), two points or more")
    require(bool(np.isfinite(d).all() and np.isfinite(alpha).all()), name, "not finite", "finite numbers")
    return d, alpha


def _rigid_branch(rigid: Curve) -> tuple[Array, Array, float | None]:
    """Return the rigid curve up to α = 0 and its d_0 (None where α stays positive)."""
    d, alpha = _branch(rigid, "rigid curve")
    require(bool((np.diff(d) > 0.0).all()), "rigid curve", "displacement", "growing from point to point")
    if alpha[0] <= 0.0:
        none = message("alpha_0 = {alpha:.6g}: the rigid mechanism needs no horizontal load: no seismic capacity",
                       alpha=float(alpha[0]))  # fmt: skip
        raise CapacityError(none)
    if (d_0 := _crossing(d, alpha)) is None:
        return d, alpha, None
    k = int(np.argmax(alpha <= 0.0))
    return np.append(d[:k], d_0), np.append(alpha[:k], 0.0), d_0


def _rising_branch(elastic: Curve | None) -> tuple[float, float, tuple[Array, Array]]:
    """Return where the curve reaches 0.4 α_u (m), α_u, and the curve up to where its displacement turns back."""
    if elastic is None:
        raise CapacityError(message('no elastic pushover curve: ask for contacts = ["rigid", "elastic"] and give '
                                    'normal_stiffness_kN_m3, or set model = "none" (rigid branch alone)'))  # fmt: skip
    d, alpha = _branch(elastic, "elastic curve")
    d, alpha = np.insert(d, 0, 0.0), np.insert(alpha, 0, 0.0)
    peak = int(np.argmax(alpha))
    alpha_u = float(alpha[peak])
    if alpha_u <= 0.0:
        why = message("elastic curve: its peak alpha_u = {alpha:.6g} must be positive", alpha=alpha_u)
        raise CapacityError(why)
    above = int(np.argmax(alpha >= SECANT_SHARE * alpha_u))
    share = (SECANT_SHARE * alpha_u - alpha[above - 1]) / (alpha[above] - alpha[above - 1])
    d_secant = float(d[above - 1] + share * (d[above] - d[above - 1]))
    grows = alpha[: peak + 1] >= np.maximum.accumulate(alpha[: peak + 1])  # not where a part snaps through
    if d_secant <= 0.0 or (np.maximum.accumulate(d) - d)[: peak + 1][grows].max() > SWAY * d[peak]:
        raise CapacityError(
            message("elastic curve: the control point does not advance as the load grows; choose another one")
        )
    turned = np.flatnonzero(np.maximum.accumulate(d[peak:]) - d[peak:] > 1e-9 * np.abs(d).max())
    end = peak + int(turned[0]) if turned.size else d.size
    return d_secant, alpha_u, (np.maximum.accumulate(d[:end]), alpha[:end])


def _idealised(
    model: str, rigid: tuple[Array, Array, float | None], secant: float, alpha_u: float, alpha_y: float,
    area: float | None = None, *notes: Message,
) -> CurveFit:  # fmt: skip
    """Return min(secant stiffness times d, α_y, rigid branch) as a piecewise-linear curve.

    secant: displacement at 0.4 α_u, m; area: of the curve from which α_y was found, m, None for a share of α_u. Where
    the elastic branch meets the rigid one below the plateau, there is none.
    """
    d, alpha, d_0 = rigid
    K = SECANT_SHARE * alpha_u / secant
    d_y, meets, cut = alpha_y / K, _crossing(d, alpha - K * d), False
    if alpha_u > alpha[0]:
        notes += (message("elastic peak α_u = {peak:.4g} above the rigid onset α0 = {onset:.4g}: the fit is cut",
                          peak=alpha_u, onset=float(alpha[0])),)  # fmt: skip
    if meets is None:
        raise CapacityError(
            message("the elastic branch does not meet the rigid branch: follow the rigid pushover further")
        )
    if meets < d_y:
        d_y, alpha_y, end, cut = meets, float(K * meets), meets, True
        notes += (message("the secant meets the rigid branch at α = {alpha:.4g}, below the plateau: no plateau",
                          alpha=alpha_y),)  # fmt: skip
    else:
        below = d >= d_y
        tail = np.concatenate([[np.interp(d_y, d, alpha)], alpha[below]]) - alpha_y
        found = _crossing(np.concatenate([[d_y], d[below]]), tail)
        d_y, alpha_y, end = float(d_y), float(alpha_y), float(d[-1]) if found is None else found
        if found is None:
            notes += (message("the plateau does not meet the rigid branch within the curve"),)
    knots = [(0.0, 0.0), (d_y, alpha_y)] + ([(end, alpha_y)] if end > d_y else [])
    displacement = np.concatenate([[knot[0] for knot in knots], d[d > end]])
    multiplier = np.concatenate([[knot[1] for knot in knots], np.minimum(alpha[d > end], alpha_y)])
    steps: list[Line] = [
        datum("alpha_u", alpha_u, "", "pushover, elastic contacts: peak"),
        datum("d_40", secant, "m", f"pushover, elastic contacts: at {SECANT_SHARE:g} α_u"),
        step("K", f"{SECANT_SHARE:g}*alpha_u/d_40", K, "1/m", _PAPER),
    ]
    if cut:
        steps += [
            datum("d_y", d_y, "m", "where the secant meets the rigid branch"),
            step("alpha_y", "K*d_y", alpha_y, "", _PAPER),
        ]
    elif area is None:
        steps.append(step("alpha_y", f"{alpha_y / alpha_u:g}*alpha_u", alpha_y, "", _PAPER))
    else:
        equal = "2*(A - A_m)/(d_m + sqrt(d_m**2 - 2*(A - A_m)/K))"
        beyond = float(np.trapezoid(multiplier[displacement >= end], displacement[displacement >= end]))
        steps += [
            datum("A", area, "m", "area of the elastic curve, up to the rigid branch"),
            datum("d_m", end, "m", "where the plateau meets the rigid branch"),
            datum("A_m", beyond, "m", "area of the rigid branch beyond d_m"),
            step("alpha_y", equal, alpha_y, "", "equal area: NTC 2018, C7.3.4.2"),
        ]
    if not cut:
        steps.append(step("d_y", "alpha_y/K", d_y, "m", _PAPER))
    made = worked(*steps)
    return CurveFit(model, float(alpha[0]), d_0, alpha_u, alpha_y, d_y, displacement, multiplier, notes, made)


def _crossing(d: Array, value: Array) -> float | None:
    """Return the first d where the piecewise-linear value falls to 0; None where it stays positive."""
    down = np.flatnonzero(value <= 0.0)
    if not down.size:
        return None
    k = int(down[0])
    if k == 0:
        return float(d[0])
    return float(d[k - 1] + (d[k] - d[k - 1]) * value[k - 1] / (value[k - 1] - value[k]))


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
    """Capacity of the equivalent oscillator: a* = α/(e* F_C) (k,) in g over d* = d Γ* (k,) in m, with the fit.

    F_C divides here alone, from the paragraph `confidence_source`; `activation`: what activates the first mechanism.
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
