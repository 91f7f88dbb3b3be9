"""Built-in templates: masonry without gaps or overlaps, and projects that load, are explained and stand."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon
from shapely.ops import unary_union

from assessment.project.catalogue.geometry import THINNEST, Layout, Ring
from assessment.project.catalogue.new_project import TEMPLATES, made, new_project
from assessment.project.project import load_project
from assessment.runtime.errors import ProjectError
from mechanics import Material, read_drawing
from mechanics.model.drawing import Layer
from tests import ROOT
from tests.support.template_assembly import template_assembly

PROJECTS = ROOT / "projects"
STONE = Material(unit_weight=16.0, friction=0.65)
templates = pytest.mark.parametrize("template", TEMPLATES)


def polygons(layout: Layout) -> list[Polygon]:
    return [Polygon(each) for layer in layout.values() for each in layer]


def corners(layout: Layout, sign: float = 1.0) -> set[frozenset[tuple[float, float]]]:
    """Blocks as sets of vertices, mirrored for sign = -1."""
    return {
        frozenset((round(sign * x, 9) + 0.0, round(z, 9) + 0.0) for x, z in each)
        for layer in layout.values()
        for each in layer
    }


def assert_tiled(layout: Layout, openings: int = 0) -> None:
    """Simple blocks, no overlaps, and no gaps inside the masonry but the openings."""
    shapes = polygons(layout)
    assert all(shape.is_valid for shape in shapes)
    whole = unary_union(shapes)
    assert sum(shape.area for shape in shapes) == pytest.approx(whole.area, rel=1e-10)
    parts = getattr(whole, "geoms", [whole])
    gaps = [ring for part in parts for ring in part.interiors if Polygon(ring).area > 1e-9]
    assert len(gaps) == openings


@templates
def test_default_masonry_is_tiled_without_gaps_or_overlaps(template: str) -> None:
    openings = {"wall-with-openings": 4, "bell-gable": 2}
    assert_tiled(made(template, {})[0], openings.get(template, 0))


@templates
def test_joints_are_exact_and_long_enough_to_carry(template: str) -> None:
    """Shared boundaries agree to 1e-9 m: a tighter tolerance finds the same joints as the default one."""
    exact, usual = template_assembly(template, tolerance=1e-9).joints, template_assembly(template).joints
    assert len(exact.a) == len(usual.a) > 0
    assert exact.length.min() > 0.005


@given(
    span=st.floats(0.4, 12.0),
    ratio=st.floats(0.1, 0.5),
    slenderness=st.floats(0.05, 0.2),
    voussoirs=st.integers(3, 40),
)
def test_ring_has_the_asked_span_rise_and_thickness(
    span: float, ratio: float, slenderness: float, voussoirs: int
) -> None:
    """Area of an annular polygon: N/2 sin(2β/N) ((R+t)² − R²)."""
    ring = Ring(span, ratio * span, slenderness * span, voussoirs, springing=1.0)
    inner, outer = ring.joints(0.0), ring.joints(ring.thickness_m)
    assert inner[[0, -1]] == pytest.approx(np.array([(-span / 2, 1.0), (span / 2, 1.0)]), abs=1e-9)
    assert ring.radius - (ring.radius * np.cos(ring.half_angle)) == pytest.approx(ring.rise_m)
    assert np.hypot(*(outer - inner).T) == pytest.approx(ring.thickness_m)
    area = sum(Polygon(each).area for each in ring.blocks())
    annulus = (ring.radius + ring.thickness_m) ** 2 - ring.radius**2
    assert area == pytest.approx(0.5 * voussoirs * np.sin(2.0 * ring.half_angle / voussoirs) * annulus)


@settings(max_examples=6)
@given(
    span=st.floats(4.0, 8.0), ratio=st.floats(0.1, 0.5), thickness=st.floats(0.25, 0.7),
    cover=st.floats(0.1, 2.5), springing=st.floats(1.0, 5.0), voussoirs=st.integers(9, 35),
    wall_blocks=st.integers(1, 4), spandrel_blocks=st.integers(8, 20),
)  # fmt: skip
def test_triumphal_arch_of_any_dimensions_is_tiled_by_stout_blocks(
    span: float,
    ratio: float,
    thickness: float,
    cover: float,
    springing: float,
    voussoirs: int,
    wall_blocks: int,
    spandrel_blocks: int,
) -> None:
    layout = made(
        "triumphal-arch",
        {
            "span_m": span, "rise_m": ratio * span, "thickness_m": thickness, "springing_m": springing,
            "height_m": springing + ratio * span + thickness + cover, "wall_thickness_m": 1.3,
            "voussoirs": voussoirs, "wall_blocks": wall_blocks, "spandrel_blocks": spandrel_blocks,
            "beams": 4,
        },
    )[0]  # fmt: skip
    assert_tiled(layout)
    assert not any(Polygon(each).buffer(-0.499 * THINNEST).is_empty for each in layout["ARCO"])


@templates
def test_new_project_loads_and_its_drawing_holds_the_layout(template: str, tmp_path: Path) -> None:
    new_project(tmp_path / "deep" / "new", template, {})
    project = load_project(tmp_path / "deep" / "new")
    assert project.supports
    assert project.pushover
    assert project.assessment
    assert {file.name for file in project.folder.iterdir()} == {"geometry.dxf", "project.toml", "records"}
    import ezdxf

    drawing = ezdxf.readfile(project.path("geometry.dxf"))
    assert drawing.units == 6
    drawn: Layout = {}
    for entity in drawing.modelspace():
        assert entity.closed
        drawn.setdefault(entity.dxf.layer, []).append(np.array(entity.get_points("xy")))
    assert corners(drawn) == corners(made(template, {})[0])
    assert set(project.layers) <= set(drawn)


@pytest.mark.parametrize(
    ("template", "options", "message"),
    [
        ("archh", {}, '--template: archh: .*did you mean "arch"'),
        ("arch", {"spam_m": 3.0}, 'arch: spam_m: .*did you mean "span_m"'),
        ("arch", {"span_m": -1.0}, "span_m: is -1; must be a number, in m, from 0.001 to 1000"),
        ("arch", {"span_m": float("nan")}, "span_m: is nan; must be a number"),
        ("arch", {"voussoirs": 7.5}, "voussoirs: is 7.5; must be a whole number"),
        ("arch", {"rise_m": 2.0}, "voussoirs: 21 is odd; a pointed arch"),
        ("arch", {"voussoirs": 1}, "voussoirs: must be 2 or more"),
        ("facade", {"course_height_m": 3.5}, "course_height_m: must be half of storey_height_m at most"),
        ("facade", {"roof_span_m": 0.1}, "roof_span_m: must be 0.6 or more"),
        ("facade", {"bearing_m": 0.6}, "bearing_m: must be less than thickness_m"),
        ("facade", {"crack_deg": 70.0}, "crack_deg: must be 60 at most, is 70"),
        ("facade", {"tie_kN": -1.0}, "tie_kN: is -1; must be a number, in kN, from 0 to"),
        ("arcade", {"pier_width_m": 0.5}, "the ring's foot is 0.3 m wide, its support 0.25 m"),
        ("wall-with-openings", {"openings": 5}, "opening_width_m: with its lintel wider than the 1.4 m"),
        ("wall-with-openings", {"opening_height_m": 2.1}, "opening_height_m: sill, opening and lintel take 11 of 10"),
        ("wall", {"moving_blocks": 6}, "moving_blocks: must be fewer than blocks"),
        ("buttressed-arch", {"pier_width_m": 0.03}, "the ring's foot is"),
        ("triumphal-arch", {"height_m": 5.0}, "height_m: must be above the ring's crown"),
        ("triumphal-arch", {"beams": 80}, "beams: 80 beams of 0.2 m do not fit"),
    ],
)  # fmt: skip
def test_wrong_options_are_named_and_nothing_is_written(
    template: str, options: dict[str, float], message: str, tmp_path: Path
) -> None:
    with pytest.raises(ProjectError, match=message):
        new_project(tmp_path / "new", template, options)
    assert not list(tmp_path.iterdir())


def test_an_existing_project_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ProjectError, match="exists and is not empty"):
        new_project(tmp_path, "block", {})
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("folder", "template"),
    [
        ("rocking_block", "block"), ("buttressed_arch", "buttressed-arch"),
        ("triumphal_arch", "triumphal-arch"), ("arch_campaign", None), ("tuff_panel", None),
    ],
)  # fmt: skip
def test_example_project_is_sound(folder: str, template: str | None) -> None:
    """The worked examples load; those made from a template are its defaults, with analyses beside them."""
    project = load_project(PROJECTS / folder)
    unread = Layer(STONE, 1.0)
    blocks = read_drawing(project.path("geometry.dxf"), project.geometry.unit, unread).blocks
    assert {block.layer for block in blocks} >= set(project.layers)
    if template:
        drawn: Layout = {}
        for each in blocks:
            drawn.setdefault(each.layer, []).append(each.polygon)
        assert corners(drawn) == corners(made(template, {})[0])
        _, content = made(template, {})
        said = tomllib.loads((PROJECTS / folder / "project.toml").read_text(encoding="utf-8"))
        for each in (said, content):  # an example shows the hazard typed in
            each["assessment"] = {k: v for k, v in each["assessment"].items() if k != "site"}
        assert {key: said[key] for key in content} == content
