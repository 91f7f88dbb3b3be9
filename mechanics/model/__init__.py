"""Blocks, the joints between them as drawn, and where they touch in a configuration."""

from mechanics.kernels.joint import NX, NZ, H, V
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.model.block import Block, Material, Tie, connected, default_tolerance
from mechanics.model.contacts import (
    Contacts,
    FaceLines,
    end_gaps,
    end_points,
    face_lines,
    kinematic_contacts,
    relative_motion,
)
from mechanics.model.drawing import METRES, Drawing, Layer, Sheet, of_block, read_drawing, survey_drawing
from mechanics.model.dxf import dxf_bytes, reproducible
from mechanics.model.layout import NEAR, survey_layout
from mechanics.model.polylines import PlacedOutline
from mechanics.model.repair import Repair, repair_drawing

__all__ = [
    "METRES", "NEAR", "NX", "NZ", "Assembly", "Behaviour", "Block", "Contacts", "Direction", "Drawing",
    "FaceLines", "H", "Layer", "Material", "PlacedOutline", "Repair", "Sheet", "State", "Tie", "V",
    "connected", "default_tolerance", "dxf_bytes", "end_gaps", "end_points", "face_lines", "kinematic_contacts",
    "of_block", "read_drawing", "relative_motion", "repair_drawing", "reproducible", "survey_drawing",
    "survey_layout",
]  # fmt: skip
