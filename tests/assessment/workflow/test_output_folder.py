"""What is left on the disk: each file whole or not at all, and nobody else's touched."""

from __future__ import annotations

import os

import numpy as np
import pytest

from assessment.cli.main import main
from assessment.results.schema.part import plain
from assessment.workflow import run as output
from assessment.workflow import stages as workflow
from tests.support.block_project import contents, run

pytestmark = pytest.mark.usefixtures("quick")


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


def test_a_disk_that_refuses_leaves_the_earlier_result(project, capsys, monkeypatch):
    assert run(project) == 0
    before = contents(project)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", str(project / "output"))

    monkeypatch.setattr(output.disk, "write_atomically", full)
    assert run(project, "--fresh") == 2
    assert "No space left on device" in capsys.readouterr().err
    assert contents(project) == before
    assert sorted(path.name for path in project.iterdir()) == ["geometry.dxf", "output", "project.toml"]


@pytest.mark.parametrize("jobs", ["0", "x", "1.5"])
def test_a_number_of_processes_is_one_or_more(project, capsys, jobs):
    with pytest.raises(SystemExit) as left:
        run(project, "--jobs", jobs)
    assert left.value.code == 2
    assert "is no number of processes; write 1 or more, or leave it out" in capsys.readouterr().err


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
