"""A check: about how long a run takes; a project drawn at geographic coordinates."""

import re
from pathlib import Path

import numpy as np
import pytest

from assessment.project.catalogue.new_project import made, new_project, write_drawing
from assessment.project.masonry import chosen_mechanisms
from assessment.project.model import build_model, gauges
from assessment.project.project import load_project
from assessment.results.hand_check import hand_checks, macro_blocks
from assessment.studies import identification
from assessment.workflow.checking import expected, read_inputs
from assessment.workflow.stages import run
from tests import ROOT
from tests.support.block_project import TURNED, block
from tests.support.tied_project import TIE


@pytest.fixture(scope="module")
def arch():
    project = load_project(ROOT / "projects" / "arch_campaign")
    return read_inputs(project, build_model(project))


def changed(read, **tables):
    project = read.project.model_copy(update=tables)
    return expected(type(read)(**{**vars(read), "project": project}))


def test_a_campaign_takes_as_long_as_its_motions(arch):
    study = arch.project.campaign
    as_drawn = changed(arch, campaign=study.model_copy(update={"shares": (0.0,)}))["campaign"]
    # as drawn once, and two movements at two shares each
    assert expected(arch)["campaign"] == pytest.approx(5.0 * as_drawn)
    one_sign = changed(arch, campaign=study.model_copy(update={"signs": (1,)}))["campaign"]
    assert expected(arch)["campaign"] == pytest.approx(2.0 * one_sign)


def test_members_of_an_ensemble_and_smaller_increments_take_longer(arch):
    assert changed(arch, scatter=5)["pushover"] == pytest.approx(4.0 * expected(arch)["pushover"])
    finer = tuple(each.model_copy(update={"increment_m": 0.0015}) for each in arch.project.settlements)
    assert changed(arch, settlements=finer)["pushdown"] == pytest.approx(2.0 * expected(arch)["pushdown"])


@pytest.mark.parametrize(("template", "seconds"), [("arch", 5.8), ("facade", 11.0), ("wall", 85.0)])
def test_templates_take_what_was_measured(tmp_path, template, seconds):
    """Processor time of the static chain, within a factor of two: arches, a stacked wall, walls in bond."""
    new_project(tmp_path / template, template, {})
    project = load_project(tmp_path / template)
    told = expected(read_inputs(project, build_model(project)))
    assert seconds / 2.0 < told.get("pushdown", 0.0) + told["pushover"] < 2.0 * seconds


UTM = (498123.4, 4601237.7)
TABLES = """[pushover]
contacts = ["rigid"]
increment_m = 0.2
[pushover.control]
"+x" = "right"
"-x" = "left"
[[mechanism]]
name = "toe"
about_m = [0.3, 0.0]
rotation = -1.0
region_m = [-1.0, 0.0, 1.0, 5.0]
[[measurement]]
name = "joint"
kind = "crack"
point_m = [-0.3, 0.0]
opening_mm = 1.0
sigma_mm = 0.5
[identification]
hypotheses = [{ base = ["rotation"] }]
"""
PLACES = re.compile(r"(point_m|from_m|to_m|about_m|region_m) = \[([^\]]*)\]")


def project(folder: Path, away: tuple[float, float]):
    folder.mkdir()
    layout = made("block", {"width_m": 0.6, "height_m": 4.2})[0]
    write_drawing(folder / "geometry.dxf", {layer: [p + away for p in own] for layer, own in layout.items()})

    def moved(found: re.Match[str]) -> str:
        numbers = [float(n) + away[k % 2] for k, n in enumerate(found[2].split(","))]
        return f"{found[1]} = {numbers}"

    text = 'scatter = 1\naccuracy = "fast"\n' + PLACES.sub(moved, block() + TURNED + TIE + TABLES)
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return load_project(folder)


def test_points_are_given_and_told_as_drawn_and_numbers_are_those_at_the_origin(tmp_path, monkeypatch):
    for name, value in {"FARTHEST": 2.0, "COARSE": 5, "FINE": 2, "STARTS": 1}.items():
        monkeypatch.setattr(identification, name, value)
    near, far = project(tmp_path / "near", (0.0, 0.0)), project(tmp_path / "far", UTM)
    models = [build_model(each) for each in (near, far)]
    assert [w for w in models[1].warnings if "count from (498122, 4601237) m" in w] and not models[0].warnings
    found = [run(each, model, jobs=1).results for each, model in zip((near, far), models, strict=True)]
    for one, other in zip(*(each.geometry.blocks for each in found), strict=True):
        assert np.subtract(other.vertices_m, UTM) == pytest.approx(np.array(one.vertices_m), abs=2e-9)
    assert found[0].geometry.origin_m is None and found[1].geometry.origin_m == [498122.0, 4601237.0]
    assert found[1].geometry.controls[0].point_m == pytest.approx(np.add(UTM, (0.3, 4.2)), abs=1e-6)
    for state in ("original", "base turned"):
        for direction in ("+x", "-x"):
            one, other = (each.states[state].pushover[direction].rigid for each in found)
            assert other.alpha_0 == pytest.approx(one.alpha_0, rel=1e-7)
            assert other.d_0_m == pytest.approx(one.d_0_m, rel=1e-6)
            points = [np.array(each.mechanism.hinge_points_m) for each in (one, other)]
            assert points[1] - UTM == pytest.approx(points[0], abs=1e-6)
            groups = [macro_blocks(each, state, direction) for each in found]
            centre, seen = ([group[0].x_C_m, group[0].z_C_m] for group in groups)
            assert np.add(seen, found[1].geometry.origin_m) - UTM == pytest.approx(centre, abs=2e-4)
    checks = [list(hand_checks(each)) for each in found]
    assert [c.hand_deviation for c in checks[1]] == pytest.approx(
        [c.hand_deviation for c in checks[0]], abs=1e-3
    )
    given = [each.mechanisms[0] for each in found]
    assert given[1].alpha_0 == pytest.approx(given[0].alpha_0, rel=1e-6)
    assert np.subtract(given[1].macro_blocks[0].about_m, UTM) == pytest.approx((0.3, 0.0), abs=1e-6)
    assert np.subtract(given[1].control_m, UTM) == pytest.approx(given[0].control_m, abs=1e-6)
    assert gauges(far, models[1].assembly)[0].end == gauges(near, models[0].assembly)[0].end
    assert chosen_mechanisms(far, models[1].assembly)[0].parts[0].blocks.tolist() == [1]
