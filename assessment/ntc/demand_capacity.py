"""Where the demand of a spectrum meets the capacity of a mechanism: the a_g of each check, and its calculation."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from assessment.ntc.calculation import Step, Trace, step
from assessment.ntc.capacity.curve import CapacityCurve
from assessment.ntc.capacity.curve_fit import CapacityError
from assessment.ntc.demand.spectrum import Spectrum
from assessment.ntc.demand.spectrum_scaling import Demand, spectrum_at_return_period
from assessment.ntc.methods import ACTIVATION_DAMPING, LAW, RULES, Method, Nonlinear
from mechanics.messages import Message, message
from mechanics.types import GRAVITY


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


def solve_linear(capacity: CapacityCurve, spectrum: Spectrum, method: Method, q: float = 1.0) -> Solved:
    """Return where S_e(0) = q a_0*, of the rigid multiplier: a_g S at the ground, a_Z at height (C8.7.1.2)."""
    return _solve_acceleration(capacity.a_0_star, "a_0_star", None, 0.0, spectrum, method, q)


def solve_elastic(capacity: CapacityCurve, spectrum: Spectrum, method: Method) -> Solved:
    """Return where S_e(T_0) = a_y*, the end of the elastic branch (Circolare 7/2019, C8.7.1.2).

    Raises CapacityError where the capacity curve has no elastic branch.
    """
    if capacity.a_y_star is None or capacity.T_0 is None:
        raise CapacityError(message("the capacity curve has no elastic branch"))
    return _solve_acceleration(
        capacity.a_y_star, "a_y_star", capacity.d_y_star, capacity.T_0, spectrum, method
    )


def solve_activation(capacity: CapacityCurve, spectrum: Spectrum, method: Method) -> Solved:
    """Return where the capacity curve is left: at a_y* and T_0, or at a_0* where it is rigid (and in 2009)."""
    rigid = method.circular == "2009" or capacity.T_0 is None
    return (solve_linear if rigid else solve_elastic)(capacity, spectrum, method)


def _solve_acceleration(
    a_star: float,
    symbol: str,
    d_star: float | None,
    T: float,
    spectrum: Spectrum,
    method: Method,
    q: float = 1.0,
) -> Solved:
    """Return where S_e(T) = q a* at 5 % damping, with the symbol that a* has in the steps."""

    def demand(s: Spectrum) -> float:
        return float(s.acceleration(T))

    base, notes = _scaled(demand, q * a_star, spectrum.with_damping(ACTIVATION_DAMPING), method)
    S_e = demand(base)
    a_g = base.ag * q * a_star / S_e
    numbers = {"a_g": base.ag, symbol: a_star, "S_e": S_e}
    name, formula, governing = "a_g_act", f"a_g*{symbol}/S_e", "activation" if T == 0.0 else "elastic branch"
    if q != 1.0:
        name, formula, governing = "a_g_linear", f"q*{formula}", "q times activation"
        numbers["q"] = q
    line = step(name, formula, a_g, "g", LAW[method.circular], **numbers)
    return Solved(d_star, a_star, T, a_g, base, ACTIVATION_DAMPING, governing, (*base.steps(T), line), notes)


def solve_displacement(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method
) -> Solved:
    """Return where S_De(T) = d at the displacement limit d, T from the secant of the capacity curve.

    Raises CapacityError where d_0 is not reached, where no capacity is left at the limit, or where the
    circular knows no nonlinear check for the limit state.
    """
    rule = RULES.get((method.circular, limit_state))
    if rule is None:
        raise CapacityError(
            message(
                "{limit}: the circular of {year} has no nonlinear check for it",
                limit=limit_state,
                year=method.circular,
            )
        )
    d, governing, first = _limit(capacity, limit_state, method, rule)
    lines = [first]
    d_secant, name = d, limit_state
    if rule.secant != 1.0:
        d_secant, name = rule.secant * d, "s"
        lines.append(step("d_s", f"{rule.secant:g}*{first.symbol}", d_secant, "m", LAW[method.circular],
                          **{first.symbol: d}))  # fmt: skip
    a = capacity.a_star(d_secant)
    if a <= 0.0:
        raise CapacityError(
            message(
                "{limit}: no acceleration capacity is left at d* = {displacement:.6g} m",
                limit=limit_state,
                displacement=d_secant,
            )
        )
    T, T_0 = rule.factor * pi * sqrt(d_secant / (a * GRAVITY)), capacity.T_0 or 0.0
    largest = method.displacement_demand == "maximum"

    def demand(s: Spectrum) -> float:
        return s.largest_displacement(T_0, T)[0] if largest else float(s.displacement(T))

    base, notes = _scaled(demand, d, spectrum.with_damping(rule.damping), method)
    S_De = demand(base)
    a_g = base.ag * d / S_De
    highest, at = base.largest_displacement(T_0, T)
    if highest > 1.001 * S_De:
        larger = message(
            "{limit}: S_De of the demand is larger at {at:.3g} s than at T = {T:.3g} s: the maximum over "
            "[T_0, T] of the circular would give a_g = {least:.3g} g in place of {a_g:.3g} g",
            limit=limit_state, at=at, T=T, least=base.ag * d / highest, a_g=a_g,
        )  # fmt: skip
        notes = (*notes, larger)
    lines += [
        _curve_step(capacity, f"a_{name}", d_secant, a),
        step(f"T_{name}", f"{rule.factor:g}*pi*sqrt(d/(a*g))", T, "s", LAW[method.circular], d=d_secant, a=a,
             g=GRAVITY),
        *(base.demand_steps(T_0, T) if largest else base.steps(T)),
        step("a_g_nonlinear", "a_g*d/S_De", a_g, "g", LAW[method.circular], a_g=base.ag, d=d, S_De=S_De),
    ]  # fmt: skip
    return Solved(d, a, T, a_g, base, rule.damping, governing, tuple(lines), notes)


def _limit(
    capacity: CapacityCurve, limit_state: str, method: Method, rule: Nonlinear
) -> tuple[float, str, Step]:
    """Return the displacement limit d* (m), what sets it, and its step."""
    d_0, Gamma = capacity.d_0_star, capacity.gamma_star
    if d_0 is None:
        raise CapacityError(
            message(
                "{limit}: d_0 is not reached: the multiplier of the rigid branch stays positive up to "
                "{displacement:.6g} m; follow the pushover with rigid contacts to zero",
                limit=limit_state,
                displacement=float(capacity.fit.displacement[-1]),
            )
        )
    symbol = "d_u" if method.circular == "2009" else f"d_{limit_state}"
    share, law = f"{rule.share:g}*d_0_star", LAW[method.circular]
    d, governing = rule.share * d_0, f"{rule.share:.2f} d_0"
    local, elastic = method.local_limits.get(limit_state), capacity.fit.elastic_end
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


def _curve_step(capacity: CapacityCurve, symbol: str, d: float, a: float) -> Step:
    """Return the interpolation of a* on the capacity curve between the two points about d."""
    k = int(np.clip(np.searchsorted(capacity.displacement, d), 1, len(capacity.displacement) - 1))
    d_1, d_2 = capacity.displacement[k - 1 : k + 1]
    a_1, a_2 = capacity.acceleration[k - 1 : k + 1]
    return step(symbol, "a_1 + (a_2 - a_1)*(d - d_1)/(d_2 - d_1)", a, "g", "capacity curve", a_1=a_1, a_2=a_2,
                d=d, d_1=d_1, d_2=d_2)  # fmt: skip


def _scaled(
    demand: Demand, capacity: float, spectrum: Spectrum, method: Method
) -> tuple[Spectrum, tuple[Message, ...]]:
    """Return the spectrum that meets the capacity when scaled by capacity/demand, and notes."""
    if method.scaling == "shape" or method.hazard is None:
        return spectrum, ()
    return spectrum_at_return_period(demand, capacity, spectrum, method.hazard)
