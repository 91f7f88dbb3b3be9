"""What standards tabulate, and what follows from single numbers: the lines of a calculation, return periods, risk.

Without arrays: a run in which nothing has changed reads a project, and needs none for that.
"""

import re
from bisect import bisect_right
from collections.abc import Container, Mapping
from itertools import pairwise
from math import inf, log
from typing import Final

from assessment.results.schema.checks import RiskIndices
from assessment.results.schema.model import Line

_NAME = re.compile(r"[A-Za-z_]\w*")
LINEAR = ("SLO", "SLD", "SLV linear")
QUOTED = ("SLC", "SLV", "SLD", "SLO")  # the farthest first
# the ratio of a_g borne to a_g demanded at the first that is checked is ζ_E (NTC 2018, §8.3)
INDEXED = ("SLV", "SLC")
INDEX = INDEXED[0]

# of an acceleration: on rigid ground (category A) without S, or with it
ROCK: Final = "rock"
SURFACE: Final = "surface"

EXCEEDANCE = {"SLO": 0.81, "SLD": 0.63, "SLV": 0.10, "SLC": 0.05}  # P_VR, Tab. 3.2.I
USE_COEFFICIENT = {"I": 0.7, "II": 1.0, "III": 1.5, "IV": 2.0}  # C_U, Tab. 2.4.II
SHORTEST, LONGEST = 30.0, 2475.0  # years, of the reference hazard
MEAN_FROM, ENOUGH = 7, 3  # records: NTC 2018 §7.3.5


Trace = tuple[Line, ...]


def step(symbol: str, formula: str, result: float, unit: str, paragraph: str, /, **inputs: float) -> Line:
    """Return a line of a result; its inputs are given, or those that `worked` finds in the lines before."""
    numbers, found = {name: float(value) for name, value in inputs.items()}, float(result)
    return Line(symbol=symbol, formula=formula, inputs=numbers, result=found, unit=unit, paragraph=paragraph)


def datum(symbol: str, value: float, unit: str, source: str) -> Line:
    """Return the line of a number that is given or read, not calculated; `source`: from where."""
    return step(symbol, "", value, unit, source)


def worked(*lines: Line, **known: float) -> Trace:
    """Return a calculation whose lines have the numbers that their formulas name: `known` ones, results before them."""
    results: dict[str, float] = {}
    found = []
    for line in lines:
        numbers = results | known | line.inputs
        inputs = {name: float(numbers[name]) for name in _NAME.findall(line.formula) if name in numbers}
        found.append(line if line.inputs.keys() == inputs.keys() else line.replace(inputs=inputs))
        results[line.symbol] = line.result
    return tuple(found)


def farthest(limit_states: Container[str]) -> str | None:
    """Return the farthest of some limit states, of which capacities are quoted; None of none."""
    return next((limit for limit in QUOTED if limit in limit_states), None)


def return_period(limit_state: str, nominal_life: float = 50.0, use_class: str = "II") -> float:
    """Return T_R = −V_R/ln(1 − P_VR), V_R = V_N C_U, years (NTC 2018, §2.4, §3.2.1; bounds [k]). Raises ValueError."""
    if limit_state not in EXCEEDANCE:
        raise ValueError(f"limit_state = {limit_state!r}: must be one of SLO, SLD, SLV, SLC")
    if use_class not in USE_COEFFICIENT:
        raise ValueError(f"use_class = {use_class!r}: must be one of I, II, III, IV")
    if not 0.0 < nominal_life < inf:
        raise ValueError(f"nominal_life = {nominal_life!r}: must be positive, in years")
    T_R = -nominal_life * USE_COEFFICIENT[use_class] / log(1.0 - EXCEEDANCE[limit_state])
    return min(max(T_R, SHORTEST), LONGEST)


PSI_2 = {"A": 0.3, "B": 0.3, "C": 0.6, "D": 0.6, "E": 0.8, "F": 0.6, "G": 0.3, "H": 0.0}
PSI_2 |= {"wind": 0.0, "snow": 0.0, "snow above 1000 m": 0.2}
"""Of variable loads by category: Tab. 2.5.I, not compared with the text [k]."""
OWN_PSI_2 = ("I", "K")  # of these categories the designer decides case by case


def psi_2(category: str | None, given: float | None) -> float:
    """Return ψ₂ of a variable load: as given, else that of its category of use (Tab. 2.5.I); 0 without either."""
    return given if given is not None else PSI_2[category] if category is not None else 0.0


CONFIDENCE_FACTOR = "Circolare 7/2019, C8.5.4"  # where F_C is a number that is given
LEVELS = {"LC1": 1.35, "LC2": 1.20, "LC3": 1.00}
COMPONENTS = {  # F_Ck that may be chosen, from limited to exhaustive knowledge (D.P.C.M. 9/2/2011, Tab. 4.1)
    "geometry": (0.05, 0.0),
    "construction": (0.12, 0.06, 0.0),
    "mechanical": (0.12, 0.06, 0.0),
    "ground": (0.06, 0.03, 0.0),
}


def confidence_factor(level: str | None, components: Mapping[str, float]) -> Line:
    """Return the step of F_C of a level of knowledge (C8.5.4), or 1 + Σ F_Ck of the components where none is given."""
    if level is not None:
        return datum("F_C", LEVELS[level], "", f"{CONFIDENCE_FACTOR}, {level}")
    named = {f"F_C{k}": components[name] for k, name in enumerate(COMPONENTS, 1)}
    formula = "1 + " + " + ".join(named)
    return step("F_C", formula, 1.0 + sum(named.values()), "", "D.P.C.M. 9/2/2011, §4.2", **named)


# indices beside ζ_E (D.P.C.M. 9/2/2011, of heritage; D.M. 58/2017, Allegato A); not compared with the texts [k]
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
