"""Rigid blocks in dry contact: limit analysis, pushdown, pushover and time histories by one program."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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
    from mechanics.model.block import Block, Material, Tie
    from mechanics.model.drawing import Layer, read_drawing
    from mechanics.procedures.limit_analysis import Limit, limit_analysis
    from mechanics.procedures.pushdown import Pushdown, pushdown
    from mechanics.procedures.pushover import Pushover, pushover
    from mechanics.procedures.support_movement import Following
    from mechanics.procedures.time_history import TimeHistory, time_history
    from mechanics.records.record import Record, read_record

_NAMES = {  # by the module that has them
    "errors": "ArgumentError CollapseError ControlError ConvergenceError DrawingError MechanicsError "
    "NoEquilibriumError RecordError UnstableError",
    "model.assembly": "Assembly State",
    "model.block": "Block Material Tie",
    "model.drawing": "Layer read_drawing",
    "procedures.limit_analysis": "Limit limit_analysis",
    "procedures.pushdown": "Pushdown pushdown",
    "procedures.pushover": "Pushover pushover",
    "procedures.support_movement": "Following",
    "procedures.time_history": "TimeHistory time_history",
    "records.record": "Record read_record",
}
_HOME = {name: home for home, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_HOME)  # noqa: PLE0605 - each is named once


def __getattr__(name: str) -> Any:
    """Import a public name where it is first asked for: what needs a message or an error alone needs no NumPy."""
    if name not in _HOME:
        raise AttributeError(f"module 'mechanics' has no attribute {name!r}")
    return getattr(import_module(f"mechanics.{_HOME[name]}"), name)
