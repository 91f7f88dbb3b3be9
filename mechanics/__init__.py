"""Rigid blocks in dry contact: limit analysis, pushdown and pushover by one program."""

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
from mechanics.pushdown import pushdown
from mechanics.pushover import pushover

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
    "UnstableError",
    "limit_analysis",
    "pushdown",
    "pushover",
    "read_drawing",
]
