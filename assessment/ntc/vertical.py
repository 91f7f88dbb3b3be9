"""The vertical component of the seismic action in the linear check of a mechanism.

NTC 2018, §3.2.3.2.2, §7.2.2, §7.3.5. Its numbers and thresholds are not compared with the text [k].
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from assessment.ntc.calculation import Trace, datum, step
from assessment.ntc.demand.spectrum import ElasticSpectrum

THRUSTING_A_G = 0.15
"""g: from this a_g on thrusting structures need the vertical component (§7.2.2) [k]."""

_SHARE = 0.3  # of the components that are not the leading one, §7.3.5


@dataclass(frozen=True)
class VerticalComponent:
    """The linear check with lighter weights: a_v and a_0* (g), α0, the ratio of a_0* to its demand; step by step."""

    a_v: float
    alpha_0: float
    a_0_star: float
    ratio: float
    trace: Trace


def vertical_component(
    spectrum: ElasticSpectrum, alpha_0: float, a_0_star: float, demand: float
) -> VerticalComponent:
    """Return the linear check of a mechanism with the weights made lighter by the vertical component.

    The masses of a rigid mechanism feel S_ve(0) = a_g S F_v/F_0 = 1.35 S_T √(a_g/g) a_g (§3.2.3.2.2, S_S = 1). What
    bears is in proportion to the weights, so that E_x + 0.3 E_z makes α0 smaller by the factor 1 − 0.3 a_v, and
    0.3 E_x + E_z by (1 − a_v)/0.3 against the whole horizontal action (§7.3.5): the smaller one counts.
    `demand` (g): what a_0* (g) of α0 is compared with.
    """
    a_g, S_T = spectrum.ag, spectrum.S_T
    a_v = 1.35 * S_T * sqrt(a_g) * a_g
    leading, beside = 1.0 - _SHARE * a_v, (1.0 - a_v) / _SHARE
    factor = min(leading, beside)
    law, rule = "NTC 2018, §3.2.3.2.2", "NTC 2018, §7.2.2, §7.3.5"
    lighter = factor * a_0_star
    trace = (
        datum("a_g", a_g, "g", "hazard of the site, or peak of the record"),
        step("a_v", "1.35*S_T*sqrt(a_g)*a_g", a_v, "g", law, S_T=S_T, a_g=a_g),
        step("lambda_v", "min(1 - 0.3*a_v, (1 - a_v)/0.3)", factor, "", rule, a_v=a_v),
        step("alpha_0_v", "lambda_v*alpha_0", factor * alpha_0, "", rule, lambda_v=factor, alpha_0=alpha_0),
        step("a_0_star_v", "lambda_v*a_0_star", lighter, "g", rule, lambda_v=factor,
             a_0_star=a_0_star),
        step("r_v", "a_0_star_v/a_demand", lighter / demand, "", "Circolare 7/2019, C8.7.1.2",
             a_0_star_v=lighter, a_demand=demand),
    )  # fmt: skip
    return VerticalComponent(a_v, factor * alpha_0, lighter, lighter / demand, trace)
