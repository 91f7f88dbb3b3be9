"""A small arch analysed from its drawing, once per process: what tests of the products look into."""

import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from assessment.project.catalogue.new_project import new_project
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema import as_bytes
from assessment.workflow.stages import run
from tests.support.block_project import HAZARD

SETTLED = "right support 60 mm"
PROJECT = """title = "Small arch"
scatter = 2

[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0

[material]
unit_weight_kN_m3 = 20.0
friction = 0.7
normal_stiffness_kN_m3 = 1e6

[layers.BASE_SINISTRA]
support = "left"
[layers.BASE_DESTRA]
support = "right"

[[control]]
name = "crown"
point_m = [0.0, 1.65]

[[settlements]]
name = "right support 60 mm"
support = "right"
displacement_m = [0.06, -0.02]
increment_m = 0.01

[pushover]
contacts = ["rigid", "elastic"]
directions = ["+x", "-x"]
increment_m = 0.01

[[history]]
record = "pulse.csv"
time_step_s = 0.01
contacts = "rigid"

[assessment]
model = "trilinear"
[assessment.site]
soil = "B"
HAZARD
[report]
language = "LANGUAGE"
client = "Parish of St. <Mary>"
""".replace("HAZARD", HAZARD)


def analysed(language: str = "en") -> dict[str, Any]:
    """Results of the small arch, a fresh copy; language of its report."""
    results: dict[str, Any] = json.loads(_analysed())
    results["echo"]["report"]["language"] = language
    return results


@cache
def _analysed() -> str:
    with tempfile.TemporaryDirectory() as folder:
        project = arch(Path(folder) / "arch")
        outcome = run(load_project(project), build_model(load_project(project)), jobs=1)
        assert outcome.complete, outcome.results.quality.warnings
        return as_bytes(outcome.results).decode()


def arch(folder: Path, language: str = "en") -> Path:
    """Write the project of the small arch into a new folder."""
    new_project(folder, "arch", {"voussoirs": 11})
    (folder / "project.toml").write_text(PROJECT.replace("LANGUAGE", language), encoding="utf-8")
    time = np.arange(0.0, 1.0, 0.01)
    pulse = np.column_stack([time, 0.5 * np.sin(2.0 * np.pi * np.minimum(time, 0.5) / 0.5)])
    np.savetxt(folder / "pulse.csv", pulse, delimiter=",", fmt="%.6f")
    return folder
