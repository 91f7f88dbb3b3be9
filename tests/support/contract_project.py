"""A project file with every table that has one, with the files that it names."""

from pathlib import Path

import pytest

from assessment.project.project import ProjectError, load_project
from tests.support.hostile.judge import check

CONTRACT = """
title = "Buttressed arch"

[geometry]
drawing = "geometry.dxf"
unit = "mm"
depth_m = 0.10
[material]
unit_weight_kN_m3 = 11.5
friction = 0.6
normal_stiffness_kN_m3 = 1.2e5

[layers.PIERS]
depth_m = 5.5
[layers.BASE_RIGHT]
support = "right"
[layers.ROOF]
vertical_load_kN = 9.1
load_has_mass = true

[[control]]
name = "C1"
point_m = [0.0, 3.2]
[[control]]
name = "C2"
point_m = [1, 3]

[[settlements]]
name = "right support 20 mm"
support = "right"
displacement_m = [0.020, -0.020]
rotation_rad = 0.0
increment_m = 0.001
to_collapse = true

[pushover]
contacts = ["rigid", "elastic"]
directions = ["+x", "-x"]
increment_m = 0.001
control = "C1"

[[history]]
record = "records/aqv_ns.acc"
scale = 1.0
window_s = [15.0, 22.0]
time_step_s = 0.005
contacts = "elastic"
integrator = "implicit-euler"
control = "C1"
vertical_record = "records/aqv_up.acc"

[incremental]
records = ["records/*.acc"]
tolerance_g = 0.01
max_scale = 5.0

[assessment]
limit_states = ["SLD", "SLV", "SLC"]
confidence_factor = 1.35
behaviour_factor = 2.0
model = "trilinear"
spectrum = "ntc"
[assessment.site]
latitude = 42.35
longitude = 13.40
grid = "allegato_b.txt"
soil = "B"
topography = "T1"
nominal_life_years = 50
use_class = "II"

[report]
language = "it"
client = "Comune"
engineer = "Ing. Rossi"
location = "L'Aquila"
"""


MINIMAL = """
title = "Wall"
[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0
[material]
unit_weight_kN_m3 = 18.0
"""


HAZARD = "{ag_g = 0.26, F0 = 2.4, Tc_star_s = 0.35}"


def write_named_files(folder: Path) -> Path:
    """Make the files that the examples name, empty."""
    (folder / "records").mkdir()
    for name in (
        "geometry.dxf",
        "allegato_b.txt",
        "records/aqv_ns.acc",
        "records/aqv_up.acc",
        "records/b.csv",
    ):
        (folder / name).touch()
    return folder


def load(folder: Path, text: str):
    """Write the project file and load it."""
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return load_project(folder)


def message(folder: Path, text: str) -> str:
    """Return what is said of a project file that is wrong: what is wrong with it, and what to do, line by line."""
    with pytest.raises(ProjectError) as caught:
        load(folder, text)
    check(str(caught.value))
    return str(caught.value)
