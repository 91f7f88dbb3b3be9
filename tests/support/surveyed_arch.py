"""The buttressed arch with measurements of a support movement that is known: made by a pushdown of the test's own."""

import shutil
from functools import cache
from pathlib import Path

import numpy as np

from assessment.project.model import build_model
from assessment.project.project import Project, load_project
from assessment.results.schema.studies import Identification
from assessment.runtime.tasks import Workers
from assessment.studies.identification import identification
from assessment.studies.variants import Study
from mechanics import Assembly, pushdown
from mechanics.model import V, end_gaps

SOURCE = Path(__file__).parents[2] / "projects" / "buttressed_arch"
CROWN, LEFT, RIGHT = (-0.019, 0.789), (-0.282, 0.684), (0.282, 0.684)  # edges of joints, as drawn
PIER, SPRINGING, OTHER = (0.345, 0.30), (0.27, 0.50), (-0.27, 0.50)


@cache
def moved(model: Assembly, movement: tuple[float, float, float], support: str) -> np.ndarray:
    """Return the positions (n, 3) after a movement of a support, m and rad."""
    x, z, rotation = movement
    return pushdown(model, support, (x, z), rotation, increment=0.001).final.positions


def measured(
    model: Assembly, kind: str, point, movement: tuple[float, float, float], support: str = "destro"
) -> float:
    """Return what a movement (m, m, rad) of a support makes of a measurement, mm or mrad.

    "span": along x against the other springing; "foot": along z against the benchmark.
    """
    final = moved(model, movement, support)
    if kind == "lean":
        return 1e3 * float(final[model.block_at(point), 2])
    if kind in {"span", "foot"}:
        here = model.point_displacement(point, model.block_at(point), final)
        other = model.point_displacement(OTHER, model.block_at(OTHER), final)
        return 1e3 * float((here - other)[0] if kind == "span" else here[1])
    ends = model.joints.ends.reshape(-1, 2)
    nearest = int(np.argmin(np.hypot(*(ends - np.array(point)).T)))
    places = model.contacts.places(final)
    if kind == "slip":
        return 1e3 * abs(float(places[nearest // 2, V]))
    return 1e3 * float(end_gaps(places).reshape(-1)[nearest])


def entry(name: str, kind: str, point, value: float, sigma: float = 0.2) -> str:
    """Return a measurement of the project file."""
    keys = {
        "crack": ("crack", "opening_mm", ""),
        "slip": ("slip", "slip_mm", ""),
        "lean": ("lean", "rotation_mrad", ""),
        "span": ("relative", "value_mm", f'from_m = {list(OTHER)}\ncomponent = "x"\n'),
        "foot": ("relative", "value_mm", 'from_m = "benchmark"\ncomponent = "z"\n'),
    }
    own, key, more = keys[kind]
    unit = key.rpartition("_")[2]
    value = max(value, 0.0) if kind in {"crack", "slip"} else value
    return (
        f'[[measurement]]\nname = "{name}"\nkind = "{own}"\npoint_m = {list(point)}\n'
        f"{key} = {float(value)!r}\nsigma_{unit} = {sigma}\n{more}"
    )


def write_surveyed(folder: Path, hypotheses: str, *entries: str, sliding: str = "associative") -> Path:
    """Write the project of the arch with hypotheses and measurements, and no other analysis.

    Its joints only open: both laws of friction have one path, and that of the associative one takes less time.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(SOURCE / "geometry.dxf", folder)
    text = (SOURCE / "project.toml").read_text(encoding="utf-8").partition("[[settlements]]")[0]
    text += f'[contacts]\nsliding = "{sliding}"\n[report]\nlanguage = "it"\n'
    text += f"[identification]\nhypotheses = {hypotheses}\n"
    (folder / "project.toml").write_text(text + "".join(entries), encoding="utf-8")
    return folder


def surveyed(folder: Path) -> tuple[Project, Assembly]:
    """Return a project and its model."""
    project = load_project(folder)
    return project, build_model(project).assembly


def identified(folder: Path, workers: Workers) -> tuple[Identification, Study]:
    """Return the identification of a project, and its messages."""
    project, model = surveyed(folder)
    study = Study()
    return identification(project, model, workers, study), study
