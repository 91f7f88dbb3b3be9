"""Drawings as they come: front views, heights, versions, spellings; some that gave a wrong model or took minutes."""

import math
import re
import unicodedata

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.model import default_tolerance, read_drawing, repair_drawing, survey_drawing, survey_layout
from mechanics.model.drawing import Layer
from mechanics.model.layout import touching
from tests.support.dxf import SQUARE, STONE, drawing, outline, read, refused

WALL = [[(0, 0), (20, 0), (20, 5), (0, 5)], [(5, 5), (15, 5), (15, 30), (5, 30)]]  # mm: a base and a block


def polygons(blocks) -> list[np.ndarray]:
    return [1e3 * block.polygon for block in blocks]


@settings(max_examples=15)
@given(
    turn=st.floats(-math.pi, math.pi),
    at=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    kind=st.sampled_from(["polyline3d", "lwpolyline", "insert"]),
)
def test_a_view_drawn_in_a_vertical_plane_is_turned(turn, at, kind, tmp_path_factory):
    """Whatever its direction and kind, z is up, and x runs towards +x (or +y) of the drawing."""
    along = np.array([math.cos(turn), math.sin(turn), 0.0])
    along *= -1.0 if along[0] + 1e-9 * along[1] < 0.0 else 1.0
    document, space = drawing()
    if kind == "polyline3d":
        for ring in WALL:
            space.add_polyline3d([at + x * along + (0, 0, z) for x, z in ring], close=True)
    else:
        normal = np.cross(along, (0, 0, 1))  # seen from there, x to the right and z up
        here = space if kind == "lwpolyline" else document.blocks.new("VIEW")
        for ring in WALL:
            added = outline(here, ring, "0")
            if kind == "lwpolyline":
                added.dxf.extrusion = tuple(normal)
                ocs = added.ocs()
                corners = [ocs.from_wcs(tuple(at + x * along + (0, 0, z))) for x, z in ring]
                added.set_points([(c.x, c.y) for c in corners])
                added.dxf.elevation = corners[0].z
        if kind == "insert":
            inserted = space.add_blockref("VIEW", (0, 0), dxfattribs={"extrusion": tuple(normal)})
            ocs = inserted.ocs()
            inserted.dxf.insert = ocs.from_wcs(tuple(at))
            ahead = ocs.from_wcs(tuple(along))
            inserted.dxf.rotation = math.degrees(math.atan2(ahead.y, ahead.x))
    result = read(document, tmp_path_factory.mktemp("view"))
    left = float(np.dot(at, along))
    for found, ring in zip(polygons(result.blocks), WALL, strict=True):
        assert found == pytest.approx(np.add(ring, (left, at[2])), abs=1e-6)
    (warning,) = result.warnings
    assert "drawn in a vertical plane and turned: x of blocks and points is along (" in warning
    told = [float(number) for number in re.search(r"along \((.*), (.*), 0\)", warning).groups()]
    assert told == pytest.approx(along[:2], abs=1e-4)


def test_a_front_view_is_repaired_in_its_own_plane(tmp_path):
    document, space = drawing()
    for ring, lift in zip(WALL, (0.0, 0.01), strict=True):
        added = outline(space, [(x, z + lift) for x, z in ring], "STONES")
        added.dxf.extrusion = (0, -1, 0)
    document.saveas(tmp_path / "geometry.dxf")
    repair = repair_drawing(tmp_path / "geometry.dxf", "mm", STONE, tolerance=2e-6)
    assert len(repair.changes) == 2
    (tmp_path / "repaired.dxf").write_bytes(repair.file)
    lower, upper = polygons(read_drawing(tmp_path / "repaired.dxf", "mm", STONE))
    assert lower == pytest.approx(np.array(WALL[0]), abs=1e-9)
    assert upper[:2] == pytest.approx(np.array(WALL[1][:2]), abs=1e-9)


def test_heights_that_are_nearly_equal_are_left_out_and_told(tmp_path):
    document, space = drawing(unit="m")
    space.add_polyline3d([(0, 0, 0), (2, 0, 0.001), (2, 0.5, 0.002), (0, 0.5, 0.003)], close=True)
    result = read(document, tmp_path, unit="m")
    assert result.blocks[0].area == pytest.approx(1.0)
    assert result.warnings == (
        "geometry.dxf: heights out of the plane are left out, of up to 0.003 m; outlines: 1",
    )
    space.add_polyline3d([(0, 0, 0), (2, 0, 0), (2, 0.5, 0.03), (0, 0.5, 0.03)], close=True)
    assert "is not in the XY plane, nor in a vertical one with the others, by 0.03" in refused(
        document, tmp_path, unit="m"
    )


def polyline(points, *, layer="WALL", markers=True, handle="", bulge="") -> str:
    """The text of an LWPOLYLINE."""
    marks = ("100\nAcDbEntity\n", "100\nAcDbPolyline\n") if markers else ("", "")
    corners = "".join(f" 10\n{x}\n 20\n{y}\n{bulge}" for x, y in points)
    return f"  0\nLWPOLYLINE\n{handle}{marks[0]}  8\n{layer}\n 62\n1\n{marks[1]} 90\n{len(points)}\n 70\n1\n{corners}"


def file(entities: str, version: str | None = "AC1009", header: bool = True) -> str:
    named = f"  9\n$ACADVER\n  1\n{version}\n" if version else ""
    head = (
        f"  0\nSECTION\n  2\nHEADER\n{named}  9\n$INSBASE\n 10\n0.0\n 20\n0.0\n 30\n0.0\n  0\nENDSEC\n"
        if header
        else ""
    )
    return f"{head}  0\nSECTION\n  2\nENTITIES\n{entities}  0\nENDSEC\n  0\nEOF\n"


@pytest.mark.parametrize("ends", ["\n", "\r"])
@pytest.mark.parametrize("markers", [True, False])
@pytest.mark.parametrize("version", ["AC1006", "AC1032", None, "no header"])
def test_an_lwpolyline_is_one_whatever_the_file_says_of_its_version(version, markers, ends, tmp_path):
    old = "  0\nPOLYLINE\n  8\nWALL\n 66\n1\n 70\n1\n" + "".join(
        f"  0\nVERTEX\n  8\nWALL\n 10\n{x}\n 20\n{y}\n" for x, y in SQUARE
    ) + "  0\nSEQEND\n"  # fmt: skip
    both = polyline(SQUARE, markers=markers, handle="  5\n2A\n") + polyline(
        SQUARE, markers=markers, bulge=" 42\n0.5\n"
    )
    text = file(both + old, None if version == "no header" else version, header=version != "no header")
    path = tmp_path / "geometry.dxf"
    path.write_bytes(text.replace("\n", ends).encode())
    result = read_drawing(path, "mm", STONE)
    assert [len(b.polygon) > 4 for b in result.blocks] == [False, True, False]
    assert [b.layer for b in result.blocks] == ["WALL"] * 3
    assert result.blocks[0].area == result.blocks[2].area == pytest.approx(1e-4)
    asked = markers and str(version) > "AC1011" and str(version).startswith("AC")
    told = [w for w in result.warnings if "LWPOLYLINEs without their subclass, or in a file of version" in w]
    assert len(told) == (not asked) and not [w for w in result.warnings if "damaged" in w]


def test_a_layer_is_one_in_any_case_with_its_accents_composed_or_not(tmp_path):
    document, space = drawing()
    composed, apart = unicodedata.normalize("NFC", "Facciàta"), unicodedata.normalize("NFD", "FACCIÀTA")
    outline(space, SQUARE, composed)
    outline(space, [(x + 20, y) for x, y in SQUARE], apart)
    heavy = Layer(STONE.material, 3.0)
    for name in (composed, apart, apart.lower()):
        assert [b.depth for b in read(document, tmp_path, layers={name: heavy}).blocks] == [3.0, 3.0]
    document.layers.add(apart).freeze()
    assert 'layer "Facciàta" has 2 polylines that are frozen' in refused(
        document, tmp_path, layers={composed: heavy}
    )


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
