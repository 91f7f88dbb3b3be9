"""Temporary files of processes that were killed go; those of processes at work stay, and so does everything else."""

from __future__ import annotations

import os

from assessment.runtime.files import LONGEST, clear_left_over


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
