"""Checks and capacity curves of the standard as results.json has them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from assessment.ntc import verification
from assessment.ntc.capacity import curve as capacity
from assessment.ntc.capacity.return_period import stated
from assessment.results.lines import lines
from assessment.results.plain import finite
from assessment.results.schema.checks import CapacityCurve, Check

Kind = TypeVar("Kind", bound=Check)


def check_of(kind: type[Kind], check: verification.Check, common: int, **more: Any) -> Kind:
    """Return a check as a part of the results of that kind, with what such a part has `more`; null: not finite.

    Its trace leaves out the `common` first steps, those of the capacity curve.
    """
    return kind(
        method=check.method,
        d_star_m=finite(check.d_star),
        a_star_g=finite(check.a_star),
        T_s=finite(check.T),
        a_g_g=finite(check.a_g),
        demand_a_g_g=check.demand_a_g,
        demand_a_star_g=finite(check.demand_a_star),
        pga_g=finite(check.pga),
        demand_pga_g=finite(check.demand_pga),
        S=finite(check.S),
        demand_S=finite(check.demand_S),
        reference=check.reference,
        zeta_E=finite(check.zeta_E),
        verified=check.verified,
        damping=finite(check.damping),
        return_period_years=finite(check.return_period),
        return_period_stated=stated(check.return_period),
        governing=check.governing,
        notes=list(check.notes),
        trace=lines(check.trace[common:]),
        **more,
    )


def checks_of(curve: capacity.CapacityCurve, checks: Mapping[str, verification.Check]) -> dict[str, Check]:
    """Return the checks of a capacity curve by their names; linear ones with α and e* of what is activated first."""
    common = len(curve.steps())
    linear = {"alpha_0": curve.activation.alpha, "e_star": curve.activation.e_star}
    return {
        name: check_of(Check, check, common, **(linear if check.method == "linear" else {}))
        for name, check in checks.items()
    }


def curve_of(curve: capacity.CapacityCurve) -> CapacityCurve:
    """Return a capacity curve as a part of the results: d* (m) and a* (g), divided by the confidence factor."""
    return CapacityCurve(d_star_m=curve.displacement.tolist(), a_star_g=curve.acceleration.tolist())
