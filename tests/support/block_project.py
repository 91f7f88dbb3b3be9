"""A project of one block on a base, the quickest there is, and what tests ask of a folder."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from assessment.cli.main import main
from assessment.project.catalogue.new_project import made, write_drawing
from assessment.project.model import build_model
from assessment.project.project import Project
from assessment.results.schema.part import plain
from assessment.runtime.cache import FOLDER
from assessment.runtime.progress import NAME as JOURNAL
from assessment.runtime.tasks import Outcome
from assessment.workflow import stages
from assessment.workflow.run import ENTRY
from tests import ROOT


def block(stiffness: str = "1e6") -> str:
    """The tables that every project of the block has; stiffness of its joint in kN/m³."""
    return f"""title = "Block"
[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0
[material]
unit_weight_kN_m3 = 18.0
friction = 0.7
normal_stiffness_kN_m3 = {stiffness}
[layers.BASE]
support = "base"
[[control]]
name = "right"
point_m = [0.3, 4.2]
[[control]]
name = "left"
point_m = [-0.3, 4.2]
"""


TURNED = """[[settlements]]
name = "base turned"
support = "base"
rotation_rad = -0.02
increment_rad = 0.01
"""
PUSHED = """[pushover]
contacts = ["rigid"]
directions = ["+x"]
increment_m = 0.2
"""
PROJECT = block() + TURNED + PUSHED
HAZARD = """SLD = {ag_g = 0.104, F0 = 2.33, Tc_star_s = 0.28}
SLV = {ag_g = 0.261, F0 = 2.36, Tc_star_s = 0.35}
SLC = {ag_g = 0.334, F0 = 2.40, Tc_star_s = 0.36}
"""
ASSESSMENT = f"""[assessment]
limit_states = ["SLV"]
model = "none"
[assessment.site]
soil = "B"
{HAZARD}"""


def write_block(folder: Path, text: str = PROJECT, height: float = 4.2) -> Path:
    """Write drawing and project file into a folder, made if it is not there; return it. `height` (m): of the block."""
    folder.mkdir(exist_ok=True)
    write_drawing(folder / "geometry.dxf", made("block", {"height_m": height})[0])
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder


def edit(folder: Path, old: str, new: str) -> None:
    """Replace a text of the project file, which has to be there."""
    text = (folder / "project.toml").read_text(encoding="utf-8")
    assert old in text
    (folder / "project.toml").write_text(text.replace(old, new), encoding="utf-8")


def read_results(folder: Path) -> dict[str, Any]:
    """Return results.json of a folder of results, which has to be JSON in the strict sense."""
    found: dict[str, Any] = json.loads(
        (folder / "results.json").read_text(encoding="utf-8"), parse_constant=_refuse
    )
    return found


def _refuse(name: str) -> None:
    raise AssertionError(f"{name} is no JSON")


def forget(output: Path) -> None:
    """Remove the record of the last run from an output folder, so that the next one writes every part again."""
    (output / FOLDER / ENTRY).unlink(missing_ok=True)


def contents(folder: Path) -> dict[str, str]:
    """Files and their digests, without the analyses kept for later runs and the journal of one that was killed."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not {FOLDER, JOURNAL} & {*path.parts}
    }


def timeless(value: Any) -> Any:
    """Results without the times, which no two computations share."""
    if isinstance(value, dict):
        return {key: timeless(item) for key, item in value.items() if key not in {"timing_s", "seconds"}}
    return [timeless(item) for item in value] if isinstance(value, list) else value


def run(folder: Path, *options: str) -> int:
    """Run the project without its report; return the exit code."""
    return main(["run", str(folder), "--no-report", *options])


def outcome_of(project: Project, jobs: int = 1) -> Outcome:
    """Analyse a project that has been read."""
    return stages.run(project, build_model(project), jobs)


def results_of(project: Project, jobs: int = 1) -> dict[str, Any]:
    """Its results as results.json has them."""
    found: dict[str, Any] = plain(outcome_of(project, jobs).results)
    return found


def command(*arguments: str, code: str = "", **options: object) -> subprocess.CompletedProcess[str]:
    """Run the program as a process of its own, or some code."""
    return subprocess.run(
        [sys.executable, *(("-c", code) if code else ("-m", "assessment.cli", *arguments))],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        **options,  # type: ignore[call-overload]
    )
