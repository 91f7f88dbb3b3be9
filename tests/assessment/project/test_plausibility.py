"""Values that are allowed and hardly meant, of records too: the key, and what was probably meant."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from assessment.cli.main import main
from assessment.project.model import build_model
from assessment.project.plausibility import implausible_hazard
from assessment.project.project import load_project
from assessment.report.language import Words, cell
from assessment.report.tables.structure import layers
from assessment.workflow.checking import describe, read_motions
from tests import ROOT
from tests.support.block_project import ASSESSMENT, HAZARD, PROJECT, PUSHED, block, edit, write_block
from tests.support.rows import rows

MOVED = '[[settlements]]\nname = "down"\nsupport = "base"\ndisplacement_m = [0.0, -0.01]\n'
SITE = PROJECT + ASSESSMENT
AT_HEIGHT = """[assessment.floor]
height_m = 6
building_height_m = 9
storeys = 3
[[history]]
record = "wave.csv"
contacts = "rigid"
[pushover]"""
TEXTS = {
    "block": PROJECT, "site": SITE, "elastic": PROJECT.replace('["rigid"]', '["rigid", "elastic"]'),
    "moved": block() + MOVED + PUSHED, "small": block() + PUSHED.replace("0.2", "0.0002"),
}  # fmt: skip
CASES = rows(r"""
# what is meant | project | a text of it | its replacement | the warning
friction in degrees | block | friction = 0.7 | friction = 35
    | material.friction: 35 is the tangent of 88.4°; write 0.7 if an angle of 35° was meant
friction of no stone | block | friction = 0.7 | friction = 1.6
    | material.friction: 1.6 is the tangent of 58°; stone on stone has 0.4 to 0.8; write inf
friction of a layer | block | [layers.BASE] | [layers.BASE]\nfriction = 40 | layers.BASE.friction: 40 is the tangent
unit weight in kg/m³ | block | = 18.0 | = 1800.0
    | material.unit_weight_kN_m3: 1800 kN/m³ is no masonry's; write 17.7 if kg/m³ were meant
unit weight in N/m³ | block | = 18.0 | = 18000.0 | write 18 if N/m³ were meant
unit weight in t/m³ | block | = 18.0 | = 1.8 | write 17.7 if t/m³ were meant
unit weight of nothing | block | = 18.0 | = 90.0 | masonry has 5 to 40
stiffness in N/mm³ | elastic | = 1e6 | = 1.0
    | material.normal_stiffness_kN_m3: with 1 kN/m³ the weight alone presses block 1 into its bed by 18 of
stiffness that sinks a block by 1.1 hundredths | elastic | = 1e6 | = 1636.0 | bed by 0.011 of its height
movement in mm | moved | [0.0, -0.01] | [0.0, -10.0]
    | settlements[1].displacement_m: 10 m is more than the whole structure (4.5 m); write 0.01 if mm were meant
rotation in degrees | block | rotation_rad = -0.02 | rotation_rad = -2.0
    | settlements[1].rotation_rad: 2 rad are 115°; write 0.0349 if degrees were meant, 0.002 if mrad
depth in mm | block | depth_m = 1.0 | depth_m = 500.0 | geometry.depth_m: 500 m out of plane; write 0.5 if mm were
unit of the drawing | small | unit = "m" | unit = "mm"
    | geometry.unit: with "mm" the structure is 0.0045 m large; write the unit of the drawing
a_g in m/s² | site | ag_g = 0.261 | ag_g = 2.56
    | assessment.site.SLV.ag_g: 2.56 g at SLV is outside 0.0364 to 0.278 g, which Italian sites have at 475 years
    (Allegato B); write 0.261 if m/s² were meant; write 0.256 if g/10 were meant
T_C* in ms | site | Tc_star_s = 0.35 | Tc_star_s = 350.0
    | 350 s is outside 0.1 to 0.6 s, which Italian sites have (Allegato B); write 0.35 if ms were meant
T_C* of no site | site | Tc_star_s = 0.35 | Tc_star_s = 0.75 | Tc_star_s: 0.75 s is outside 0.1 to 0.6 s, which Italian
F0 of no site | site | F0 = 2.36 | F0 = 3.36
    | assessment.site.SLV.F0: 3.36 is outside 2.2 to 3.3, which Italian sites have
a_g of another return period | site | SLC = {ag_g = 0.334 | SLC = {ag_g = 0.414
    | SLC.ag_g: 0.414 g at SLC is outside 0.0427 to 0.403 g, which Italian sites have at 975 years (Allegato B);
    compare it with the hazard of the site
SLV below SLD | site | SLV = {ag_g = 0.261 | SLV = {ag_g = 0.1
    | assessment.site.SLV.ag_g: 0.1 g at SLV is below the 0.104 g of SLD, which comes more often
behaviour factor of a building | site | model = "none" | model = "none"\nbehaviour_factor = 6
    | assessment.behaviour_factor: 6 is above 2, the factor of local mechanisms
records of the ground at height | site | [pushover] | AT_HEIGHT
    | assessment.floor: static checks contain what the building amplifies
confidence factor without crushing | site | model = "none" | model = "none"\nconfidence_factor = 1.2
    | assessment.confidence_factor: 1.2 is below 1.35, which Circolare 7/2019, C8.7.1.2, asks for
""")


def warned(folder: Path) -> list[str]:
    project = load_project(folder)
    return [
        w for w in (*build_model(project).warnings, *implausible_hazard(project, {})) if "project.toml" in w
    ]


@pytest.mark.parametrize(("case", "text", "old", "new", "said"), CASES)
def test_what_was_probably_meant_is_said(tmp_path, case, text, old, new, said):
    folder = write_block(tmp_path / "block", TEXTS[text])
    (folder / "wave.csv").touch()
    if text == "small":
        edit(folder, "[0.3, 4.2]", "[0.0003, 0.0042]")
        edit(folder, "[-0.3, 4.2]", "[-0.0003, 0.0042]")
    else:
        assert warned(folder) == []
    edit(folder, old, new.replace("AT_HEIGHT", AT_HEIGHT))
    warning, *others = warned(folder)
    assert warning.startswith("project.toml: ") and said in warning
    assert len(others) == ("ag_g = 2.56" in new)  # SLC is then below SLV


def test_a_control_point_on_a_corner_of_two_blocks_is_told(tmp_path):
    """It moves with the one that is drawn first: d_0 of a portal was 216 or 65 mm by their order."""
    folder = Path(shutil.copytree(ROOT / "projects" / "tuff_panel", tmp_path / "panel"))
    model = build_model(load_project(folder)).assembly
    corners, times = np.unique(
        np.concatenate([block.polygon for block in model.blocks]), axis=0, return_counts=True
    )
    corner = corners[times.argmax()].tolist()
    edit(folder, "point_m = [-0.1, 0.65]", f"point_m = {corner}")
    on = [str(block) for block in model.blocks_at(corner)]
    (told,) = (text for text in warned(folder) if "control." in text)
    assert len(on) > 1 and f"on blocks {', '.join(on)}: it moves with the first" in told


def test_infinite_inputs_are_echoed_as_they_are_written(project):
    """JSON has no infinity, and null means that a result was not reached."""
    described = describe(load_project(project), build_model(load_project(project)))
    assert described.echo.material["tangential_stiffness_kN_m3"] == "inf"
    assert "tangential_stiffness_kN_m3" in layers(described).rows[0]
    row = layers(described).rows[0]
    assert cell("tangential_stiffness_kN_m3", row, Words.of("en")) == "∞"


@pytest.mark.parametrize("example", sorted(path.name for path in (ROOT / "projects").iterdir()))
def test_the_examples_have_nothing_implausible(example):
    assert warned(ROOT / "projects" / example) == []


def test_swapped_coordinates_are_told_before_and_with_the_grid(tmp_path, capsys):
    folder = write_block(
        tmp_path / "block", SITE.replace(HAZARD, 'latitude = 13.4\nlongitude = 42.35\ngrid = "grid.txt"\n')
    )
    (folder / "grid.txt").touch()
    (warning,) = implausible_hazard(load_project(folder), {})
    assert "write latitude = 42.35, longitude = 13.4" in warning
    values = "\t".join(f"{0.5 + k}\t2.4\t0.3" for k in range(9))
    nodes = [(13.3 + 0.06 * i, 42.25 + 0.06 * j) for i in range(4) for j in range(4)]
    (folder / "grid.txt").write_text("\n".join(f"{x}\t{y}\t{values}" for x, y in nodes), encoding="utf-8")
    assert main(["check", str(folder)]) == 2
    assert "They are swapped: write latitude = 42.35, longitude = 13.4." in capsys.readouterr().err


TIME = 0.005 * np.arange(5001)
WAVE = np.cos(2.0 * np.pi * TIME) * np.exp(-((TIME - 10.0) ** 2))  # of unit peak

HISTORY = """
[[history]]
record = "wave.csv"
scale = 2.0
contacts = "rigid"
window_s = [5.0, 15.0]
"""


def _block(folder, *tables, heading="time [s],acceleration [m/s²]"):
    write_block(folder, PROJECT[: PROJECT.index("[pushover]")] + "".join(tables))
    rows = "\n".join(f"{t:.3f},{a:.6f}" for t, a in zip(TIME, 3.2067 * WAVE, strict=True))
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


def test_a_record_too_strong_for_its_unit_is_doubted(tmp_path):
    """Accelerations in m/s² without a heading pass for g: 3.2 m/s² are a PGA of 3.2 g, which no record has."""
    folder = _block(tmp_path / "block", HISTORY, heading="t,a")
    [note] = [note for note in read_motions(load_project(folder)).notes if "unit" in note]
    assert note == "wave: a PGA of 3.21 g, read in g; check the unit of the file, and name it in its heading"
    folder = _block(tmp_path / "other", HISTORY)
    assert not any("unit" in note for note in read_motions(load_project(folder)).notes)
