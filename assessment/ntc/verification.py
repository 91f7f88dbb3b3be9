"""Checks of limit states by the a_g borne: NTC 2018, §8.3 (ζ_E); Circolare 7/2019, C8.7.1.2; 617/2009, C8A.4."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import inf, pi, sqrt
from typing import Any

import numpy as np

from assessment.ntc.capacity_curve import CapacityCurve, CapacityError
from assessment.ntc.floor_spectrum import Demand, Spectrum, spectrum_at_return_period
from assessment.ntc.hazard import HazardCurve, capacity_return_period, stated
from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from assessment.ntc.tables import EXCEEDANCE, INDEX, INDEXED, ROCK, SURFACE, Trace, datum, step, worked
from assessment.results.schema import Check, CheckMethod, Line, VerticalCheck, finite, known
from mechanics.errors import is_between, require
from mechanics.messages import Message, message
from mechanics.types import GRAVITY

ACTIVATION_DAMPING = 0.05
_SURFACE_LAW = "NTC 2018, §3.2.3.2.1"
NOTHING = dict.fromkeys((  # numbers of a check whose capacity is not defined
    "d_star_m", "a_star_g", "T_s", "a_g_g", "pga_g", "S", "zeta_E", "verified", "damping", "return_period_years",
    "return_period_stated", "demand_a_star_g",
))  # fmt: skip


@dataclass(frozen=True, slots=True)
class Nonlinear:
    """Displacement limit as a share of d_0, T = factor π √(d/a) at `secant` of the limit, damping."""

    share: float
    secant: float
    factor: float
    damping: float


RULES = {
    ("2019", "SLV"): Nonlinear(0.40, 1.0, 1.68, 0.08),
    ("2019", "SLC"): Nonlinear(0.60, 1.0, 1.56, 0.10),
    ("2009", "SLV"): Nonlinear(0.40, 0.4, 2.00, 0.05),
}
LAW = {"2019": "Circolare 7/2019, C8.7.1.2", "2009": "Circolare 617/2009, C8A.4.2.3"}


@dataclass(frozen=True)
class Method:
    """How the checks are made.

    behaviour_factor: q of the linear check. circular: "2019", or "2009" (secant at 0.4 d_u, 5 % damping, no lower bound
    by activation; SLV only) [k]. scaling: how the demand spectrum follows a_g to the capacity: "shape" keeps its shape
    (S_S and T_D with it) and scales it; "return_period" moves along `hazard` until the spectrum of that return period
    meets the capacity. displacement_demand: "maximum" of S_De over [T_0, T], which differs from S_De(T) for records and
    beyond T_E; "at_period": S_De(T), as in the paper, a number to compare: what is verified is decided by the maximum.
    local_limits: displacement of the control point (m) at which an element is lost (a beam unseats), per limit state;
    local_reason: what is lost, for the calculation. site_acceleration: a_g S of the site (g) per limit state, compared
    with the peak acceleration where the spectrum is a record's. return_periods: T_R of the demand (years) per limit
    state, where it is known. Raises ArgumentError naming the field.
    """

    behaviour_factor: float = 2.0
    circular: str = "2019"
    scaling: str = "shape"
    displacement_demand: str = "maximum"
    hazard: HazardCurve | None = None
    local_limits: Mapping[str, float] = field(default_factory=dict)
    local_reason: str = ""
    site_acceleration: Mapping[str, float] = field(default_factory=dict)
    return_periods: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require(self.behaviour_factor >= 1.0, "behaviour_factor", self.behaviour_factor, "1 or more")
        require(self.circular in {"2019", "2009"}, "circular", self.circular, '"2019" or "2009"')
        require(self.scaling in {"shape", "return_period"}, "scaling", self.scaling, "shape or return_period")
        known = self.displacement_demand in {"maximum", "at_period"}
        require(known, "displacement_demand", self.displacement_demand, "maximum or at_period")
        given = self.scaling == "shape" or self.hazard is not None
        must = "shape where the site's hazard is not given by latitude, longitude and grid"
        require(given, "scaling", self.scaling, must)
        for state, limit in self.local_limits.items():
            require(is_between(limit, 0.0, inf), f"local_limits.{state}", limit, "positive, in m")


@dataclass(frozen=True)
class Solved:
    """a_g (g) at which the demand meets the capacity, under `base`, the spectrum scaled to it; its steps."""

    d_star: float | None
    a_star: float
    T: float
    a_g: float
    base: Spectrum
    damping: float
    governing: str
    steps: Trace
    notes: tuple[Message, ...]


def verify(
    capacity: CapacityCurve, demands: Mapping[str, Spectrum], method: Method = Method()
) -> dict[str, Check]:
    """Return the checks of the limit states in `demands` (limit state → spectrum of the site at that state).

    SLO, SLD and "SLV linear": linear; "SLO elastic" and "SLD elastic": end of the elastic branch, of a curve that has
    one; SLV and SLC: nonlinear, without numbers where a capacity is not defined. Raises ValueError for a wrong method.
    """
    checks = {}
    for state, spectrum in demands.items():
        require(state in EXCEEDANCE, "limit state", state, "one of SLO, SLD, SLV, SLC")
        if state in {"SLO", "SLD"}:
            checks[state] = check_linear(capacity, state, spectrum, method)
            if capacity.T_0 is not None and method.circular == "2019":
                solved = _solve_elastic(capacity, spectrum, method)
                checks[f"{state} elastic"] = _check(state, solved, capacity, spectrum, method, "elastic")
            continue
        try:
            checks[state] = check_nonlinear(capacity, state, spectrum, method)
        except CapacityError as refusal:
            checks[state] = _part(state, spectrum, method, "nonlinear", notes=[refusal.message])
        if state == "SLV":
            checks["SLV linear"] = check_linear(capacity, state, spectrum, method)
    life, collapse = (checks[state].a_g_g if state in checks else None for state in ("SLV", "SLC"))
    if life is not None and collapse is not None and collapse < life:
        shapes = message(
            "a_g of SLC comes out below that of SLV because their demand spectra differ in shape: the smaller one "
            "counts for both"
        )
        checks["SLC"] = checks["SLC"].replace(notes=[*checks["SLC"].notes, shapes])
    return checks


def check_linear(capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method) -> Check:
    """Return the linear kinematic check of a_0* = α0/(e* F_C), of the rigid multiplier (Circolare 7/2019, C8.7.1.2).

    At the ground a_0* ≥ a_g S/q, at height a_0* ≥ a_Z(z)/q with a_Z = S_e(T_1) |γ ψ| √(1 + 0.0004 ξ²), not below
    a_g S (2009: S_e(T_1) ψ γ); q = 1 at SLO and SLD, the behaviour factor at SLV.
    """
    q, law = method.behaviour_factor if limit_state in INDEXED else 1.0, LAW[method.circular]
    solved = _solve_linear(capacity, spectrum, method, q)
    check = _check(limit_state, solved, capacity, spectrum, method, "linear")
    by_site, a_g = limit_state in method.site_acceleration, check.demand_a_g_g
    S, at_rest = 1.0 if by_site else spectrum.S, float(spectrum.acceleration(0.0))
    if by_site or at_rest <= a_g * S * (1.0 + 1e-9):
        steps: Trace = (step("a_demand", "a_g_demand*S_demand/q", a_g * S / q, "g", law, a_g_demand=a_g,
                             S_demand=S, q=q),)  # fmt: skip
    else:
        steps = (
            *spectrum.with_damping(ACTIVATION_DAMPING).steps(0.0),
            step("a_demand", "S_eZ/q", at_rest / q, "g", law, S_eZ=at_rest, q=q),
        )
    return check.replace(demand_a_star_g=steps[-1].result, trace=[*check.trace, *steps])


def check_nonlinear(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method = Method()
) -> Check:
    """Return the nonlinear kinematic check at SLV or SLC (Circolare 7/2019, C8.7.1.2, or that of 2009).

    d_SLV = min(0.40 d_0, local limit, end of the elastic curve), d_SLC = min(0.60 d_0, the same), T = 1.68 π √(d/a) at
    8 % damping or 1.56 π √(d/a) at 10 %; a_g solves S_De(T) = d, is not below activation, and at SLV not above that at
    which the same spectrum reaches d_SLC: a structure past SLC is past SLV. 2009: d_u = min(0.40 d_0, local limit),
    T_s = 2π √(d_s/a_s) at d_s = 0.4 d_u, S_De(T_s, 5 %) = d_u. With S_De at T alone a check is verified where that of
    the circular is, too. Raises CapacityError where no d or a is left.
    """
    solved = _solve_displacement(capacity, limit_state, spectrum, method)
    if method.circular == "2019":
        if limit_state == "SLV":
            with suppress(CapacityError):
                solved = _first(solved, _solve_displacement(capacity, "SLC", spectrum, method))
        # where the curve is left: at a_y* and T_0, or at a_0* where it is rigid
        active = (_solve_linear if capacity.T_0 is None else _solve_elastic)(capacity, spectrum, method)
        largest = max(solved.a_g, active.a_g)
        line = step(f"a_g_{limit_state}", "max(a_g_nonlinear, a_g_act)", largest, "g", LAW["2019"])
        steps = worked(*solved.steps, *active.steps, line)
        if active.a_g > solved.a_g:
            solved = replace(
                solved, a_g=active.a_g, base=active.base, governing="activation", notes=active.notes
            )
        solved = replace(solved, steps=steps)
    check = _check(limit_state, solved, capacity, spectrum, method, "nonlinear")
    if method.displacement_demand == "maximum":
        return check
    worst = check_nonlinear(capacity, limit_state, spectrum, replace(method, displacement_demand="maximum"))
    least, told = known(worst.a_g_g), known(check.a_g_g)
    if told <= 1.001 * least:
        return check
    larger = message(
        "{limit}: S_De of the demand is larger between T_0 and T = {T:.3g} s than at T: the maximum over [T_0, T] "
        "of the circular gives a_g = {least:.3g} g in place of {a_g:.3g} g, and decides what is verified",
        limit=limit_state, T=known(check.T_s), least=least, a_g=told,
    )  # fmt: skip
    return check.replace(notes=[*check.notes, larger], verified=check.verified and worst.verified)


def _first(life: Solved, collapse: Solved) -> Solved:
    """Return the solution of SLV, or that of SLC where the same spectrum reaches d_SLC at a smaller a_g."""
    if collapse.a_g >= life.a_g:
        return life
    *steps, last = collapse.steps
    *before, own = life.steps
    line = step("a_g_nonlinear", "min(a_g_life, a_g_collapse)", collapse.a_g, "g", LAW["2019"])
    both = (*before, own.replace(symbol="a_g_life"), *steps, last.replace(symbol="a_g_collapse"))
    note = message(
        "SLV: d_SLC is reached at a smaller a_g under the same spectrum (the formulas allow it where T_SLV lies on "
        "the plateau): that a_g counts"
    )
    governing = f"SLC reached first: {collapse.governing}"
    return replace(collapse, governing=governing, steps=worked(*both, line), notes=(*collapse.notes, note))


def _demand(limit_state: str, spectrum: Spectrum, method: Method) -> tuple[float, str, float]:
    """Return the a_g demanded (g): the `spectrum`'s own, or that of the site; what it refers to, and its S."""
    # a record's peak is of its own surface
    reference = SURFACE if isinstance(spectrum, RecordSpectrum) else ROCK
    site = method.site_acceleration.get(limit_state)
    return (spectrum.ag, reference, spectrum.S) if site is None else (site, reference, 1.0)


def _check(
    limit_state: str, solved: Solved, capacity: CapacityCurve, spectrum: Spectrum, method: Method,
    kind: CheckMethod,
) -> Check:  # fmt: skip
    a_g, S = solved.a_g, solved.base.S
    demand, reference, S_demand = _demand(limit_state, spectrum, method)
    given = limit_state in method.site_acceleration
    pga, demanded = a_g * S, demand * S_demand
    zeta = pga / demanded
    law = "NTC 2018, §8.3" if limit_state == INDEX else LAW[method.circular]
    source = "a_g S of the site" if given else "hazard of the site, or peak of the record"
    lines = worked(
        datum("a_g_demand", demand, "g", source),
        step("PGA_capacity", "S_capacity*a_g_capacity", pga, "g", _SURFACE_LAW),
        step("PGA_demand", "S_demand*a_g_demand", demanded, "g", _SURFACE_LAW),
        step("zeta_E" if limit_state == INDEX else f"r_{limit_state}", "PGA_capacity/PGA_demand", zeta, "", law),
        S_capacity=S, a_g_capacity=a_g, S_demand=S_demand,
    )  # fmt: skip
    period = None
    if reference == ROCK:
        known = method.return_periods.get(limit_state)
        period = capacity_return_period(a_g, pga, demanded, known, method.hazard)
        lines += (period,) if period else ()
    T_R = period.result if period else None
    return _part(
        limit_state, spectrum, method, kind, d_star_m=solved.d_star, a_star_g=solved.a_star, T_s=solved.T, a_g_g=a_g,
        pga_g=pga, S=S, zeta_E=zeta, verified=bool(zeta >= 1.0), damping=solved.damping, governing=solved.governing,
        return_period_years=T_R, return_period_stated=stated(T_R), notes=[*capacity.fit.notes, *solved.notes],
        trace=[*capacity.steps(), *solved.steps, *lines],
    )  # fmt: skip


def _part(limit_state: str, spectrum: Spectrum, method: Method, kind: CheckMethod, **found: Any) -> Check:
    """Return a check of what was `found`, by its keys; null: what was not, as where the capacity is not defined."""
    demand, reference, S = _demand(limit_state, spectrum, method)
    asked = {"demand_a_g_g": demand, "demand_pga_g": S * demand, "demand_S": S, "reference": reference}
    told = {name: finite(float(x)) if isinstance(x, float) else x for name, x in found.items()}
    return Check(method=kind, **NOTHING | {"governing": "", "trace": []} | asked | told)


def _solve_linear(capacity: CapacityCurve, spectrum: Spectrum, method: Method, q: float = 1.0) -> Solved:
    """Return where S_e(0) = q a_0*, of the rigid multiplier: a_g S at the ground, a_Z at height (C8.7.1.2)."""
    return _solve_acceleration(capacity.a_0_star, "a_0_star", None, 0.0, spectrum, method, q)


def _solve_elastic(capacity: CapacityCurve, spectrum: Spectrum, method: Method) -> Solved:
    """Return where S_e(T_0) = a_y*, the end of the elastic branch, of a curve that has one (C8.7.1.2)."""
    assert capacity.a_y_star is not None and capacity.T_0 is not None
    d, T = capacity.d_y_star, capacity.T_0
    return _solve_acceleration(capacity.a_y_star, "a_y_star", d, T, spectrum, method)


def _solve_acceleration(
    a_star: float, symbol: str, d_star: float | None, T: float, spectrum: Spectrum, method: Method,
    q: float = 1.0,
) -> Solved:  # fmt: skip
    """Return where S_e(T) = q a* at 5 % damping, with the symbol that a* has in the steps."""

    def demand(s: Spectrum) -> float:
        return float(s.acceleration(T))

    base, notes = _scaled(demand, q * a_star, spectrum.with_damping(ACTIVATION_DAMPING), method)
    S_e = demand(base)
    a_g = base.ag * q * a_star / S_e
    name, formula, governing = "a_g_act", f"a_g*{symbol}/S_e", "activation" if T == 0.0 else "elastic branch"
    if q != 1.0:
        name, formula, governing = "a_g_linear", f"q*{formula}", "q times activation"
    known = {"a_g": base.ag, symbol: a_star, "S_e": S_e, "q": q}
    steps = worked(*base.steps(T), step(name, formula, a_g, "g", LAW[method.circular]), **known)
    return Solved(d_star, a_star, T, a_g, base, ACTIVATION_DAMPING, governing, steps, notes)


def _solve_displacement(capacity: CapacityCurve, limit: str, spectrum: Spectrum, method: Method) -> Solved:
    """Return where S_De(T) = d at the displacement limit d, T from the secant of the capacity curve."""
    rule = RULES.get((method.circular, limit))
    if rule is None:
        raise CapacityError(message("{limit}: the circular of {year} has no nonlinear check for it", limit=limit,
                                    year=method.circular))  # fmt: skip
    d, governing, first = _limit(capacity, limit, method, rule)
    lines = [first]
    d_secant, name = d, limit
    if rule.secant != 1.0:
        d_secant, name = rule.secant * d, "s"
        lines.append(step("d_s", f"{rule.secant:g}*{first.symbol}", d_secant, "m", LAW[method.circular]))
    a = capacity.a_star(d_secant)
    if a <= 0.0:
        none = message("{limit}: no acceleration capacity is left at d* = {displacement:.6g} m", limit=limit,
                       displacement=d_secant)  # fmt: skip
        raise CapacityError(none)
    T, T_0 = rule.factor * pi * sqrt(d_secant / (a * GRAVITY)), capacity.T_0 or 0.0
    largest = method.displacement_demand == "maximum"

    def demand(s: Spectrum) -> float:
        return s.largest_displacement(T_0, T)[0] if largest else float(s.displacement(T))

    base, notes = _scaled(demand, d, spectrum.with_damping(rule.damping), method)
    S_De = demand(base)
    a_g = base.ag * d / S_De
    k = int(np.clip(np.searchsorted(capacity.displacement, d_secant), 1, len(capacity.displacement) - 1))
    (d_1, d_2), (a_1, a_2) = capacity.displacement[k - 1 : k + 1], capacity.acceleration[k - 1 : k + 1]
    steps = worked(
        *lines,
        step(f"a_{name}", "a_1 + (a_2 - a_1)*(d - d_1)/(d_2 - d_1)", a, "g", "capacity curve", d=d_secant),
        step(f"T_{name}", f"{rule.factor:g}*pi*sqrt(d/(a*g))", T, "s", LAW[method.circular], d=d_secant),
        *(base.demand_steps(T_0, T) if largest else base.steps(T)),
        step("a_g_nonlinear", "a_g*d/S_De", a_g, "g", LAW[method.circular]),
        a_1=a_1, a_2=a_2, d=d, d_1=d_1, d_2=d_2, a=a, g=GRAVITY, a_g=base.ag, S_De=S_De,
    )  # fmt: skip
    return Solved(d, a, T, a_g, base, rule.damping, governing, steps, notes)


def _limit(capacity: CapacityCurve, limit: str, method: Method, rule: Nonlinear) -> tuple[float, str, Line]:
    """Return the displacement limit d* (m), what sets it, and its step."""
    d_0, Gamma = capacity.d_0_star, capacity.gamma_star
    if d_0 is None:
        raise CapacityError(message(
            "{limit}: d_0 is not reached: the multiplier of the rigid branch stays positive up to "
            "d* = {displacement:.4g} m; follow the pushover with rigid contacts to zero",
            limit=limit, displacement=float(capacity.displacement[-1]),
        ))  # fmt: skip
    symbol = "d_u" if method.circular == "2009" else f"d_{limit}"
    share, law = f"{rule.share:g}*d_0_star", LAW[method.circular]
    d, governing = rule.share * d_0, f"{rule.share:.2f} d_0"
    local, elastic = method.local_limits.get(limit), capacity.fit.elastic_end
    limits = {"d_local": (local, "local limit"), "d_elastic": (elastic, "end of the elastic curve")}
    known = {name: (value, reason) for name, (value, reason) in limits.items() if value is not None}
    if not known:
        return d, governing, step(symbol, share, d, "m", law, d_0_star=d_0)
    way, terms, numbers = capacity.fit.way, [share], {"Gamma_star": Gamma}
    for name, (value, reason) in known.items():
        gone = 1.0 if way is None else float(way.blocks(value)) / value
        if gone * value * Gamma < d:
            d, governing = gone * value * Gamma, reason
        terms.append(f"{name}*Gamma_star" if way is None else f"{name}*{name.replace('d_', 'r_')}*Gamma_star")
        numbers |= {name: value} if way is None else {name: value, name.replace("d_", "r_"): gone}
    source = law
    if local is not None:
        reason = method.local_reason or message("given, without a reason")
        source = message("{law}; local limit: {reason}", law=law, reason=reason)
    line = step(symbol, f"min({', '.join(terms)})", d, "m", source, d_0_star=d_0, **numbers)
    return d, governing, line


def _scaled(
    demand: Demand, capacity: float, spectrum: Spectrum, method: Method
) -> tuple[Spectrum, tuple[Message, ...]]:
    """Return the spectrum that meets the capacity when scaled by capacity/demand, and notes."""
    if method.scaling == "shape" or method.hazard is None:
        return spectrum, ()
    return spectrum_at_return_period(demand, capacity, spectrum, method.hazard)


THRUSTING_A_G = 0.15
"""g: from this a_g on thrusting structures need the vertical component (§7.2.2) [k]."""

_SHARE = 0.3  # of the components that are not the leading one, §7.3.5


def vertical_component(
    spectrum: ElasticSpectrum, alpha_0: float, a_0_star: float, demand: float
) -> VerticalCheck:
    """Return the linear check of a mechanism with the weights made lighter by the vertical component.

    Rigid masses feel S_ve(0) = 1.35 S_T √(a_g/g) a_g (§3.2.3.2.2, S_S = 1). What bears is in proportion to the weights:
    E_x + 0.3 E_z makes α0 smaller by 1 − 0.3 a_v, 0.3 E_x + E_z by (1 − a_v)/0.3 (§7.3.5), and the smaller one counts.
    `demand` (g): what a_0* (g) is compared with.
    """
    a_g, S_T = spectrum.ag, spectrum.S_T
    a_v = 1.35 * S_T * sqrt(a_g) * a_g
    factor = min(1.0 - _SHARE * a_v, (1.0 - a_v) / _SHARE)
    law, rule = "NTC 2018, §3.2.3.2.2", "NTC 2018, §7.2.2, §7.3.5"
    lighter = factor * a_0_star
    trace = worked(
        datum("a_g", a_g, "g", "hazard of the site, or peak of the record"),
        step("a_v", "1.35*S_T*sqrt(a_g)*a_g", a_v, "g", law),
        step("lambda_v", "min(1 - 0.3*a_v, (1 - a_v)/0.3)", factor, "", rule),
        step("alpha_0_v", "lambda_v*alpha_0", factor * alpha_0, "", rule),
        step("a_0_star_v", "lambda_v*a_0_star", lighter, "g", rule),
        step("r_v", "a_0_star_v/a_demand", lighter / demand, "", "Circolare 7/2019, C8.7.1.2"),
        S_T=S_T, alpha_0=alpha_0, a_0_star=a_0_star, a_demand=demand,
    )  # fmt: skip
    return VerticalCheck(
        a_v_g=a_v, alpha_0=factor * alpha_0, a_0_star_g=lighter, demand_a_star_g=demand, ratio=lighter / demand,
        verified=bool(lighter >= demand), trace=[*trace],
    )  # fmt: skip
