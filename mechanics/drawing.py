"""A DXF drawing to blocks: every closed polyline of model space is a block, its layer says what it is of."""

from __future__ import annotations

import math
import re
import struct
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ezdxf import recover, units
from ezdxf.audit import AuditError
from ezdxf.document import Drawing as Document
from ezdxf.entities.dxfentity import DXFTagStorage
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.entities.insert import Insert
from ezdxf.entities.lwpolyline import LWPolyline
from ezdxf.entities.polyline import Polyline
from ezdxf.filemanagement import readfile
from ezdxf.lldxf.const import DXFError
from ezdxf.math import Matrix44, Vec3

from mechanics.errors import DrawingError, require
from mechanics.layout import itemised, listed
from mechanics.block import Block, Material
from mechanics.types import Array

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
INSUNITS = {"mm": "Millimeters", "cm": "Centimeters", "m": "Meters"}  # as ezdxf names them
SAME_POINT = 1e-6  # of an outline's size: vertices closer than this are one vertex
SAGITTA = 1e-3  # of an arc's width: the default distance between an arc and its chords
SPLINE_FRAME = 16  # flag of a vertex that controls a spline-fitted polyline but is not on it
SHAPES = {"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "MLINE", "SOLID", "TRACE", "3DFACE", "REGION", "BODY"}
SHAPES |= {"3DSOLID", "SURFACE", "MESH", "POLYLINE", "INSERT"}  # here: a mesh, an external reference
_key = str.lower  # DXF does not heed the case of layer names
NOWHERE = Vec3(math.nan, math.nan, math.nan)
ENTITIES = re.compile(rb"[2\x02][\s\x00]*ENTITIES[\s\x00].*?(ENDSEC|SECTION|EOF)", re.DOTALL)
UNPARSED = (DXFError, OSError, struct.error, AssertionError, StopIteration)
MISLEADING = {AuditError.INVALID_FLOATING_POINT_VALUE, AuditError.INVALID_BLOCK_REFERENCE_CYCLE}


@dataclass(frozen=True, slots=True)
class Layer:
    """What the blocks of one drawing layer are; the fields are those of Block."""

    material: Material
    depth: float
    support: str | None = None
    vertical_load: float = 0.0
    load_has_mass: bool = True
    segments: int | None = None


@dataclass(frozen=True)
class Drawing:
    """Blocks of a drawing, warnings about it, and the largest distance (m) of an arc from its chords."""

    blocks: tuple[Block, ...]
    warnings: tuple[str, ...]
    sagitta: float = 0.0


@dataclass(frozen=True, slots=True)
class _Placed:
    """An entity as model space shows it, inside INSERTs or not; `handle` is INSERT/…/entity."""

    entity: DXFGraphic
    to_model: Matrix44
    layer: str
    handle: str
    hidden: bool

    def at(self, *points: Array) -> str:
        """Return layer, type, handle and coordinates (drawing units), for a message."""
        where = " and ".join(f"({p[0]:.9g}, {p[1]:.9g})" for p in points)
        return f'layer "{self.layer}", {self.entity.dxftype()} {self.handle} at {where or "no point"}'


@dataclass(frozen=True, slots=True)
class _Outline:
    """A polyline in model space: distinct `points` (n, 3), drawing units, arcs replaced by chords."""

    source: _Placed
    points: Array
    closed: bool
    sagitta: float


def read_drawing(
    path: str | Path,
    unit: str,
    default: Layer,
    layers: Mapping[str, Layer] = {},
    sagitta: float | None = None,
) -> Drawing:
    """Read the blocks of a DXF drawing (text or binary, R12 and later); their vertices are in m.

    Each closed LWPOLYLINE, 2D or plane 3D POLYLINE of model space is a block, also inside INSERTs
    (nested, scaled, mirrored, arrays; there layer 0 stands for the INSERT's layer). A polyline that ends
    where it starts is closed. `unit` ("mm", "cm", "m") is the drawing's. `layers` replaces `default` by
    layer name, in any case of letters. What is frozen, off or invisible is left out with a warning: the
    place for closed outlines that are no blocks. An open polyline is an error, but left out with a
    warning where `layers` names other layers and not its own, and no closed one is there. Other shapes
    (lines, arcs, circles, …) are left out with a warning, annotation without.

    Arcs become chords that are nowhere further than `sagitta` (m) from the arc; by default a thousandth
    of the arc's width (its chord; beyond half a circle, its diameter). An arc is divided evenly, so that
    one shared by two blocks gives both the same vertices.

    Raises DrawingError listing all that is wrong, with file, layer, handle and coordinates in drawing
    units: the file cannot be read or is cut off; an outline is open, self-crossing, without area or out
    of the drawing's plane; a layer of `layers` is not in the drawing, or hidden; nothing closed is in
    model space. Raises ValueError for an unknown `unit` or a `sagitta` that is not positive.
    """
    require(unit in METRES, "unit", unit, '"mm", "cm" or "m"')
    require(sagitta is None or 0.0 < sagitta < np.inf, "sagitta", sagitta, "positive, in m, or None")
    path, scale = Path(path), METRES[unit]
    document, warnings = _open(path)
    placed = _model_space(document)
    allowed = None if sagitta is None else sagitta / scale
    outlines = [_outline(p, allowed) for p in placed if not p.hidden and _is_polyline(p.entity)]
    used = [o for o in outlines if o.closed]
    holding = {_key(o.source.layer) for o in used}
    named = {_key(name): layer for name, layer in layers.items()}
    needed = [o for o in outlines if not named or not used or _key(o.source.layer) in holding | named.keys()]

    problems = _layer_problems(document, placed, layers)
    problems += listed([fault for o in needed if (fault := _fault(o)) is not None])
    if not used and not problems:
        problems = [_nothing(document, placed)]
    if problems:
        raise DrawingError(f"{path}: {itemised('the drawing cannot be used', problems)}")

    idle = [name for name in layers if _key(name) not in holding]
    if (own := units.unit_name(document.units)) not in {"Unitless", "unitless", INSUNITS[unit]}:
        warnings.append(f"$INSUNITS says {own}, the project {unit}, which is used; check the sizes")
    warnings += [f'layer "{name}" holds no block: what the project says of it has no effect' for name in idle]
    warnings += _left_out(placed, [o for o in outlines if not o.closed])
    return Drawing(
        tuple(_block(o, named.get(_key(o.source.layer), default), scale) for o in used),
        tuple(f"{path.name}: {w}" for w in warnings),
        scale * max(o.sagitta for o in used),
    )


def _open(path: Path) -> tuple[Document, list[str]]:
    """Read the document, repaired where that loses nothing; warn of repairs."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DrawingError(
            f"{path}: cannot be read ({error.strerror}); give the path of a DXF file"
        ) from None
    if data.startswith(b"AC10"):
        raise DrawingError(f"{path}: this is a DWG drawing; save it as DXF")
    if b"SECTION" not in data:
        raise DrawingError(f"{path}: this is no DXF drawing; export the drawing as DXF")
    if not ENTITIES.search(data):
        raise DrawingError(f"{path}: the file is cut off before the end of its entities; export it again")
    try:
        if data.startswith(b"AutoCAD Binary DXF"):
            document = readfile(path)  # recover mode is for text only
            auditor = document.audit()
        else:
            document, auditor = recover.read(BytesIO(data))
    except (*UNPARSED, ValueError, LookupError, TypeError, AttributeError) as error:
        raise DrawingError(f"{path}: the file is damaged ({error}); export it again") from error
    faults = [*auditor.errors, *auditor.fixes]
    if fatal := [fault.message for fault in faults if fault.code in MISLEADING]:
        raise DrawingError(f"{path}: {itemised('the file is damaged', listed(fatal))}; export it again")
    if not faults:
        return document, []
    what = f"{len(faults)} faults, first: {faults[0].message}"
    return document, [
        f"the file was damaged and has been repaired ({what}); compare the model with the drawing"
    ]


def _model_space(document: Document) -> list[_Placed]:
    """Return all entities of model space, those inside INSERTs where these put them."""
    off = {_key(layer.dxf.name) for layer in document.layers if layer.is_off()}
    frozen = {_key(layer.dxf.name) for layer in document.layers if layer.is_frozen()}

    def place(
        space: Iterable[Any], to_model: Matrix44, outer: str, path: str, hidden: bool
    ) -> Iterator[_Placed]:
        for entity in space:
            own = entity.graphic_properties().get("layer", "0")
            layer = outer if own == "0" else own
            handle = f"{path}{entity.dxf.handle}"
            invisible = entity.dxf.hasattr("invisible") and entity.dxf.invisible
            gone = hidden or bool(invisible) or _key(layer) in frozen
            block = entity.block() if isinstance(entity, Insert) else None
            if block is None or block.block is None or block.block.is_xref:
                yield _Placed(entity, to_model, layer, handle, gone or _key(layer) in off)
                continue
            for single in entity.multi_insert() if entity.mcount > 1 else [entity]:
                yield from place(block, single.matrix44() * to_model, layer, f"{handle}/", gone)

    return list(place(document.modelspace(), Matrix44(), "0", "", hidden=False))


def _is_polyline(entity: DXFGraphic) -> bool:
    """Tell polylines from all else, meshes of the same type included."""
    if isinstance(entity, Polyline):
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return isinstance(entity, LWPolyline)


def _outline(source: _Placed, sagitta: float | None) -> _Outline:
    """Place a polyline in model space, its arcs as chords within `sagitta` (drawing units)."""
    entity: Any = source.entity
    if isinstance(entity, LWPolyline):
        flat, rows = True, [(x, y, 0.0, bulge) for x, y, bulge in entity.get_points("xyb")]
    else:
        flat, on_it = (
            entity.is_2d_polyline,
            [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME],
        )
        rows = [(*v.get("location", NOWHERE).xyz, v.bulge if flat else 0.0) for v in on_it]
    vertices, closed = np.array(rows, dtype=float).reshape(-1, 4), bool(entity.is_closed)
    if not len(vertices) or not np.isfinite(vertices).all():
        return _Outline(source, vertices[:, :3], True, 0.0)
    ocs = entity.ocs()
    m = np.array(list(ocs.matrix * source.to_model if flat and ocs.transform else source.to_model))
    m = m.reshape(4, 4)  # of row vectors
    stretch = float(np.linalg.norm(m[:3, :3], 2))

    points, worst = _chords(vertices, closed, None if sagitta is None else sagitta / max(stretch, 1e-99))
    points = points @ m[:3, :3] + m[3, :3]
    same = SAME_POINT * float(np.ptp(points, axis=0).max())
    closed = closed or (len(points) > 2 and bool(np.linalg.norm(points[0] - points[-1]) <= same))
    distinct = points[np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > same]
    return _Outline(source, distinct if closed and len(distinct) else points, closed, worst * stretch)


def _chords(vertices: Array, closed: bool, sagitta: float | None) -> tuple[Array, float]:
    """Return the points (m, 3) of a polyline (n, 4: x, y, z, bulge) and how far arcs are from their chords.

    A bulge b is the tangent of a quarter of the arc's angle, positive with the arc right of its chord p →
    q; the point at the angle φ of the arc θ is p + (q − p) · sin ½φ / sin ½θ · exp ½i(φ − θ).
    """
    xyz, bulges = vertices[:, :3], vertices[:, 3]
    if not bulges.any():
        return xyz, 0.0
    w = xyz[:, 0] + 1j * xyz[:, 1]
    pieces, worst = [], 0.0
    for k, (p, q, b) in enumerate(zip(w, np.roll(w, -1), bulges, strict=True)):
        chord = abs(q - p)
        if b == 0.0 or chord == 0.0 or (k == len(w) - 1 and not closed):
            pieces.append(np.array([p]))
            continue
        theta = 4.0 * np.arctan(b)
        radius = chord * (1.0 + b * b) / (4.0 * abs(b))
        allowed = sagitta or SAGITTA * (chord if abs(b) <= 1.0 else 2.0 * radius)
        n = int(np.ceil(abs(theta) / (4.0 * np.arcsin(np.sqrt(min(allowed / radius, 0.5) / 2.0)))))
        phi = theta * np.arange(n) / n
        pieces.append(p + (q - p) * np.sin(phi / 2.0) / np.sin(theta / 2.0) * np.exp(0.5j * (phi - theta)))
        worst = max(worst, 2.0 * radius * float(np.sin(theta / (4.0 * n))) ** 2)
    w = np.concatenate(pieces)
    return np.column_stack([w.real, w.imag, np.full(len(w), xyz[0, 2])]), worst


def _fault(outline: _Outline) -> str | None:
    """Say what keeps an outline from being a block, where, and what to do."""
    points, at = outline.points, outline.source.at
    if not np.isfinite(points).all():
        return f"{at(points[0])} has a coordinate that is no number; draw it again"
    if not outline.closed:
        apart = float(np.linalg.norm(points[0] - points[-1]))
        remedy = "close it, or freeze its layer if it is no block"
        return f"{at(points[0], points[-1])} is open, its ends {apart:.6g} apart; {remedy}"
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if size and np.ptp(points[:, 2]) > SAME_POINT * size:
        return f"{at(points[0])} is not in the XY plane; flatten it"
    polygon = shapely.Polygon(points[:, :2]) if len(points) > 2 else shapely.Polygon()
    if polygon.convex_hull.area <= SAME_POINT * size**2:
        return f"{at(*points[:1])} has no area, {len(points)} vertices in line; delete it or draw it again"
    if not polygon.is_valid:
        place = shapely.is_valid_reason(polygon).partition("[")[2].strip("]").split()
        return f"{at(np.array(place, float))} crosses or touches itself there; draw it as one simple outline"
    return None


def _layer_problems(document: Document, placed: Sequence[_Placed], layers: Mapping[str, Layer]) -> list[str]:
    """Name the layers of the project that the drawing does not have or does not show."""
    drawn = {_key(n): n for n in [*(la.dxf.name for la in document.layers), *(p.layer for p in placed)]}
    hidden = Counter(_key(p.layer) for p in placed if p.hidden and _is_polyline(p.entity))
    problems = []
    for name in layers:
        if _key(name) not in drawn:
            nearest = [drawn[key] for key in get_close_matches(_key(name), drawn, n=1)]
            has = ", ".join(sorted(drawn.values()))
            hint = f'did you mean "{nearest[0]}"?' if nearest else f"it has {has}"
            problems.append(f'layer "{name}" is not in the drawing; {hint}')
        elif n := hidden[_key(name)]:
            remedy = "show them, or take the layer out of the project"
            problems.append(f'layer "{name}" has {n} polylines that are frozen, off or invisible; {remedy}')
    return problems


def _nothing(document: Document, placed: Sequence[_Placed]) -> str:
    """Say what a drawing without polylines in model space has instead."""
    paper = [
        f'layer "{e.dxf.layer}", {e.dxftype()} {e.dxf.handle} of layout "{layout.name}"'
        for layout in document.layouts
        for e in layout
        if not layout.is_modelspace and _is_polyline(e)
    ]
    if paper:
        return f"the polylines are in paper space ({paper[0]}, {len(paper)} in all); move them to model space"
    counts = Counter(("hidden " if p.hidden else "") + p.entity.dxftype() for p in placed)
    found = ", ".join(f"{n} {kind}" for kind, n in counts.most_common()) or "nothing at all"
    return f"nothing closed is in model space, but {found}; draw each block as one closed polyline"


def _left_out(placed: Sequence[_Placed], open_: Sequence[_Outline]) -> list[str]:
    """Warn of what looks like a block and is none."""
    hidden = Counter(p.layer for p in placed if p.hidden and _is_polyline(p.entity))
    warnings = [f'layer "{k}": {n} frozen, off or invisible polylines left out' for k, n in hidden.items()]
    if open_:
        first = open_[0].source.at(*open_[0].points[[0, -1]])
        warnings.append(f"{len(open_)} open polylines on layers without blocks left out, first: {first}")
    rest = [p for p in placed if not (p.hidden or _is_polyline(p.entity))]
    shapes = [p for p in rest if p.entity.dxftype() in SHAPES or isinstance(p.entity, DXFTagStorage)]
    if shapes:
        kinds = Counter(p.entity.dxftype() for p in shapes)
        found = ", ".join(f"{n} {kind}" for kind, n in kinds.most_common())
        on = ", ".join(sorted({p.layer for p in shapes}))
        warnings.append(f"left out, being no closed polylines: {found}, on layers {on}")
    return warnings


def _block(outline: _Outline, layer: Layer, scale: float) -> Block:
    of_layer = {field.name: getattr(layer, field.name) for field in fields(layer)}
    source = outline.source
    return Block(scale * outline.points[:, :2], **of_layer, layer=source.layer, handle=source.handle)
