"""Rigid blocks in dry contact: limit analysis, pushdown, pushover and time histories by one program."""

from mechanics.assembly import Assembly, State
from mechanics.block import Block, Material
from mechanics.drawing import read_drawing
from mechanics.errors import (
    CollapseError,
    ControlError,
    ConvergenceError,
    DrawingError,
    NoEquilibriumError,
    UnstableError,
)
from mechanics.limit import limit_analysis
from mechanics.load_control import load_control
from mechanics.pushdown import pushdown
from mechanics.pushover import pushover
from mechanics.time_history import TimeHistory, time_history

__all__ = [
    "Assembly",
    "Block",
    "CollapseError",
    "ControlError",
    "ConvergenceError",
    "DrawingError",
    "Material",
    "NoEquilibriumError",
    "State",
    "TimeHistory",
    "UnstableError",
    "limit_analysis",
    "load_control",
    "pushdown",
    "pushover",
    "read_drawing",
    "time_history",
]
