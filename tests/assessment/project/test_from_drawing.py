"""assesto new DIR --drawing FILE: what is proposed, and that check accepts it."""

import tomllib

import numpy as np
import pytest

from assessment.cli.main import main
from assessment.project.catalogue.new_project import made
from assessment.project.model import build_model
from assessment.project.project import load_project
from tests.support.dxf import drawing, outline

SCALE = {"mm": 1e3, "cm": 1e2, "m": 1.0}


def survey(path, unit="m", declared=None, layers=None, template="arcade"):
    """A template's outlines as a survey has them: with a frame, an axis, a crack, a title and a north arrow."""
    document, space = drawing(unit=declared or unit)
    if declared == "":
        document.header["$INSUNITS"] = 0
    factor = SCALE[unit]
    every = []
    for layer, polygons in made(template, {})[0].items():
        for polygon in polygons:
            outline(space, (factor * polygon).tolist(), (layers or {}).get(layer, layer))
            every.append(polygon)
    low, high = np.concatenate(every).min(axis=0) - 2.0, np.concatenate(every).max(axis=0) + 2.0
    box = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    outline(space, (factor * box).tolist(), "SQUADRATURA")
    arrow = low + np.array([(0.5, 0.5), (0.8, 0.5), (0.65, 1.0)])
    outline(space, (factor * arrow).tolist(), "NORD")
    outline(space, (factor * np.array([(0.0, 1.0), (0.5, 2.0)])).tolist(), "FESSURE", close=False)
    space.add_line((factor * low[0], 0.0), (factor * high[0], 0.0), dxfattribs={"layer": "ASSI"})
    space.add_text("Prospetto", dxfattribs={"layer": "TESTI"})
    document.saveas(path)


@pytest.mark.parametrize(("unit", "declared"), [("mm", "as it is"), ("cm", ""), ("m", "")])
def test_a_clean_drawing_becomes_a_project_that_check_accepts(unit, declared, tmp_path, capsys):
    survey(tmp_path / "rilievo.dxf", unit, unit if declared == "as it is" else declared)
    assert main(["new", str(tmp_path / "p"), "--drawing", str(tmp_path / "rilievo.dxf")]) == 0
    out = capsys.readouterr().out
    assert f"unit: {unit}, " in out
    assert ("though $INSUNITS says m" in out) == (declared == "m" and unit != "m")
    project = load_project(tmp_path / "p")
    assert project.geometry.unit == unit
    ignored = {name for name, layer in project.layers.items() if layer.ignore}
    assert ignored == {"SQUADRATURA", "NORD", "ASSI"}
    assert len(project.supports) == 4
    assert project.settlements[0].support == project.supports[-1]
    model = build_model(project)
    assert [w for w in model.warnings if "$INSUNITS" not in w] == []
    assert sum(block.support is not None for block in model.assembly.blocks) == 4
    [crack] = model.cracks
    assert crack == pytest.approx(np.array([(0.0, 1.0), (0.5, 2.0)])) and "surveyed cracks" in out
    assert (tmp_path / "p" / "rilievo.dxf").read_bytes() == (tmp_path / "rilievo.dxf").read_bytes()
    for key in ("geometry.depth_m = 1.0", "material.friction = 0.6", "[assessment.site]"):
        assert key in out
    assert out.rstrip().endswith(f"next: assesto check {tmp_path / 'p'}")
    text = (tmp_path / "p" / "project.toml").read_text(encoding="utf-8")
    assert text.count("TO FILL IN") == 5
    assert "assessment" not in tomllib.loads(text), "a site is nothing to be guessed"
    assert main(["check", str(tmp_path / "p")]) == 0


def test_supports_without_a_layer_of_their_own_are_regions(tmp_path, capsys):
    every = dict.fromkeys(made("barrel-vault", {})[0], "MURATURA")
    survey(tmp_path / "g.dxf", "mm", layers=every, template="barrel-vault")
    assert main(["new", str(tmp_path / "p"), "--drawing", str(tmp_path / "g.dxf")]) == 0
    out = capsys.readouterr().out
    assert 'support "sinistro": the lowest blocks (1) between x = ' in out
    project = load_project(tmp_path / "p")
    assert [each.support for each in project.region] == ["sinistro", "destro"]
    blocks = build_model(project).assembly.blocks
    assert [block.support for block in blocks if block.support] == ["sinistro", "destro"]
    assert all(block.polygon[:, 1].min() < 0.0 for block in blocks if block.support), "the bases"


@pytest.mark.parametrize("broken", [(0, 1), (2, 0)])
@pytest.mark.parametrize("lines", [False, True])
def test_what_rests_on_an_outline_with_a_fault_is_no_support(broken, lines, tmp_path, capsys):
    document, space = drawing(unit="mm")
    at = np.array([251300.0, 12040.0])  # as a survey has them
    outline(space, at + 1e3 * np.array([(0, -1), (3, -1), (3, 0), (0, 0)]), "FONDAZIONE")
    for k, row in np.ndindex(3, 6):
        ring = at + 1e3 * np.array([(k, row), (k + 1, row), (k + 1, row + 1), (k, row + 1)])
        if (k, row) == broken and lines:
            for one, other in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                space.add_line(one, other, dxfattribs={"layer": "MURO"})
        elif (k, row) == broken:  # open, its last point a hand away from the first
            outline(space, [*ring, ring[0] + (3.0, 2.0)], "MURO", close=False)
        else:
            outline(space, ring, "MURO")
    document.saveas(tmp_path / "g.dxf")
    assert main(["new", str(tmp_path / "p"), "--drawing", str(tmp_path / "g.dxf")]) == 0
    assert 'support "base": layer FONDAZIONE' in capsys.readouterr().out
    project = load_project(tmp_path / "p")
    assert list(project.supports) == ["base"]
    assert not project.region


def lines(folder):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    document.saveas(folder / "g.dxf")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda folder: None, "g.dxf: cannot be read (No such file or directory); give the path of a DXF file"),
        (lambda folder: (folder / "g.dxf").write_bytes(b"AC1032 a DWG"), "DWG"),
        (lines, "nothing closed is in model space, but 1 LINE; draw each block as one closed polyline"),
    ],
)  # fmt: skip
def test_what_is_no_drawing_of_blocks_is_refused_and_nothing_written(make, said, tmp_path, capsys):
    make(tmp_path)
    assert main(["new", str(tmp_path / "p"), "--drawing", str(tmp_path / "g.dxf")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert said in error
    assert not (tmp_path / "p").exists()


def test_a_wall_with_openings_is_cut_into_blocks(tmp_path, capsys):
    """A door touches the outline of its wall from within; the ground below stays a support."""
    document, space = drawing(unit="m")
    for layer, (x0, z0, x1, z1) in (
        ("MURO", (0.0, 0.0, 6.0, 4.0)),
        ("MURO", (2.4, 0.0, 3.6, 2.1)),
        ("MURO", (4.4, 1.2, 5.2, 2.4)),
        ("FONDAZIONE", (-0.5, -0.6, 2.4, 0.0)),
        ("FONDAZIONE", (3.6, -0.6, 6.5, 0.0)),
    ):
        outline(space, [(x0, z0), (x1, z0), (x1, z1), (x0, z1)], layer)
    document.saveas(tmp_path / "muro.dxf")
    assert main(["new", str(tmp_path / "p"), "--drawing", str(tmp_path / "muro.dxf")]) == 0
    assert "[layers.MURO.bond]" in capsys.readouterr().out
    model = build_model(load_project(tmp_path / "p"))
    walled = [block for block in model.assembly.blocks if block.support is None]
    assert sum(block.area for block in walled) == pytest.approx(24.0 - 2.52 - 0.96)
    assert len(walled) > 60
