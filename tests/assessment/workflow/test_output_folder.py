"""What is left on the disk: each file whole or not at all; what was completed where analyses cannot be."""

import importlib
import json
import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

import mechanics
from assessment.analyses import capacity
from assessment.cli.main import main
from assessment.ntc.capacity_curve import CapacityError
from assessment.project.catalogue.new_project import write_drawing
from assessment.results.schema.dynamic import Course
from assessment.workflow import run as output
from assessment.workflow import stages as workflow
from mechanics import ConvergenceError, pushover
from mechanics.messages import message
from mechanics.procedures.push_path import PushoverTolerances
from tests.support.block_project import ASSESSMENT, PROJECT, TURNED, contents, edit, read_results, run
from tests.support.structures import rectangle

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


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_what_is_no_number_is_no_result(number):
    with pytest.raises(ValidationError, match="finite number"):
        Course(time_s=[0.0, 1.0], displacement_m=[0.0, number])


def test_a_structure_that_cannot_stand(project, capsys):
    _overhang(project)
    assert run(project) == 3
    found = read_results(project / "output")
    assert found["model"]["self_weight_stable"] is False
    assert "own weight" in found["quality"]["warnings"][0]
    assert all(state["pushover"] == {} for state in found["states"].values())
    assert "own weight: NO" in capsys.readouterr().out
    assert main(["check", str(project)]) == 0
    assert "own weight: NO" in capsys.readouterr().out


def _overhang(project: Path) -> None:
    """A block whose centroid is beyond the edge of its base."""
    base, block = rectangle(-2.0, -1.0, 0.0, 0.0), rectangle(-0.3, 0.0, 0.9, 4.2)
    write_drawing(project / "geometry.dxf", {"BASE": [np.array(base)], "BLOCKS": [np.array(block)]})


def test_a_settlement_beyond_collapse_keeps_what_was_completed(project, capsys):
    edit(project, "rotation_rad = -0.02", "rotation_rad = -0.3")
    assert run(project) == 3
    found = read_results(project / "output")
    settled = found["states"]["base turned"]
    assert found["states"]["original"]["pushover"]["+x"]["rigid"]["alpha_0"] == pytest.approx(1 / 7, rel=1e-3)
    assert len(settled["pushdown"]["rigid"]["movement_m"]) > 5
    assert (
        settled["pushdown"]["rigid"]["ultimate_movement_m"] == settled["pushdown"]["rigid"]["movement_m"][-1]
    )
    assert settled["pushover"] == {}
    assert any("collapses at a movement of" in text for text in found["quality"]["warnings"])
    assert "collapses" in capsys.readouterr().out


def test_an_analysis_that_does_not_converge_is_reported_as_such(project, monkeypatch):
    def fail(*_: object, **__: object) -> None:
        raise ConvergenceError("equilibrium exists, but no solver found it")

    monkeypatch.setattr(mechanics, "pushover", fail)
    assert run(project, "--jobs", "1") == 3
    found = read_results(project / "output")
    assert any("no solver found it" in text for text in found["quality"]["warnings"])
    assert found["states"]["base turned"]["pushdown"]["rigid"]["movement_m"]


def test_a_path_cut_short_has_no_capacity(project, monkeypatch):
    few = PushoverTolerances(points=3)
    monkeypatch.setattr(mechanics, "pushover", partial(pushover, tolerances=few))
    (project / "project.toml").write_text(PROJECT + ASSESSMENT, encoding="utf-8")
    run(project)
    results = read_results(project / "output")
    found = results["states"]["original"]
    assert found["pushover"]["+x"]["rigid"]["d_0_m"] is None
    assert found["capacity"]["+x"]["SLV"]["verified"] is None
    assert any(
        text.startswith("original, pushover +x, rigid contacts: ends at d = ")
        and text.endswith(": a curve has 3 points at most; write a larger increment_m")
        for text in results["quality"]["warnings"]
    )


def test_a_direction_without_capacity_is_incomplete_and_its_state_has_no_index(project, monkeypatch, capsys):
    """A state was given the ζ_E of its other direction, and the run the exit code of a complete one."""
    push = 'directions = ["+x", "-x"]\ncontrol = {"+x" = "right", "-x" = "left"}'
    text = (PROJECT + ASSESSMENT).replace('directions = ["+x"]', push)
    (project / "project.toml").write_text(text, encoding="utf-8")
    assert run(project, "--jobs", "1") == 0
    complete = read_results(project / "output")["states"]["original"]
    assert complete["indices"]

    def refuse(rigid, gamma_star, direction):
        if direction == "-x":
            raise CapacityError(message("α = 0"))
        return way(rigid, gamma_star, direction)

    way = capacity.way_of_blocks
    monkeypatch.setattr(capacity, "way_of_blocks", refuse)
    capsys.readouterr()
    assert run(project, "--jobs", "1", "--fresh", "--json") == 3
    assert json.loads(capsys.readouterr().out)["complete"] is False
    for state in read_results(project / "output")["states"].values():
        assert list(state["pushover"]) == ["+x", "-x"] and list(state["capacity"]) == ["+x"]
        assert state["indices"] is None


def test_what_a_path_had_reached_is_kept_where_no_solver_goes_on(project, monkeypatch):
    procedure = importlib.import_module("mechanics.procedures.push_path")
    step, count = procedure.reach, iter(range(1000))

    def fails_later(*arguments):
        if next(count) >= 2:
            raise ConvergenceError("no answer")
        return step(*arguments)

    monkeypatch.setattr(procedure, "reach", fails_later)
    edit(project, TURNED, "")
    run(project)
    rigid = read_results(project / "output")["states"]["original"]["pushover"]["+x"]["rigid"]
    assert len(rigid["curve"]["multiplier"]) == 3
    assert rigid["d_0_m"] is None
