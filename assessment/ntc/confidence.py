"""The confidence factor F_C from what is known of a structure. In plain Python, as what reads a project has to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from assessment.ntc.calculation import Trace, datum, step

CONFIDENCE_FACTOR = "Circolare 7/2019, C8.5.4"  # where F_C is a number that is given


@dataclass(frozen=True)
class Knowledge:
    """F_C (–) with the components it is made of: by level of knowledge (C8.5.4) or 1 + Σ F_Ck (D.P.C.M. 9/2/2011)."""

    factor: float
    trace: Trace


LEVELS = {"LC1": 1.35, "LC2": 1.20, "LC3": 1.00}
COMPONENTS = {  # F_Ck that may be chosen, from limited to exhaustive knowledge (D.P.C.M. 9/2/2011, Tab. 4.1)
    "geometry": (0.05, 0.0),
    "construction": (0.12, 0.06, 0.0),
    "mechanical": (0.12, 0.06, 0.0),
    "ground": (0.06, 0.03, 0.0),
}


def confidence_factor(level: str | None, components: Mapping[str, float]) -> Knowledge:
    """Return F_C of a level of knowledge, or 1 + Σ F_Ck of the four components where no level is given."""
    if level is not None:
        source = f"{CONFIDENCE_FACTOR}, {level}"
        return Knowledge(LEVELS[level], (datum("F_C", LEVELS[level], "", source),))
    named = {f"F_C{k}": components[name] for k, name in enumerate(COMPONENTS, 1)}
    factor = 1.0 + sum(named.values())
    line = step("F_C", "1 + " + " + ".join(named), factor, "", "D.P.C.M. 9/2/2011, §4.2", **named)
    return Knowledge(factor, (line,))
