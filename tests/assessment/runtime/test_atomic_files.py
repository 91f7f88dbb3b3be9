"""Temporary files of processes that were killed go; those of processes at work stay, and so does everything else."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from assessment.cli.main import main
from assessment.runtime.files import LONGEST, clear_left_over, temporary_of, write_atomically
from tests.support.block_project import run, write_block

POSIX = pytest.mark.skipif(os.name != "posix", reason="a process can only be asked for where signals are")


@pytest.fixture
def dead():
    """The number of a process that is gone."""
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    return done.pid


def test_what_a_killed_process_left_goes(tmp_path, dead):
    old = tmp_path / f".a.svg.{os.getpid()}.tmp"
    others = [".a.tmp", "a.1.tmp", ".a.b.tmp", f".a.svg.{os.getppid()}.tmp"]
    left = [f".a.svg.{dead}.tmp", f".project.xlsx.{dead}.tmp"] if os.name == "posix" else []
    for name in (old.name, *left, *others):
        (tmp_path / name).touch()
    long_ago = old.stat().st_mtime - 2.0 * LONGEST
    os.utime(old, (long_ago, long_ago))
    clear_left_over(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*others}


def test_a_failed_write_leaves_nothing(tmp_path):
    (tmp_path / "a").mkdir()
    with pytest.raises(OSError, match="a'"):
        write_atomically(tmp_path / "a", b"x")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@POSIX
def test_commands_remove_what_killed_ones_have_left(tmp_path, dead):
    project = write_block(tmp_path / "block")
    output = project / "output"
    output.mkdir()
    left = [project / f".project.xlsx.{dead}.tmp", output / f".model.svg.{dead}.tmp"]
    for path in left:
        path.touch()
    assert run(project) == 0
    assert not any(path.exists() for path in left)
    half = tmp_path / f".wall.{dead}.tmp"
    (half / "records").mkdir(parents=True)
    assert main(["new", str(tmp_path / "wall"), "--template", "wall"]) == 0
    assert not half.exists() and not temporary_of(tmp_path / "wall").exists()


@POSIX
def test_a_working_directory_that_is_gone_is_told(tmp_path, monkeypatch, capsys):
    """The message was "error: None"."""
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    for arguments in (["check", "block"], ["new", "block", "--template", "wall"], ["status", "block"]):
        assert main(arguments) == 2
        said = capsys.readouterr().err
        assert said == "error: the folder that the command is given in is gone; change to another one (cd)\n"
