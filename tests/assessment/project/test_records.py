"""The record files of a project: what `assesto check` prints of each, and what is doubted."""

import numpy as np
import pytest

from assessment.cli.main import main
from assessment.project.project import load_project
from assessment.workflow.checking import read_motions
from tests.support.block_project import PROJECT, write_block

TIME = 0.005 * np.arange(5001)
WAVE = np.cos(2.0 * np.pi * TIME) * np.exp(-((TIME - 10.0) ** 2))  # of unit peak

HISTORY = """
[[history]]
record = "wave.csv"
scale = 2.0
contacts = "rigid"
window_s = [5.0, 15.0]
"""


def _block(folder, *tables, heading="time [s],acceleration [m/s²]", size=3.2067):
    write_block(folder, PROJECT[: PROJECT.index("[pushover]")] + "".join(tables))
    rows = "\n".join(f"{t:.3f},{a:.6f}" for t, a in zip(TIME, size * WAVE, strict=True))
    (folder / "wave.csv").write_text(f"{heading}\n{rows}\n", encoding="utf-8")
    return folder


def test_check_prints_a_line_for_every_record(tmp_path, capsys):
    """PGA and duration are those of the file: neither scaled nor cut; a file that is named twice has one line."""
    incremental = '[incremental]\nrecords = ["*.csv"]\ncontacts = "rigid"\n'
    folder = _block(
        tmp_path / "block", HISTORY, 'time_step_s = 0.005\nvertical_record = "up.csv"\n', incremental
    )
    (folder / "up.csv").write_text(
        "t,a\n" + "\n".join(f"{0.01 * k:.2f},{0.1 * (k % 3)}" for k in range(2501)), encoding="utf-8"
    )
    assert main(["check", str(folder)]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("record ")]
    assert lines == [
        "record wave: PGA 0.327 g, step 0.005 s, 25.0 s, unit m/s²",
        "record up: PGA 0.2 g, step 0.01 s, 25.0 s, unit g",
    ]


@pytest.mark.parametrize(
    ("heading", "said"),
    [
        ("time [s],velocity [cm/s]", "names time and velocity; give accelerations"),
        (
            "time [s],acc [kg]",
            "'kg' in the heading 'acc [kg]' is no unit that is known; known are g, % g, mg, gal",
        ),
        ("O.000,0.5", "line 1: 'O.000,0.5' holds the number '0.5' and is no line of numbers"),
    ],
)
def test_a_record_that_is_not_understood_is_refused_by_name(tmp_path, capsys, heading, said):
    folder = _block(tmp_path / "block", HISTORY, heading=heading)
    assert main(["check", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {folder / 'wave.csv'}: line 1: ") and said in error


def test_a_record_too_strong_for_its_unit_is_doubted(tmp_path):
    """Accelerations in m/s² without a heading pass for g: 3.2 m/s² are a PGA of 3.2 g, which no record has."""
    folder = _block(tmp_path / "block", HISTORY, heading="t,a")
    [note] = [note for note in read_motions(load_project(folder)).notes if "unit" in note]
    assert note == "wave: a PGA of 3.21 g, read in g; check the unit of the file, and name it in its heading"
    folder = _block(tmp_path / "other", HISTORY)
    assert not any("unit" in note for note in read_motions(load_project(folder)).notes)
