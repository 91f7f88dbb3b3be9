"""A new project from a built-in template: its drawing and a project file that explains every key."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from assessment.ntc.demand.spectrum import ElasticSpectrum
from assessment.project.catalogue.geometry import Layout
from assessment.project.catalogue.record import RECORD, write_artificial_record
from assessment.project.catalogue.templates import DRAWING, NUMBER, TEMPLATES, Option, Template
from assessment.project.formats.convert import TOML, source_bytes
from assessment.project.project import CONTROL, load_project
from assessment.project.structure.model import build_model
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files.atomic_files import left_over, naming, temporary_of
from mechanics import DrawingError
from mechanics.faults import visible

SIZES = (1e-3, 1e3)  # m
MOST_BLOCKS = 100  # of each kind, in a row
COLOURS = (7, 8, 30, 1, 5, 3)  # AutoCAD colour indices of the layers, in their order


def template_options(template: str) -> dict[str, Option]:
    """Return the options of a template: name to (default, unit, description). Raises ProjectError if it is unknown."""
    return dict(_template(template).options)


def template_layout(template: str, options: Mapping[str, float] | None = None) -> Layout:
    """Return the polygons of a template by layer, m. Raises ProjectError for options that do not fit."""
    try:
        return _template(template).layout(**_values(template, options or {}))
    except ProjectError:
        raise
    except ValueError as error:
        raise ProjectError(f"{template}: {error}") from None


def new_project(folder: Path, template: str, options: Mapping[str, float], source: str = TOML) -> None:
    """Write drawing, artificial record and project file of a template into a new folder, whole or not at all.

    `options` change the template's dimensions (see template_options), `source` is the name of the project file, which
    tells its form. Raises ProjectError where the template or an option is unknown or does not fit, or the folder
    holds something already; OSError where it cannot be written.
    """
    layout = template_layout(template, options)
    content = _template(template).content(_values(template, options))
    write_project(folder, layout, content, source)


def write_project(folder: Path, layout: Layout, content: Mapping[str, Any], source: str = TOML) -> None:
    """Write drawing, record and commented project file into a new folder, whole or not at all.

    Raises ProjectError as `new_folder`, and where the project is no structure; OSError, with the name of the file, if
    it cannot be written.
    """
    with new_folder(folder) as made:
        with naming(folder / DRAWING):
            write_drawing(made / DRAWING, layout)
        with naming(folder / source):
            (made / source).write_bytes(source_bytes(source, content))
        with naming(folder / RECORD):
            write_artificial_record(made, _spectrum(content["assessment"]["site"]))
        _refuse_what_is_no_structure(made)


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder that becomes `folder` when the block ends, and is removed where it fails.

    Raises ProjectError if the folder exists and is not empty, or has a name that no command takes; OSError, with its
    name, if it cannot be written.
    """
    if CONTROL.search(str(folder.absolute())):
        raise ProjectError(
            f"{visible(str(folder))}: folder: control characters in the name; give another one"
        )
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
        raise ProjectError(f"{folder}: folder: exists and is not empty; give the name of a new one")
    temporary = temporary_of(folder)
    try:
        with naming(folder):
            folder.parent.mkdir(parents=True, exist_ok=True)
            for killed in left_over(folder.parent, folder.name):
                shutil.rmtree(killed, ignore_errors=True)
            temporary.mkdir()
        yield temporary
        if folder.is_dir():
            folder.rmdir()  # Windows renames nothing over a folder, not even over an empty one
        temporary.replace(folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _refuse_what_is_no_structure(folder: Path) -> None:
    """Raise ProjectError where a run would refuse the project: dimensions that are valid each may not go together."""
    try:
        build_model(load_project(folder))
    except (ProjectError, DrawingError) as error:
        reason = str(error).split("\n")[0].partition(": ")[2].partition("; ")[0]
        raise ProjectError(f"--set: the dimensions give no structure: {reason}; give others") from None


def _spectrum(site: Mapping[str, Any]) -> ElasticSpectrum:
    hazard = site["SLC"]
    return ElasticSpectrum(
        hazard["ag_g"], hazard["F0"], hazard["Tc_star_s"], site["soil"], site["topography"]
    )


def write_drawing(path: Path, layout: Layout) -> None:
    """Write a DXF in metres: one closed polyline per block on the layer of its role."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    drawing = new("R2010")
    drawing.units = units.M
    space = drawing.modelspace()
    for colour, (layer, polygons) in zip(COLOURS, layout.items(), strict=False):
        drawing.layers.add(layer, color=colour)
        for polygon in polygons:
            space.add_lwpolyline(polygon.tolist(), close=True, dxfattribs={"layer": layer})
    drawing.saveas(path)


def _template(name: str) -> Template:
    if name not in TEMPLATES:
        raise ProjectError(f"--template: {name}: no such template; {nearest(name, TEMPLATES)}")
    return TEMPLATES[name]


def _values(template: str, options: Mapping[str, float]) -> dict[str, float]:
    """Return the template's defaults with the given options over them, counts as int."""
    known = _template(template).options
    values = {name: default for name, (default, _, _) in known.items()}
    for name, value in options.items():
        if name not in known:
            raise ProjectError(f"{template}: {name}: no such option; {nearest(name, known)}")
        counts = known[name][1] == NUMBER
        low, high = (1, MOST_BLOCKS) if counts else SIZES
        if not (low <= value <= high) or (counts and value != int(value)):
            unit = "a whole number" if counts else f"a number, in {known[name][1]},"
            raise ProjectError(f"{template}: {name}: is {value:g}; must be {unit} from {low:g} to {high:g}")
        values[name] = value
    return {name: int(v) if known[name][1] == NUMBER else float(v) for name, v in values.items()}
