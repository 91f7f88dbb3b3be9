"""What the page draws, as plain numbers: the model with its faults, records and spectra. Computed in the worker."""

from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from assessment.analyses.demand import demand_spectra
from assessment.analyses.time_history import thinned
from assessment.app.session import model_tag
from assessment.ntc.hazard import HazardError, read_grid, read_site_table
from assessment.project.catalogue.new_project import new_folder, proposal
from assessment.project.model import build_model, how_to_read, with_repaired_drawing
from assessment.project.problems import project_error, schema_problems, wrong_file
from assessment.project.project import load_project, survey_project
from assessment.project.schema import ProjectContent
from assessment.project.toml import commented_toml
from assessment.report.language import Words, translated
from assessment.runtime.errors import ProjectError, error_text, is_input_error
from assessment.workflow.checking import checked, elapsed, expected
from mechanics import Layer, Material
from mechanics.errors import FaultyDrawingError, Outline
from mechanics.model import repair_drawing, survey_drawing
from mechanics.records import read_record, response_spectrum
from mechanics.types import Array

PERIODS = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(1.02, 4.0, 150)])  # s


def model_picture(folder: Path) -> dict[str, Any]:
    """Return what the drawing of a project is: its blocks and joints, or its outlines and faults; and warnings.

    Lengths in m. `tag`: by which it is known what is drawn; `error`: why a run would refuse the project; `self_weight`:
    whether it stands, None where that is not known; `expected`, `elapsed`: see workflow.checking. Raises ProjectError
    where the keys of the project file are wrong.
    """
    project, contradictions = survey_project(folder)
    found: dict[str, Any] = {"faults": [], "warnings": [], "joints": [], "repairable": False}
    found |= {"error": None, "self_weight": None, "tag": model_tag(project)}
    try:
        model = build_model(project)
        blocks = []
        for block in model.assembly.blocks:
            role = {"layer": block.layer, "support": block.support, "weight": float(f"{block.weight:.6g}")}
            blocks.append({"at": _short(block.polygon), "centre": _short(block.centroid)} | role)
        found["joints"] = [{"at": ends} for ends in _short(model.assembly.joints.ends)]
        found |= {"blocks": blocks, "layers": Counter(each.layer for each in model.assembly.blocks)}
        if contradictions is not None:
            raise contradictions
        check = checked(project, model)
        found["warnings"] = [bilingual(text) for text in check.warnings]
        found["self_weight"] = check.results.model.self_weight_stable
        found["expected"] = expected(check)
        found["elapsed"] = elapsed(found["expected"])
    except FaultyDrawingError as faulty:
        mendable = any(fault.remedy for fault in faulty.faults)
        found |= _outlined(faulty.outlines) | {"error": error_text(faulty), "repairable": mendable}
        for fault in faulty.faults:
            places = {"points": _short(fault.points), "lines": [_short(line) for line in fault.lines]}
            found["faults"].append({"kind": fault.kind, "text": fault.text} | places)
    except (ValueError, OSError) as error:
        if not is_input_error(error):
            raise
        outlines: tuple[Outline, ...] = ()
        with suppress(ValueError, OSError):
            outlines = survey_drawing(*how_to_read(project)).outlines
        found = _outlined(outlines) | found | {"error": error_text(error)}
    return found


def _outlined(outlines: tuple[Outline, ...]) -> dict[str, Any]:
    """Return the outlines of a drawing that is no assembly, in the place of blocks."""
    blocks = []
    for each in outlines:
        role = {"layer": each.layer, "support": each.support or None, "open": not each.closed}
        blocks.append({"at": _short(each.points)} | role)
    return {"blocks": blocks, "layers": Counter(each.layer for each in outlines)}


def repair_picture(folder: Path, apply: bool) -> dict[str, Any]:
    """Return what a repair of the drawing changes, a line each, and the name of the repaired copy.

    The copy is written where `apply` says so. Raises ProjectError or DrawingError as `with_repaired_drawing`.
    """
    project, _ = survey_project(folder)
    if apply:
        repaired, changes = with_repaired_drawing(project)
        return {"changes": list(changes), "drawing": repaired.geometry.drawing}
    changes = repair_drawing(*how_to_read(project), project.geometry.tolerance_m).changes
    return {"changes": list(changes), "drawing": None}


def record_picture(path: Path, time_step: float | None = None) -> dict[str, Any]:
    """Return a(t) of a record, g, and its Sa(T), g, at 5 % damping. Raises RecordError for a file that is none."""
    record = read_record(path, time_step)
    kept = thinned(record.acceleration)
    keys = {key: getattr(record, key) for key in ("name", "unit", "time_step", "duration", "pga")}
    spectrum = response_spectrum(record.acceleration, record.time_step, PERIODS)[0]
    return keys | {
        "arias": list(record.arias_window()),
        "time": _short(record.time[kept]),
        "acceleration": _short(record.acceleration[kept]),
        "periods": _short(PERIODS),
        "Sa": _short(spectrum),
    }


def spectrum_picture(folder: Path) -> dict[str, Any]:
    """Return the elastic spectra of the site, g, by limit state; none where nothing is assessed on a spectrum of it."""
    project = load_project(folder)
    if project.assessment is None or project.assessment.spectrum != "ntc":
        return {"periods": [], "spectra": {}}
    spectra = {
        name: {"Se": _short(each.acceleration(PERIODS)), "ag": each.ag, "S": each.S}
        for name, each in demand_spectra(project).spectra.items()
    }
    return {"periods": _short(PERIODS), "spectra": spectra}


def bilingual(text: str) -> dict[str, str]:
    """Return a sentence of the program in both languages."""
    return {"en": str(text), "it": translated(text, Words.of("it"))}


def _short(values: Array) -> list[Any]:
    """Return numbers with the digits that can be seen: a hundredth of a millimetre."""
    return np.round(np.asarray(values, dtype=float), 5).tolist()


def drawing_picture(path: Path) -> dict[str, Any]:
    """Return outlines by layer and size (drawing units) of a DXF file, the proposed `unit` and `notes`, a line each.

    Raises DrawingError for a file that cannot be read.
    """
    found = survey_drawing(path, "m", Layer(Material(20.0), 1.0))
    points = np.concatenate([each.points for each in found.outlines] or [np.zeros((1, 2))])
    content, lines = _proposed(path, None)
    layers = Counter(each.layer for each in found.outlines)
    size, said = np.ptp(points, axis=0).tolist(), [bilingual(text) for text in lines]
    return {"layers": layers, "size": size, "unit": content["geometry"]["unit"], "notes": said}


def _proposed(drawing: Path, unit: str | None) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return what `assesto new --drawing` would make of a drawing; of one with faulty outlines alone just itself."""
    try:
        return proposal(drawing, unit)
    except FaultyDrawingError as faulty:  # the page shows what is wrong and mends it
        if not faulty.outlines:
            raise
        return {"geometry": {"drawing": drawing.name, "unit": unit or "m"}, "material": {}}, ()


def grid_picture(path: Path) -> dict[str, Any]:
    """Return nothing of a hazard grid, or the hazard of one site, that can be read. Raises ProjectError for others."""
    try:
        if read_site_table(path) is None:
            read_grid(path)
    except HazardError as error:
        raise ProjectError(str(error)) from None
    return {}


def attachment_picture(path: Path) -> dict[str, Any]:
    """Return nothing of a picture that can be printed. Raises ProjectError for others."""
    if wrong := wrong_file("picture", path.parent, path.name):
        raise ProjectError(wrong)
    return {}


def begin_project(folder: Path, drawing: Path, given: dict[str, Any]) -> None:
    """Make a project of a drawing in a new folder, with what is proposed for it.

    `given`: title, unit, depth_m, unit_weight_kN_m3, language. Raises ProjectError where one is wrong, or the folder is
    there.
    """
    own = {
        "title": given["title"],
        "geometry": {"drawing": drawing.name, "unit": given["unit"], "depth_m": given["depth_m"]},
        "material": {"unit_weight_kN_m3": given["unit_weight_kN_m3"]},
        "report": {"language": given["language"] or "it"},
    }
    try:
        ProjectContent.model_validate(own)
    except ValidationError as error:
        raise project_error("project.toml", schema_problems(error, own), {}) from None
    content = _proposed(drawing, given["unit"])[0]
    for key, each in own.items():
        content[key] = content.get(key, {}) | each if isinstance(each, dict) else each
    files = {drawing.name: drawing.read_bytes(), "project.toml": commented_toml(content).encode()}
    with new_folder(folder, files):
        pass
