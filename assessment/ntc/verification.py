"""Safety of a mechanism at the limit states: Circolare 7/2019, C8.7.1.2, and the 2009 circular's variant.

Every check solves for the ground acceleration a_g at which the demand equals the capacity, and carries the
trace of its calculation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from assessment.ntc.calculation import Trace, datum, step
from assessment.ntc.capacity.curve import CapacityCurve
from assessment.ntc.capacity.curve_fit import CapacityError
from assessment.ntc.capacity.return_period import capacity_return_period
from assessment.ntc.demand.return_period import EXCEEDANCE
from assessment.ntc.demand.spectrum import RecordSpectrum, Spectrum
from assessment.ntc.demand_capacity import (
    Solved,
    solve_activation,
    solve_displacement,
    solve_elastic,
    solve_linear,
)
from assessment.ntc.limit_states import INDEX, INDEXED, ROCK, SURFACE
from assessment.ntc.methods import ACTIVATION_DAMPING, LAW, Method
from mechanics.errors import require
from mechanics.messages import Message, message

__all__ = ["Check", "Method", "check_elastic", "check_linear", "check_nonlinear", "verify"]

CheckMethod = Literal["linear", "elastic", "nonlinear"]

_SURFACE_LAW = "NTC 2018, §3.2.3.2.1"
_COLLAPSE_FIRST = message(
    "SLV: d_SLC is reached at a smaller a_g under the same spectrum (the formulas allow it where T_SLV lies on "
    "the plateau): that a_g counts"
)
_SHAPES = message(
    "a_g of SLC comes out below that of SLV because their demand spectra differ in shape: the smaller one counts "
    "for both"
)


@dataclass(frozen=True)
class Check:
    """The answer of one check of one limit state.

    method: "linear", "elastic" or "nonlinear". d_star (m), a_star (g): point of the capacity curve that
    counts; T (s): its period; a_g: capacity, g; demand_a_g: demand, g; zeta_E: their ratio, with S on both
    sides, which is the index ζ_E at SLV only (§8.3); return_period: of the capacity, years, where the site's
    hazard, or the return period of the demand, is known. governing: what gave a_g. demand_a_star (g): of the linear
    check, what a_0* is compared with: a_g S/q at the ground, a_Z/q at height. reference: of a_g and demand_a_g, "rock"
    (category A, without S) or, of a record's spectrum, "surface"; S, demand_S: from there to the surface.
    Numbers are None where the capacity is not defined, and `notes` say why.
    """

    limit_state: str
    method: CheckMethod
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
    notes: tuple[Message, ...] = ()
    demand_a_star: float | None = None
    reference: str = ROCK
    S: float | None = None
    demand_S: float = 1.0  # noqa: N815

    @property
    def pga(self) -> float | None:
        """Capacity at the surface S a_g, g."""
        return None if self.a_g is None or self.S is None else self.S * self.a_g

    @property
    def demand_pga(self) -> float:
        """Demand at the surface S a_g, g."""
        return self.demand_S * self.demand_a_g


def verify(
    capacity: CapacityCurve, demands: Mapping[str, Spectrum], method: Method | None = None
) -> dict[str, Check]:
    """Return the checks of the limit states in `demands` (limit state → spectrum of the site at that state).

    SLO, SLD and "SLV linear": linear; "SLO elastic" and "SLD elastic": end of the elastic branch, where the curve has
    one; SLV and SLC: nonlinear. For a mechanism at height the spectra are floor spectra; for the paper's assessment a
    RecordSpectrum. A capacity that is not defined (d_0 not reached) gives a Check without numbers that says why.
    Raises ValueError for an unknown limit state or an unsuitable method.
    """
    method = method or Method()
    checks = {}
    for state, spectrum in demands.items():
        require(state in EXCEEDANCE, "limit state", state, "one of SLO, SLD, SLV, SLC")
        if state in {"SLO", "SLD"}:
            checks[state] = check_linear(capacity, state, spectrum, method)
            if capacity.T_0 is not None and method.circular == "2019":
                checks[f"{state} elastic"] = check_elastic(capacity, state, spectrum, method)
            continue
        try:
            checks[state] = check_nonlinear(capacity, state, spectrum, method)
        except CapacityError as refusal:
            checks[state] = _refused(state, spectrum, method, refusal.message)
        if state == "SLV":
            checks["SLV linear"] = check_linear(capacity, state, spectrum, method)
    life, collapse = (checks[state].a_g if state in checks else None for state in ("SLV", "SLC"))
    if life is not None and collapse is not None and collapse < life:
        checks["SLC"] = replace(checks["SLC"], notes=(*checks["SLC"].notes, _SHAPES))
    return checks


def check_linear(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the linear kinematic check of a_0* = α0/(e* F_C), of the rigid multiplier (Circolare 7/2019, C8.7.1.2).

    At the ground a_0* ≥ a_g S/q, at height a_0* ≥ a_Z(z)/q with a_Z = S_e(T_1) |γ ψ| √(1 + 0.0004 ξ²), not below
    a_g S (2009: S_e(T_1) ψ γ); q = 1 at SLO and SLD, the behaviour factor at SLV.
    """
    method = method or Method()
    q = method.behaviour_factor if limit_state in INDEXED else 1.0
    solved = solve_linear(capacity, spectrum, method, q)
    check = _check(limit_state, solved, capacity, spectrum, method, kind="linear")
    demand, steps = _linear_demand(check.demand_a_g, limit_state, spectrum, method, q)
    return replace(check, demand_a_star=demand, trace=(*check.trace, *steps))


def check_elastic(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the check of the end of the elastic branch: a_y* = S_e(T_0, 5 %) (Circolare 7/2019, C8.7.1.2).

    Raises CapacityError where the capacity curve has no elastic branch.
    """
    method = method or Method()
    solved = solve_elastic(capacity, spectrum, method)
    return _check(limit_state, solved, capacity, spectrum, method, kind="elastic")


def check_nonlinear(
    capacity: CapacityCurve, limit_state: str, spectrum: Spectrum, method: Method | None = None
) -> Check:
    """Return the nonlinear kinematic check at SLV or SLC (Circolare 7/2019, C8.7.1.2).

    d_SLV = min(0.40 d_0, local limit, end of the elastic curve), d_SLC = min(0.60 d_0, the same);
    T = 1.68 π √(d/a) at 8 % damping,
    T = 1.56 π √(d/a) at 10 %; a_g solves S_De(T) = d, is not below activation, and at SLV not above that at
    which the same spectrum reaches d_SLC. Circular of 2009:
    d_u = min(0.40 d_0, local limit), T_s = 2π √(d_s/a_s) at d_s = 0.4 d_u, S_De(T_s, 5 %) = d_u.
    Raises CapacityError where d_0 is not reached, where no capacity is left at the limit, or where the
    circular knows no nonlinear check for the limit state.
    """
    method = method or Method()
    solved = solve_displacement(capacity, limit_state, spectrum, method)
    if method.circular == "2019":
        if limit_state == "SLV":
            solved = _before_collapse(solved, capacity, spectrum, method)
        solved = _after_activation(solved, limit_state, capacity, spectrum, method)
    return _check(limit_state, solved, capacity, spectrum, method, kind="nonlinear")


def _before_collapse(life: Solved, capacity: CapacityCurve, spectrum: Spectrum, method: Method) -> Solved:
    """Return the solution of SLV, or that of SLC where the same spectrum reaches d_SLC at a smaller a_g.

    The formulas allow it where T_SLV lies on the plateau: a structure past SLC is past SLV.
    """
    try:
        collapse = solve_displacement(capacity, "SLC", spectrum, method)
    except CapacityError:
        return life
    if collapse.a_g >= life.a_g:
        return life
    *steps, last = collapse.steps
    line = step("a_g_nonlinear", "min(a_g_life, a_g_collapse)", collapse.a_g, "g", LAW["2019"],
                a_g_life=life.a_g, a_g_collapse=collapse.a_g)  # fmt: skip
    steps = [*life.steps[:-1], replace(life.steps[-1], symbol="a_g_life"), *steps,
             replace(last, symbol="a_g_collapse"), line]  # fmt: skip
    return replace(
        collapse, governing=f"SLC reached first: {collapse.governing}", steps=tuple(steps),
        notes=(*collapse.notes, _COLLAPSE_FIRST),
    )  # fmt: skip


def _after_activation(
    solved: Solved, limit_state: str, capacity: CapacityCurve, spectrum: Spectrum, method: Method
) -> Solved:
    """Return the solution, its a_g in no case below the activation of the mechanism."""
    active = solve_activation(capacity, spectrum, method)
    line = step(f"a_g_{limit_state}", "max(a_g_nonlinear, a_g_act)", max(solved.a_g, active.a_g), "g",
                LAW["2019"], a_g_nonlinear=solved.a_g, a_g_act=active.a_g)  # fmt: skip
    steps = (*solved.steps, *active.steps, line)
    if active.a_g > solved.a_g:
        solved = replace(solved, a_g=active.a_g, base=active.base, governing="activation", notes=active.notes)
    return replace(solved, steps=steps)


def _check(
    limit_state: str,
    solved: Solved,
    capacity: CapacityCurve,
    spectrum: Spectrum,
    method: Method,
    *,
    kind: CheckMethod,
) -> Check:
    """Return the Check of the capacity against the demand: `spectrum`'s own a_g, or that of the site."""
    a_g, S = solved.a_g, solved.base.S
    site = method.site_acceleration.get(limit_state)
    demand, S_demand = (spectrum.ag, spectrum.S) if site is None else (site, 1.0)
    source = "hazard of the site, or peak of the record" if site is None else "a_g S of the site"
    pga = a_g * S
    zeta = pga / (demand * S_demand)
    indexed = limit_state == INDEX
    symbol, law = ("zeta_E", "NTC 2018, §8.3") if indexed else (f"r_{limit_state}", LAW[method.circular])
    lines = [
        datum("a_g_demand", demand, "g", source),
        step("PGA_capacity", "S_capacity*a_g_capacity", pga, "g", _SURFACE_LAW, S_capacity=S, a_g_capacity=a_g),
        step("PGA_demand", "S_demand*a_g_demand", demand * S_demand, "g", _SURFACE_LAW, S_demand=S_demand,
             a_g_demand=demand),
        step(symbol, "PGA_capacity/PGA_demand", zeta, "", law, PGA_capacity=pga, PGA_demand=demand * S_demand),
    ]  # fmt: skip
    T_R = None
    if not isinstance(spectrum, RecordSpectrum):
        known = method.return_periods.get(limit_state)
        line = capacity_return_period(a_g, pga, demand * S_demand, known, method.hazard)
        if line is not None:
            T_R = line.result
            lines.append(line)
    trace = (*capacity.steps(), *solved.steps, *lines)
    return Check(
        limit_state, kind, solved.d_star, solved.a_star, solved.T, a_g, demand, zeta, zeta >= 1.0,
        solved.damping, T_R, solved.governing, trace, (*capacity.fit.notes, *solved.notes),
        reference=_reference(spectrum), S=S, demand_S=S_demand,
    )  # fmt: skip


def _reference(spectrum: Spectrum) -> str:
    """Return where the a_g of a spectrum is: a record's peak is that of its own surface."""
    return SURFACE if isinstance(spectrum, RecordSpectrum) else ROCK


def _linear_demand(
    a_g: float, limit_state: str, spectrum: Spectrum, method: Method, q: float
) -> tuple[float, Trace]:
    """Return what a_0* is compared with (g), and its steps; `a_g`: the demand, on the spectrum's own reference."""
    S = 1.0 if limit_state in method.site_acceleration else spectrum.S
    at_rest, law = float(spectrum.acceleration(0.0)), LAW[method.circular]
    if limit_state in method.site_acceleration or at_rest <= a_g * S * (1.0 + 1e-9):
        line = step(
            "a_demand", "a_g_demand*S_demand/q", a_g * S / q, "g", law, a_g_demand=a_g, S_demand=S, q=q
        )
        return line.result, (line,)
    line = step("a_demand", "S_eZ/q", at_rest / q, "g", law, S_eZ=at_rest, q=q)
    return line.result, (*spectrum.with_damping(ACTIVATION_DAMPING).steps(0.0), line)


def _refused(limit_state: str, spectrum: Spectrum, method: Method, reason: Message) -> Check:
    """Return the Check of a capacity that is not defined."""
    demand = method.site_acceleration.get(limit_state, spectrum.ag)
    return Check(
        limit_state,
        "nonlinear",
        None,
        None,
        None,
        None,
        demand,
        None,
        None,
        None,
        None,
        "",
        (),
        (reason,),
        reference=_reference(spectrum),
        demand_S=1.0 if limit_state in method.site_acceleration else spectrum.S,
    )
