"""Return periods of the limit states from nominal life and use class (NTC 2018, §2.4 and §3.2.1).

In plain Python: a run in which nothing has changed reads a project, and needs no arrays for that.
"""

from __future__ import annotations

from math import inf, log

EXCEEDANCE = {"SLO": 0.81, "SLD": 0.63, "SLV": 0.10, "SLC": 0.05}  # P_VR, Tab. 3.2.I
USE_COEFFICIENT = {"I": 0.7, "II": 1.0, "III": 1.5, "IV": 2.0}  # C_U, Tab. 2.4.II
SHORTEST, LONGEST = 30.0, 2475.0  # years, of the reference hazard


def return_period(limit_state: str, nominal_life: float = 50.0, use_class: str = "II") -> float:
    """Return T_R = −V_R/ln(1 − P_VR), V_R = V_N C_U, in years (NTC 2018, §2.4 and §3.2.1).

    The bounds 30 and 2475 years are not compared with the text [k]. Raises ValueError naming the argument.
    """
    if limit_state not in EXCEEDANCE:
        raise ValueError(f"limit_state = {limit_state!r}: must be one of SLO, SLD, SLV, SLC")
    if use_class not in USE_COEFFICIENT:
        raise ValueError(f"use_class = {use_class!r}: must be one of I, II, III, IV")
    if not 0.0 < nominal_life < inf:
        raise ValueError(f"nominal_life = {nominal_life!r}: must be positive, in years")
    T_R = -nominal_life * USE_COEFFICIENT[use_class] / log(1.0 - EXCEEDANCE[limit_state])
    return min(max(T_R, SHORTEST), LONGEST)
