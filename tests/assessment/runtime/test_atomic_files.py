"""Temporary files of processes that were killed go; those of processes at work stay, and so does everything else."""

from __future__ import annotations

import os

from assessment.cli.main import main
from assessment.runtime.files import LONGEST, clear_left_over, temporary_of
from tests.support.block_project import run, write_block


def age(path, seconds):
    written = path.stat().st_mtime - seconds
    os.utime(path, (written, written))


def test_what_a_killed_process_left_goes(tmp_path):
    others = [".a.tmp", "a.1.tmp", ".a.b.tmp", ".a.svg.3.tmp"]
    for name in (".a.svg.2.tmp", ".project.xlsx.2.tmp", *others):
        (tmp_path / name).touch()
        age(tmp_path / name, 2.0 * LONGEST if name != others[-1] else 0.5 * LONGEST)
    clear_left_over(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*others}


def test_commands_remove_what_killed_ones_have_left(tmp_path):
    """In an output folder, which is locked, all that is a second old."""
    project = write_block(tmp_path / "block")
    output = project / "output"
    output.mkdir()
    left = {project / ".project.xlsx.2.tmp": 2.0 * LONGEST, output / ".model.svg.2.tmp": 2.0}
    for path, seconds in left.items():
        path.touch()
        age(path, seconds)
    assert run(project) == 0
    assert not any(path.exists() for path in left)
    half = tmp_path / ".wall.2.tmp"
    (half / "records").mkdir(parents=True)
    age(half, 2.0 * LONGEST)
    assert main(["new", str(tmp_path / "wall"), "--template", "wall"]) == 0
    assert not half.exists() and not temporary_of(tmp_path / "wall").exists()
