"""The analyses: each reads as its pseudo-code.

The analyses themselves are public names of `mechanics`; here are their results and helpers.
"""

from mechanics.procedures.energy import may_fall
from mechanics.procedures.limit_analysis import (
    farthest_corner,
    friction_work,
    hinges,
    limit_in,
    virtual_work_multiplier,
)
from mechanics.procedures.mirror import Mirror
from mechanics.procedures.motion_start import HISTORY
from mechanics.procedures.path_start import settled
from mechanics.procedures.pushdown import Pushdown, pushdown_together
from mechanics.procedures.pushover import Pushover
from mechanics.procedures.static_theorem import static_theorem
from mechanics.procedures.step_control import PATH
from mechanics.procedures.support_movement import SupportMovement, drawn_extent, whole_movement
from mechanics.procedures.time_history import unfinished

__all__ = [
    "HISTORY", "PATH", "Mirror", "Pushdown", "Pushover", "SupportMovement", "drawn_extent", "farthest_corner",
    "friction_work", "hinges", "limit_in", "may_fall", "pushdown_together", "settled", "static_theorem", "unfinished",
    "virtual_work_multiplier", "whole_movement",
]  # fmt: skip
