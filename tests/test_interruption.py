"""Runs that are interrupted or killed: nothing of an earlier result is lost, and what is finished is kept.

What would not end is ended by pytest's faulthandler_timeout, long before the hour that endless work takes here.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from assessment import figures
from assessment.cli import main
from assessment.store import FOLDER, Store
from tests.block_project import contents, edit, read_results, timeless
from tests.every_stage import ALL, assesto, counts, entries, write_every_stage

ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch):
    monkeypatch.setattr(figures, "write_figures", lambda _, folder: folder.mkdir())


@pytest.fixture
def project(tmp_path):
    return write_every_stage(tmp_path / "block")


@pytest.mark.parametrize("finished", range(ALL + 1))
def test_a_run_killed_at_any_boundary_goes_on_from_there(project, capsys, finished):
    """SIGKILL as soon as some analyses are kept, in a process of its own; after the last, before files are written."""
    assert counts(project, capsys, "--out", str(project / "whole")) == (ALL, 0)
    child = os.fork()
    if child == 0:
        _die_after(finished)
        assesto(project)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert not (project / "output" / "results.json").exists()
    assert counts(project, capsys) == (ALL - finished, finished)
    assert timeless(read_results(project / "output")) == timeless(read_results(project / "whole"))


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
    assert [path.name for path in (project / "output").iterdir()] == [FOLDER]
    monkeypatch.setattr(Store, "keep", keep)
    assert main(["run", str(project), "--no-report"]) == 0
    out = capsys.readouterr().out
    assert f"taken over from earlier runs: 3 of {ALL} analyses, inputs unchanged" in out


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_no_process_is_left_behind(project, sent):
    """An interruption, or a kill, of the parent alone while two others work on something endless."""
    code = (
        "import os, sys, time\n"
        "from assessment import states\n"
        "from assessment.cli import main\n"
        "def endless(*_):\n"
        "    os.write(1, b'begun\\n')\n"
        "    time.sleep(3600)\n"
        "states.push = endless\n"
        "sys.exit(main(['run', sys.argv[1], '--no-report', '--jobs', '2']))"
    )
    edit(project, '["+x"]', '["+x", "-x"]')
    started = subprocess.Popen(
        [sys.executable, "-c", code, str(project)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        assert started.stdout is not None
        assert [started.stdout.readline() for _ in range(2)] == ["begun\n", "begun\n"]
        started.send_signal(sent)
        _, err = started.communicate()  # ends where no process holds its pipes any more
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(started.pid, signal.SIGKILL)
    assert started.returncode == (3 if sent == signal.SIGINT else -signal.SIGKILL)
    assert "Traceback" not in err
    assert len(entries(project)) == 2  # self-weight and the pushdown


def test_an_interruption_that_a_library_swallows_ends_the_run_all_the_same(project):
    code = (
        "import contextlib, os, sys, time\n"
        "from assessment import stages\n"
        "from assessment.cli import main\n"
        "def deaf(*_):\n"
        "    os.write(1, b'begun\\n')\n"
        "    while True:\n"
        "        with contextlib.suppress(KeyboardInterrupt):\n"
        "            time.sleep(3600)\n"
        "stages.pushover = deaf\n"
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
    assert seen == {"geometry.dxf", "project.toml", "wave.csv", "output"}
    assert assesto(project) == 0
    after = contents(project / "output")
    assert after != before
    assert not any(name.startswith(".assesto-") for name in after)
