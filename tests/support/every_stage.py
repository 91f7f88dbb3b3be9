"""The block with every stage, in two states: what tests of resumption and of the terminal run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from assessment.runtime.cache import FOLDER
from tests.support.block_project import ASSESSMENT, PROJECT, run, write_block

DYNAMICS = """[[history]]
record = "wave.csv"
contacts = "rigid"
[incremental]
records = ["wave*.csv"]
contacts = "rigid"
tolerance_g = 0.2
max_scale = 2.0
"""
REPORT = """[report]
language = "it"
"""
# self-weight, a pushdown, two pushovers with their second solver, four histories, two scans in two rounds each
ALL = 14


def write_every_stage(folder: Path) -> Path:
    """Write drawing, record and project file."""
    write_wave(write_block(folder, PROJECT + DYNAMICS + ASSESSMENT + REPORT) / "wave.csv", 0.1)
    return folder


def write_wave(path: Path, peak: float) -> None:
    """Write a record of that peak, g."""
    time_s = 0.02 * np.arange(40)
    np.savetxt(path, np.column_stack([time_s, peak * np.sin(6.0 * time_s)]), delimiter=",", fmt="%.8f")


def assesto(folder: Path, *options: str) -> int:
    """Run the project without its report and tell of it in JSON; return the exit code."""
    return run(folder, "--json", *options)


def counts(folder: Path, capsys, *options: str) -> tuple[int, int]:
    """Run and return how many analyses were computed and taken over."""
    capsys.readouterr()
    assert assesto(folder, *options) == 0
    found = json.loads(capsys.readouterr().out)["analyses"]
    return found["computed"], found["taken_over"]


def entries(folder: Path) -> list[Path]:
    """The analyses kept."""
    return sorted((folder / "output" / FOLDER).iterdir())
