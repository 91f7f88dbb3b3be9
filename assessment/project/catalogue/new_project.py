"""A new project folder: from a template, a function of its dimensions, or from an example."""

import inspect
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_type_hints

from assessment.project.catalogue import NAMES, templates
from assessment.project.catalogue.geometry import DRAWING, Layout, Made
from assessment.project.project import CONTROL, TOML, convert, load_project, source_bytes
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files import naming, temporary_of
from mechanics.messages import visible

NUMBER = ""  # unit of a dimension that counts, a whole number
UNITS = {"_kN_m3": "kN/m³", "_kN": "kN", "_deg": "°", "_m": "m"}  # by the end of a name
LARGEST = {NUMBER: 100, "m": 1e3, "kN": 1e6, "kN/m³": 1e3, "°": 89.0}
LEAST = 1e-3  # m, of a dimension that is not 0 by default
TEMPLATES: dict[str, Callable[..., Made]] = {
    name: getattr(templates, name.replace("-", "_")) for name in NAMES
}


class Option(NamedTuple):
    """A dimension of a template."""

    default: float
    unit: str
    description: str


def template_options(template: str) -> dict[str, Option]:
    """Return the dimensions of a template by name. Raises ProjectError if it is unknown."""
    if template not in TEMPLATES:
        raise ProjectError(f"--template: {template}: no such template; {nearest(template, TEMPLATES)}")
    found = {}
    for argument, each in inspect.signature(TEMPLATES[template], eval_str=True).parameters.items():
        hints = {argument: each.annotation}
        if is_dataclass(each.default):
            hints = get_type_hints(each.annotation, include_extras=True)
        for name, hint in hints.items():
            if get_args(hint):  # what follows from other dimensions has no meaning of its own
                default = getattr(each.default, name, each.default)
                unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), NUMBER)
                unit = NUMBER if isinstance(default, int) else unit
                found[name] = Option(default, unit, hint.__metadata__[0])
    return found


def made(template: str, options: Mapping[str, float]) -> Made:
    """Return polygons by layer, m, and project file of a template. Raises ProjectError for options that do not fit."""
    known, values = template_options(template), {}
    for name, value in options.items():
        if name not in known:
            raise ProjectError(f"{template}: {name}: no such option; {nearest(name, known)}")
        default, unit, _ = known[name]
        low, high = (1.0 if unit == NUMBER else LEAST if unit == "m" and default else 0.0), LARGEST[unit]
        if not low <= value <= high or (unit == NUMBER and value != int(value)):
            what = "a whole number" if unit == NUMBER else f"a number, in {unit},"
            raise ProjectError(f"{template}: {name}: is {value:g}; must be {what} from {low:g} to {high:g}")
        values[name] = int(value) if unit == NUMBER else float(value)
    parts: dict[str, Any] = {}
    try:
        for name, each in inspect.signature(TEMPLATES[template]).parameters.items():
            if is_dataclass(part := each.default):
                own = {field.name for field in fields(part)} & values.keys()
                parts[name] = replace(part, **{key: values.pop(key) for key in own})  # type: ignore[type-var]
        return TEMPLATES[template](**values, **parts)
    except ValueError as error:
        raise ProjectError(f"{template}: {error}") from None


COLOURS = (7, 8, 30, 1, 5, 3)  # AutoCAD colour indices of the layers, in their order
# within 10 % of the SLC spectrum of L'Aquila (soil B, T1, class II, 50 years) from 0.15 to 2 s; 15 s at 0.01 s
RECORD = "records/artificial.csv"
_PACKAGE = Path(__file__).parents[2]


def new_project(folder: Path, template: str, options: Mapping[str, float], source: str = TOML) -> None:
    """Write drawing, record and project file of a template into a new folder. Raises ProjectError if no structure."""
    layout, content = made(template, options)
    record = (examples()["triumphal_arch"] / RECORD).read_bytes()
    files = {source: source_bytes(source, content), RECORD: record}
    with new_folder(folder, files) as fresh:
        with naming(folder / DRAWING):
            write_drawing(fresh / DRAWING, layout)
        if options:
            from assessment.project.model import build_model  # late: the mechanics take their time
            from mechanics.errors import DrawingError

            try:
                build_model(load_project(fresh))
            except (ProjectError, DrawingError) as error:
                reason = str(error).split("\n")[0].partition(": ")[2].partition("; ")[0]
                text = f"--set: the dimensions give no structure: {reason}; give others"
                raise ProjectError(text) from None


@contextmanager
def new_folder(folder: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """Yield a temporary folder of files that becomes `folder` when the block ends. Raises ProjectError unless new."""
    if CONTROL.search(str(folder.absolute())):
        raise ProjectError(
            f"{visible(str(folder))}: folder: control characters in the name; give another one"
        )
    if folder.is_file():
        raise ProjectError(f"{folder}: is a file; give the name of a new folder")
    if folder.is_dir() and any(folder.iterdir()):
        raise ProjectError(f"{folder}: folder: exists and is not empty; give the name of a new one")
    temporary = temporary_of(folder)
    try:
        with naming(folder):
            folder.parent.mkdir(parents=True, exist_ok=True)
            temporary.mkdir()
        for name, data in files.items():
            with naming(folder / name):
                (temporary / name).parent.mkdir(parents=True, exist_ok=True)
                (temporary / name).write_bytes(data)
        yield temporary
        if folder.is_dir():
            folder.rmdir()  # Windows renames nothing over a folder, not even over an empty one
        temporary.replace(folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


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
    """Copy an example into a new folder with a project file called `source`. Raises ProjectError as `new_folder`."""
    known = examples()
    name = name.lower().replace("-", "_")
    if name not in known:
        raise ProjectError(f"--example: {name}: no such example; {nearest(name, known)}")
    within = (
        (path.relative_to(known[name]), path) for path in sorted(known[name].rglob("*")) if path.is_file()
    )
    files = {place.as_posix(): path.read_bytes() for place, path in within if place.parts[0] != "output"}
    with new_folder(folder, files) as fresh:
        if source != TOML:
            _, kept = convert(fresh / TOML, load_project(fresh).content(defaults=False))
            kept.unlink()
