"""Drawings that tests make and read."""

from pathlib import Path

import pytest
from ezdxf.filemanagement import new

from mechanics.errors import DrawingError
from mechanics.model.block import Material
from mechanics.model.drawing import Layer, read_drawing

STONE = Layer(Material(18.0), depth=1.0)


SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]


UNITS = {"mm": 4, "cm": 5, "m": 6}


def drawing(version: str = "R2018", unit: str = "mm"):
    """An empty document and its model space."""
    document = new(version)
    if version != "R12":
        document.header["$INSUNITS"] = UNITS[unit]
    return document, document.modelspace()


def outline(space, points, layer="STONES", close=True):
    return space.add_lwpolyline(points, close=close, format="xyb", dxfattribs={"layer": layer})


def read(document, folder: Path, unit="mm", layers=None, sagitta=None, fmt="asc"):
    path = folder / "geometry.dxf"
    document.saveas(path, fmt=fmt)
    return read_drawing(path, unit, STONE, layers or {}, sagitta)


def refused(document, folder: Path, **options) -> str:
    with pytest.raises(DrawingError) as caught:
        read(document, folder, **options)
    message = str(caught.value)
    assert message.startswith(f"{folder / 'geometry.dxf'}: ")
    return message
