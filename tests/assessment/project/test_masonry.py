"""Layers that are ignored, bonds that cut outlines, regions whose blocks have something of their own."""

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from assessment.project.masonry import running
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.project.schema import BondTable
from assessment.results.hand_check import weights
from assessment.runtime.errors import ProjectError
from assessment.workflow.checking import describe
from mechanics.errors import DrawingError
from tests.support.contract_project import MINIMAL
from tests.support.dxf import drawing, outline

WALL = [(0, 0), (4, 0), (4, 3), (0, 3)]
BASE = [(-1, -0.5), (5, -0.5), (5, 0), (-1, 0)]
TOML = f"""{MINIMAL.replace("depth_m = 1.0", "depth_m = 0.5")}[layers.BASE]
support = "base"
[layers.WALL]
bond = {{ pattern = "running", course_m = 0.3, block_m = 0.6 }}
"""


def project(folder, toml=TOML, **layers):
    """The project of a drawing in m with these outlines by layer, its base beside them."""
    document, space = drawing(unit="m")
    for layer, outlines in {"BASE": [BASE], **layers}.items():
        for points in outlines:
            outline(space, points, layer)
    document.saveas(folder / "geometry.dxf")
    (folder / "project.toml").write_text(toml, encoding="utf-8")
    return load_project(folder)


def built(folder, toml=TOML, **layers):
    return build_model(project(folder, toml, **layers)).assembly


def refusal(folder, toml, **layers):
    with pytest.raises((ProjectError, DrawingError)) as caught:
        built(folder, toml, **layers)
    return str(caught.value)


def area(model):
    return sum(Polygon(block.polygon).area for block in model.blocks if block.support is None)


def test_an_outline_becomes_a_wall_in_running_bond(tmp_path):
    model = built(tmp_path, WALL=[WALL])
    assert len(model.blocks) == 1 + 5 * 7 + 5 * 8  # 4 m in 7 blocks, 3 m in 10 courses
    assert area(model) == pytest.approx(12.0)
    heads = [
        round(float(block.polygon[:, 0].min()), 6)
        for block in model.blocks[1:]
        if block.polygon[:, 1].min() < 0.01
    ]
    assert np.diff(sorted(heads)) == pytest.approx(4.0 / 7.0, abs=2e-6)


def test_openings_are_left_out_below_lintels_and_doors_reach_the_ground(tmp_path):
    window, door = [(1, 0.9), (2, 0.9), (2, 2.1), (1, 2.1)], [(2.8, 0), (3.5, 0), (3.5, 2.0), (2.8, 2.0)]
    model = built(tmp_path, WALL=[WALL, window, door])
    assert area(model) == pytest.approx(12.0 - 1.2 - 1.4)
    for hole in (window, door):
        assert all(Polygon(block.polygon).intersection(Polygon(hole)).area < 1e-9 for block in model.blocks)
        (left, _), (right, _), (_, head), _ = hole
        above = [
            b
            for b in model.blocks
            if b.polygon[:, 1].min() == pytest.approx(head)
            and b.polygon[:, 0].min() < right
            and b.polygon[:, 0].max() > left
        ]
        assert len(above) == 1, "one lintel"
        assert above[0].polygon[:, 0].min() == pytest.approx(left - 0.3)
        assert above[0].polygon[:, 0].max() == pytest.approx(right + 0.3)
    from mechanics import limit_analysis

    assert limit_analysis(model).alpha > 0.0, "the wall stands"


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_a_bond_fills_any_outline_without_overlap(scale):
    gable = Polygon(scale * np.array([(0, 0), (4, 0), (4, 2), (2, 3.3), (0, 2)]))
    blocks = running(
        gable,
        [box(*(scale * np.array([1.2, 1, 2.1, 1.7])))],
        [],
        BondTable(course_m=0.3 * scale, block_m=0.5 * scale),
    )
    assert sum(Polygon(each).area for each in blocks) == pytest.approx(gable.area - 0.63 * scale**2)
    assert all(Polygon(each).is_valid for each in blocks)
    assert len(blocks) > 60


@pytest.mark.parametrize("long", [0.6, 0.62])
def test_a_pier_is_as_wide_as_its_blocks_and_a_plinth_as_high_as_its_course(long):
    """A whole number of blocks is fitted to what was drawn: one where the outline is a little less than a block."""
    bond = BondTable(course_m=0.3, block_m=long)
    assert len(running(box(0, 0, 0.6, 1.5), [], [], bond)) == 5 + 2  # two courses of halves
    assert len(running(box(0, 0, 3.0, 0.29), [], [], bond)) == 5
    assert len(running(box(0, 0, 0.3, 1.5), [], [], bond)) == 5 + 2  # a narrow pier of a wall's layer


@pytest.mark.parametrize(
    ("bond", "said"),
    [
        ("course_m = 0.01, block_m = 0.6", "layers.WALL.bond.course_m: 0.01 makes 300 courses, at most 100"),
        ("course_m = 0.3, block_m = 0.001", "layers.WALL.bond.block_m: 0.001 makes more than 10000 blocks"),
        ("course_m = 300, block_m = 600", "layers.WALL.bond.course_m: 300 is wrong; write a number not greater than 3"),
        ("course_m = 0.3, block_m = 60", "layers.WALL.bond.block_m: 60 is wrong; write a number not greater than 5"),
        ("course_m = 3.0, block_m = 4.0", "layers.WALL.bond.block_m: a block would enclose an opening"),
        (
            'pattern = "english", course_m = 0.3, block_m = 0.6',
            'layers.WALL.bond.pattern: "english" is wrong; write "running"',
        ),
    ],
)  # fmt: skip
def test_bonds_that_cannot_be(bond, said, tmp_path):
    toml = TOML.replace('pattern = "running", course_m = 0.3, block_m = 0.6', bond)
    assert said in refusal(tmp_path, toml, WALL=[WALL, [(1, 1), (2, 1), (2, 2), (1, 2)]])


def test_a_layer_that_is_ignored_holds_nothing_and_says_nothing(tmp_path):
    frame = [(-5, -5), (9, -5), (9, 9), (-5, 9)]
    toml = TOML + "[layers.CORNICE]\nignore = true\n"
    document, space = drawing(unit="m")
    for layer, points in (("BASE", BASE), ("WALL", WALL), ("cornice", frame)):
        outline(space, points, layer)
    outline(space, [(0, 0), (7, 7)], "CORNICE", close=False)
    space.add_line((0, 0), (1, 1), dxfattribs={"layer": "CORNICE"})
    document.saveas(tmp_path / "geometry.dxf")
    (tmp_path / "project.toml").write_text(toml, encoding="utf-8")
    model = build_model(load_project(tmp_path))
    assert not model.warnings
    assert {block.layer for block in model.assembly.blocks} == {"BASE", "WALL"}
    (tmp_path / "project.toml").write_text(TOML, encoding="utf-8")
    with pytest.raises(DrawingError, match="is open"):
        build_model(load_project(tmp_path))
    (tmp_path / "project.toml").write_text(toml + 'support = "x"\n', encoding="utf-8")
    with pytest.raises(ProjectError, match=r"layers.CORNICE.ignore: what is ignored has no other keys"):
        load_project(tmp_path)
    (tmp_path / "project.toml").write_text(toml.replace("CORNICE", "CORNISE"), encoding="utf-8")
    with pytest.raises(
        DrawingError,
        match=r'layers.CORNISE of the project is not in the drawing; did you mean "(?i:CORNICE)"',
    ):
        build_model(load_project(tmp_path))


REGION = """[[region]]
name = "left"
outline_m = [[-0.1, -0.1], [2.0, -0.1], [2.0, 4.0], [-0.1, 4.0]]
friction = 0.4
unit_weight_kN_m3 = 20.0
[[region]]
name = "foot"
outline_m = [[-0.1, -0.1], [1.0, -0.1], [1.0, 0.3], [-0.1, 0.3]]
depth_m = 0.6
"""


def test_keys_of_a_region_count_before_those_of_the_layer(tmp_path):
    toml = (
        TOML.replace(
            "[layers.WALL]", "[layers.WALL]\nload_has_mass = false\nvertical_load_kN = 0.1\nfriction = 0.7"
        )
        + REGION
    )
    given = project(tmp_path, toml, WALL=[WALL])
    model = build_model(given)
    regions = {"": 0, "left": 0, "foot": 0}
    for block in model.assembly.blocks[1:]:
        regions[block.region] += 1
        x, z = block.centroid
        assert block.region == ("foot" if x <= 1.0 and z <= 0.3 else "left" if x <= 2.0 else "")
        assert block.material.friction == (0.4 if block.region == "left" else 0.7), "of one region alone"
        assert block.material.unit_weight == (20.0 if block.region == "left" else 18.0)
        assert block.depth == (0.6 if block.region == "foot" else 0.5)
        assert block.vertical_load == 0.1
        assert not block.load_has_mass, "a default of the region is no key of it"
    assert all(regions.values())
    results = describe(given, model)
    weight, seismic = weights(results)
    assert weight[1:] == pytest.approx([block.weight for block in model.assembly.blocks[1:]])
    assert seismic[1:] == pytest.approx([9.80665 * block.mass for block in model.assembly.blocks[1:]])
    assert [each.layer for each in results.loads or ()] == ["WALL", "WALL, foot", "WALL, left"]
    assert sum(each.combined_kN for each in results.loads or ()) == pytest.approx(model.assembly.weight)


def test_a_region_may_be_a_support_or_be_ignored(tmp_path):
    toml = TOML.replace('[layers.BASE]\nsupport = "base"\n', "") + REGION.replace(
        "friction = 0.4\nunit_weight_kN_m3 = 20.0", 'support = "ground"'
    )
    toml = (
        toml.replace("depth_m = 0.6", "ignore = true")
        .replace("[[-0.1, -0.1], [2.0", "[[-2.0, -1.0], [5.0")
        .replace("[2.0, 4.0], [-0.1, 4.0]", "[5.0, 0.0], [-2.0, 0.0]")
    )
    toml += '[[settlements]]\nname = "s"\nsupport = "ground"\ndisplacement_m = [0.0, -0.01]\n'
    model = built(tmp_path, toml, WALL=[WALL])
    assert [block.support for block in model.blocks].count("ground") == 1
    assert not any(block.centroid[0] < 1.0 and 0.0 < block.centroid[1] < 0.3 for block in model.blocks)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[-0.1, -0.1], [2.0, -0.1]", "[9.0, 9.0], [10.0, 9.0], [10.0, 9.1], [9.0, 9.1], [9.0, 9.0]", "crosses itself"),
        ("[[-0.1, -0.1], [2.0, -0.1], [2.0, 4.0], [-0.1, 4.0]]", "[[9, 9], [8, 9], [9, 8]]", "no block"),
        ('name = "foot"', 'name = "left"', 'region[2].name: "left" is the name of an earlier entry'),
        ("depth_m = 0.6", "dept_m = 0.6", "region[2].dept_m: unknown key"),
        ("friction = 0.4", "bond = { course_m = 1e-4, block_m = 0.5 }", "region.left.bond.course_m: 0.0001 makes"),
        ("[[-0.1, -0.1], [2.0, -0.1], [2.0, 4.0], [-0.1, 4.0]]", "[[9, 9], [10, 9]]", "region[1].outline_m"),
    ],
)  # fmt: skip
def test_regions_that_cannot_be(old, new, said, tmp_path):
    assert old in REGION
    assert said in refusal(tmp_path, TOML + REGION.replace(old, new), WALL=[WALL])
