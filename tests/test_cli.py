"""The program as users run it: commands, exit codes, messages, and what is left on the disk."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from assessment import output, stages, workflow
from assessment.cli import main
from assessment.new_project import write_drawing
from assessment.store import FOLDER
from mechanics import ConvergenceError
from tests.structures import rectangle

ROOT = Path(__file__).parents[1]
PROJECT = """title = "Block"

[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0
segments_per_joint = 2

[material]
unit_weight_kN_m3 = 18.0
friction = 0.7
normal_stiffness_kN_m3 = 1e6

[layers.BASE]
support = "base"

[[control]]
name = "top"
point_m = [0.3, 4.2]

[[settlements]]
name = "base turned"
support = "base"
rotation_rad = -0.02
increment_rad = 0.01

[pushover]
contacts = ["rigid"]
directions = ["+x"]
increment_m = 0.2
"""
ASSESSMENT = """
[assessment]
limit_states = ["SLV"]
model = "none"
[assessment.site]
soil = "B"
[assessment.site.SLV]
ag_g = 0.261
F0 = 2.36
Tc_star_s = 0.35
"""


@pytest.fixture
def drawn():
    """For tests that want the figures: everywhere else they would take most of the time."""


@pytest.fixture(autouse=True)
def _quick(monkeypatch, request):
    """One empty figure, and a PDF that only looks like one (the real one: see test_report)."""
    from assessment import figures

    def blank(_crew: object, folder: Path) -> None:
        folder.mkdir()
        (folder / "model.svg").write_text("<?xml?>", encoding="utf-8")

    if "drawn" not in request.fixturenames:
        monkeypatch.setattr(figures, "write_figures", blank)
        monkeypatch.setattr(figures, "write_images", lambda *_: [])
    printed = SimpleNamespace(write_pdf=lambda: b"%PDF-")
    monkeypatch.setitem(sys.modules, "weasyprint", SimpleNamespace(HTML=lambda string: printed))


@pytest.fixture
def project(tmp_path):
    """A project folder whose run takes a tenth of a second."""
    assert main(["new", str(tmp_path / "block"), "--template", "block"]) == 0
    folder = tmp_path / "block"
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    return folder


def edit(folder: Path, old: str, new: str) -> None:
    text = (folder / "project.toml").read_text(encoding="utf-8")
    assert old in text
    (folder / "project.toml").write_text(text.replace(old, new), encoding="utf-8")


def run(folder: Path, *options: str) -> int:
    return main(["run", str(folder), "--no-report", *options])


def results(folder: Path):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"), parse_constant=_no_constant)


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} is no JSON")


def contents(folder: Path) -> dict[str, str]:
    """Files and their digests, without the analyses kept for later runs."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and FOLDER not in path.parts
    }


def command(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "assessment.cli", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        **options,  # type: ignore[call-overload]
    )


def test_a_run_writes_everything_and_says_where(project, capsys, drawn):
    assert main(["run", str(project)]) == 0
    out, err = capsys.readouterr()
    assert str(project / "output") in out
    assert err == ""  # silent: no terminal
    found = {path.name for path in (project / "output").iterdir() if path.name != FOLDER}
    assert found == {"results.json", "report.html", "report.pdf", "judgement.md", "tables", "figures"}
    assert {p.suffix for p in (project / "output" / "figures").iterdir()} == {".svg", ".png", ".dxf"}
    assert {p.suffix for p in (project / "output" / "tables").iterdir()} == {".csv"}
    assert (project / "output" / "figures" / "model.svg").is_file()
    before = (project / "output" / "results.json").read_bytes()
    (project / "output" / "report.html").unlink()
    assert main(["report", str(project)]) == 0
    assert (project / "output" / "report.html").is_file()
    assert json.loads(before) == results(project / "output")


def test_without_report_there_is_none(project):
    assert run(project) == 0
    assert not list((project / "output").glob("report.*"))


def test_out_is_where_results_go(project, tmp_path):
    assert run(project, "--out", str(tmp_path / "deep" / "there")) == 0
    assert (tmp_path / "deep" / "there" / "results.json").is_file()
    assert not (project / "output").exists()


def test_results_have_the_keys_of_the_contract(project):
    edit(project, "increment_m = 0.2\n", "increment_m = 0.2\n" + ASSESSMENT)
    edit(project, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
    assert run(project) == 0
    found = results(project / "output")
    assert found.keys() >= {
        "assesto",
        "title",
        "inputs",
        "model",
        "states",
        "comparison",
        "quality",
        "timing_s",
    }
    drawing = (project / "geometry.dxf").read_bytes()
    assert found["inputs"]["geometry.dxf"] == hashlib.sha256(drawing).hexdigest()
    assert found["inputs"].keys() == {"project.toml", "geometry.dxf"}
    model = found["model"]
    assert model.keys() >= {
        "blocks",
        "movable_blocks",
        "joints",
        "contact_points",
        "weight_kN",
        "self_weight_stable",
        "warnings",
    }
    assert (model["blocks"], model["movable_blocks"], model["joints"], model["contact_points"]) == (
        2,
        1,
        1,
        8,
    )
    assert model["weight_kN"] == pytest.approx(0.6 * 4.2 * 18.0)
    assert model["self_weight_stable"] is True
    assert list(found["states"]) == ["original", "base turned"]
    for name, state in found["states"].items():
        assert state.keys() >= {"pushover", "capacity", "history", "incremental"}
        assert state["history"] == []
        rigid, elastic = state["pushover"]["+x"]["rigid"], state["pushover"]["+x"]["elastic"]
        assert rigid.keys() >= {"alpha_0", "d_0_m", "curve", "mechanism"}
        assert rigid["mechanism"].keys() >= {"hinges", "e_star", "gamma_star"}
        assert elastic.keys() >= {"alpha_u", "alpha_y", "d_y_m", "curve"}
        for curve in (rigid["curve"], elastic["curve"]):
            assert curve["displacement_m"][0] == 0.0
            assert len(curve["displacement_m"]) == len(curve["multiplier"]) > 2
        capacity = state["capacity"]["+x"]
        assert capacity.keys() >= {"e_star", "gamma_star", "T_0_s", "SLV"}
        assert capacity["SLV"].keys() >= {
            "d_star_m", "a_star_g", "T_s", "a_g_g", "demand_a_g_g", "zeta_E", "verified"
        }  # fmt: skip
        assert capacity["SLV"]["a_g_g"] is not None, name
    path = found["states"]["base turned"]["pushdown"]["rigid"]
    assert path.keys() >= {"movement_m", "reaction_x_kN", "reaction_z_kN", "ultimate_movement_m"}
    assert path["movement_m"][0] == 0.0
    assert path["ultimate_movement_m"] is None  # not sought
    assert found["comparison"][0].keys() >= {
        "state", "direction", "static_pga_g", "static_reduction", "dynamic_pga_g", "dynamic_reduction"
    }  # fmt: skip
    assert found["comparison"][0]["static_reduction"] > 0.0
    quality = found["quality"]
    assert quality.keys() >= {
        "solves",
        "worst_equilibrium_residual",
        "worst_penetration_m",
        "worst_complementarity",
        "warnings",
    }
    assert 0.0 <= quality["worst_equilibrium_residual"] < 1e-8
    assert quality["solves"] > 10
    assert found["timing_s"].keys() >= {"pushdown", "pushover"}


def test_results_are_right_for_a_block(project):
    # α = tan(arctan(B/H) − θ), d_0 where the centroid stands over the corner
    edit(project, "increment_m = 0.2", "increment_m = 0.02")
    assert run(project) == 0
    states = results(project / "output")["states"]
    for name, turn in (("original", 0.0), ("base turned", 0.02)):
        rigid = states[name]["pushover"]["+x"]["rigid"]
        angle = 0.14189705460416394 - turn  # arctan(0.6/4.2)
        assert rigid["alpha_0"] == pytest.approx(angle, rel=0.01)
        assert rigid["d_0_m"] == pytest.approx(4.2 * angle, rel=0.01)
        assert rigid["curve"]["multiplier"][-1] == pytest.approx(0.0, abs=1e-6)


def test_the_same_project_gives_the_same_numbers(project):
    found = []
    for name in ("one", "two"):
        assert run(project, "--out", str(project / name)) == 0
        found.append(results(project / name))
        del found[-1]["timing_s"]
    assert found[0] == found[1]


def test_several_processes_give_what_one_gives(project):
    edit(project, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
    states = []
    for jobs in ("1", "2"):
        assert run(project, "--jobs", jobs, "--out", str(project / jobs)) == 0
        states.append(results(project / jobs)["states"])
    assert states[0] == states[1]


def test_only_the_stages_asked_for(project):
    edit(project, "increment_m = 0.2\n", "increment_m = 0.2\n" + ASSESSMENT)
    assert run(project, "--only", "pushover") == 0
    state = results(project / "output")["states"]["base turned"]
    assert state["capacity"] == {}
    assert set(state["pushover"]) == {"+x"}
    assert run(project, "--only", "pushdown") == 0
    states = results(project / "output")["states"]
    assert "rigid" in states["base turned"]["pushdown"]
    assert all(state["pushover"] == {} for state in states.values())


def test_a_table_that_is_absent_switches_its_stage_off(project):
    (project / "project.toml").write_text(PROJECT.partition("[pushover]")[0], encoding="utf-8")
    assert run(project) == 0
    found = results(project / "output")
    assert list(found["states"]) == ["base turned"]
    assert found["states"]["base turned"]["pushover"] == {}
    assert found["comparison"] == []


def test_check_draws_the_model_and_runs_nothing(project, capsys):
    assert main(["check", str(project)]) == 0
    out = capsys.readouterr().out
    assert "blocks 2 (1 movable)" in out
    assert "own weight: yes" in out
    assert (project / "output" / "model.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
    assert not (project / "output" / "results.json").exists()


def test_check_leaves_earlier_results(project):
    assert run(project) == 0
    before = contents(project / "output")
    assert main(["check", str(project)]) == 0
    assert before.items() <= contents(project / "output").items()


# what is wrong: text of the project, its replacement, what the message says
WRONG = {
    "unknown key": (
        "friction = 0.7",
        "fricton = 0.7",
        'material.fricton: unknown key; did you mean "friction"',
    ),
    "wrong type": ("depth_m = 1.0", 'depth_m = "1"', "geometry.depth_m: "),
    "not positive": ("unit_weight_kN_m3 = 18.0", "unit_weight_kN_m3 = -1.0", "material.unit_weight_kN_m3: "),
    "missing file": ("geometry.dxf", "geometri.dxf", 'geometry.drawing: no file "geometri.dxf"'),
    "unknown support": (
        '"base"\nrotation',
        '"bse"\nrotation',
        'settlements[1].support: no support "bse"; did you',
    ),
    "unknown control": (
        "_m = 0.2",
        '_m = 0.2\ncontrol = "tap"',
        'pushover.control: no control point "tap"; did you',
    ),
    "no stiffness": ("normal_stiffness_kN_m3 = 1e6\n", "", "material.normal_stiffness_kN_m3: missing"),
    "control outside": (
        "[0.3, 4.2]",
        "[0.3, 5.2]",
        "control.top.point_m: [0.3, 5.2] must be in or on a block",
    ),
    "unknown layer": ("[layers.BASE]", "[layers.BASIS]", "BASIS"),
    "no support": ('support = "base"\n\n', "friction = 0.6\n\n", "support"),
    "not TOML": ("[geometry]", "[geometry", ""),
}


@pytest.mark.parametrize("verb", ["run", "check"])
@pytest.mark.parametrize("what", WRONG)
def test_wrong_input_is_said_in_one_message_and_nothing_is_touched(project, capsys, what, verb):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text("earlier", encoding="utf-8")
    before = contents(project / "output")
    old, new, message = WRONG[what]
    if what == "no stiffness":
        edit(project, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
    edit(project, old, new)
    assert main([verb, str(project)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert message in err
    assert "Traceback" not in err
    assert contents(project / "output") == before


@pytest.mark.parametrize("verb", ["run", "check", "report"])
def test_a_project_that_is_not_there(tmp_path, capsys, verb):
    assert main([verb, str(tmp_path / "nothing")]) == 2
    assert capsys.readouterr().err.startswith(f"error: {tmp_path / 'nothing'}: project: no such folder")


def test_an_unknown_stage(project, capsys):
    assert run(project, "--only", "pushover,colapse") == 2
    assert "error: --only: colapse: no such stage; choose from pushdown" in capsys.readouterr().err


def test_a_drawing_that_is_none(project, capsys):
    (project / "geometry.dxf").write_text("not a drawing", encoding="utf-8")
    assert run(project) == 2
    assert capsys.readouterr().err.startswith("error: ")


@pytest.mark.parametrize("verb", ["run", "check"])
@pytest.mark.parametrize("where", ["output", "output/below"])
def test_a_file_where_the_folder_should_go(project, capsys, verb, where):
    (project / "output").write_text("a file", encoding="utf-8")
    assert main([verb, str(project), "--out", str(project / where)]) == 2
    assert (
        f"error: {project / 'output'}: is a file; give another folder with --out" in capsys.readouterr().err
    )
    assert (project / "output").read_text(encoding="utf-8") == "a file"


@pytest.mark.parametrize("verb", ["run", "check"])
def test_a_folder_without_write_permission_is_said_before_any_analysis(project, capsys, monkeypatch, verb):
    # root may write anywhere: the system's answer is replaced
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    monkeypatch.setattr(workflow, "run", lambda *_: pytest.fail("an analysis ran"))
    before = contents(project)
    assert main([verb, str(project)]) == 2
    assert f"error: {project}: no permission to write" in capsys.readouterr().err
    assert contents(project) == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(project, capsys):
    project.chmod(0o500)
    try:
        assert run(project) == 2
    finally:
        project.chmod(0o700)
    assert "no permission to write" in capsys.readouterr().err


def test_a_disk_that_refuses_leaves_the_earlier_result(project, capsys, monkeypatch):
    assert run(project) == 0
    before = contents(project)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", str(project / "output"))

    monkeypatch.setattr(output, "write_atomically", full)
    assert run(project) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert contents(project) == before
    assert sorted(path.name for path in project.iterdir()) == [
        "geometry.dxf",
        "output",
        "project.toml",
        "records",
    ]


def test_a_structure_that_cannot_stand(project, capsys):
    _overhang(project)
    assert run(project) == 3
    found = results(project / "output")
    assert found["model"]["self_weight_stable"] is False
    assert "own weight" in found["quality"]["warnings"][0]
    assert all(state["pushover"] == {} for state in found["states"].values())
    assert "own weight: NO" in capsys.readouterr().out
    assert main(["check", str(project)]) == 0
    assert "own weight: NO" in capsys.readouterr().out


def test_the_report_of_a_structure_that_cannot_stand(project, drawn):
    _overhang(project)
    assert main(["run", str(project)]) == 3
    assert (project / "output" / "report.html").is_file()


def _overhang(project: Path) -> None:
    """A block whose centroid is beyond the edge of its base."""
    base, block = rectangle(-2.0, -1.0, 0.0, 0.0), rectangle(-0.2, 0.0, 0.6, 4.2)
    write_drawing(project / "geometry.dxf", {"BASE": [np.array(base)], "BLOCKS": [np.array(block)]})


def test_a_settlement_beyond_collapse_keeps_what_was_completed(project, capsys):
    edit(project, "rotation_rad = -0.02", "rotation_rad = -0.3")
    assert run(project) == 3
    found = results(project / "output")
    settled = found["states"]["base turned"]
    assert found["states"]["original"]["pushover"]["+x"]["rigid"]["alpha_0"] == pytest.approx(1 / 7, rel=1e-3)
    assert len(settled["pushdown"]["rigid"]["movement_m"]) > 5
    assert (
        settled["pushdown"]["rigid"]["ultimate_movement_m"] == settled["pushdown"]["rigid"]["movement_m"][-1]
    )
    assert settled["pushover"] == {}
    assert any("collapses at a movement of" in text for text in found["quality"]["warnings"])
    assert "collapses" in capsys.readouterr().out


def test_the_report_of_what_was_completed(project, drawn):
    edit(project, "rotation_rad = -0.02", "rotation_rad = -0.3")
    assert main(["run", str(project)]) == 3
    assert (project / "output" / "report.html").is_file()


def test_a_stale_figure_goes_and_a_stranger_stays(project):
    assert run(project) == 0
    (project / "output" / "figures" / "pushover_of_yesterday.svg").write_text("old", encoding="utf-8")
    (project / "output" / "notes.txt").write_text("mine", encoding="utf-8")
    assert run(project) == 0
    assert [path.name for path in (project / "output" / "figures").iterdir()] == ["model.svg"]
    assert (project / "output" / "notes.txt").read_text(encoding="utf-8") == "mine"


def test_an_analysis_that_does_not_converge_is_reported_as_such(project, monkeypatch):
    def fail(*_: object) -> None:
        raise ConvergenceError("equilibrium exists, but no solver found it")

    monkeypatch.setattr(stages, "pushover", fail)
    assert run(project, "--jobs", "1") == 3
    found = results(project / "output")
    assert any("no solver found it" in text for text in found["quality"]["warnings"])
    assert found["states"]["base turned"]["pushdown"]["rigid"]["movement_m"]


def test_a_bug_is_no_input_error(project, monkeypatch):
    monkeypatch.setattr(stages, "pushover", lambda *_: {}["bug"])
    with pytest.raises(KeyError, match="bug"):
        run(project, "--jobs", "1")


def test_the_report_needs_results(project, capsys):
    assert main(["report", str(project)]) == 2
    assert "no stored results; run the project first" in capsys.readouterr().err


@pytest.mark.parametrize("stored", ["", "{", "[]", "{}", '{"echo": {}}'])
def test_results_that_are_none(project, capsys, stored):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text(stored, encoding="utf-8")
    assert main(["report", str(project)]) == 2
    assert "results.json: not readable as results" in capsys.readouterr().err
    assert (project / "output" / "results.json").read_text(encoding="utf-8") == stored


def test_results_cut_short(project, capsys):
    (project / "output").mkdir()
    content = {"echo": {"report": {}}, "title": "Block", "model": {}, "states": {}, "quality": {}}
    (project / "output" / "results.json").write_text(json.dumps(content), encoding="utf-8")
    assert main(["report", str(project)]) == 2
    said = capsys.readouterr().err
    assert "results.json: geometry missing: results cut short; run the project again" in said


def test_a_value_error_of_a_library_is_a_bug_and_not_the_users(project, monkeypatch):
    monkeypatch.setattr("assessment.project.load_project", lambda _: np.array_split(np.zeros(3), 0))
    with pytest.raises(ValueError, match="number sections"):
        main(["check", str(project)])


def test_new_writes_a_project_that_checks(tmp_path, capsys):
    assert (
        main(["new", str(tmp_path / "w"), "--template", "wall", "--set", "courses=3", "--set", "blocks=3"])
        == 0
    )
    assert main(["check", str(tmp_path / "w")]) == 0
    assert "own weight: yes" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--template", "arc"], "no such template; did you mean"),
        (["--template", "block", "--set", "width=1"], 'no such option; did you mean "width_m"'),
        (["--template", "block", "--set", "width_m"], "--set width_m: not KEY=NUMBER"),
        (["--template", "block", "--set", "width_m=-1"], "must be a positive number"),
    ],
)
def test_new_says_what_is_wrong(tmp_path, capsys, options, message):
    assert main(["new", str(tmp_path / "n"), *options]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: ")
    assert message in err
    assert not list(tmp_path.iterdir())


def test_new_leaves_what_is_there(project, capsys):
    before = contents(project)
    assert main(["new", str(project), "--template", "arch"]) == 2
    assert "exists and is not empty" in capsys.readouterr().err
    assert contents(project) == before


def test_new_lists_the_dimensions(tmp_path, capsys):
    assert main(["new", str(tmp_path / "n"), "--template", "block", "--list"]) == 0
    assert "width_m" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_help_as_a_command():
    done = command("--help")
    assert done.returncode == 0
    assert all(verb in done.stdout for verb in ("run", "check", "new", "report"))


def test_no_traceback_as_a_command(project):
    edit(project, "friction = 0.7", "fricton = 0.7")
    done = command("run", str(project))
    assert done.returncode == 2
    assert done.stderr.startswith("error: project.toml: material.fricton: ")
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_a_killed_run_leaves_the_earlier_result(project):
    """SIGKILL wherever it strikes: during the analyses and while files are written."""
    assert run(project) == 0
    before = contents(project / "output")
    edit(project, "increment_m = 0.2", "increment_m = 0.001")
    # the process kills itself after its first figure: that is written, results.json is not
    code = (
        "import os, signal, sys, assessment.figures as figures\n"
        "from assessment.cli import main\n"
        "draw = figures.save_svg\n"
        "figures.save_svg = lambda *it: (draw(*it), os.kill(os.getpid(), signal.SIGKILL))\n"
        "main(['run', sys.argv[1], '--no-report', '--jobs', '1'])"
    )
    killed = subprocess.run(
        [sys.executable, "-c", code, str(project)], cwd=ROOT, capture_output=True, check=False
    )
    assert killed.returncode == -signal.SIGKILL
    left = contents(project / "output")
    assert any(name.startswith(".assesto-") for name in left)
    assert {name: value for name, value in left.items() if not name.startswith(".")} == before
    # what is left over is hidden, is taken for no result, and does not stop the next run
    seen = {path.name for path in project.iterdir() if not path.name.startswith(".")}
    assert seen == {"geometry.dxf", "project.toml", "records", "output"}
    assert run(project) == 0
    after = contents(project / "output")
    assert after != before
    assert not any(name.startswith(".assesto-") for name in after)


def test_files_that_are_not_ours_stay(project, tmp_path):
    out = tmp_path / "docs"
    for name in ("tables/mine.txt", "tables/mine.csv", "figures/sub/mine.svg", "report.pdf"):
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text("mine", encoding="utf-8")
    assert run(project, "--out", str(out)) == 0
    for name in ("tables/mine.txt", "tables/mine.csv", "figures/sub/mine.svg", "report.pdf"):
        assert (out / name).read_text(encoding="utf-8") == "mine"


def test_e_star_and_gamma_star_without_an_assessment(project):
    """One block: its centroid moves as the whole does, and half as far as the control point at its top."""
    assert run(project) == 0
    mechanism = results(project / "output")["states"]["original"]["pushover"]["+x"]["rigid"]["mechanism"]
    assert mechanism["e_star"] == pytest.approx(1.0)
    assert mechanism["gamma_star"] == pytest.approx(0.5)


def test_a_layer_without_stiffness_is_named(project, capsys):
    edit(project, "normal_stiffness_kN_m3 = 1e6\n", "")
    edit(
        project,
        '[layers.BASE]\nsupport = "base"',
        '[layers.BASE]\nsupport = "base"\nnormal_stiffness_kN_m3 = 1e6',
    )
    edit(project, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
    assert main(["check", str(project)]) == 2
    message = capsys.readouterr().err
    assert message.startswith("error: project.toml: layers.")
    assert "normal_stiffness_kN_m3: missing" in message


def test_a_path_cut_short_has_no_capacity(project, monkeypatch):
    import importlib

    monkeypatch.setattr(importlib.import_module("mechanics.pushover"), "MOST_STEPS", 3)
    (project / "project.toml").write_text(PROJECT + ASSESSMENT, encoding="utf-8")
    run(project)
    found = results(project / "output")["states"]["original"]
    assert found["pushover"]["+x"]["rigid"]["d_0_m"] is None
    assert found["capacity"]["+x"]["SLV"]["verified"] is None


def test_what_a_path_had_reached_is_kept_where_no_solver_goes_on(project, monkeypatch):
    import importlib

    procedure = importlib.import_module("mechanics.pushover")
    step, count = procedure.find_step, iter(range(1000))

    def fails_later(*arguments):
        if next(count) >= 2:
            raise ConvergenceError("no answer")
        return step(*arguments)

    monkeypatch.setattr(procedure, "find_step", fails_later)
    edit(
        project,
        '[[settlements]]\nname = "base turned"\nsupport = "base"\nrotation_rad = -0.02\nincrement_rad = 0.01\n',
        "",
    )
    run(project)
    rigid = results(project / "output")["states"]["original"]["pushover"]["+x"]["rigid"]
    assert len(rigid["curve"]["multiplier"]) == 3
    assert rigid["d_0_m"] is None
