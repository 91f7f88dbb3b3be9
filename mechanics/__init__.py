"""Rigid blocks in dry contact: limit analysis, pushdown, pushover and time histories by one program."""

from mechanics.errors import (
    ArgumentError,
    CollapseError,
    ControlError,
    ConvergenceError,
    DrawingError,
    MechanicsError,
    NoEquilibriumError,
    RecordError,
    UnstableError,
)
from mechanics.model.assembly import Assembly, State
from mechanics.model.block import Block, Material
from mechanics.model.dxf import Layer, read_drawing
from mechanics.model.tie import Tie
from mechanics.procedures.following import Following
from mechanics.procedures.limit_analysis import limit_analysis
from mechanics.procedures.pushdown import pushdown
from mechanics.procedures.pushover import pushover
from mechanics.procedures.time_history import TimeHistory, time_history
from mechanics.records.record import Record, read_record

__all__ = [
    "ArgumentError",
    "Assembly",
    "Block",
    "CollapseError",
    "ControlError",
    "ConvergenceError",
    "DrawingError",
    "Following",
    "Layer",
    "Material",
    "MechanicsError",
    "NoEquilibriumError",
    "Record",
    "RecordError",
    "State",
    "Tie",
    "TimeHistory",
    "UnstableError",
    "limit_analysis",
    "pushdown",
    "pushover",
    "read_drawing",
    "read_record",
    "time_history",
]
