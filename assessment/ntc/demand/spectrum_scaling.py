"""How the demand spectrum follows the ground acceleration up to the capacity.

S_S, T_D and, with the return period, F0 and T_C* depend on a_g, so the method must be declared (ζ_E).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import exp, log

from assessment.ntc.demand.floor_spectrum import FloorSpectrum, FloorSpectrum2009
from assessment.ntc.demand.hazard import Hazard, HazardCurve
from assessment.ntc.demand.hazard_grid import RETURN_PERIODS
from assessment.ntc.demand.spectrum import ElasticSpectrum, Spectrum
from mechanics.messages import Message, message

Demand = Callable[[Spectrum], float]
_LOW, *_, _HIGH = RETURN_PERIODS.tolist()


def spectrum_at_return_period(
    demand: Demand, capacity: float, spectrum: Spectrum, hazard: HazardCurve
) -> tuple[Spectrum, tuple[Message, ...]]:
    """Return the spectrum of the first return period whose demand is the capacity, and notes.

    demand maps a spectrum to an ordinate in the unit of capacity. Beyond 30–2475 years the spectrum of the
    nearest bound is returned, to be scaled, with a note. Raises ValueError for the spectrum of a record.
    """

    def at(T_R: float) -> Spectrum:
        return with_hazard(spectrum, hazard.at(min(max(T_R, _LOW), _HIGH)))

    def excess(log_T_R: float) -> float:
        return demand(at(exp(log_T_R))) / capacity - 1.0

    knots = [log(T_R) for T_R in RETURN_PERIODS]
    over = [excess(knot) >= 0.0 for knot in knots]
    if over[0]:
        return at(_LOW), (
            message("capacity below the hazard of 30 years: the shape of that return period is scaled"),
        )
    if not any(over):
        return at(_HIGH), (
            message("capacity above the hazard of 2475 years: the shape of that return period is scaled"),
        )
    from scipy.optimize import brentq  # late: few projects need it, and it takes long to import

    k = over.index(True)
    return at(exp(float(brentq(excess, knots[k - 1], knots[k], xtol=1e-14, rtol=1e-14)))), ()


def with_hazard(spectrum: Spectrum, hazard: Hazard) -> Spectrum:
    """Return the spectrum on the same ground under another hazard. Raises ValueError for that of a record."""
    if isinstance(spectrum, ElasticSpectrum):
        return replace(spectrum, ag=hazard.ag, F0=hazard.F0, Tc_star=hazard.Tc_star)
    if isinstance(spectrum, FloorSpectrum | FloorSpectrum2009):
        ground = replace(spectrum.ground, ag=hazard.ag, F0=hazard.F0, Tc_star=hazard.Tc_star)
        return replace(spectrum, ground=ground)
    raise ValueError('scaling = "return_period": must be "shape" where the spectrum is that of a record')
