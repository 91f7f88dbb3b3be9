"""A new project folder: from a built-in template, with drawing and explained project file, or from an example."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import Any

from assessment.project.catalogue.content import DRAWING
from assessment.project.catalogue.geometry import Layout
from assessment.project.catalogue.templates import made as made_of
from assessment.project.formats.convert import TOML, convert, source_bytes
from assessment.project.project import CONTROL, load_project
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files.atomic_files import left_over, naming, temporary_of

COLOURS = (7, 8, 30, 1, 5, 3)  # AutoCAD colour indices of the layers, in their order
RECORD = "records/artificial.csv"
_PACKAGE = Path(__file__).parents[2]


def template_layout(template: str, options: Mapping[str, float] | None = None) -> Layout:
    """Return the polygons of a template by layer, m. Raises ProjectError for options that do not fit."""
    return made_of(template, options or {})[0]


def new_project(folder: Path, template: str, options: Mapping[str, float], source: str = TOML) -> None:
    """Write drawing, artificial record and project file of a template into a new folder, whole or not at all.

    `options` change the template's dimensions (see template_options), `source` is the name of the project file, which
    tells its form. Raises ProjectError where the template or an option is unknown or does not fit, or the folder
    holds something already; OSError where it cannot be written.
    """
    layout, content = made_of(template, options)
    write_project(folder, layout, content, source, sound=not options)


def write_project(
    folder: Path, layout: Layout, content: Mapping[str, Any], source: str = TOML, sound: bool = False
) -> None:
    """Write drawing, record and commented project file into a new folder, whole or not at all.

    `sound`: it is known to be a structure. Raises ProjectError as `new_folder`, and where it is none; OSError, with the
    name of the file, if it cannot be written.
    """
    with new_folder(folder) as made:
        with naming(folder / DRAWING):
            write_drawing(made / DRAWING, layout)
        with naming(folder / source):
            (made / source).write_bytes(source_bytes(source, content))
        with naming(folder / RECORD):
            write_record(made)
        if not sound:
            _refuse_what_is_no_structure(made)


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder that becomes `folder` when the block ends, and is removed where it fails.

    Raises ProjectError if the folder exists and is not empty, or has a name that no command takes; OSError, with its
    name, if it cannot be written.
    """
    if CONTROL.search(str(folder.absolute())):
        from mechanics.faults import visible  # late: the mechanics take their time

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


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a new folder, all or none. Raises as `new_folder`, OSError naming the file."""
    with new_folder(folder) as made:
        for name, data in files.items():
            with naming(folder / name):
                (made / name).write_bytes(data)


def _refuse_what_is_no_structure(folder: Path) -> None:
    """Raise ProjectError where a run would refuse the project: dimensions that are valid each may not go together."""
    from assessment.project.structure.model import build_model  # late: the mechanics take their time
    from mechanics.errors import DrawingError

    try:
        build_model(load_project(folder))
    except (ProjectError, DrawingError) as error:
        reason = str(error).split("\n")[0].partition(": ")[2].partition("; ")[0]
        raise ProjectError(f"--set: the dimensions give no structure: {reason}; give others") from None


def write_record(folder: Path) -> None:
    """Write the artificial record of the example of a triumphal arch into a project folder: 15 s at 0.01 s.

    It is within 10 % of the SLC spectrum of L'Aquila (soil B, T1, class II, 50 years) between 0.15 and 2 s.
    """
    (folder / RECORD).parent.mkdir()
    shutil.copyfile(examples()["triumphal_arch"] / RECORD, folder / RECORD)


def write_drawing(path: Path, layout: Layout) -> None:
    """Write a DXF in metres: one closed polyline per block on the layer of its role."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    drawing = new("R2010")
    drawing.units = units.M
    space = drawing.modelspace()
    for colour, (layer, polygons) in zip(cycle(COLOURS), layout.items(), strict=False):
        drawing.layers.add(layer, color=colour)
        for polygon in polygons:
            space.add_lwpolyline(polygon.tolist(), close=True, dxfattribs={"layer": layer})
    drawing.saveas(path)


def examples() -> dict[str, Path]:
    """Return the folder of every example by its name."""
    installed = _PACKAGE / "examples"
    folder = installed if installed.is_dir() else _PACKAGE.parent / "projects"
    return {path.name: path for path in sorted(folder.iterdir()) if (path / TOML).is_file()}


def example_title(folder: Path) -> str:
    """Return the first heading of an example's README."""
    first, *_ = (folder / "README.md").read_text(encoding="utf-8").split("\n", 1)
    return first.removeprefix("# ")


def new_example(folder: Path, name: str, source: str = TOML) -> None:
    """Copy an example into a new folder, whole or not at all; `source`: name of the project file, which tells its form.

    Raises ProjectError where there is no such example, or the folder holds something already; OSError where it cannot
    be written.
    """
    known = examples()
    name = name.lower().replace("-", "_")
    if name not in known:
        raise ProjectError(f"--example: {name}: no such example; {nearest(name, known)}")
    with new_folder(folder) as made:
        for path in sorted(known[name].rglob("*")):
            within = path.relative_to(known[name])
            if path.is_file() and within.parts[0] != "output":
                (made / within).parent.mkdir(exist_ok=True)
                shutil.copyfile(path, made / within)
        if source != TOML:
            _, kept = convert(made / TOML, load_project(made).content(defaults=False))
            kept.unlink()
