"""How the checks are made: the rules of the two circulars, and what the user chooses among them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from assessment.ntc.demand.hazard import HazardCurve
from mechanics.errors import require

ACTIVATION_DAMPING = 0.05


@dataclass(frozen=True, slots=True)
class Nonlinear:
    """Displacement limit as a share of d_0, T = factor π √(d/a) at `secant` of the limit, damping."""

    share: float
    secant: float
    factor: float
    damping: float


RULES = {
    ("2019", "SLV"): Nonlinear(0.40, 1.0, 1.68, 0.08),
    ("2019", "SLC"): Nonlinear(0.60, 1.0, 1.56, 0.10),
    ("2009", "SLV"): Nonlinear(0.40, 0.4, 2.00, 0.05),
}
LAW = {"2019": "Circolare 7/2019, C8.7.1.2", "2009": "Circolare 617/2009, C8A.4.2.3"}


@dataclass(frozen=True)
class Method:
    """How the checks are made.

    behaviour_factor: q of the linear check. circular: "2019", or "2009" (secant at 0.4 d_u, 5 % damping, no
    lower bound by activation; SLV only) [k]. scaling: how the demand spectrum follows a_g to the capacity:
    "shape" keeps its shape (S_S and T_D with it) and scales it; "return_period" moves along `hazard` until
    the spectrum of that return period meets the capacity. displacement_demand: "maximum" of S_De over
    [T_0, T], which differs from S_De(T) for records and beyond T_E; "at_period": S_De(T), as in the paper.
    local_limits: displacement of the control point (m) at which an element is lost (a beam unseats), per
    limit state; local_reason: what is lost, for the calculation. site_acceleration: a_g S of the site (g) per
    limit state, compared with the peak acceleration where the spectrum is a record's. return_periods: T_R of the
    demand (years) per limit state, where it is known. Raises ArgumentError naming the field.
    """

    behaviour_factor: float = 2.0
    circular: str = "2019"
    scaling: str = "shape"
    displacement_demand: str = "maximum"
    hazard: HazardCurve | None = None
    local_limits: Mapping[str, float] = field(default_factory=dict)
    local_reason: str = ""
    site_acceleration: Mapping[str, float] = field(default_factory=dict)
    return_periods: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require(self.behaviour_factor >= 1.0, "behaviour_factor", self.behaviour_factor, "1 or more")
        require(self.circular in {"2019", "2009"}, "circular", self.circular, '"2019" or "2009"')
        require(self.scaling in {"shape", "return_period"}, "scaling", self.scaling, "shape or return_period")
        require(
            self.displacement_demand in {"maximum", "at_period"},
            "displacement_demand",
            self.displacement_demand,
            "maximum or at_period",
        )
        require(
            self.scaling == "shape" or self.hazard is not None,
            "scaling",
            self.scaling,
            "shape where the site's hazard is not given by latitude, longitude and grid",
        )
        for state, limit in self.local_limits.items():
            require(0.0 < limit < inf, f"local_limits.{state}", limit, "positive, in m")
