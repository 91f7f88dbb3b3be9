"""Return period of the action that a structure bears, T_R,C, within and beyond the hazard of its site."""

from __future__ import annotations

from assessment.ntc.calculation import Step, step
from assessment.ntc.demand.hazard import HazardCurve
from assessment.ntc.demand.hazard_grid import RETURN_PERIODS

EXPONENT = 0.41  # slope of log a_g over log T_R for Italy as a whole (not compared with the text [k])
_LAW = "D.M. 58/2017, Allegato A; NTC 2018, §3.2.1"


def capacity_return_period(
    a_g: float, pga: float, demand_pga: float, demand_T_R: float | None, hazard: HazardCurve | None
) -> Step | None:
    """Return the step of T_R,C (years); None where neither the hazard curve nor the demand's T_R is known.

    a_g (g) on rock is looked up on the site's hazard between 30 and 2475 years; beyond, and without a curve,
    T_R,C = T_R,D (PGA_C/PGA_D)^(1/0.41), PGA at the surface, and not back inside the bound of the curve. Where
    the demand's T_R is not known either, the bound stands for what lies beyond it.
    """
    if hazard is not None and (demand_T_R is None or hazard.values[0, 0] <= a_g <= hazard.values[-1, 0]):
        return hazard.return_period_step(a_g)
    if demand_T_R is None:
        return None
    formula = f"T_R_demand*(PGA_capacity/PGA_demand)**(1/{EXPONENT:g})"
    T_R = demand_T_R * (pga / demand_pga) ** (1.0 / EXPONENT)
    if hazard is not None:
        low, *_, high = RETURN_PERIODS.tolist()
        above = a_g > hazard.values[-1, 0]
        T_R = max(high, T_R) if above else min(low, T_R)
        formula = f"max({high:g}, {formula})" if above else f"min({low:g}, {formula})"
    return step("T_R_capacity", formula, T_R, "years", _LAW, T_R_demand=demand_T_R, PGA_capacity=pga,
                PGA_demand=demand_pga)  # fmt: skip


def stated(T_R: float | None) -> str | None:
    """Return "> 2475" or "< 30" for a return period (years) outside what the hazard is known for, otherwise None."""
    low, *_, high = RETURN_PERIODS.tolist()
    if T_R is None or low <= T_R <= high:
        return None
    return f"> {high:g}" if high < T_R else f"< {low:g}"
