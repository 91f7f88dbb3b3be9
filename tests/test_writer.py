"""What is written by a process that got ready beforehand: the same files, errors come through, nothing is left."""

import multiprocessing
import os
import tempfile
import time
from pathlib import Path

import pytest

from assessment import output
from assessment.writer import Writer


@pytest.mark.parametrize("jobs", [1, 2])
def test_warnings_come_back_from_the_process_that_writes(jobs, tmp_path, monkeypatch):
    monkeypatch.setattr(output, "write", lambda *given: [*map(str, given), str(os.getpid())])
    with Writer(report=False, jobs=jobs) as writer:
        *given, process = writer.write({"title": "Arch"}, tmp_path)
    assert given == ["{'title': 'Arch'}", str(tmp_path), "False", str(jobs)]
    assert (process == str(os.getpid())) == (jobs == 1)
    assert not multiprocessing.active_children()


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_folder_that_refuses_is_named(jobs, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError) as refused, Writer(report=False, jobs=jobs) as writer:
        writer.write({}, tmp_path / "file")
    assert refused.value.filename == str(tmp_path / "file")
    assert not multiprocessing.active_children()


def test_a_run_that_fails_before_anything_is_written_waits_for_nobody(tmp_path, monkeypatch):
    monkeypatch.setattr(output, "prepare", lambda _: time.sleep(3600))
    with pytest.raises(ZeroDivisionError), Writer(report=False, jobs=2):
        raise ZeroDivisionError
    assert not multiprocessing.active_children()


def test_an_interruption_while_files_are_written_leaves_none_half_made(tmp_path, monkeypatch):
    def endless(_, folder: Path, *__):
        with tempfile.TemporaryDirectory(dir=folder):
            time.sleep(3600)

    def interrupted(*_):
        while not list(tmp_path.iterdir()):
            time.sleep(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(output, "write", endless)
    monkeypatch.setattr("concurrent.futures.Future.result", interrupted)
    with pytest.raises(KeyboardInterrupt), Writer(report=False, jobs=2) as writer:
        writer.write({}, tmp_path)
    assert not multiprocessing.active_children()
    assert not list(tmp_path.iterdir())
