"""Safety of a mechanism at the limit states: Circolare 7/2019, C8.7.1.2, and the 2009 circular's variant.

Every check solves for the ground acceleration a_g at which the demand equals the capacity, and carries the
trace of its calculation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, pi, sqrt

import numpy as np

from assessment.capacity import CapacityCurve
from assessment.hazard import EXCEEDANCE, HazardCurve
from assessment.idealisation import CapacityError
from assessment.scaling import Demand, spectrum_at_return_period
from assessment.spectrum import RecordSpectrum, Spectrum
from assessment.trace import Step, Trace, datum, step
from mechanics.block import GRAVITY
from mechanics.errors import require

_ACTIVATION_DAMPING = 0.05
_COLLAPSE_FIRST = (
    "a_g of SLC comes out below that of SLV: the formulas allow it where T_SLV lies on the plateau of the "
    "spectrum; the smaller one counts for both"
)


@dataclass(frozen=True, slots=True)
class _Nonlinear:
    """Displacement limit as a share of d_0, T = factor π √(d/a) at `secant` of the limit, damping."""

    share: float
    secant: float
    factor: float
    damping: float


_RULES = {
    ("2019", "SLV"): _Nonlinear(0.40, 1.0, 1.68, 0.08),
    ("2019", "SLC"): _Nonlinear(0.60, 1.0, 1.56, 0.10),
    ("2009", "SLV"): _Nonlinear(0.40, 0.4, 2.00, 0.05),
}
_LAW = {"2019": "Circolare 7/2019, C8.7.1.2", "2009": "Circolare 617/2009, C8A.4.2.3"}


@dataclass(frozen=True)
class Method:
    """How the checks are made.

    behaviour_factor: q of the linear check. circular: "2019", or "2009" (secant at 0.4 d_u, 5 % damping, no
    lower bound by activation; SLV only) [k]. scaling: how the demand spectrum follows a_g to the capacity:
    "shape" keeps its shape (S_S and T_D with it) and scales it; "return_period" moves along `hazard` until
    the spectrum of that return period meets the capacity. displacement_demand: "maximum" of S_De over
    [T_0, T], which differs from S_De(T) for records and beyond T_E; "at_period": S_De(T), as in the paper.
    local_limits: displacement of the control point (m) at which an element is lost (a beam unseats), per
    limit state. site_acceleration: a_g S of the site (g) per limit state, compared with the peak acceleration
    where the spectrum is a record's.
    """

    behaviour_factor: float = 2.0
    circular: str = "2019"
    scaling: str = "shape"
    displacement_demand: str = "maximum"
    hazard: HazardCurve | None = None
    local_limits: Mapping[str, float] = field(default_factory=dict)
    site_acceleration: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require(self.behaviour_factor >= 1.0, "behaviour_factor", self.behaviour_factor, "1 or more")
        require(self.circular in {"2019", "2009"}, "circular", self.circular, '"2019" or "2009"')
        require(self.scaling in {"shape", "return_period"}, "scaling", self.scaling, "shape or return_period")
        require(
            self.displacement_demand in {"maximum", "at_period"},
            "displacement_demand",
            self.displacement_demand,
            "maximum or at_period",
        )
        require(
            self.scaling == "shape" or self.hazard is not None,
            "scaling",
            self.scaling,
            "shape where the site's hazard is not given by latitude, longitude and grid",
        )
        for state, limit in self.local_limits.items():
            require(0.0 < limit < inf, f"local_limits.{state}", limit, "positive, in m")


@dataclass(frozen=True)
class Check:
    """The answer of one check of one limit state.

    method: "activation", "linear" or "nonlinear". d_star (m), a_star (g): point of the capacity curve that
    counts; T (s): its period; a_g: capacity, g; demand_a_g: demand, g; zeta_E: their ratio, with S on both
    sides; return_period: of the capacity, years, where the site's hazard is known. governing: what gave a_g.
    Numbers are None where the capacity is not defined, and `notes` say why.
    """

    limit_state: str
    method: str
    d_star: float | None
    a_star: float | None
    T: float | None
    a_g: float | None
    demand_a_g: float
    zeta_E: float | None  # noqa: N815 — the key of the contract
    verified: bool | None
    damping: float | None
    return_period: float | None
    governing: str
    trace: Trace
    notes: tuple[str, ...] = ()


def verify(
    capacity: CapacityCurve, demands: Mapping[str, Spectrum], method: Method | None = None
) -> dict[str, Check]:
    """Return the checks of the limit states in `demands` (limit state → spectrum of the site at that state).

    SLO and SLD: activation; SLV and SLC: nonlinear; under "SLV linear" also the linear check with q. For a
    mechanism at height the spectra are floor spectra; for the paper's assessment a RecordSpectrum. A capacity
    that is not defined (d_0 not reached) gives a Check without numbers that says why.
    Raises ValueError for an unknown limit state or an unsuitable method.
    """
    method = method or Method()
    checks = {}
    for state, spectrum in demands.items():
        require(state in EXCEEDANCE, "limit state", state, "one of SLO, SLD, SLV, SLC")
        if state in {"SLO", "SLD"}:
            checks[state] = check_activation(capacity, state, spectrum, method)
            continue
        try:
            checks[state] = check_nonlinear(capacity, state, spectrum, method)
        except CapacityError as refusal:
            checks[state] = _refused(state, spectrum, method, str(refusal))
        if state == "SLV":
            checks["SLV linear"] = check_linear(capacity, state, spectrum, method)
    life, collapse = (checks[state].a_g if state in checks else None for state in ("SLV", "SLC"))
    if life is not None and collapse is not None and collapse < life:
        checks["SLC"] = replace(checks["SLC"], notes=(*checks["SLC"].notes, _COLLAPSE_FIRST))
    return checks


def check_activation(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the check against activation of the mechanism (Circolare 7/2019, C8.7.1.2: SLD).

    Rigid capacity: a_0* = S_e(0) = a_g S (or the floor's a_Z). With an elastic branch: a_y* = S_e(T_0, 5 %).
    """
    method = method or Method()
    solved = _activation(capacity, spectrum, method)
    return _check(limit_state, solved, capacity, spectrum, method, kind="activation")


def check_linear(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the linear kinematic check q a_0* = S_e(0): a_g,SLV = q a_g,SLD (Circolare 7/2019, C8.7.1.2).

    a_g,SLD is here the activation under the spectrum of this limit state, so that S is that of its demand.
    """
    method = method or Method()
    solved = _activation(capacity, spectrum, method, method.behaviour_factor)
    return _check(limit_state, solved, capacity, spectrum, method, kind="linear")


def check_nonlinear(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the nonlinear kinematic check at SLV or SLC (Circolare 7/2019, C8.7.1.2).

    d_SLV = min(0.40 d_0, local limit), d_SLC = min(0.60 d_0, local limit); T = 1.68 π √(d/a) at 8 % damping,
    T = 1.56 π √(d/a) at 10 %; a_g solves S_De(T) = d and is not below activation. Circular of 2009:
    d_u = min(0.40 d_0, local limit), T_s = 2π √(d_s/a_s) at d_s = 0.4 d_u, S_De(T_s, 5 %) = d_u.
    Raises CapacityError where d_0 is not reached, where no capacity is left at the limit, or where the
    circular knows no nonlinear check for the limit state.
    """
    method = method or Method()
    rule = _RULES.get((method.circular, limit_state))
    if rule is None:
        raise CapacityError(f"{limit_state}: the circular of {method.circular} has no nonlinear check for it")
    solved = _displacement_demand(capacity, limit_state, spectrum, method, rule)
    if method.circular == "2019":  # in no case below the acceleration of SLD
        active = _activation(capacity, spectrum, method)
        line = step(f"a_g_{limit_state}", "max(a_g_nonlinear, a_g_act)", max(solved.a_g, active.a_g), "g",
                    _LAW["2019"], a_g_nonlinear=solved.a_g, a_g_act=active.a_g)  # fmt: skip
        steps = (*solved.steps, *active.steps, line)
        if active.a_g > solved.a_g:
            solved = replace(
                solved, a_g=active.a_g, base=active.base, governing="activation", notes=active.notes
            )
        solved = replace(solved, steps=steps)
    return _check(limit_state, solved, capacity, spectrum, method, kind="nonlinear")


@dataclass(frozen=True)
class _Solved:
    """a_g (g) at which the demand meets the capacity, under `base`, the spectrum scaled to it; its steps."""

    d_star: float | None
    a_star: float
    T: float
    a_g: float
    base: Spectrum
    damping: float
    governing: str
    steps: Trace
    notes: tuple[str, ...]


def _activation(capacity: CapacityCurve, spectrum: Spectrum, method: Method, q: float = 1.0) -> _Solved:
    """Solve S_e(0) = q a_0* or, with an elastic branch (2019), S_e(T_0) = q a_y* at 5 % damping."""
    d_star, a_star, T, symbol = None, capacity.a_0_star, 0.0, "a_0_star"
    if method.circular == "2019" and capacity.a_y_star is not None and capacity.T_0 is not None:
        d_star, a_star, T, symbol = capacity.d_y_star, capacity.a_y_star, capacity.T_0, "a_y_star"

    def demand(s: Spectrum) -> float:
        return float(s.acceleration(T))

    base, notes = _scaled(demand, q * a_star, spectrum.with_damping(_ACTIVATION_DAMPING), method)
    S_e = demand(base)
    a_g = base.ag * q * a_star / S_e
    numbers = {"a_g": base.ag, symbol: a_star, "S_e": S_e}
    name, formula, governing = "a_g_act", f"a_g*{symbol}/S_e", "activation"
    if q != 1.0:
        name, formula, governing = "a_g_linear", f"q*{formula}", f"q = {q:g} times activation"
        numbers["q"] = q
    line = step(name, formula, a_g, "g", _LAW[method.circular], **numbers)
    return _Solved(
        d_star, a_star, T, a_g, base, _ACTIVATION_DAMPING, governing, (*base.steps(T), line), notes
    )


def _displacement_demand(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method, rule: _Nonlinear
) -> _Solved:
    """Solve S_De(T) = d at the displacement limit d, T from the secant of the capacity curve."""
    d, governing, first = _limit(capacity, limit_state, method, rule)
    lines = [first]
    d_secant, name = d, limit_state
    if rule.secant != 1.0:
        d_secant, name = rule.secant * d, "s"
        lines.append(step("d_s", f"{rule.secant:g}*{first.symbol}", d_secant, "m", _LAW[method.circular],
                          **{first.symbol: d}))  # fmt: skip
    a = capacity.a_star(d_secant)
    if a <= 0.0:
        raise CapacityError(f"{limit_state}: no acceleration capacity is left at d* = {d_secant:.6g} m")
    T, T_0 = rule.factor * pi * sqrt(d_secant / (a * GRAVITY)), capacity.T_0 or 0.0
    largest = method.displacement_demand == "maximum"

    def demand(s: Spectrum) -> float:
        return s.largest_displacement(T_0, T)[0] if largest else float(s.displacement(T))

    base, notes = _scaled(demand, d, spectrum.with_damping(rule.damping), method)
    S_De = demand(base)
    a_g = base.ag * d / S_De
    lines += [
        _curve_step(capacity, f"a_{name}", d_secant, a),
        step(f"T_{name}", f"{rule.factor:g}*pi*sqrt(d/(a*g))", T, "s", _LAW[method.circular], d=d_secant, a=a,
             g=GRAVITY),
        *(base.demand_steps(T_0, T) if largest else base.steps(T)),
        step("a_g_nonlinear", "a_g*d/S_De", a_g, "g", _LAW[method.circular], a_g=base.ag, d=d, S_De=S_De),
    ]  # fmt: skip
    return _Solved(d, a, T, a_g, base, rule.damping, governing, tuple(lines), notes)


def _limit(
    capacity: CapacityCurve, limit_state: str, method: Method, rule: _Nonlinear
) -> tuple[float, str, Step]:
    """Return the displacement limit d* (m), what sets it, and its step."""
    d_0, Gamma = capacity.d_0_star, capacity.gamma_star
    if d_0 is None:
        raise CapacityError(
            f"{limit_state}: d_0 is not reached: the multiplier of the rigid branch stays positive up to "
            f"{capacity.fit.displacement[-1]:.6g} m; follow the pushover with rigid contacts to zero"
        )
    symbol = "d_u" if method.circular == "2009" else f"d_{limit_state}"
    share, law = f"{rule.share:g}*d_0_star", _LAW[method.circular]
    d, governing = rule.share * d_0, f"{rule.share:.2f} d_0"
    local = method.local_limits.get(limit_state)
    if local is None:
        return d, governing, step(symbol, share, d, "m", law, d_0_star=d_0)
    if local * Gamma < d:
        d, governing = local * Gamma, "local limit"
    line = step(symbol, f"min({share}, d_local*Gamma_star)", d, "m", law, d_0_star=d_0, d_local=local,
                Gamma_star=Gamma)  # fmt: skip
    return d, governing, line


def _curve_step(capacity: CapacityCurve, symbol: str, d: float, a: float) -> Step:
    """Return the interpolation of a* on the capacity curve between the two points about d."""
    k = int(np.clip(np.searchsorted(capacity.displacement, d), 1, len(capacity.displacement) - 1))
    d_1, d_2 = capacity.displacement[k - 1 : k + 1]
    a_1, a_2 = capacity.acceleration[k - 1 : k + 1]
    return step(symbol, "a_1 + (a_2 - a_1)*(d - d_1)/(d_2 - d_1)", a, "g", "capacity curve", a_1=a_1, a_2=a_2,
                d=d, d_1=d_1, d_2=d_2)  # fmt: skip


def _scaled(
    demand: Demand, capacity: float, spectrum: Spectrum, method: Method
) -> tuple[Spectrum, tuple[str, ...]]:
    """Return the spectrum that meets the capacity when scaled by capacity/demand, and notes."""
    if method.scaling == "shape" or method.hazard is None:
        return spectrum, ()
    return spectrum_at_return_period(demand, capacity, spectrum, method.hazard)


def _check(
    limit_state: str,
    solved: _Solved,
    capacity: CapacityCurve,
    spectrum: Spectrum,
    method: Method,
    *,
    kind: str,
) -> Check:
    """Return the Check of the capacity against the demand: `spectrum`'s own a_g, or that of the site."""
    a_g, S = solved.a_g, solved.base.S
    site = method.site_acceleration.get(limit_state)
    demand, S_demand = (spectrum.ag, spectrum.S) if site is None else (site, 1.0)
    source = "hazard of the site, or peak of the record" if site is None else "a_g S of the site"
    zeta = a_g * S / (demand * S_demand)
    lines = [
        datum("a_g_demand", demand, "g", source),
        step("zeta_E", "a_g_capacity*S_capacity/(a_g_demand*S_demand)", zeta, "", "NTC 2018, §8.3",
             a_g_capacity=a_g, S_capacity=S, a_g_demand=demand, S_demand=S_demand),
    ]  # fmt: skip
    T_R = None
    if method.hazard is not None and not isinstance(spectrum, RecordSpectrum):
        T_R = method.hazard.return_period(a_g)
        lines.append(datum("T_R_capacity", T_R, "years", "hazard of the site at a_g, within 30–2475 years"))
    trace = (*capacity.steps(), *solved.steps, *lines)
    return Check(
        limit_state, kind, solved.d_star, solved.a_star, solved.T, a_g, demand, zeta, zeta >= 1.0,
        solved.damping, T_R, solved.governing, trace, (*capacity.fit.notes, *solved.notes),
    )  # fmt: skip


def _refused(limit_state: str, spectrum: Spectrum, method: Method, reason: str) -> Check:
    """Return the Check of a capacity that is not defined."""
    demand = method.site_acceleration.get(limit_state, spectrum.ag)
    return Check(
        limit_state, "nonlinear", None, None, None, None, demand, None, None, None, None, "", (), (reason,)
    )
