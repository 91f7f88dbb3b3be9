"""Rigid blocks in dry contact: limit analysis, pushdown, pushover and time history by one mathematical program."""

from mechanics.assembly import Assembly, State
from mechanics.block import Block, Material
from mechanics.errors import ConvergenceError, DrawingError, NoEquilibriumError, UnstableError
from mechanics.limit import limit_analysis
from mechanics.pushdown import pushdown
from mechanics.pushover import pushover

__all__ = [
    "Assembly",
    "Block",
    "ConvergenceError",
    "DrawingError",
    "Material",
    "NoEquilibriumError",
    "State",
    "UnstableError",
    "limit_analysis",
    "pushdown",
    "pushover",
]
