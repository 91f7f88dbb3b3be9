"""A new project folder: from a template, an example, or one's own drawing, of which unit and supports are proposed."""

import inspect
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np
import shapely

from assessment.project.catalogue import NAMES, templates
from assessment.project.catalogue.geometry import DRAWING, Layout, Made
from assessment.project.project import CONTROL, TOML, convert, load_project, source_bytes
from assessment.project.schema import KeyPath
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files import naming, temporary_of
from mechanics import Layer, Material
from mechanics.errors import FaultyDrawingError
from mechanics.messages import Message, layer_key, message, visible
from mechanics.model import METRES, NEAR, PlacedOutline, Sheet, connected, default_tolerance
from mechanics.types import Mask

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
    own = known[name]
    within = ((path.relative_to(own), path) for path in sorted(own.rglob("*")) if path.is_file())
    files = {place.as_posix(): path.read_bytes() for place, path in within if place.parts[0] != "output"}
    with new_folder(folder, files) as fresh:
        if source != TOML:
            _, kept = convert(fresh / TOML, load_project(fresh).content(defaults=False))
            kept.unlink()


BLOCK = (0.05, 0.4, 3.0)  # m: least, usual and largest size of most blocks of masonry
FRAME = 0.5  # of all outlines: one that encloses so many is a frame
HOLE = 0.5  # of the area of an outline: one within it that is smaller is an opening
BOND = {"course_m": 0.3, "block_m": 0.6}  # of a wall that is drawn as one outline
STRUCTURE = 0.1  # of the area of the largest part: what touches nothing and is smaller is a note
LOW = 0.25  # of a structure's height, within which it is supported
BEARING = 0.02  # of a block's width: what rests on less rests on nothing
CLOSED = 0.05  # of an outline's length: ends that are nearer were meant to meet
DRAWN = {"LWPOLYLINE", "POLYLINE", "LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "SOLID", "3DFACE", "INSERT"}
GROUND = re.compile(r"fond|found|suolo|terreno|ground|soil|appogg|support|^base", re.IGNORECASE)
TO_FILL_IN: tuple[KeyPath, ...] = (
    ("title",), ("geometry", "depth_m"), ("material", "unit_weight_kN_m3"), ("material", "friction"),
    ("settlements", 0, "displacement_m"),
)  # fmt: skip


def new_from_drawing(folder: Path, drawing: Path, source: str = TOML) -> tuple[str, ...]:
    """Write a project of a drawing, with a copy of it, into a new folder, whole or not at all; return what tells it."""
    content, told = proposal(drawing)
    source_data = source_bytes(source, content, TO_FILL_IN)
    with new_folder(folder, {drawing.name: drawing.read_bytes(), source: source_data}):
        pass
    return told


def proposal(path: Path, unit: str | None = None) -> tuple[dict[str, Any], tuple[Message, ...]]:
    """Return the content of a project for a drawing, and lines that tell it. Raises DrawingError, ProjectError."""
    if not re.fullmatch(r"\S(.*\S)?", path.name) or not path.name.isprintable():
        text = "blanks at its ends or control characters; rename the file"
        raise ProjectError(f"--drawing {path.name!r}: {text}")
    sheet = Sheet.of(path, "m", Layer(Material(18.0), 1.0), {}, None, None)
    drawn = sheet.drawing
    if not drawn.blocks:
        raise FaultyDrawingError(str(path), drawn.faults, drawn.outlines)
    unit, why = (unit, message("as given")) if unit else _unit(sheet)
    scale = METRES[unit]
    enclosed = replace(sheet, unit=unit).enclosed
    wrong = [o for o in sheet.outlines if o.source.handle in sheet.wrong and _is_meant(o)]
    meant = [o for o in wrong if o.is_near(scale)]
    layers = [block.layer for block in drawn.blocks] + [outline.source.layer for outline in meant]
    layers += [layer for layer, _ in enclosed]
    faulty = [*(outline.points[:, :2] for outline in meant), *(line for _, line in enclosed)]
    rings = np.array([
        *(shapely.Polygon(scale * block.polygon) for block in drawn.blocks),
        *(shapely.Polygon(scale * points).convex_hull for points in faulty),
    ])  # fmt: skip
    reach = NEAR * scale * default_tolerance(drawn.blocks)
    masonry = _masonry(rings, reach)
    read = len(drawn.blocks)
    # layers to be ignored, and those of outlines with faults that show nothing else
    open_ = {layer_key(outline.source.layer) for outline in wrong}
    holding = {
        layer_key(layer) for layer, is_one in zip(layers[:read], masonry[:read], strict=True) if is_one
    }
    named = (each.layer for each in sheet.placed if not each.hidden and each.entity.dxftype() in DRAWN)
    shown = {layer_key(layer): layer for layer in named}
    ignored = sorted(name for key, name in shown.items() if key not in holding | open_)
    unclosed = sorted(name for key, name in shown.items() if key in open_ - holding)
    masonry &= ~np.isin(layers, ignored)
    walls, openings = _openings(rings, layers, masonry)
    masonry &= ~openings
    size = float(np.median(np.sqrt(shapely.area(rings[masonry]))))
    tables, regions, lines = _supports(rings, layers, masonry, reach, size)
    width, height = np.ptp(shapely.bounds(rings[masonry]).reshape(-1, 2), axis=0).tolist()
    names = [each["support"] for each in (*tables.values(), *regions)]
    moved = [
        {"name": f"cedimento {name}", "support": name, "displacement_m": [0.0, -0.01], "to_collapse": True}
        for name in names[1:][-1:]
    ]
    bonds = {name: {"bond": dict(BOND)} for name in walls}
    left_out = {name: {"ignore": True} for name in ignored}
    content: dict[str, Any] = {
        "title": path.stem.strip() or "project",
        "geometry": {"drawing": path.name, "unit": unit, "depth_m": 1.0},
        "material": {"unit_weight_kN_m3": 18.0, "friction": 0.6},
        "layers": tables | {key: {} for key in unclosed} | bonds | left_out,
        "region": regions,
        "settlements": moved,
        "pushover": {"contacts": ["rigid"], "increment_m": float(f"{1e-3 * height:.1g}")},
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }
    sizes = message(
        "unit: {unit}, {why}: {width:.3g} m wide, {height:.3g} m high, blocks: {blocks}, of about {size:.2g} m",
        unit=unit, why=why, width=width, height=height, blocks=int(masonry[:read].sum()), size=size,
    )  # fmt: skip
    told = [sizes, *lines]
    if broken := len(faulty):
        told.append(message("outlines with faults, taken as they seem meant: {broken}", broken=broken))
    if ignored:
        told.append(message("ignored, being no masonry: layers {ignored}", ignored=ignored))
    if walls:
        bond = message("an outline with openings: [layers.{wall}.bond] cuts it into blocks", wall=walls[0])
        told.append(bond)
    if drawn.cracks:
        told.append(message("surveyed cracks, to be drawn beside those calculated: {n}", n=len(drawn.cracks)))
    keys = ["geometry.depth_m = 1.0", "material.unit_weight_kN_m3 = 18.0", "material.friction = 0.6"]
    keys += [f"layers.{name}.bond" for name in walls] + ["settlements"] * len(moved) + ["report"]
    told.append(message(
        'to fill in: {keys}; for NTC 2018 [assessment] and [assessment.site], with model = "none", or elastic contacts',
        keys=keys,
    ))  # fmt: skip
    return {key: value for key, value in content.items() if value}, tuple(told)


def _unit(sheet: Sheet) -> tuple[str, Message]:
    """Return the unit that makes the blocks a size of blocks: the drawing's own if it does, and what tells so."""
    size = float(np.median([np.sqrt(block.area) for block in sheet.drawing.blocks]))
    own = sheet.own_unit
    least, usual, largest = BLOCK
    if own and least <= METRES[own] * size <= largest:
        return own, message("as $INSUNITS says")
    unit = min(METRES, key=lambda each: abs(np.log(METRES[each] * size / usual)))
    if own and own != unit:
        return unit, message("by the sizes, though $INSUNITS says {own}", own=own)
    return unit, message("by the sizes")


def _masonry(rings: Any, reach: float) -> Mask:
    """Return which outlines (b,) are part of a structure: no frame, and nothing small that touches nothing."""
    tree = shapely.STRtree(rings)
    frame, _ = tree.query(rings, predicate="contains_properly")
    frames = np.bincount(frame, minlength=len(rings)) > max(2.0, FRAME * len(rings))
    one, other = tree.query(rings, predicate="dwithin", distance=reach)
    kept = ~frames[one] & ~frames[other]
    part = connected(np.column_stack([one[kept], other[kept]]), len(rings))
    areas = np.bincount(part, weights=np.where(frames, 0.0, shapely.area(rings)))
    return np.asarray(~frames & (areas[part] >= STRUCTURE * areas.max()))


def _is_meant(outline: PlacedOutline) -> bool:
    """Return whether an outline with a fault was meant as a block: it is closed, or its ends nearly meet."""
    if len(outline.points) < 3 or not shapely.MultiPoint(outline.points[:, :2]).convex_hull.area:
        return False
    length = float(np.linalg.norm(np.diff(outline.points, axis=0), axis=1).sum())
    return bool(outline.closed or np.linalg.norm(outline.points[-1] - outline.points[0]) < CLOSED * length)


def _openings(rings: Any, layers: list[str], masonry: Mask) -> tuple[list[str], Mask]:
    """Return the layers, sorted, of outlines around others of their layer, and which (b,) these openings are."""
    tree = shapely.STRtree(rings)
    outer, inner = tree.query(rings, predicate="covers")
    same = np.array(layers)[outer] == np.array(layers)[inner]
    areas = shapely.area(rings)
    chosen = (outer != inner) & same & masonry[outer] & (areas[inner] < HOLE * areas[outer])
    openings = np.zeros(len(rings), dtype=bool)
    openings[inner[chosen]] = True
    return sorted({layers[k] for k in outer[chosen].tolist()}), openings


def _supports(
    rings: Any, layers: list[str], masonry: Mask, reach: float, size: float
) -> tuple[dict[str, dict[str, str]], list[dict[str, Any]], list[Message]]:
    """Return tables of layers and regions that are supports, what rests on nothing and low; and what tells of them."""
    number = np.flatnonzero(masonry)
    shapes, names = rings[masonry], np.array([layers[k] for k in number])
    bounds = shapely.bounds(shapes)
    low = bounds[:, 1] <= bounds[:, 1].min() + LOW * np.ptp(bounds[:, [1, 3]])
    ground = low & ~_rests(shapes, reach + 0.02 * size)
    named = [name for name in dict.fromkeys(names[ground].tolist()) if GROUND.search(name)]
    ground |= low & np.isin(names, named)
    if ground.all():
        text = message("no support: every block is a lowest one; draw the ground below them as a support")
        return {}, [], [text]
    chosen = np.flatnonzero(ground)
    tree = shapely.STRtree(shapes[chosen])
    near = tree.query(shapes[chosen], predicate="dwithin", distance=reach + 0.5 * size)
    part = connected(near.T, len(chosen))
    groups = sorted((chosen[part == k] for k in range(part.max() + 1)), key=lambda own: bounds[own, 0].min())
    calls = {1: ["base"], 2: ["sinistro", "destro"]}.get(len(groups))
    calls = calls or [f"appoggio {k}" for k in range(1, len(groups) + 1)]
    tables, regions, lines = dict[str, dict[str, str]](), list[dict[str, Any]](), list[Message]()
    for call, own in zip(calls, groups, strict=True):
        on = dict.fromkeys(names[own].tolist())
        if len(on) == 1 and np.isin(names, [*on]).sum() == len(own):
            tables[next(iter(on))] = {"support": call}
            lines.append(message('support "{call}": layer {layer}', call=call, layer=next(iter(on))))
            continue
        centres = shapely.get_coordinates(shapely.centroid(shapes[own]))
        (x0, z0), (x1, z1) = centres.min(axis=0) - 0.01 * size, centres.max(axis=0) + 0.01 * size
        corners = np.array([(x0, z0), (x1, z0), (x1, z1), (x0, z1)]).round(6).tolist()
        regions.append({"name": call, "outline_m": corners, "support": call})
        first, last = bounds[own, 0].min(), bounds[own, 2].max()
        lines.append(message(
            'support "{call}": the lowest blocks ({blocks}) between x = {first:.5g} and {last:.5g} m become the ground'
            "; draw the ground below if they are masonry", call=call, blocks=len(own), first=first, last=last,
        ))  # fmt: skip
    return tables, regions, lines


def _rests(shapes: Any, down: float) -> Mask:
    """Return which outlines (b,) bear on another: those that meet one beyond BEARING of their width, `down` m lower."""
    moved = shapely.transform(shapes, lambda points: points - (0.0, down))
    one, other = shapely.STRtree(shapes).query(moved, predicate="intersects")
    one, other = one[one != other], other[one != other]
    deeper = shapely.area(shapely.intersection(moved[one], shapes[other]))
    deeper -= shapely.area(shapely.intersection(shapes[one], shapes[other]))
    width = np.ptp(shapely.bounds(shapes)[:, [0, 2]], axis=1)
    bearing = np.bincount(one, weights=np.maximum(deeper, 0.0), minlength=len(shapes))
    return np.asarray(bearing > BEARING * down * width)
