"""One run at a time in an output folder: the second is refused, and told by which process."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from assessment.runtime.journal import LOCK, BusyError, locked
from tests.support.block_project import ROOT, run

HOLD = """
import sys, pathlib, assessment.runtime.journal as lock
with lock.locked(pathlib.Path(sys.argv[1])):
    input(print('held'))
"""


def test_a_second_run_is_refused_and_told_by_which_process(project, capsys):
    with locked(project / "output"):
        assert run(project) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {project / 'output' / LOCK}: another run is writing into this folder")
    assert f"(process {os.getpid()} on " in said
    assert said.count("\n") == 1
    assert not (project / "output").exists()


def test_a_killed_run_holds_nothing(tmp_path):
    held = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert held.stdout is not None
    assert held.stdout.readline() == b"held\n"
    with pytest.raises(BusyError, match=f"process {held.pid} on "), locked(tmp_path):
        pass
    held.kill()
    held.communicate()
    assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()


def test_who_waits_for_a_lock_that_is_removed_meanwhile_gets_one_that_others_see(tmp_path):
    """The run before removes its file: who has opened it just before would hold a lock that nobody else sees."""
    with locked(tmp_path):
        (tmp_path / LOCK).unlink()
        (tmp_path / LOCK).touch()  # as of another run, which begins
        with locked(tmp_path), pytest.raises(BusyError), locked(tmp_path):
            pass
