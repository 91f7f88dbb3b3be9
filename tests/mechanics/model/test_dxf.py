"""DXF to blocks: what is read, and where it ends up."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.model.block import Material, default_tolerance, find_joints, polygons_of
from mechanics.model.drawing import Layer
from mechanics.model.layout import find_overlaps
from tests.support.dxf import SQUARE, STONE, drawing, outline, read, refused


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


@settings(max_examples=15)
@given(
    radii=st.lists(st.floats(1.0, 10.0), min_size=3, max_size=9), unit=st.sampled_from(["mm", "cm", "m"]),
    scale=st.tuples(*[st.floats(0.2, 4.0).flatmap(lambda s: st.sampled_from([s, -s]))] * 2),
    rotation=st.floats(-180.0, 180.0), at=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    flipped=st.booleans(), grid=st.tuples(st.integers(1, 2), st.integers(1, 3)),
)  # fmt: skip
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


METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


def rotation_matrix(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s], [s, c]])


def polygon_area(p) -> float:
    x, y = p.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def test_layer_zero_in_an_insert_and_other_layers_there(tmp_path):
    document, space = drawing()
    stone = document.blocks.new("STONE")
    outline(stone, SQUARE, "0")
    outline(stone, SQUARE, "CAP")
    space.add_blockref("STONE", (0, 0), dxfattribs={"layer": "PIERS"})
    assert [b.layer for b in read(document, tmp_path).blocks] == ["PIERS", "CAP"]


@pytest.mark.parametrize("bulge", [1e-3, -0.05, 0.4, 2.5])
@pytest.mark.parametrize("sagitta", [None, 1e-4])
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


def test_sagitta_is_kept_where_an_insert_stretches_the_arc(tmp_path):
    document, space = drawing(unit="m")
    outline(document.blocks.new("DRUM"), [(-1, 0, 1), (1, 0, 1)])
    space.add_blockref("DRUM", (0, 0), dxfattribs={"xscale": 5, "yscale": 2})
    result = read(document, tmp_path, "m", sagitta=1e-3)
    assert result.sagitta <= 1e-3
    assert 0.0 < math.pi * 10.0 - result.blocks[0].area <= 1e-3 * 2.0 * math.pi * 5.0


@pytest.mark.parametrize("cut", [1, 4])
def test_an_arc_that_blocks_divide_at_different_points_is_told_with_its_remedy(cut, tmp_path):
    """The chords of the one lie within the other by less than the sagitta: the tolerance that is named makes joints."""
    document, space = drawing(unit="m")

    def at(degrees, radius):
        return radius * math.cos(math.radians(degrees)), radius * math.sin(math.radians(degrees))

    ends = [180.0 - k * 180.0 / cut for k in range(cut + 1)]
    bulge = math.tan(math.radians(180.0 / cut) / 4.0)
    for left, right in pairwise(ends):
        outline(
            space, [(*at(left, 1.0), -bulge), (*at(right, 1.0), 0), (*at(right, 0.5), 0), (*at(left, 0.5), 0)]
        )
    above = [
        (*at(155.0, 1.0), -math.tan(math.radians(130.0) / 4.0)),
        (*at(25.0, 1.0), 0),
        (2, 2, 0),
        (-2, 2, 0),
    ]
    outline(space, above)
    blocks = read(document, tmp_path, "m").blocks
    polygons, tolerance = polygons_of(blocks), default_tolerance([block.polygon for block in blocks])
    [fault] = find_overlaps(blocks, polygons, tolerance).faults
    correct, _, wider = fault.text.rpartition(", or write geometry.tolerance_m = ")
    assert correct.endswith("correct its outline" if cut > 1 else "correct their outlines")
    wider = float(wider.removesuffix(" if one arc is divided at different points"))
    assert not find_overlaps(blocks, polygons, wider).faults
    joints = find_joints(blocks, wider)
    assert set(range(cut)) == {*joints.a[joints.b == cut], *joints.b[joints.a == cut]}
    apart = [*blocks[:1], replace(blocks[-1], vertices=blocks[-1].polygon - (0.0, 0.1))]
    assert all(
        f.text.endswith("outlines") for f in find_overlaps(apart, polygons_of(apart), tolerance).faults
    )


def test_other_shapes_are_counted_and_annotation_is_not(tmp_path):
    document, space = drawing()
    outline(space, SQUARE)
    for _ in range(3):
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": "AXES"})
    space.add_circle((0, 0), 1, dxfattribs={"layer": "STONES"})
    space.add_text("pier")
    space.add_hatch().paths.add_polyline_path(SQUARE)
    space.add_mpolygon().paths.add_polyline_path(SQUARE)
    space.add_linear_dim(base=(0, 20), p1=(0, 0), p2=(10, 0)).render()
    result = read(document, tmp_path)
    assert len(result.blocks) == 1
    assert result.warnings == (
        "geometry.dxf: left out, being no closed polylines: 3 LINE, 1 CIRCLE, 1 HATCH, 1 MPOLYGON, on layers 0, AXES, "
        "STONES",
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
    assert result.warnings == ('geometry.dxf: layer "Frame": frozen, off or invisible polylines left out: 1',)
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
