"""Wrong input is told in one message with exit code 2, a wrong drawing with a picture, and nothing is touched."""

import json
import re

import numpy as np
import pytest

from assessment.cli.main import main
from tests.support.block_project import ASSESSMENT, PROJECT, contents, edit, run, write_block
from tests.support.contract_project import MINIMAL
from tests.support.dxf import drawing, outline
from tests.support.structures import rectangle

pytestmark = pytest.mark.usefixtures("quick")


# what is wrong: text of the project, its replacement, what the message says
WRONG = {
    "unknown key": ("friction = 0.7", "fricton = 0.7", 'material.fricton: unknown key; did you mean "friction"'),
    "a folder": ('"geometry.dxf"', '"."', 'geometry.drawing: "." is a folder; name a file'),
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
    "not TOML": ("[geometry]", "[geometry", ""),
}  # fmt: skip


@pytest.mark.parametrize("verb", ["run", "check"])
@pytest.mark.parametrize("what", WRONG)
def test_wrong_input_is_said_in_one_message_and_nothing_is_touched(project, capsys, what, verb):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text("earlier", encoding="utf-8")
    before = contents(project / "output")
    old, new, message = WRONG[what]
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


@pytest.mark.parametrize("stored", ["{", "[]", '{"echo": {}}'])
def test_results_that_are_none(project, capsys, stored):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text(stored, encoding="utf-8")
    assert main(["report", str(project)]) == 2
    assert "results.json: not readable as results" in capsys.readouterr().err
    assert (project / "output" / "results.json").read_text(encoding="utf-8") == stored


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
    monkeypatch.setattr("assessment.project.model.default_tolerance", own["tolerance"])
    if is_fault:
        with pytest.raises(ValueError, match=r"NaN|broadcast"):
            main(["check", str(project)])
    else:
        assert main(["check", str(project)]) == 2
        assert capsys.readouterr().err == "error: geometry.dxf: wrong; mend it\n"


WALL = MINIMAL + '[layers.BASE]\nsupport = "base"\n'


def checked(folder, capsys, document, text=WALL):
    """The lines that a check of a drawing says, and the picture."""
    document.saveas(folder / "geometry.dxf")
    (folder / "project.toml").write_text(text, encoding="utf-8")
    assert main(["check", str(folder)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    return err.splitlines(), (folder / "output" / "model.svg").read_text(encoding="utf-8")


def numbers(picture: str) -> set[str]:
    """The numbers that stand in a picture."""
    return set(re.findall(r"<text[^>]*>(\d+)</text>", picture))


def test_every_fault_is_listed_once_and_marked(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 9, 0), "BASE")
    for k in range(8):
        outline(space, rectangle(k, 0, k + 1, 1))
    outline(space, rectangle(-3, -3, 12, 9), "FRAME")
    outline(space, rectangle(3, 0, 4, 1))
    outline(space, rectangle(5.5, 0.5, 6.5, 2))
    lines, picture = checked(tmp_path, capsys, document)
    *told, last, hint = lines
    assert hint == "small faults can be repaired in a copy of the drawing: assesto check --repair"
    assert last == f"drawing with the faults marked: {tmp_path / 'output' / 'model.svg'}"
    assert all(re.match(r"error: geometry\.dxf: fault \d: block \d+ \(layer ", line) for line in told)
    assert [("twice" in line, "encloses" in line, "overlap by" in line) for line in told] == [
        (True, False, False), (False, True, False), (False, False, True), (False, False, True),
    ]  # fmt: skip
    assert numbers(picture) == {"1", "2", "3", "4"}
    for key in ("drawn more than once: 1", "frame around other blocks: 1", "overlap: 2"):
        assert key in picture


def test_the_tolerance_that_mends_is_proposed_and_mends(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 4, 0), "BASE")
    for k in range(3):
        outline(space, rectangle(k, 0, k + 1, 1))
        outline(space, rectangle(k, 1.0026, k + 1, 2))
    lines, picture = checked(tmp_path, capsys, document)
    assert lines[-3] == (
        "error: geometry.dxf: gaps of up to 2.6 mm: geometry.tolerance_m = 0.004 closes all of them"
    )
    assert numbers(picture) == {"1", "2", "3"}
    (tmp_path / "project.toml").write_text(
        WALL.replace("[material]", "tolerance_m = 0.004\n[material]"), encoding="utf-8"
    )
    assert main(["check", str(tmp_path)]) == 0
    assert "stands under its own weight: yes" in capsys.readouterr().out


def test_faults_of_outlines_and_of_blocks_are_told_together(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 4, 0), "BASE")
    outline(space, rectangle(0, 0, 1, 1))
    outline(space, rectangle(0, 0, 1, 1))
    outline(space, rectangle(2, 0, 3, 1), close=False)
    outline(space, [(5, 0), (6, 1), (6, 0), (5, 1)])
    lines, picture = checked(tmp_path, capsys, document)
    assert ["is open" in lines[0], "crosses" in lines[1], "twice" in lines[2]] == [True] * 3
    assert lines[3] == (
        "error: geometry.dxf: gaps, and blocks that touch nothing, are looked for once these are mended"
    )
    assert numbers(picture) == {"1", "2", "3"}
