"""What is said of drawings that are wrong: the entity, the place and what to do."""

import io
from pathlib import Path

import numpy as np
import pytest

from mechanics.errors import DrawingError
from mechanics.model.drawing import read_drawing
from tests.support.dxf import SQUARE, STONE, drawing, outline, read, refused


def test_open_polyline(tmp_path):
    document, space = drawing()
    outline(space, SQUARE, "PIERS")
    wrong = outline(space, [(1.5, 2), (10, 2), (10, 10), (1.5, 5)], "PIERS", close=False)
    message = refused(document, tmp_path)
    assert (
        f'layer "PIERS", LWPOLYLINE {wrong.dxf.handle} at (1.5, 2) and (1.5, 5) is open, its ends 3 apart'
        in message
    )
    assert "close it" in message


def test_what_rounding_leaves_of_a_coordinate_is_told_as_0(tmp_path):
    document, space = drawing()
    outline(space, [(8.3e-17, -0.0), (10, 2), (10, 10), (1.5, 5)], "PIERS", close=False)
    assert "at (0, 0) and (1.5, 5) is open" in refused(document, tmp_path)


@pytest.mark.parametrize(
    ("points", "where"),
    [
        ([(0, 0), (10, 10), (10, 0), (0, 10)], "(5, 5)"),
        ([(0, 0), (10, 0), (10, 10), (5, 0), (0, 10)], "(5, 0)"),
        ([(0, 0), (10, 0), (20, 0), (10, 0), (10, 10), (0, 10)], "(20, 0)"),
    ],
    ids=["crossing", "touching", "spike"],
)
def test_self_crossing(points, where, tmp_path):
    document, space = drawing()
    wrong = outline(space, points, "ARCH")
    message = refused(document, tmp_path)
    assert f'layer "ARCH", LWPOLYLINE {wrong.dxf.handle} at {where} crosses or touches itself' in message


def test_out_of_the_plane(tmp_path):
    document, space = drawing()
    wrong = space.add_polyline3d(
        [(0, 0, 0), (10, 0, 0), (10, 10, 1)], close=True, dxfattribs={"layer": "ARCH"}
    )
    upright = outline(space, SQUARE, "ARCH")
    upright.dxf.extrusion = (0, 1, 0)
    outline(space, SQUARE, "ARCH")
    outline(space, SQUARE, "ARCH")
    message = refused(document, tmp_path)
    assert f'layer "ARCH", POLYLINE {wrong.dxf.handle} at (0, 0) is not in the XY plane, nor' in message
    assert "by 1; turn it there (ROTATE3D), or flatten it" in message
    assert f'layer "ARCH", LWPOLYLINE {upright.dxf.handle} at (0, 0) is not in the XY plane' in message


def test_coordinate_that_is_no_number(tmp_path):
    document, space = drawing()
    wrong = outline(space, [(1, 2), (float("nan"), 0), (10, 10)], "ARCH")
    assert (
        f'layer "ARCH", LWPOLYLINE {wrong.dxf.handle} at (1, 2) has a coordinate that is no number'
        in refused(document, tmp_path)
    )


def test_all_faults_in_one_message(tmp_path):
    document, space = drawing()
    outline(space, SQUARE, close=False)
    outline(space, [(0, 0), (10, 10), (10, 0), (0, 10)])
    message = refused(document, tmp_path, layers={"STONE": STONE, "NAVE": STONE})
    assert [line.split(": ")[1] for line in message.splitlines()] == [f"fault {n}" for n in range(1, 5)]
    for text in (
        "is open",
        "crosses or touches itself",
        'layers.STONE of the project is not in the drawing; did you mean "STONES"?',
    ):
        assert text in message
    assert "layers.NAVE of the project is not in the drawing; it has " in message


def test_a_drawing_of_text_alone_is_told_before_its_layers(tmp_path):
    document, space = drawing()
    space.add_text("PROSPETTO")
    message = refused(document, tmp_path, layers={"STONE": STONE})
    assert "nothing closed is in model space, but 1 TEXT; draw each block as one closed polyline" in message
    assert "STONE" not in message


@pytest.mark.parametrize("layer", ["MURO", "RILIEVO"])
@pytest.mark.parametrize("apart", [0.0, 0.004])
def test_a_stone_drawn_by_lines_beside_blocks_is_no_hole_in_silence(layer, apart, tmp_path):
    document, space = drawing()
    for k in (0, 2):
        outline(space, [(k, 0), (k + 1, 0), (k + 1, 1), (k, 1)], "MURO")
    corners = np.array([(1, 0), (2, 0), (2, 1), (1, 1)], dtype=float)
    for k in range(4):  # the second end is a hand away from the next line
        space.add_line(corners[k], corners[(k + 1) % 4] + (apart, 0.0), dxfattribs={"layer": layer})
    space.add_line((0.1, 0.2), (0.7, 0.9), dxfattribs={"layer": "MURO"})  # a crack
    if layer == "MURO":
        message = refused(document, tmp_path)
        assert message.count("LINEs around") == 1 and 'layer "MURO": LINEs around (1.5' in message
        assert "enclose what is no block; join them" in message
    else:  # a layer without blocks: no masonry, told as before
        assert "left out, being no closed polylines: 5 LINE" in read(document, tmp_path).warnings[0]


def test_paper_space_only(tmp_path):
    document, _ = drawing()
    wrong = outline(document.paperspace(), SQUARE, "PIERS")
    message = refused(document, tmp_path)
    assert f'layer "PIERS", LWPOLYLINE {wrong.dxf.handle} of layout "Layout1"' in message
    assert "move them to model space" in message


def test_block_that_inserts_itself(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    document.blocks.new("LOOP").add_blockref("LOOP", (0, 0))
    assert 'cycle detected in block "LOOP"' in refused(document, tmp_path)


def text_of(document) -> str:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def read_text(folder: Path, content: str | bytes):
    path = folder / "geometry.dxf"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_drawing(path, "mm", STONE)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "no DXF drawing"),
        ("vertices,1,2\n", "no DXF drawing"),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "no DXF drawing"),
        (b"AC1032" + bytes(500), "DWG drawing; save it as DXF"),
        ("  0\nSECTION\n", "cut off"),
        ("  0\nSECTION\n  2\nENTITIES\nabc\n0\nENDSEC\n  0\nEOF\n", "damaged"),
    ],
)
def test_no_dxf(content, said, tmp_path):
    with pytest.raises(DrawingError, match=r"geometry\.dxf: .*" + said):
        read_text(tmp_path, content)


@pytest.mark.parametrize("fmt", ["asc", "bin"])
def test_cut_off_files_are_refused_or_whole(fmt, tmp_path):
    document, space = drawing()
    for k in range(4):
        outline(space, [(x + 10 * k, y) for x, y in SQUARE])
    document.saveas(tmp_path / "geometry.dxf", fmt=fmt)
    whole = (tmp_path / "geometry.dxf").read_bytes()
    read_whole = 0
    for cut in range(0, len(whole), len(whole) // 40):
        try:
            read_whole += len(read_text(tmp_path, whole[:cut]).blocks) == 4
        except DrawingError as error:
            assert str(error).startswith(str(tmp_path / "geometry.dxf"))
        else:
            assert cut > whole.rindex(b"LWPOLYLINE")
    assert read_whole > 0 or fmt == "bin"


def test_dirty_text_is_repaired_with_a_warning(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    space.add_blockref("ABSENT", (0, 0))
    text = text_of(document).replace("  0\nSECTION\n", "999\nby some exporter\n  0\nSECTION\n", 1)
    result = read_text(tmp_path, text.replace("\n", "\r\n"))
    assert len(result.blocks) == 1
    (warning,) = result.warnings
    assert "repaired" in warning and "without required BLOCK" in warning
