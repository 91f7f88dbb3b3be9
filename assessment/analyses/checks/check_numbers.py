"""A check as plain numbers for results.json."""

from __future__ import annotations

from typing import Any

from assessment.ntc.calculation import numbers
from assessment.ntc.capacity_return_period import stated
from assessment.ntc.verification import Check


def check_numbers(check: Check, common: int) -> dict[str, Any]:
    """Return the numbers of a check; its trace leaves out the `common` first steps, those of the capacity curve."""
    return {
        "method": check.method,
        "d_star_m": check.d_star,
        "a_star_g": check.a_star,
        "T_s": check.T,
        "a_g_g": check.a_g,
        "demand_a_g_g": check.demand_a_g,
        "demand_a_star_g": check.demand_a_star,
        "pga_g": check.pga,
        "demand_pga_g": check.demand_pga,
        "S": check.S,
        "demand_S": check.demand_S,
        "reference": check.reference,
        "zeta_E": check.zeta_E,
        "verified": check.verified,
        "damping": check.damping,
        "return_period_years": check.return_period,
        "return_period_stated": stated(check.return_period),
        "governing": check.governing,
        "notes": list(check.notes),
        "trace": numbers(check.trace[common:]),
    }
