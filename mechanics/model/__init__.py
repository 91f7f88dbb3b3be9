"""Blocks, the joints between them as drawn, and where they touch in a configuration."""

from mechanics.kernels.joint import (
    A1,
    A2,
    B1,
    B2,
    FACE,
    MEET,
    NX,
    NZ,
    PX,
    PZ,
    QX,
    QZ,
    TAX,
    TAZ,
    TBX,
    TBZ,
    H,
    V,
)
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.model.block import Block, Material
from mechanics.model.contacts import CORNER, Contacts, end_gaps, end_points, rows
from mechanics.model.dxf import Drawing, Layer, read_drawing, survey_drawing
from mechanics.model.joints import default_tolerance
from mechanics.model.model_checks import survey_layout

__all__ = [
    "A1",
    "A2",
    "B1",
    "B2",
    "CORNER",
    "FACE",
    "MEET",
    "NX",
    "NZ",
    "PX",
    "PZ",
    "QX",
    "QZ",
    "TAX",
    "TAZ",
    "TBX",
    "TBZ",
    "Assembly",
    "Behaviour",
    "Block",
    "Contacts",
    "Direction",
    "Drawing",
    "H",
    "Layer",
    "Material",
    "State",
    "V",
    "default_tolerance",
    "end_gaps",
    "end_points",
    "read_drawing",
    "rows",
    "survey_drawing",
    "survey_layout",
]
