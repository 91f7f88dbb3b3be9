"""A project from one's own drawing: unit, supports and layers that are no masonry are proposed, the rest is named."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from assessment.project.catalogue.new_project import new_folder
from assessment.project.formats.convert import TOML, source_bytes
from assessment.project.schema import KeyPath
from assessment.runtime.errors import ProjectError
from assessment.runtime.files.atomic_files import naming
from mechanics import Layer, Material
from mechanics.faults import FaultyDrawingError
from mechanics.model import METRES, NEAR, Sheet, default_tolerance, layer_key
from mechanics.types import Mask

BLOCK = (0.05, 0.4, 3.0)  # m: least, usual and largest size of most blocks of masonry
FRAME = 0.5  # of all outlines: one that encloses so many is a frame
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
    """Write a project of a drawing, a copy of which goes with it, into a new folder, whole or not at all.

    Returns the lines that say what is proposed and what is to be filled in.
    Raises ProjectError where the folder holds something already, DrawingError where the drawing cannot be read or has
    no closed outline, OSError where something cannot be read or written.
    """
    data = drawing.read_bytes()
    content, told = proposal(drawing)
    with new_folder(folder) as made:
        with naming(folder / drawing.name):
            (made / drawing.name).write_bytes(data)
        with naming(folder / source):
            (made / source).write_bytes(source_bytes(source, content, TO_FILL_IN))
    return told


def proposal(path: Path) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the content of a project for the drawing of that name, and the lines that tell of it.

    Raises DrawingError as `new_from_drawing`, ProjectError for a name that no project can have.
    """
    if not re.fullmatch(r"\S(.*\S)?", path.name) or not path.name.isprintable():
        raise ProjectError(
            f"--drawing {path.name!r}: blanks at its ends or control characters; rename the file"
        )
    sheet = Sheet.of(path, "m", Layer(Material(18.0), 1.0), {}, None, None)
    drawn = sheet.drawing
    if not drawn.blocks:
        raise FaultyDrawingError(str(path), drawn.faults, drawn.outlines)
    unit, why = _unit(sheet)
    scale = METRES[unit]
    rings = shapely.polygons([shapely.linearrings(scale * block.polygon) for block in drawn.blocks])
    layers = [block.layer for block in drawn.blocks]
    reach = NEAR * scale * default_tolerance(drawn.blocks)
    masonry = _masonry(rings, reach)
    ignored, unclosed = _no_masonry(sheet, layers, masonry)
    masonry &= ~np.isin(layers, ignored)
    size = float(np.median(np.sqrt(shapely.area(rings[masonry]))))
    tables, regions, lines = _supports(rings, layers, masonry, reach, size)
    height = float(np.ptp(shapely.bounds(rings[masonry])[:, [1, 3]]))
    width = float(np.ptp(shapely.bounds(rings[masonry])[:, [0, 2]]))
    names = [each["support"] for each in (*tables.values(), *regions)]
    moved = [
        {"name": f"{name} 10 mm", "support": name, "displacement_m": [0.0, -0.01], "to_collapse": True}
        for name in names[1:][-1:]
    ]
    content: dict[str, Any] = {
        "title": path.stem.strip() or "project",
        "geometry": {"drawing": path.name, "unit": unit, "depth_m": 1.0},
        "material": {"unit_weight_kN_m3": 18.0, "friction": 0.6},
        "layers": tables | {key: {} for key in unclosed} | {name: {"ignore": True} for name in ignored},
        "region": regions,
        "settlements": moved,
        "pushover": {"contacts": ["rigid"], "increment_m": float(f"{1e-3 * height:.1g}")},
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }
    sizes = f"{width:.3g} m wide, {height:.3g} m high, {masonry.sum()} blocks of about {size:.2g} m"
    told = (f"unit: {unit}, {why}: {sizes}", *lines)
    if broken := len(sheet.wrong):
        told += (f"outlines with faults, of which nothing is known here: {broken}; assesto check tells them",)
    if ignored:
        told += (f"ignored, being no masonry: layers {', '.join(ignored)}",)
    to_fill_in = ["geometry.depth_m = 1.0", "material.unit_weight_kN_m3 = 18.0", "material.friction = 0.6"]
    to_fill_in += ["settlements: support and movement"] * len(moved)
    to_fill_in += ["[assessment] and [assessment.site], which a check to NTC 2018 needs", "[report]"]
    told += (f"to fill in: {'; '.join(to_fill_in)}",)
    return {key: value for key, value in content.items() if value}, told


def _unit(sheet: Sheet) -> tuple[str, str]:
    """Return the unit that makes the blocks a size of blocks: the drawing's own if it does, and what says so."""
    size = float(np.median([np.sqrt(block.area) for block in sheet.drawing.blocks]))
    own = {4: "mm", 5: "cm", 6: "m"}.get(sheet.document.units)
    least, usual, largest = BLOCK
    if own and least <= METRES[own] * size <= largest:
        return own, "as $INSUNITS says"
    unit = min(METRES, key=lambda each: abs(np.log(METRES[each] * size / usual)))
    return unit, "by the sizes" + (f", though $INSUNITS says {own}" if own and own != unit else "")


def _masonry(rings: Any, reach: float) -> Mask:
    """Return which outlines (b,) are part of a structure: no frame, and nothing small that touches nothing."""
    tree = shapely.STRtree(rings)
    frame, _ = tree.query(rings, predicate="contains_properly")
    frames = np.bincount(frame, minlength=len(rings)) > max(2.0, FRAME * len(rings))
    one, other = tree.query(rings, predicate="dwithin", distance=reach)
    kept = ~frames[one] & ~frames[other]
    links = coo_array((np.ones(kept.sum()), (one[kept], other[kept])), shape=(len(rings), len(rings)))
    _, part = connected_components(links, directed=False)
    areas = np.bincount(part, weights=np.where(frames, 0.0, shapely.area(rings)))
    return np.asarray(~frames & (areas[part] >= STRUCTURE * areas.max()))


def _no_masonry(sheet: Sheet, layers: list[str], masonry: Mask) -> tuple[list[str], list[str]]:
    """Return the layers, sorted, that are to be ignored, and those that show nothing but outlines with faults."""
    holding = {layer_key(layer) for layer, is_one in zip(layers, masonry, strict=True) if is_one}
    faulty = set[str]()
    for outline in sheet.outlines:
        ends = outline.points[[0, -1]]
        length = float(np.linalg.norm(np.diff(outline.points, axis=0), axis=1).sum())
        meant = outline.closed or np.linalg.norm(ends[1] - ends[0]) < CLOSED * length
        if outline.source.handle in sheet.wrong and len(outline.points) > 2 and meant:
            faulty.add(layer_key(outline.source.layer))
    shown = {
        layer_key(p.layer): p.layer for p in sheet.placed if not p.hidden and p.entity.dxftype() in DRAWN
    }
    told = {key: shown[key] for key in shown.keys() - holding}
    ignored = sorted(name for key, name in told.items() if key not in faulty)
    return ignored, sorted(name for key, name in told.items() if key in faulty)


def _supports(
    rings: Any, layers: list[str], masonry: Mask, reach: float, size: float
) -> tuple[dict[str, dict[str, str]], list[dict[str, Any]], list[str]]:
    """Return tables of layers and regions that are supports, and lines that tell of them: what rests on nothing, low.

    Nothing where no block would be left.
    """
    number = np.flatnonzero(masonry)
    shapes, names = rings[masonry], np.array([layers[k] for k in number])
    bounds = shapely.bounds(shapes)
    low = bounds[:, 1] <= bounds[:, 1].min() + LOW * np.ptp(bounds[:, [1, 3]])
    ground = low & ~_rests(shapes, reach + 0.02 * size)
    named = [name for name in dict.fromkeys(names[ground].tolist()) if GROUND.search(name)]
    ground |= low & np.isin(names, named)
    if ground.all():
        text = "no support: every block is a lowest one; draw the ground below them as a support"
        return {}, [], [text]
    chosen = np.flatnonzero(ground)
    near = shapely.STRtree(shapes[chosen]).query(
        shapes[chosen], predicate="dwithin", distance=reach + 0.5 * size
    )
    _, part = connected_components(
        coo_array((np.ones(near.shape[1]), near), shape=(len(chosen),) * 2), directed=False
    )
    groups = sorted((chosen[part == k] for k in range(part.max() + 1)), key=lambda own: bounds[own, 0].min())
    calls = {1: ["base"], 2: ["sinistro", "destro"]}.get(len(groups))
    calls = calls or [f"appoggio {k}" for k in range(1, len(groups) + 1)]
    tables, regions, lines = dict[str, dict[str, str]](), list[dict[str, Any]](), list[str]()
    for call, own in zip(calls, groups, strict=True):
        on = dict.fromkeys(names[own].tolist())
        if len(on) == 1 and np.isin(names, [*on]).sum() == len(own):
            tables[next(iter(on))] = {"support": call}
            lines.append(f'support "{call}": layer {next(iter(on))}')
            continue
        centres = shapely.get_coordinates(shapely.centroid(shapes[own]))
        (x0, z0), (x1, z1) = centres.min(axis=0) - 0.01 * size, centres.max(axis=0) + 0.01 * size
        corners = [
            [round(float(x), 6), round(float(z), 6)] for x, z in ((x0, z0), (x1, z0), (x1, z1), (x0, z1))
        ]
        regions.append({"name": call, "outline_m": corners, "support": call})
        what = "block becomes" if len(own) == 1 else f"{len(own)} blocks become"
        where = f"between x = {bounds[own, 0].min():.5g} and {bounds[own, 2].max():.5g} m"
        text = f'support "{call}": the lowest {what} the ground, {where}; draw the ground below if that is masonry'
        lines.append(text)
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
