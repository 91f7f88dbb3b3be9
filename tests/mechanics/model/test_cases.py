"""Drawings that once gave a wrong model or took minutes, each small: read, refused by name, or mended."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from mechanics.model import default_tolerance, read_drawing, repair_drawing, survey_drawing, survey_layout
from mechanics.model.drawing import Layer
from mechanics.model.layout import touching
from tests.support.dxf import STONE, drawing, outline, read, refused

BASE = {"BASE": Layer(STONE.material, 1.0, support="base")}


def test_repair_opens_gaps(tmp_path):
    """An arch ring with a vertex 1 mm off the edge that it bears on, 7 mm from its next vertex: no joint is lost."""
    rng = np.random.default_rng(8)
    angle = np.linspace(0.0, np.pi, 16)
    inner, outer = (r * np.column_stack([np.cos(angle), np.sin(angle)]) for r in (1500.0, 1800.0))
    rings = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(15)]
    rings += [  # piers, whose corners are a few mm beside those of the ring
        np.array([(side * 1493, -800), (side * 1806, -800), (side * 1806, 0), (side * 1493, 0)])
        for side in (1, -1)
    ]
    document, space = drawing()
    for ring in rings:
        outline(space, (ring + rng.uniform(-0.6, 0.6, ring.shape)).tolist(), "ARCH")
    outline(space, [(-2000, -1000), (2000, -1000), (2000, -800), (-2000, -800)], "BASE")
    document.saveas(tmp_path / "geometry.dxf")
    before = survey_drawing(tmp_path / "geometry.dxf", "mm", STONE, BASE).blocks
    tolerance = default_tolerance(before)
    repair = repair_drawing(tmp_path / "geometry.dxf", "mm", STONE, BASE)
    (tmp_path / "repaired.dxf").write_bytes(repair.file)
    after = read_drawing(tmp_path / "repaired.dxf", "mm", STONE, BASE).blocks
    meant = {*((k, k + 1) for k in range(14)), (0, 15), (14, 16), (15, 17), (16, 17)}
    assert repair.changes
    assert touching(before, tolerance) < touching(after, tolerance) == meant
    assert not survey_layout(after, tolerance).faults


@pytest.mark.parametrize(
    ("corners", "close", "said"),
    [(501, True, "crosses or touches itself there"), (4001, True, "crosses"), (4001, False, "is open")],
)
def test_star_500(corners, close, said, tmp_path, monkeypatch):
    """Whether a loop could be taken off or an end closed, and what lines enclose, without laying out all crossings."""
    for lays_out in ("make_valid", "buffer"):
        monkeypatch.setattr(shapely, lays_out, lambda *_, **__: pytest.fail("all crossings are laid out"))
    turns = np.arange(corners) * 2.0 * np.pi * (corners // 2) / corners
    star = 1e3 * np.column_stack([np.cos(turns), np.sin(turns)])
    document, space = drawing()
    outline(space, [(-2e3, -2e3), (2e3, -2e3), (2e3, -1e3), (-2e3, -1e3)])
    space.add_line((-2e3, -1e3), (-2e3, 1e3), {"layer": "STONES"})
    outline(space, [*star.tolist(), *([] if close else [(1e3, 0.1)])], close=close)
    assert said in refused(document, tmp_path)


@pytest.mark.parametrize("by", ["XZ", "OCS"])
def test_front_view(by, tmp_path):
    document, space = drawing(unit="m")
    for ring in ([(0, 0), (2, 0), (2, 1), (0, 1)], [(0.5, 1), (1.5, 1), (1.5, 4), (0.5, 4)]):
        if by == "XZ":
            space.add_polyline3d([(x, 3.0, z) for x, z in ring], close=True)
        else:
            outline(space, ring).dxf.extrusion = (0, -1, 0)
    found = read(document, tmp_path, unit="m")
    assert [block.polygon[:, 1].max() for block in found.blocks] == pytest.approx([1.0, 4.0])
    assert any("turned" in warning for warning in found.warnings)


def test_clipped_insert(tmp_path):
    from ezdxf.xclip import XClip

    document, space = drawing()
    column = document.blocks.new("COLUMN")
    for k in range(13):
        outline(column, [(0, 10 * k), (20, 10 * k), (20, 10 * k + 10), (0, 10 * k + 10)], "0")
    insert = space.add_blockref("COLUMN", (0, 0))
    XClip(insert).set_block_clipping_path([(-1, -1), (21, 70)])
    assert len(read(document, tmp_path).blocks) == 7
    XClip(insert).set_block_clipping_path([(-1, -1), (21, 75)])
    assert "is cut by the clip of INSERT" in refused(document, tmp_path)
