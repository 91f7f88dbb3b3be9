"""One step of an analysis: an equilibrium, or a time step."""

from mechanics.steps.equilibrium import CLOSED, ONSET, check_self_weight
from mechanics.steps.static_step import Sliding, static_system

__all__ = [
    "CLOSED",
    "ONSET",
    "Sliding",
    "check_self_weight",
    "static_system",
]
