"""One run at a time in an output folder: the second is refused, and told by which process."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from assessment.runtime.files import lock
from assessment.runtime.files.lock import NAME, BusyError, locked
from tests.support.block_project import ROOT, run

HOLD = """
import sys, pathlib, assessment.runtime.files.lock as lock
with lock.locked(pathlib.Path(sys.argv[1])):
    input(print('held'))
"""


def test_a_second_run_is_refused_and_told_by_which_process(project, capsys):
    with locked(project / "output"):
        assert run(project) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {project / 'output' / NAME}: another run is writing into this folder")
    assert f"(process {os.getpid()} on " in said
    assert said.count("\n") == 1
    assert not (project / "output").exists()


def test_the_report_waits_for_nobody_either(project, capsys):
    (project / "output").mkdir()
    (project / "output" / "results.json").write_text("{}", encoding="utf-8")
    with locked(project / "output"):
        from assessment.cli.main import main

        assert main(["report", str(project)]) == 2
    assert NAME in capsys.readouterr().err


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
    assert (tmp_path / NAME).exists()
    with locked(tmp_path):
        pass
    assert not (tmp_path / NAME).exists()


def test_a_folder_that_a_run_made_and_left_empty_goes_again(tmp_path):
    with locked(tmp_path / "a" / "b"):
        assert (tmp_path / "a" / "b" / NAME).exists()
    assert not (tmp_path / "a" / "b").exists()
    with locked(tmp_path / "c"):
        (tmp_path / "c" / "result").touch()
    assert [path.name for path in (tmp_path / "c").iterdir()] == ["result"]


def test_a_lock_on_a_file_that_was_removed_meanwhile_is_none(tmp_path, monkeypatch):
    """The run before removes its file: who has opened it just before would hold a lock that nobody else sees."""
    claim, gone = lock._lock, []

    def removed_meanwhile(descriptor):
        if not gone:
            gone.append((tmp_path / NAME).unlink())
        return claim(descriptor)

    monkeypatch.setattr(lock, "_lock", removed_meanwhile)
    with locked(tmp_path), pytest.raises(BusyError), locked(tmp_path):
        pass


def test_a_file_system_without_locks_has_none(tmp_path, monkeypatch):
    def unknown(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(lock, "fcntl", SimpleNamespace(flock=unknown, LOCK_EX=2, LOCK_NB=4))
    with locked(tmp_path), locked(tmp_path):
        pass


def test_on_windows_a_byte_is_locked_that_leaves_the_holder_readable(tmp_path, monkeypatch):
    taken = []

    def locking(descriptor, mode, count):
        place = os.lseek(descriptor, 0, os.SEEK_CUR)
        assert (mode, count, place > 1000) == (2, 1, True)
        if taken:
            raise PermissionError(errno.EACCES, "Permission denied")
        taken.append(descriptor)

    monkeypatch.setattr(lock, "fcntl", None)
    monkeypatch.setattr(lock, "msvcrt", SimpleNamespace(locking=locking, LK_NBLCK=2), raising=False)
    with locked(tmp_path), pytest.raises(BusyError, match=f"process {os.getpid()} "), locked(tmp_path):
        pass
