"""The block with every stage, in two states: what tests of resumption and of the terminal run."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from assessment.runtime.cache import FOLDER
from assessment.runtime.progress import Stage, read_journal
from tests.support.block_project import ASSESSMENT, PROJECT, run, write_block

DYNAMICS = """[[history]]
record = "wave.csv"
contacts = "rigid"
[incremental]
records = ["wave*.csv"]
contacts = "rigid"
tolerance_g = 0.2
max_scale = 1.2
"""
REPORT = """[report]
language = "it"
"""
WRITING = {"figures and tables", "report"}  # stages that hold no analysis


def write_every_stage(folder: Path) -> Path:
    """Write drawing, record and project file."""
    write_wave(
        write_block(folder, "scatter = 1\n" + PROJECT + DYNAMICS + ASSESSMENT + REPORT) / "wave.csv", 0.1
    )
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


def planned(folder: Path) -> dict[str, int]:
    """Return how many analyses each stage of the last run has, by its own account, in the order of the stages."""
    return _by_stage(folder, lambda stage: stage.total)


def computed(folder: Path) -> dict[str, int]:
    """Return how many of them it computed itself."""
    return _by_stage(folder, lambda stage: stage.done)


def _by_stage(folder: Path, count: Callable[[Stage], int]) -> dict[str, int]:
    found: dict[str, int] = {}
    for stage in read_journal(folder / "output").stages:
        if stage.name not in WRITING:
            found[stage.name] = found.get(stage.name, 0) + count(stage)
    return found


def entries(folder: Path) -> list[Path]:
    """The analyses kept."""
    return sorted((folder / "output" / FOLDER).iterdir())
