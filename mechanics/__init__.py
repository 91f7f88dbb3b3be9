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
from mechanics.procedures.limit_analysis import limit_analysis
