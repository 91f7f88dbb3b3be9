"""Indices of safety and risk beside ζ_E, and what interventions must reach; not compared with the texts [k].

D.P.C.M. 9/2/2011 (heritage): I_S, f_a, acceptable nominal life; D.M. 58/2017, Allegato A: IS-V, PAM, risk class;
NTC 2018, §8.4: what interventions must reach.
"""

from bisect import bisect_right
from collections.abc import Mapping
from itertools import pairwise
from math import log

from assessment.ntc.tables import EXCEEDANCE, USE_COEFFICIENT, Trace, datum, step, worked
from assessment.results.schema import RiskIndices

CLASSES = ("A+", "A", "B", "C", "D", "E", "F", "G")
_IS_V = (1.0, 0.80, 0.60, 0.45, 0.30, 0.15)  # least IS-V of classes A+ to E; below: F
_PAM = (0.005, 0.010, 0.015, 0.025, 0.035, 0.045, 0.075)  # largest PAM of classes A+ to F; above: G
# share of the cost of reconstruction at each limit state, from initial damage to collapse
_COST = {"SLID": 0.0, "SLO": 0.07, "SLD": 0.15, "SLV": 0.50, "SLC": 0.80, "SLR": 1.0}
_INITIAL_DAMAGE = 0.1  # 1/years: annual frequency of initial damage
_SLO_OF_SLD, _SLC_OF_SLV = 1.67, 0.49  # frequencies of SLO and SLC from those of SLD and SLV
_HERITAGE = "D.P.C.M. 9/2/2011, §2.4"
_RISK = "D.M. 58/2017, Allegato A"


def heritage_and_risk_indices(
    a_g: float, demand_a_g: float, zeta: float, use_class: str, T_SLV: float | None = None,
    T_R_SLV: float | None = None, T_SLD: float | None = None,
) -> RiskIndices:  # fmt: skip
    """Return the indices from a_g and demand on rock (g), ratio ζ of PGA at SLV, T_R (years) of all."""
    f_a, C_U, P = a_g / demand_a_g, USE_COEFFICIENT[use_class], EXCEEDANCE["SLV"]
    lines = [
        datum("a_g_SLV", a_g, "g", _HERITAGE),
        datum("a_g_demand", demand_a_g, "g", _HERITAGE),
        step("f_a", "a_g_SLV/a_g_demand", f_a, "", _HERITAGE),
        step("IS_V", "zeta_SLV", zeta, "", _RISK),
    ]
    I_S = life = None
    known = {"T_SLV": T_SLV, "T_R_SLV": T_R_SLV, "T_SLD": T_SLD}
    lines += [datum(name, T, "years", _HERITAGE) for name, T in known.items() if T is not None]
    if T_SLV is not None and T_R_SLV is not None:
        I_S = T_SLV / T_R_SLV
        lines.append(step("I_S", "T_SLV/T_R_SLV", I_S, "", _HERITAGE))
    if T_SLV is not None:
        life = -T_SLV * log(1.0 - P) / C_U
        lines.append(step("V_N_acceptable", "-T_SLV*log(1 - P_VR)/C_U", life, "years", _HERITAGE))
    pam = pam_class = risk = None
    is_v_class = CLASSES[sum(zeta < least for least in _IS_V)]
    if T_SLV is not None and T_SLD is not None:
        pam, steps = expected_annual_loss(T_SLD, T_SLV)
        pam_class = CLASSES[bisect_right(_PAM, pam * (1.0 - 1e-12))]
        risk = max(is_v_class, pam_class, key=CLASSES.index)
        lines += steps
    return RiskIndices(
        I_S=I_S, f_a=f_a, acceptable_nominal_life_years=life, IS_V=zeta, IS_V_class=is_v_class, PAM=pam,
        PAM_class=pam_class, risk_class=risk, trace=[*worked(*lines, zeta_SLV=zeta, P_VR=P, C_U=C_U)],
    )  # fmt: skip


def expected_annual_loss(T_SLD: float, T_SLV: float) -> tuple[float, Trace]:
    """Return PAM, the area below cost over annual frequency, from T_R (years) of the capacities at SLD and SLV.

    λ = 1/T; λ_SLO = 1.67 λ_SLD, λ_SLC = 0.49 λ_SLV; no damage is more frequent than its beginning, λ = 0.1, and SLD is
    not rarer than SLV. The costs are trapezia between limit states, and the whole at λ_SLC.
    """
    SLV = min(_INITIAL_DAMAGE, 1.0 / T_SLV)
    SLD = min(_INITIAL_DAMAGE, max(1.0 / T_SLD, SLV))
    rates = {
        "SLID": _INITIAL_DAMAGE, "SLO": min(_INITIAL_DAMAGE, _SLO_OF_SLD * SLD), "SLD": SLD, "SLV": SLV,
        "SLC": _SLC_OF_SLV * SLV,
    }  # fmt: skip
    stretches = [(often, seldom, (_COST[often] + _COST[seldom]) / 2.0) for often, seldom in pairwise(rates)]
    pam = rates["SLC"] * _COST["SLR"] + sum((rates[a] - rates[b]) * cost for a, b, cost in stretches)
    parts = [
        f"({'lambda_' + a if a != 'SLID' else f'{_INITIAL_DAMAGE:g}'} - lambda_{b})*{cost:g}"
        for a, b, cost in stretches
    ]
    frequency = f"{_INITIAL_DAMAGE:g}"
    return pam, worked(
        step("lambda_SLV", f"min({frequency}, 1/T_SLV)", SLV, "1/years", _RISK),
        step("lambda_SLD", f"min({frequency}, max(1/T_SLD, lambda_SLV))", SLD, "1/years", _RISK),
        step("lambda_SLO", f"min({frequency}, {_SLO_OF_SLD:g}*lambda_SLD)", rates["SLO"], "1/years", _RISK),
        step("lambda_SLC", f"{_SLC_OF_SLV:g}*lambda_SLV", rates["SLC"], "1/years", _RISK),
        step("PAM", " + ".join([f"{_COST['SLR']:g}*lambda_SLC", *parts]), pam, "", _RISK),
        T_SLV=T_SLV,
        T_SLD=T_SLD,
    )


def required_zeta(zeta: float | None, use_class: str) -> dict[str, float | None]:
    """Return the ζ_E that each kind of intervention must reach from the one before it (NTC 2018, §8.4).

    Repair, §8.4.1: none; improvement, §8.4.2: 0.1 more in classes II and III, 0.6 at least in class IV and for schools
    of class III, nothing said of class I; retrofit, §8.4.3: 0.8 for changes of use and class (c, e), 1.0 otherwise.
    """
    more = None if zeta is None else min(1.0, zeta + 0.1)
    enough = None if zeta is None else max(0.6, min(1.0, zeta))
    return {
        "repair": None, "improvement": {"I": None, "II": more, "III": more, "IV": enough}[use_class],
        "improvement_school": enough if use_class == "III" else None, "retrofit_use": 0.8, "retrofit": 1.0,
    }  # fmt: skip


def attained(zeta: float, required: Mapping[str, float | None]) -> dict[str, bool]:
    """Return whether ζ_E after an intervention reaches what each kind of it requires, where that is known."""
    return {kind: zeta >= least for kind, least in required.items() if least is not None}
