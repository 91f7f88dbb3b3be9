"""The control point of a project: chosen where none is given, and where the given one takes no part."""

from __future__ import annotations

import re

import pytest

from assessment.analyses import lateral
from assessment.cli.main import main
from assessment.project.catalogue.geometry import rectangle
from assessment.project.catalogue.new_project import write_drawing
from assessment.project.schema import ControlTable
from mechanics.errors import NoEquilibriumError
from mechanics.messages import message
from tests.support.block_project import ASSESSMENT, TURNED, block, read_results, run
from tests.support.structures import block_on_base

CONTROLS = re.compile(r"\[\[control\]\]\nname = .*\npoint_m = .*\n")
BARE = CONTROLS.sub("", block())
PUSH = '[pushover]\ncontacts = ["rigid", "elastic"]\nincrement_m = 0.05\n'


def plinth(folder, text: str):
    """A wall 0.6 × 4.2 m on a plinth 1 × 1 m that does not move in its mechanism."""
    folder.mkdir(exist_ok=True)
    layers = {
        "BASE": [rectangle(-1.0, 1.0, -0.3, 0.0)],
        "WALL": [rectangle(-0.5, 0.5, 0.0, 1.0), rectangle(-0.3, 0.3, 1.0, 5.2)],
    }
    write_drawing(folder / "geometry.dxf", layers)
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.usefixtures("no_figures")
def test_a_project_without_control_point_follows_one_and_says_which(tmp_path, capsys):
    """Every stage that needs one has it, in every state; `check` says the same."""
    project = plinth(tmp_path / "wall", BARE + TURNED + PUSH)
    assert main(["check", str(project)]) == 0
    said = "no control point given: towards +x that of block 2 at (0.3, 5.2) m is followed"
    assert said in capsys.readouterr().out
    assert run(project) == 0
    results = read_results(project / "output")
    assert any(said in warning for warning in results["quality"]["warnings"])
    controls = {each["name"]: (each["point_m"], each["block"]) for each in results["geometry"]["controls"]}
    assert controls == {"scelto +x": ([0.3, 5.2], 2), "scelto -x": ([-0.3, 5.2], 2)}
    for state in results["states"].values():
        for direction, pushed in state["pushover"].items():
            assert (
                pushed["control"] == f"scelto {direction}"
                and pushed["control_m"] == controls[pushed["control"]][0]
            )
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    assert rigid["alpha_0"] == pytest.approx(1.0 / 7.0, rel=1e-6)


@pytest.mark.usefixtures("no_figures")
def test_a_curve_is_not_thrown_away_for_its_control_point(tmp_path):
    """It had no curve, with the advice to add a point; with elastic joints the plinth moved, and had its own."""
    given = BARE + '[[control]]\nname = "plinth"\npoint_m = [0.45, 0.9]\n'
    found = {}
    for name, text in (("plinth", given), ("none", BARE)):
        project = plinth(tmp_path / name, text + PUSH + ASSESSMENT.replace('"none"', '"trilinear"'))
        assert run(project) == 0
        results = read_results(project / "output")
        found[name] = results["states"]["original"]
        warned = [each for each in results["quality"]["warnings"] if "takes no part" in each]
        assert len(warned) == (2 if name == "plinth" else 0), warned
    for direction, pushed in found["plinth"]["pushover"].items():
        other = found["none"]["pushover"][direction]
        assert pushed["control_m"] == other["control_m"]
        for contacts in ("rigid", "elastic"):
            for key, values in pushed[contacts]["curve"].items():
                assert values == pytest.approx(other[contacts]["curve"][key], rel=1e-6, abs=1e-9)
        ratios = [found[name]["capacity"][direction]["SLV"]["zeta_E"] for name in ("plinth", "none")]
        assert ratios[0] == pytest.approx(ratios[1], rel=1e-6)


def test_a_curve_whose_first_motion_is_not_found_is_told_and_the_others_go_on(monkeypatch):
    """Checks are of the first motion: without it there is no capacity, and none that is too large."""
    model, made = block_on_base(), lateral.rigid_push

    def lost(control, path):
        if path.direction == "-x":
            raise NoEquilibriumError(message("no equilibrium: some block would start to move"))
        return made(control, path)

    monkeypatch.setattr(lateral, "rigid_push", lost)
    setting = lateral.PushSetting("rigid", "coulomb", 0.02)
    control = ControlTable(name="C", point_m=(0.0, 1.0))
    there, none = lateral.push(model, "original", None, setting, ("+x", "-x"), (control, control))
    assert there.value is not None
    assert none.value is None
    assert "pushover -x, rigid contacts: the mechanism of the first motion is not found" in none.failures[0]
