"""Wrong input is told in one message with exit code 2, and nothing is touched."""

from __future__ import annotations

import json

import numpy as np
import pytest

from assessment.analyses.static import lateral
from assessment.cli.main import main
from assessment.results.schema import FORMAT
from tests.support.block_project import ASSESSMENT, PROJECT, command, contents, edit, run, write_block

pytestmark = pytest.mark.usefixtures("quick")


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
        '_m = 0.2\ncontrol = "rigth"',
        'pushover.control: no control point "rigth"; did you',
    ),
    "no stiffness": ("normal_stiffness_kN_m3 = 1e6\n", "", "material.normal_stiffness_kN_m3: missing"),
    "control outside": (
        "[0.3, 4.2]",
        "[0.3, 5.2]",
        "control.right.point_m: [0.3, 5.2] must be in or on a block (the nearest one is 1 m away); move it there",
    ),
    "control in a support": (
        "[0.3, 4.2]",
        "[0.3, -0.1]",
        'control.right.point_m: [0.3, -0.1] is in the support "base", which no push moves; move it',
    ),
    "unknown layer": ("[layers.BASE]", "[layers.BASIS]", "BASIS"),
    "no support": ('support = "base"\n[[control', "friction = 0.6\n[[control", "support"),
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
    after = contents(project / "output")
    if verb == "check" and err.startswith("error: geometry.dxf: "):
        assert "drawing with the faults marked: " in err and after.pop("model.svg")
    assert after == before


@pytest.mark.parametrize("verb", ["run", "check", "report"])
def test_a_project_that_is_not_there(tmp_path, capsys, verb):
    assert main([verb, str(tmp_path / "nothing")]) == 2
    assert capsys.readouterr().err.startswith(f"error: {tmp_path / 'nothing'}: project: no such folder")


def test_an_unknown_stage(project, capsys):
    assert run(project, "--only", "pushover,colapse") == 2
    assert 'error: --only: colapse: no such stage; valid: "pushdown", "pushover"' in capsys.readouterr().err


@pytest.mark.parametrize(("stages", "table"), [("campaign", "campaign"), ("history,incremental", "history")])
def test_stages_that_the_project_has_not_are_told_and_leave_its_results(project, capsys, stages, table):
    """Nothing was run, and that took the place of the results."""
    assert run(project) == 0
    before = contents(project / "output")
    assert run(project, "--only", stages) == 2
    name = stages.partition(",")[0]
    assert f"error: --only: {name}: the project has no [{table}]; add it, or name" in capsys.readouterr().err
    assert contents(project / "output") == before
    assert run(project, "--only", f"{stages},pushover") == 0


def test_an_empty_address_of_a_scheduler_is_refused(project, capsys):
    """The processes of this machine computed instead."""
    with pytest.raises(SystemExit) as stop:
        run(project, "--scheduler", "")
    assert stop.value.code == 2
    assert "argument --scheduler: is empty; give an address such as" in capsys.readouterr().err


def test_a_drawing_that_is_none(project, capsys):
    (project / "geometry.dxf").write_text("not a drawing", encoding="utf-8")
    assert run(project) == 2
    assert capsys.readouterr().err.startswith("error: ")


@pytest.mark.parametrize("stored", ["", "{", "[]", "{}", '{"echo": {}}'])
def test_results_that_are_none(project, capsys, stored):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text(stored, encoding="utf-8")
    assert main(["report", str(project)]) == 2
    assert "results.json: not readable as results" in capsys.readouterr().err
    assert (project / "output" / "results.json").read_text(encoding="utf-8") == stored


def test_results_cut_short(project, capsys):
    (project / "output").mkdir()
    content = {"assesto": "0.1.0", "format": FORMAT, "title": "Block", "model": {}, "states": {}}
    (project / "output" / "results.json").write_text(json.dumps(content), encoding="utf-8")
    assert main(["report", str(project)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {project / 'output' / 'results.json'}: summary: missing (and ")
    assert said.endswith("; run the project again\n")


def test_results_of_another_version(project, capsys):
    assert main(["run", str(project), "--no-report"]) == 0
    stored = project / "output" / "results.json"
    content = json.loads(stored.read_text(encoding="utf-8"))
    del content["model"]["weight_kN"]
    stored.write_text(json.dumps(content), encoding="utf-8")
    assert main(["report", str(project)]) == 2
    assert (
        "model.weight_kN: missing: damaged, or written by another version; run the project again"
        in capsys.readouterr().err
    )
    assert json.loads(stored.read_text(encoding="utf-8")) == content


def test_the_report_needs_results(project, capsys):
    assert main(["report", str(project)]) == 2
    assert "no stored results; run the project first" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "--template, --drawing or --example: missing; assesto new --list names what there is"),
        (["--template", "arc"], "no such template; did you mean"),
        (["--template", "block", "--set", "width=1"], 'no such option; did you mean "width_m"'),
        (["--template", "block", "--set", "width_m"], "--set width_m: not KEY=NUMBER"),
        (["--template", "block", "--set", "width_m=-1"], "must be a number, in m, from 0.001 to 1000"),
    ],
)
def test_new_says_what_is_wrong(tmp_path, capsys, options, message):
    assert main(["new", str(tmp_path / "n"), *options]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: ")
    assert message in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["buttressed arch", "Buttressed_Arch"])
def test_new_takes_the_name_of_a_template_as_it_is_spoken(tmp_path, capsys, name):
    assert main(["new", str(tmp_path / "n"), "--template", name]) == 0
    assert (tmp_path / "n" / "project.toml").exists()


def test_new_leaves_what_is_there(project, capsys):
    before = contents(project)
    assert main(["new", str(project), "--template", "arch"]) == 2
    assert "exists and is not empty" in capsys.readouterr().err
    assert contents(project) == before


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


def test_no_traceback_as_a_command(project):
    edit(project, "friction = 0.7", "fricton = 0.7")
    done = command("run", str(project))
    assert done.returncode == 2
    assert done.stderr.startswith("error: project.toml: material.fricton: ")
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_a_bug_is_no_input_error(project, monkeypatch):
    monkeypatch.setattr(lateral, "pushover", lambda *_, **__: {}["bug"])
    with pytest.raises(KeyError, match="bug"):
        run(project, "--jobs", "1")


def test_a_value_error_of_a_library_is_a_bug_and_not_the_users(project, monkeypatch):
    monkeypatch.setattr("assessment.project.project.load_project", lambda _: np.array_split(np.zeros(3), 0))
    with pytest.raises(ValueError, match="number sections"):
        main(["check", str(project)])


OPENED = ("geometry.dxf", "grid.txt", "shaking.csv", "upward.csv", "more.csv")


@pytest.mark.parametrize("verb", ["run", "check"])
@pytest.mark.parametrize("broken", OPENED)
def test_a_check_opens_every_file_that_a_run_opens(tmp_path, capsys, broken, verb):
    history = '[[history]]\nrecord = "shaking.csv"\nvertical_record = "upward.csv"\ncontacts = "rigid"\n'
    site = '[assessment.site]\nsoil = "B"\nlatitude = 42.02\nlongitude = 13.02\ngrid = "grid.txt"\n'
    folder = write_block(
        tmp_path / "block",
        PROJECT
        + history
        + '[incremental]\nrecords = ["m*.csv"]\n'
        + ASSESSMENT.partition("[assessment.site]")[0]
        + site,
    )
    values = "\t".join(f"{0.5 + k}\t2.4\t0.3" for k in range(9))
    nodes = [f"{13.0 + 0.06 * i}\t{42.0 + 0.05 * j}\t{values}" for i in range(2) for j in range(2)]
    (folder / "grid.txt").write_text("\n".join(nodes), encoding="utf-8")
    for name in OPENED[2:]:
        (folder / name).write_text("0,0\n0.01,0.1\n0.02,0\n", encoding="utf-8")
    if verb == "check":
        assert main(["check", str(folder)]) == 0
        capsys.readouterr()
    (folder / broken).write_text("broken", encoding="utf-8")
    assert main([verb, str(folder)]) == 2
    assert broken in capsys.readouterr().err


FAULTS = {
    "Python": ("int(float('nan'))", True),
    "NumPy": ("numpy.zeros(3) + numpy.zeros(4)", True),
    "ours": ("raise_it()", False),
}


@pytest.mark.parametrize("whose", FAULTS)
def test_an_error_of_python_or_numpy_is_never_passed_off_as_the_users(project, monkeypatch, capsys, whose):
    """A fault of ours ends with a traceback, also where the line that meets it is in one of our own modules."""
    expression, is_fault = FAULTS[whose]
    own = {"__name__": "mechanics.made_up", "numpy": np}
    exec("def raise_it(): raise ValueError('geometry.dxf: wrong; mend it')", own)
    exec(f"def tolerance(blocks): {expression}", own)
    monkeypatch.setattr("assessment.project.structure.model.default_tolerance", own["tolerance"])
    if is_fault:
        with pytest.raises(ValueError, match=r"NaN|broadcast"):
            main(["check", str(project)])
    else:
        assert main(["check", str(project)]) == 2
        assert capsys.readouterr().err == "error: geometry.dxf: wrong; mend it\n"
