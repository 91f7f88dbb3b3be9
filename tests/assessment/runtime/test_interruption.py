"""Runs that are interrupted or killed: nothing of an earlier result is lost, and what is finished is kept.

What would not end is ended by pytest's faulthandler_timeout, long before the hour that endless work takes here.
"""

import multiprocessing
import os
import signal
import time
from pathlib import Path

import pytest

import mechanics
from assessment.analyses import states
from assessment.cli.main import main
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.figures import index as figures
from assessment.results.schema.part import plain
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.progress import NAME as JOURNAL
from assessment.workflow.stages import run
from tests.support.block_project import contents, edit, read_results, timeless
from tests.support.every_stage import assesto, computed, counts, entries, planned, write_every_stage
from tests.support.forked import forked

pytestmark = pytest.mark.usefixtures("no_figures")
IMAGES = figures.write_images
FORKS = pytest.mark.skipif(not hasattr(os, "fork"), reason="the child has what was put into the program here")


@pytest.fixture
def project(tmp_path):
    return write_every_stage(tmp_path / "block")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """States of a run that nothing disturbs."""
    folder = write_every_stage(tmp_path_factory.mktemp("whole") / "block")
    return timeless(plain(run(load_project(folder), build_model(load_project(folder)), jobs=1).results))[
        "states"
    ]


@FORKS
def test_a_run_killed_after_every_analysis_goes_on_from_there(project, whole):
    """SIGKILL before the first, then as soon as one more is kept; last of all the record of what was written."""
    _killed("find", project)
    results, finished = project / "output" / "results.json", 0
    while not results.exists():
        _killed("keep", project)
        finished += 1
        assert len(entries(project)) == finished
    assert finished == sum(planned(project).values()) + 1
    assert not any(computed(project).values())
    assert timeless(read_results(project / "output"))["states"] == whole


def _killed(method: str, project: Path) -> None:
    """Run in a process that is killed once the store has found, or kept, an entry."""
    child = os.fork()
    if child == 0:
        act = getattr(Store, method)

        def last(*of):
            act(*of)
            os.kill(os.getpid(), signal.SIGKILL)

        setattr(Store, method, last)
        assesto(project)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


def test_an_interrupted_run_keeps_what_is_finished_and_says_so(project, capsys, monkeypatch):
    keep = Store.keep

    def interrupted(store, key, text):
        keep(store, key, text)
        if len(list(store.folder.iterdir())) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(Store, "keep", interrupted)
    assert assesto(project) == 3
    assert "run again to go on" in capsys.readouterr().err
    assert {path.name for path in (project / "output").iterdir()} == {FOLDER, JOURNAL}
    monkeypatch.setattr(Store, "keep", keep)
    assert main(["run", str(project), "--no-report"]) == 0
    out = capsys.readouterr().out
    every = sum(planned(project).values())
    assert f"taken over from earlier runs: 3 of {every} analyses, inputs unchanged" in out


@FORKS
@pytest.mark.parametrize("sent", ["SIGTERM", "SIGKILL"])
def test_no_process_is_left_behind(project, monkeypatch, sent):
    """A signal to the parent alone while two others work on something endless."""
    monkeypatch.setattr(states, "push", endless)
    edit(project, '["+x"]', '["+x", "-x"]')
    with forked("run", str(project), "--no-report", "--jobs", "2") as started:
        assert [started.out.readline() for _ in range(2)] == ["begun\n", "begun\n"]
        started.send(getattr(signal, sent))
        code, _, err = started.end()  # ends where no process holds its pipes any more
    assert code == (-signal.SIGKILL if sent == "SIGKILL" else 3)
    assert "Traceback" not in err
    assert len(entries(project)) == 2  # self-weight and the pushdown


def endless(*_):
    """In the place of an analysis."""
    os.write(1, b"begun\n")
    time.sleep(3600)


def ended_from_outside(*_):
    """In the place of an analysis or of what writes a file: what the system does where memory runs out."""
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(600)


def as_good_as_empty(pool, folder):
    """Every figure that the report asks for."""
    folder.mkdir()
    for picture in figures.pictures(pool.held):
        (folder / f"{picture.name}.svg").write_text("<svg/>", encoding="utf-8")


@pytest.mark.parametrize("what", ["pushover", "report"])
def test_a_killed_process_is_told_and_costs_nothing_that_is_finished(project, capsys, monkeypatch, what):
    assert assesto(project) == 0
    before, plan = contents(project / "output"), planned(project)
    edit(project, "increment_m = 0.2", "increment_m = 0.1")  # the pushovers are to be computed
    capsys.readouterr()
    with monkeypatch.context() as patch:
        patch.setattr(figures, "write_figures", as_good_as_empty)
        patch.setattr(figures, "write_images", IMAGES)  # the report asks for them
        killed = (
            "assessment.analyses.states.push"
            if what == "pushover"
            else "assessment.report.document.write_pdf"
        )
        patch.setattr(killed, ended_from_outside)
        assert main(["run", str(project), "--jobs", "2"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: pushover: " if what == "pushover" else "error: report: ")
    assert "a process of the run was ended from outside" in err
    assert "finished analyses are kept: run again to go on" in err
    assert err.count("\n") == 1
    assert contents(project / "output") == before
    assert not multiprocessing.active_children()
    assert counts(project, capsys)[1] >= sum(plan.values()) - plan["pushover"] - plan["second solver"]
    left = computed(project)
    left.pop("second solver")  # it begins where the largest multiplier is, which may have moved
    assert {stage for stage, number in left.items() if number} == ({"pushover"} & {what})


@FORKS
def test_an_interruption_that_a_library_swallows_ends_the_run_all_the_same(project, monkeypatch):
    """It makes another exception of it, as numba does."""

    def deaf(*_, **__):
        os.write(1, b"begun\n")
        while True:
            try:
                time.sleep(3600)
            except KeyboardInterrupt:
                raise SystemError from None

    monkeypatch.setattr(mechanics, "pushover", deaf)
    with forked("run", str(project), "--no-report") as started:
        assert started.out.readline() == "begun\n"
        started.send(signal.SIGINT)
        code, _, err = started.end()
    assert code == 3
    assert err == (
        "interrupted: nothing of an earlier result was changed; finished analyses are kept: run again to go on\n"
    )
    assert len(entries(project)) == 2  # self-weight and the pushdown
