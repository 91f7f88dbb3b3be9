"""One step of an analysis: an equilibrium, or a time step."""

from mechanics.steps.equilibrium import check_self_weight, unpressed
from mechanics.steps.static_system import Sliding, static_system
from mechanics.steps.tolerances import LIMIT

__all__ = ["LIMIT", "Sliding", "check_self_weight", "static_system", "unpressed"]
