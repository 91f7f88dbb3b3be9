"""What standards tabulate: limit states, return periods, loads, confidence factors; the lines of a calculation.

Without arrays: a run in which nothing has changed reads a project, and needs none for that.
"""

import re
from collections.abc import Container, Mapping
from math import inf, log
from typing import Final

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
    numbers = {name: float(value) for name, value in inputs.items()}
    return Line(
        symbol=symbol, formula=formula, inputs=numbers, result=float(result), unit=unit, paragraph=paragraph
    )


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
