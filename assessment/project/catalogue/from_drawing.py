"""A project from one's own drawing: unit, supports and layers that are no masonry are proposed, the rest is named."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from assessment.project.catalogue.new_project import new_folder
from assessment.project.project import TOML, source_bytes
from assessment.project.schema import KeyPath
from assessment.runtime.errors import ProjectError
from mechanics import Layer, Material
from mechanics.errors import FaultyDrawingError
from mechanics.messages import Message, layer_key, message
from mechanics.model import METRES, NEAR, PlacedOutline, Sheet, connected, default_tolerance
from mechanics.types import Mask

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
    faulty_layers = {layer_key(outline.source.layer) for outline in wrong}
    ignored, unclosed = _no_masonry(sheet, layers[:read], masonry[:read], faulty_layers)
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


def _no_masonry(
    sheet: Sheet, layers: list[str], masonry: Mask, faulty: set[str]
) -> tuple[list[str], list[str]]:
    """Return the layers, sorted, that are to be ignored, and the `faulty` ones that show nothing else."""
    holding = {layer_key(layer) for layer, is_one in zip(layers, masonry, strict=True) if is_one}
    drawn = (each.layer for each in sheet.placed if not each.hidden and each.entity.dxftype() in DRAWN)
    shown = {layer_key(layer): layer for layer in drawn}
    told = {key: shown[key] for key in shown.keys() - holding}
    ignored = sorted(name for key, name in told.items() if key not in faulty)
    return ignored, sorted(name for key, name in told.items() if key in faulty)


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
