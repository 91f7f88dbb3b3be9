"""DXF to blocks: what is read, where it ends up, and what is said of drawings that are wrong."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import pytest
from ezdxf.filemanagement import new
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.block import Material
from mechanics.drawing import METRES, Layer, read_drawing
from mechanics.errors import DrawingError

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


# what is read


@pytest.mark.parametrize("fmt", ["asc", "bin"])
@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_versions_text_and_binary(version, fmt, tmp_path):
    document, space = drawing(version)
    attributes = {"layer": "STONES"}
    first = space.add_polyline2d(SQUARE, close=True, dxfattribs=attributes)
    solid = space.add_polyline3d([(x + 10, y, 5.0) for x, y in SQUARE], close=True, dxfattribs=attributes)
    result = read(document, tmp_path, fmt=fmt)
    assert [b.area for b in result.blocks] == pytest.approx([1e-4, 1e-4])
    assert result.blocks[1].centroid == pytest.approx([0.015, 0.005])
    assert [(b.layer, b.handle) for b in result.blocks] == [("STONES", p.dxf.handle) for p in (first, solid)]
    assert result.warnings == () and result.sagitta == 0.0


def test_layers_give_role_and_material(tmp_path):
    document, space = drawing()
    outline(space, SQUARE, "Base_Right")
    outline(space, SQUARE, "roof")
    outline(space, SQUARE, "0")
    other = Material(24.0, friction=0.4)
    layers = {
        "BASE_RIGHT": Layer(other, 5.5, support="right"),
        "Roof": Layer(other, 2.0, vertical_load=9.1, load_has_mass=False, segments=3),
    }
    base, roof, rest = read(document, tmp_path, layers=layers).blocks
    assert (base.support, base.depth, base.material, base.layer) == ("right", 5.5, other, "Base_Right")
    assert (roof.vertical_load, roof.load_has_mass, roof.segments, roof.support) == (9.1, False, 3, None)
    assert (rest.depth, rest.material, rest.layer) == (1.0, STONE.material, "0")


def test_repeated_vertices_and_a_repeated_start(tmp_path):
    document, space = drawing()
    outline(space, [*SQUARE, SQUARE[0]], close=False)
    outline(space, [(0, 0), (0, 0), (10, 0), (10, 1e-7), (10, 10), (0, 10), (0, 0)])
    result = read(document, tmp_path)
    assert [len(b.polygon) for b in result.blocks] == [4, 4]
    assert [b.area for b in result.blocks] == pytest.approx([1e-4, 1e-4])
    assert result.warnings == ()


def test_spline_frame_vertices_are_not_on_the_outline(tmp_path):
    document, space = drawing()
    polyline = space.add_polyline2d(SQUARE, close=True)
    polyline.append_vertex((50, 50), dxfattribs={"flags": 16})
    assert read(document, tmp_path).blocks[0].area == pytest.approx(1e-4)


@settings(max_examples=25, deadline=None)
@given(
    radii=st.lists(st.floats(1.0, 10.0), min_size=3, max_size=9),
    unit=st.sampled_from(["mm", "cm", "m"]),
    scale=st.tuples(*[st.floats(0.2, 4.0).flatmap(lambda s: st.sampled_from([s, -s]))] * 2),
    rotation=st.floats(-180.0, 180.0),
    at=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    flipped=st.booleans(),
    grid=st.tuples(st.integers(1, 2), st.integers(1, 3)),
)
def test_inserts_put_blocks_where_they_belong(
    tmp_path_factory, radii, unit, scale, rotation, at, flipped, grid
):
    """Against the affine maps written out: nested, turned, stretched, mirrored, arrayed, seen from behind."""
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    star = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angle, strict=True)]
    document, space = drawing(unit=unit)
    inner, outer = document.blocks.new("INNER", base_point=(1, 2)), document.blocks.new("OUTER")
    polyline = outline(inner, star, "0")
    insert = outer.add_blockref("INNER", (3, 4), dxfattribs={"rotation": 30, "layer": "0"})
    placed = space.add_blockref(
        "OUTER",
        at,
        dxfattribs={"xscale": scale[0], "yscale": scale[1], "rotation": rotation, "layer": "STONES"},
    )
    placed.grid(size=grid, spacing=(70, 100))
    if flipped:
        placed.dxf.extrusion = (0, 0, -1)
    plain = outline(space, star)
    result = read(document, tmp_path_factory.mktemp("inserts"), unit)

    *copies, reference = result.blocks
    turn = rotation_matrix(rotation)
    cells = [turn @ (100 * column, 70 * row) for row in range(grid[0]) for column in range(grid[1])]
    nested = (np.array(star) - (1, 2)) @ rotation_matrix(30).T + (3, 4)
    expected = [
        METRES[unit] * (nested * scale @ turn.T + at + cell) * (-1 if flipped else 1, 1) for cell in cells
    ]
    assert len(copies) == len(expected)
    for block, polygon in zip(copies, expected, strict=True):
        assert np.sort(block.polygon, axis=0) == pytest.approx(np.sort(polygon, axis=0), rel=1e-9, abs=1e-9)
        assert block.area == pytest.approx(abs(scale[0] * scale[1]) * reference.area)
        assert (block.layer, block.handle) == (
            "STONES",
            f"{placed.dxf.handle}/{insert.dxf.handle}/{polyline.dxf.handle}",
        )
    assert reference.handle == plain.dxf.handle
    assert reference.area == pytest.approx(polygon_area(METRES[unit] * np.array(star)))


def rotation_matrix(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s], [s, c]])


def polygon_area(p) -> float:
    x, y = p.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def test_centroid_through_a_mirrored_insert(tmp_path):
    document, space = drawing()
    outline(document.blocks.new("STONE"), [(0, 0), (30, 0), (0, 60)], "0")
    space.add_blockref("STONE", (100, 50), dxfattribs={"xscale": -2, "yscale": 1, "rotation": 90})
    (block,) = read(document, tmp_path).blocks
    assert block.centroid == pytest.approx(
        [0.080, 0.030]
    )  # (10, 20) → (−20, 20) → (−20, −20), then the shift
    assert block.area == pytest.approx(1800e-6)


def test_layer_zero_in_an_insert_and_other_layers_there(tmp_path):
    document, space = drawing()
    stone = document.blocks.new("STONE")
    outline(stone, SQUARE, "0")
    outline(stone, SQUARE, "CAP")
    space.add_blockref("STONE", (0, 0), dxfattribs={"layer": "PIERS"})
    assert [b.layer for b in read(document, tmp_path).blocks] == ["PIERS", "CAP"]


def test_object_coordinates_seen_from_behind(tmp_path):
    document, space = drawing()
    mirrored = outline(space, SQUARE)
    mirrored.dxf.extrusion = (0, 0, -1)
    (block,) = read(document, tmp_path).blocks
    assert block.centroid == pytest.approx([-0.005, 0.005])


# arcs


@pytest.mark.parametrize("bulge", [1e-3, 0.05, -0.05, 0.4, -0.4, 1.0, 2.5])
@pytest.mark.parametrize("sagitta", [None, 1e-4, 1e-2])
def test_bulge_against_the_circular_segment(bulge, sagitta, tmp_path):
    """A square with one curved side: the area is off by less than arc length × sagitta, always inside."""
    document, space = drawing(unit="m")
    outline(space, [(0, 0), (1, 0, bulge), (2, 0), (3, 0), (3, 3), (0, 3)])
    result = read(document, tmp_path, "m", sagitta=sagitta)
    theta = 4.0 * math.atan(abs(bulge))
    radius = (1.0 + bulge**2) / (4.0 * abs(bulge))
    segment = 0.5 * radius**2 * (theta - math.sin(theta))
    allowed = sagitta or 1e-3 * (1.0 if abs(bulge) <= 1.0 else 2.0 * radius)
    assert 0.0 <= result.sagitta <= allowed * (1.0 + 1e-9)
    missing = math.copysign(segment, bulge) - (result.blocks[0].area - 9.0)
    assert -1e-12 <= math.copysign(1.0, bulge) * missing <= radius * theta * allowed


def test_vertices_are_on_the_arc(tmp_path):
    document, space = drawing(unit="m")
    outline(space, [(-1, 0, 1), (1, 0, 1)])
    result = read(document, tmp_path, "m", sagitta=1e-3)
    (circle,) = result.blocks
    assert np.hypot(*circle.polygon.T) == pytest.approx(1.0)
    assert result.sagitta == pytest.approx(1.0 - math.cos(math.pi / len(circle.polygon)))
    assert result.sagitta <= 1e-3 < 1.0 - math.cos(math.pi / (len(circle.polygon) - 2))


def test_two_blocks_share_the_vertices_of_their_arc(tmp_path):
    document, space = drawing()
    outline(space, [(0, 0), (500, 0, 0.1), (500, 300), (0, 300)])
    outline(space, [(500, 0), (900, 0), (900, 300), (500, 300, -0.1)])
    left, right = read(document, tmp_path).blocks
    shared = {tuple(np.round(p, 12)) for p in left.polygon} & {tuple(np.round(p, 12)) for p in right.polygon}
    assert len(shared) == len(left.polygon) - 2 == len(right.polygon) - 2 > 2


def test_sagitta_is_kept_where_an_insert_stretches_the_arc(tmp_path):
    document, space = drawing(unit="m")
    outline(document.blocks.new("DRUM"), [(-1, 0, 1), (1, 0, 1)])
    space.add_blockref("DRUM", (0, 0), dxfattribs={"xscale": 5, "yscale": 2})
    result = read(document, tmp_path, "m", sagitta=1e-3)
    assert result.sagitta <= 1e-3
    assert 0.0 < math.pi * 10.0 - result.blocks[0].area <= 1e-3 * 2.0 * math.pi * 5.0


# what is left out


def test_other_shapes_are_counted_and_annotation_is_not(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    for _ in range(3):
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": "AXES"})
    space.add_circle((0, 0), 1, dxfattribs={"layer": "STONES"})
    space.add_text("pier")
    space.add_hatch().paths.add_polyline_path(SQUARE)
    space.add_linear_dim(base=(0, 20), p1=(0, 0), p2=(10, 0)).render()
    result = read(document, tmp_path)
    assert len(result.blocks) == 1
    assert result.warnings == (
        "geometry.dxf: left out, being no closed polylines: 3 LINE, 1 CIRCLE, on layers AXES, STONES",
    )


@pytest.mark.parametrize("how", ["freeze", "off", "invisible"])
def test_hidden_blocks_are_left_out_with_a_warning(how, tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    frame = outline(space, [(-99, -99), (99, -99), (99, 99)], "Frame")
    if how == "invisible":
        frame.dxf.invisible = 1
    else:
        getattr(document.layers.add("FRAME"), how)()
    result = read(document, tmp_path)
    assert len(result.blocks) == 1
    assert result.warnings == ('geometry.dxf: layer "Frame": 1 frozen, off or invisible polylines left out',)
    message = refused(document, tmp_path, layers={"FRAME": STONE})
    assert 'layer "FRAME" has 1 polylines that are frozen, off or invisible' in message


def test_a_frozen_insert_hides_all_of_it_and_an_off_one_only_its_layer_zero(tmp_path):
    document, space = drawing()
    stone = document.blocks.new("STONE")
    outline(stone, SQUARE, "0")
    outline(stone, SQUARE, "CAP")
    outline(space, SQUARE)
    for name in ("FROZEN", "OFF"):
        space.add_blockref("STONE", (0, 0), dxfattribs={"layer": name})
    document.layers.add("FROZEN").freeze()
    document.layers.add("OFF").off()
    assert [b.layer for b in read(document, tmp_path).blocks] == ["STONES", "CAP"]


@pytest.mark.parametrize(("code", "said"), [(0, None), (4, None), (6, "Meters"), (1, "Inches"), (99, None)])
def test_unit_of_the_drawing_is_compared(code, said, tmp_path):
    document, space = drawing()
    document.header["$INSUNITS"] = code
    outline(space, SQUARE)
    result = read(document, tmp_path)
    assert result.blocks[0].area == pytest.approx(1e-4)
    assert len(result.warnings) == (said is not None)
    if said:
        assert f"$INSUNITS says {said}, the project mm" in result.warnings[0]


def test_layer_without_blocks(tmp_path):
    document, space = drawing()
    document.layers.add("PIERS")
    outline(space, SQUARE)
    (warning,) = read(document, tmp_path, layers={"PIERS": STONE}).warnings
    assert 'layer "PIERS" holds no block' in warning


# what is refused


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


@pytest.mark.parametrize(
    ("layers", "accepted"), [((), False), (("STONES",), True), (("STONES", "dims"), False)]
)
def test_open_polylines_on_layers_that_matter_to_nobody(layers, accepted, tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    wrong = outline(space, [(1, 2), (3, 4)], "DIMS", close=False)
    where = f'layer "DIMS", LWPOLYLINE {wrong.dxf.handle} at (1, 2) and (3, 4)'
    tables = dict.fromkeys(layers, STONE)
    if accepted:
        (warning,) = read(document, tmp_path, layers=tables).warnings
        assert "1 open polylines on layers without blocks left out" in warning and where in warning
    else:
        assert f"{where} is open" in refused(document, tmp_path, layers=tables)


def test_open_polylines_alone(tmp_path):
    document, space = drawing()
    document.layers.add("PIERS")
    outline(space, SQUARE, close=False)
    assert "is open" in refused(document, tmp_path, layers={"PIERS": STONE})


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


@pytest.mark.parametrize(
    "points", [[(7, 8), (9, 8)], [(7, 8)], [(7, 8), (9, 8), (11, 8)], [(7, 8), (9, 8), (7, 8), (7, 8)]]
)
def test_no_area(points, tmp_path):
    document, space = drawing()
    wrong = outline(space, points, "ARCH")
    assert f'layer "ARCH", LWPOLYLINE {wrong.dxf.handle} at (7, 8) has no area' in refused(document, tmp_path)


def test_polyline_without_vertices(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    wrong = outline(space, [(7.25, 8.5)], "ARCH")
    text = text_of(document).replace(" 10\n7.25\n 20\n8.5\n", "")
    with pytest.raises(DrawingError) as caught:
        read_text(tmp_path, text)
    assert f'layer "ARCH", LWPOLYLINE {wrong.dxf.handle} at no point has no area' in str(caught.value)


def test_out_of_the_plane(tmp_path):
    document, space = drawing()
    wrong = space.add_polyline3d(
        [(0, 0, 0), (10, 0, 0), (10, 10, 1)], close=True, dxfattribs={"layer": "ARCH"}
    )
    upright = outline(space, SQUARE, "ARCH")
    upright.dxf.extrusion = (0, 1, 0)
    message = refused(document, tmp_path)
    assert f'layer "ARCH", POLYLINE {wrong.dxf.handle} at (0, 0) is not in the XY plane' in message
    assert f'layer "ARCH", LWPOLYLINE {upright.dxf.handle} at (0, 0) is not in the XY plane' in message


def test_coordinate_that_is_no_number(tmp_path):
    document, space = drawing()
    wrong = outline(space, [(1, 2), (float("nan"), 0), (10, 10)], "ARCH")
    assert (
        f'layer "ARCH", LWPOLYLINE {wrong.dxf.handle} at (1, 2) has a coordinate that is no number'
        in refused(document, tmp_path)
    )


def test_fault_inside_an_insert(tmp_path):
    document, space = drawing()
    wrong = outline(document.blocks.new("STONE"), SQUARE, "0", close=False)
    insert = space.add_blockref("STONE", (100, 200), dxfattribs={"layer": "PIERS"})
    message = refused(document, tmp_path)
    handle = f"{insert.dxf.handle}/{wrong.dxf.handle}"
    assert f'layer "PIERS", LWPOLYLINE {handle} at (100, 200) and (100, 210) is open' in message


def test_all_faults_in_one_message(tmp_path):
    document, space = drawing()
    outline(space, SQUARE, close=False)
    outline(space, [(0, 0), (10, 10), (10, 0), (0, 10)])
    message = refused(document, tmp_path, layers={"STONE": STONE, "NAVE": STONE})
    assert message.count("\n  - ") == 4
    for text in (
        "is open",
        "crosses or touches itself",
        '"STONE" is not in the drawing; did you mean "STONES"?',
    ):
        assert text in message
    assert 'layer "NAVE" is not in the drawing; it has ' in message


def test_long_lists_are_cut(tmp_path):
    document, space = drawing()
    for _ in range(30):
        outline(space, SQUARE, close=False)
    message = refused(document, tmp_path)
    assert message.count("is open") == 20 and "and 10 more" in message


def test_nothing_closed(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    space.add_text("arch")
    message = refused(document, tmp_path)
    assert (
        "nothing closed is in model space, but 1 LINE, 1 TEXT; draw each block as one closed polyline"
        in message
    )


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


def test_external_reference_is_mentioned(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    document.add_xref_def("other.dxf", "OTHER")
    space.add_blockref("OTHER", (0, 0), dxfattribs={"layer": "REFS"})
    (warning,) = read(document, tmp_path).warnings
    assert "left out, being no closed polylines: 1 INSERT, on layers REFS" in warning


def test_unknown_entities_are_mentioned(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    custom = f"  0\nAEC_WALL\n  5\nFF0\n330\n{space.layout_key}\n100\nAcDbEntity\n  8\nWALLS\n"
    head, mark, tail = text_of(document).partition("  2\nENTITIES\n")
    (warning,) = read_text(tmp_path, head + mark + custom + tail).warnings
    assert "left out, being no closed polylines: 1 AEC_WALL, on layers WALLS" in warning


def test_vertex_without_a_place(tmp_path):
    document, space = drawing("R12")
    wrong = space.add_polyline2d([(0, 0), (10, 0), (7.25, 8.5)], close=True)
    text = text_of(document).replace(" 10\n7.25\n 20\n8.5\n 30\n0.0\n", "")
    with pytest.raises(DrawingError) as caught:
        read_text(tmp_path, text)
    assert f'layer "0", POLYLINE {wrong.dxf.handle} at (0, 0) has a coordinate that is no number' in str(
        caught.value
    )


# files


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


def test_missing_file_and_folder(tmp_path):
    for path in (tmp_path / "absent.dxf", tmp_path):
        with pytest.raises(
            DrawingError, match=rf"{path.name}: cannot be read \(.+\); give the path of a DXF file"
        ):
            read_drawing(path, "mm", STONE)


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


def test_decimal_commas_are_no_numbers(tmp_path):
    document, space = drawing()
    outline(space, [(0.25, 0), (10, 0), (10, 10)])
    with pytest.raises(DrawingError, match="damaged"):
        read_text(tmp_path, text_of(document).replace("\n0.25\n", "\n0,25\n"))


@pytest.mark.parametrize(
    ("options", "name"),
    [({"unit": "km"}, "unit"), ({"sagitta": 0.0}, "sagitta"), ({"sagitta": math.nan}, "sagitta")],
)
def test_arguments(options, name, tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    with pytest.raises(ValueError, match=f"^{name} = "):
        read(document, tmp_path, **options)
