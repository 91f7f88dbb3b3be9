"""A drawing that is no assembly gets its picture all the same, with the number of every fault that has a place."""

from __future__ import annotations

import re

from assessment.cli.main import main
from tests.support.dxf import drawing, outline

PROJECT = """title = "Wall"
[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0
[material]
unit_weight_kN_m3 = 18.0
[layers.BASE]
support = "base"
"""


def rectangle(x0, z0, x1, z1):
    return [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]


def checked(folder, capsys, document, text=PROJECT):
    """The lines that a check of a drawing says, and the picture."""
    document.saveas(folder / "geometry.dxf")
    (folder / "project.toml").write_text(text, encoding="utf-8")
    assert main(["check", str(folder)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    return err.splitlines(), (folder / "output" / "model.svg").read_text(encoding="utf-8")


def numbers(picture: str) -> set[str]:
    """The numbers that stand in a picture."""
    return set(re.findall(r"<text[^>]*>(\d+)</text>", picture))


def test_every_fault_is_listed_once_and_marked(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 9, 0), "BASE")
    for k in range(8):
        outline(space, rectangle(k, 0, k + 1, 1))
    outline(space, rectangle(-3, -3, 12, 9), "FRAME")
    outline(space, rectangle(3, 0, 4, 1))
    outline(space, rectangle(5.5, 0.5, 6.5, 2))
    lines, picture = checked(tmp_path, capsys, document)
    *told, last, hint = lines
    assert hint == "small faults can be repaired in a copy of the drawing: assesto check --repair"
    assert last == f"drawing with the faults marked: {tmp_path / 'output' / 'model.svg'}"
    assert all(re.match(r"error: geometry\.dxf: fault \d: block \d+ \(layer ", line) for line in told)
    assert [("twice" in line, "encloses" in line, "overlap by" in line) for line in told] == [
        (True, False, False),
        (False, True, False),
        (False, False, True),
        (False, False, True),
    ]
    assert numbers(picture) == {"1", "2", "3", "4"}
    for key in ("drawn more than once: 1", "frame around other blocks: 1", "overlap: 2"):
        assert key in picture


def test_the_tolerance_that_mends_is_proposed_and_mends(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 4, 0), "BASE")
    for k in range(3):
        outline(space, rectangle(k, 0, k + 1, 1))
        outline(space, rectangle(k, 1.0026, k + 1, 2))
    lines, picture = checked(tmp_path, capsys, document)
    assert lines[-3] == (
        "error: geometry.dxf: gaps of up to 2.6 mm: geometry.tolerance_m = 0.004 closes all of them"
    )
    assert numbers(picture) == {"1", "2", "3"}
    (tmp_path / "project.toml").write_text(
        PROJECT.replace("[material]", "tolerance_m = 0.004\n[material]"), encoding="utf-8"
    )
    assert main(["check", str(tmp_path)]) == 0
    assert "stands under its own weight: yes" in capsys.readouterr().out


def test_faults_of_outlines_and_of_blocks_are_told_together(tmp_path, capsys):
    document, space = drawing(unit="m")
    outline(space, rectangle(-1, -1, 4, 0), "BASE")
    outline(space, rectangle(0, 0, 1, 1))
    outline(space, rectangle(0, 0, 1, 1))
    outline(space, rectangle(2, 0, 3, 1), close=False)
    outline(space, [(5, 0), (6, 1), (6, 0), (5, 1)])
    lines, picture = checked(tmp_path, capsys, document)
    assert ["is open" in lines[0], "crosses" in lines[1], "twice" in lines[2]] == [True] * 3
    assert lines[3] == (
        "error: geometry.dxf: gaps, and blocks that touch nothing, are looked for once these are mended"
    )
    assert numbers(picture) == {"1", "2", "3"}
