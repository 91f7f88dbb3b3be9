"""What is left on the disk: each file whole or not at all, and nobody else's touched."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from assessment.cli.main import main
from assessment.results.numbers import plain
from assessment.workflow import output
from assessment.workflow import stages as workflow
from tests.support.block_project import contents, edit, run

pytestmark = pytest.mark.usefixtures("quick")


def test_out_is_where_results_go(project, tmp_path):
    assert run(project, "--out", str(tmp_path / "deep" / "there")) == 0
    assert (tmp_path / "deep" / "there" / "results.json").is_file()
    assert not (project / "output").exists()


def test_without_report_there_is_none(project):
    assert run(project) == 0
    assert not list((project / "output").glob("report.*"))


def test_check_leaves_earlier_results(project):
    assert run(project) == 0
    before = contents(project / "output")
    assert main(["check", str(project)]) == 0
    assert before.items() <= contents(project / "output").items()


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
    assert run(project, "--fresh") == 2
    assert "No space left on device" in capsys.readouterr().err
    assert contents(project) == before
    assert sorted(path.name for path in project.iterdir()) == [
        "geometry.dxf",
        "output",
        "project.toml",
    ]


def test_a_file_that_is_open_elsewhere_is_told_by_name_and_all_else_is_kept(project, capsys, monkeypatch):
    """On Windows: the earlier results stay as they are, analyses are kept, and the next run writes them."""
    assert run(project) == 0
    edit(project, "increment_m = 0.2", "increment_m = 0.1")
    before, replace = contents(project / "output"), Path.replace

    def held(path: Path, target: Path) -> Path:
        if path.name == "blocks.csv" and path.parent.parent.name == "output":
            raise PermissionError(32, "used by another process", str(path))
        return replace(path, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", held)
        assert run(project) == 2
    path = project / "output" / "tables" / "blocks.csv"
    said = capsys.readouterr().err
    assert said.startswith(
        f"error: {path}: cannot be replaced (used by another process); close it where it is open"
    )
    assert said.count("\n") == 1
    assert contents(project / "output") == before
    assert run(project, "--json") == 0
    assert json.loads(capsys.readouterr().out)["analyses"]["computed"] == 0


def test_a_full_disk_names_the_file_in_its_place(project, capsys, monkeypatch):
    """Not the one beside it under which it is written first."""
    assert run(project) == 0
    before, write = contents(project), Path.write_bytes

    def full(path: Path, content: bytes) -> int:
        if "blocks.csv" in path.name:
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    assert run(project, "--fresh", "--jobs", "1") == 2
    place = project / "output" / "tables" / "blocks.csv"
    assert capsys.readouterr().err.startswith(f"error: {place}: No space left on device")
    assert contents(project) == before


@pytest.mark.parametrize("jobs", ["0", "-1", "x", "1.5", ""])
def test_a_number_of_processes_is_one_or_more(project, capsys, jobs):
    with pytest.raises(SystemExit) as left:
        run(project, "--jobs", jobs)
    assert left.value.code == 2
    assert "is no number of processes; write 1 or more, or leave it out" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["run"], ["check"], ["report"]])
def test_a_name_of_a_folder_is_not_empty(project, capsys, command, monkeypatch):
    """It would be the folder the command is given in."""
    monkeypatch.chdir(project)
    for arguments in ([*command, ""], [*command, str(project), "--out", ""]):
        with pytest.raises(SystemExit) as left:
            main(arguments)
        assert left.value.code == 2
        assert "is empty; give the name of a folder" in capsys.readouterr().err


def test_a_stale_figure_goes_and_a_stranger_stays(project):
    assert run(project) == 0
    (project / "output" / "figures" / "pushover_of_yesterday.svg").write_text("old", encoding="utf-8")
    (project / "output" / "notes.txt").write_text("mine", encoding="utf-8")
    assert run(project) == 0
    assert [path.name for path in (project / "output" / "figures").iterdir()] == ["model.svg"]
    assert (project / "output" / "notes.txt").read_text(encoding="utf-8") == "mine"


def test_files_that_are_not_ours_stay(project, tmp_path):
    out = tmp_path / "docs"
    for name in ("tables/mine.txt", "tables/mine.csv", "figures/sub/mine.svg", "report.pdf"):
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text("mine", encoding="utf-8")
    assert run(project, "--out", str(out)) == 0
    for name in ("tables/mine.txt", "tables/mine.csv", "figures/sub/mine.svg", "report.pdf"):
        assert (out / name).read_text(encoding="utf-8") == "mine"


def test_what_is_no_number_is_null():
    """Lists of nothing but finite floats are left as they are; all else is looked through."""
    finite = [0.5, -1e300]
    results = {"a": finite, "b": (1, np.float64(0.5), np.inf), "c": [[0.5, np.nan], [np.int64(2), None, "x"]]}
    clean = plain(results)
    assert clean == {"a": [0.5, -1e300], "b": [1, 0.5, None], "c": [[0.5, None], [2, None, "x"]]}
    assert type(clean["c"][1][0]) is int and type(clean["b"][1]) is float
    assert clean["a"] is finite


def test_a_judgement_that_is_written_while_the_report_is_made_is_kept(project, monkeypatch):
    assert run(project) == 0
    opinion, make = project / "output" / "judgement.md", output._make

    def made(*arguments):
        warnings = make(*arguments)
        opinion.write_text("Sound.\n", encoding="utf-8")
        return warnings

    monkeypatch.setattr(output, "_make", made)
    assert run(project, "--fresh") == 0
    assert opinion.read_text(encoding="utf-8") == "Sound.\n"
    assert "print it again" in output.recall(project / "output").warnings[-1]
