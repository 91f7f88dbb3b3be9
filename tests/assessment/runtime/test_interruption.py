"""Runs that are interrupted or killed: nothing of an earlier result is lost, and what is finished is kept.

What would not end is ended by pytest's faulthandler_timeout, long before the hour that endless work takes here.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import pytest

from assessment.analyses.static import states
from assessment.cli.main import main
from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.report.figures import index as figures
from assessment.results.plain import plain
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.files.journal import NAME as JOURNAL
from assessment.workflow.stages import run
from tests import ROOT
from tests.support.block_project import command, contents, edit, read_results, timeless
from tests.support.every_stage import ALL, assesto, counts, entries, write_every_stage

pytestmark = pytest.mark.usefixtures("no_figures")
IMAGES = figures.write_images


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


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the child has what was put into the program here")
@pytest.mark.parametrize("finished", range(ALL + 1))
def test_a_run_killed_at_any_boundary_goes_on_from_there(project, capsys, whole, finished):
    """SIGKILL as soon as some analyses are kept, in a process of its own; after the last, before files are written."""
    child = os.fork()
    if child == 0:
        _die_after(finished)
        assesto(project)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert not (project / "output" / "results.json").exists()
    assert counts(project, capsys) == (ALL - finished, finished)
    assert timeless(read_results(project / "output"))["states"] == whole


def _die_after(finished: int) -> None:
    keep, find = Store.keep, Store.find
    left = [finished]

    def counted(store, key, text):
        keep(store, key, text)
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    def none_left(store, key):
        if finished == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return find(store, key)

    Store.keep, Store.find = counted, none_left


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
    assert f"taken over from earlier runs: 3 of {ALL} analyses, inputs unchanged" in out


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("sent", ["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"])
def test_no_process_is_left_behind(project, sent):
    """A signal to the parent alone while two others work on something endless."""
    code = (
        "import os, signal, sys, time\n"
        "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"  # under nohup the tests hand on that it is ignored
        "from assessment.analyses.static import states\n"
        "from assessment.cli.main import main\n"
        "def endless(*_):\n"
        "    os.write(1, b'begun\\n')\n"
        "    time.sleep(3600)\n"
        "states.push = endless\n"
        "sys.exit(main())"
    )
    edit(project, '["+x"]', '["+x", "-x"]')
    started = subprocess.Popen(
        [sys.executable, "-c", code, "run", str(project), "--no-report", "--jobs", "2"],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        assert started.stdout is not None
        assert [started.stdout.readline() for _ in range(2)] == ["begun\n", "begun\n"]
        started.send_signal(getattr(signal, sent))
        _, err = started.communicate()  # ends where no process holds its pipes any more
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(started.pid, signal.SIGKILL)
    assert started.returncode == (-signal.SIGKILL if sent == "SIGKILL" else 3)
    assert "Traceback" not in err
    assert len(entries(project)) == 2  # self-weight and the pushdown


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
    before = contents(project / "output")
    edit(project, "increment_m = 0.2", "increment_m = 0.1")  # two pushovers to compute
    capsys.readouterr()
    with monkeypatch.context() as patch:
        patch.setattr(figures, "write_figures", as_good_as_empty)
        patch.setattr(figures, "write_images", IMAGES)  # the report asks for them
        killed = (
            "assessment.analyses.static.states.push"
            if what == "pushover"
            else "assessment.report.document.write_pdf"
        )
        patch.setattr(killed, ended_from_outside)
        assert main(["run", str(project), "--jobs", "2"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: pushover: " if what == "pushover" else "error: figures, judgement, report")
    assert "a process of the run was ended from outside" in err
    assert "finished analyses are kept: run again to go on" in err
    assert err.count("\n") == 1
    assert contents(project / "output") == before
    assert not multiprocessing.active_children()
    assert counts(project, capsys) == ((2, ALL - 2) if what == "pushover" else (0, ALL))


def test_memory_that_runs_out_is_told(project, capsys, monkeypatch):
    def too_large(*_):
        raise MemoryError

    monkeypatch.setattr(states, "push", too_large)
    assert assesto(project) == 3
    assert capsys.readouterr().err.startswith(
        "error: memory ran out; nothing of an earlier result was changed"
    )


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals")
def test_nohup_keeps_a_run_alive():
    code = (
        "import os, signal, time\n"
        "from assessment.runtime.processes.interruption import watch\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "watch('ended', 3)\n"
        "os.kill(os.getpid(), signal.SIGHUP)\n"
        "print('alive')\n"
        "os.kill(os.getpid(), signal.SIGTERM)\n"
    )
    done = command(code=code)
    assert done.stdout == "alive\n"
    assert "KeyboardInterrupt" in done.stderr, "what a command makes its message of"


SWALLOWED = (
    "    while True:\n        with contextlib.suppress(KeyboardInterrupt):\n            time.sleep(3600)\n"
)
RENAMED = (
    "    try:\n        time.sleep(3600)\n    except KeyboardInterrupt:\n        raise {}\n"  # as numba does
)


@pytest.mark.parametrize("deaf", [SWALLOWED, *map(RENAMED.format, ("SystemError", "ValueError", "OSError"))])
def test_an_interruption_that_a_library_swallows_ends_the_run_all_the_same(project, deaf):
    code = (
        "import contextlib, os, sys, time\n"
        "from assessment.analyses.static import lateral\n"
        "from assessment.cli.main import main\n"
        "def deaf(*_, **__):\n"
        "    os.write(1, b'begun\\n')\n"
        f"{deaf}"
        "lateral.pushover = deaf\n"
        "main()"
    )
    started = subprocess.Popen(
        [sys.executable, "-c", code, "run", str(project), "--no-report"],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert started.stdout is not None
        assert started.stdout.readline() == "begun\n"
        started.send_signal(signal.SIGINT)
        _, err = started.communicate()
    finally:
        started.kill()
    assert started.returncode == 3
    assert err == (
        "interrupted: nothing of an earlier result was changed; finished analyses are kept: run again to go on\n"
    )
    assert len(entries(project)) == 2  # self-weight and the pushdown


def test_a_killed_run_leaves_the_earlier_result(project):
    """SIGKILL wherever it strikes: during the analyses and while files are written."""
    assert assesto(project) == 0
    before = contents(project / "output")
    edit(project, "increment_m = 0.2", "increment_m = 0.1")
    # the process kills itself after its first figure: that is written, results.json is not
    code = (
        "import os, signal, sys, assessment.report.figures.index as figures\n"
        "from assessment.cli.main import main\n"
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
    assert seen == {"geometry.dxf", "project.toml", "wave.csv", "output"}
    assert assesto(project) == 0
    after = contents(project / "output")
    assert after != before
    assert not any(name.startswith(".assesto-") for name in after)
