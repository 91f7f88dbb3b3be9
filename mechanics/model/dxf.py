"""A DXF drawing to blocks: every closed polyline of model space is a block, its layer gives its properties."""

from __future__ import annotations

import logging
import re
import struct
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from io import BytesIO
from pathlib import Path
from typing import Any, overload

import numpy as np
from ezdxf import recover, units
from ezdxf.audit import AuditError
from ezdxf.document import Drawing as Document
from ezdxf.entities.dxfentity import DXFTagStorage
from ezdxf.filemanagement import readfile
from ezdxf.lldxf.const import DXFError, DXFStructureError

from mechanics.errors import DrawingError, require
from mechanics.faults import Fault, FaultyDrawingError, Outline, listed, visible
from mechanics.messages import Message, headed, message
from mechanics.model.block import Block, Material
from mechanics.model.polylines import (
    MOST_POINTS,
    PlacedOutline,
    fault_of,
    is_polyline,
    placed_outline,
)
from mechanics.model.shown import Placed, covered, placed_entities

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
INSUNITS = {"mm": "Millimeters", "cm": "Centimeters", "m": "Meters"}  # as ezdxf names them
MOST_BYTES = 200_000_000  # of a file: some 20 000 blocks take ten
LONGEST_REASON = 300  # letters of a message of ezdxf
SHAPES = {"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "MLINE", "SOLID", "TRACE", "3DFACE", "REGION", "BODY"}
SHAPES |= {"3DSOLID", "SURFACE", "MESH", "POLYLINE", "INSERT"}  # here: a mesh, an external reference
_key = str.lower  # DXF does not heed the case of layer names
ENTITIES = re.compile(rb"[2\x02][\s\x00]*ENTITIES[\s\x00]")
END = re.compile(rb"ENDSEC|SECTION|EOF")
UNPARSED = (DXFError, OSError, struct.error, AssertionError, StopIteration, ArithmeticError, RecursionError)
MISLEADING = {AuditError.INVALID_FLOATING_POINT_VALUE, AuditError.INVALID_BLOCK_REFERENCE_CYCLE}

logging.getLogger("ezdxf").addHandler(
    logging.NullHandler()
)  # its findings are reported here, in our own words


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
class Drawing(Sequence[Block]):
    """Blocks of a drawing, warnings about it, and the largest distance (m) of an arc from its chords.

    It is the sequence of its blocks: Assembly(read_drawing(…)). `faults`: what keeps outlines from being blocks, and
    layers that are not there; `outlines`: all of them, to draw.
    """

    blocks: tuple[Block, ...]
    warnings: tuple[Message, ...]
    sagitta: float = 0.0
    faults: tuple[Fault, ...] = ()
    outlines: tuple[Outline, ...] = ()

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.blocks)

    @overload
    def __getitem__(self, index: int) -> Block: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Block, ...]: ...

    def __getitem__(self, index: int | slice) -> Block | tuple[Block, ...]:
        """Return a block by its number, or some."""
        return self.blocks[index]


def read_drawing(
    path: str | Path,
    unit: str,
    default: Layer,
    layers: Mapping[str, Layer] = {},
    sagitta: float | None = None,
) -> Drawing:
    """Read the blocks of a DXF drawing (text or binary, R12 and later); their vertices are in m.

    Each closed LWPOLYLINE, 2D or plane 3D POLYLINE of model space is a block, also inside INSERTs
    (nested, scaled, mirrored, arrays; there layer 0 is the INSERT's layer). A polyline that ends
    where it starts is closed. `unit` ("mm", "cm", "m") is the drawing's. `layers` replaces `default` by
    layer name, in any case of letters. What is frozen, off, invisible or clipped away is left out with a warning:
    the place for closed outlines that are no blocks. An open polyline is an error, but left out with a
    warning where `layers` names other layers and not its own, and no closed one is there. Other shapes
    (lines, arcs, circles, …) are left out with a warning, annotation without.

    Arcs become chords that are at no place further than `sagitta` (m) from the arc; by default a thousandth
    of the arc's width (its chord; beyond half a circle, its diameter). An arc is divided evenly, so that
    one shared by two blocks gives both the same vertices.

    Raises DrawingError listing all that is wrong, with file, layer, handle and coordinates in drawing
    units: the file cannot be read or is cut off; an outline is open, self-crossing, without area or out
    of the drawing's plane, cut by a clip or covered by a wipeout; a layer of `layers` is not in the drawing, or
    hidden; nothing closed is in model space.

    Raises ValueError for an unknown `unit` or a `sagitta` that is not positive.
    """
    drawing = survey_drawing(path, unit, default, layers, sagitta)
    if drawing.faults:
        raise FaultyDrawingError(str(path), drawing.faults, drawing.outlines)
    return drawing


def survey_drawing(
    path: str | Path,
    unit: str,
    default: Layer,
    layers: Mapping[str, Layer] = {},
    sagitta: float | None = None,
) -> Drawing:
    """Return what `read_drawing` does, and its faults in place of raising them; `blocks` are then those without.

    Raises DrawingError where the file cannot be read.
    """
    require(unit in METRES, "unit", unit, '"mm", "cm" or "m"')
    require(sagitta is None or 0.0 < sagitta < np.inf, "sagitta", sagitta, "positive, in m, or None")
    path, scale = Path(path), METRES[unit]
    document, warnings = open_document(path)
    placed = placed_entities(document, path)
    outlines, clipped = placed_outlines(document, placed, scale, sagitta, path)
    closed = [o for o in outlines if o.closed]
    holding = {_key(o.source.layer) for o in closed}
    named = by_key(layers)
    needed = meant_as_blocks(outlines, layers)

    wrong = {id(o): fault for o in needed if (fault := fault_of(o, scale)) is not None}
    faults = [*_layer_faults(document, placed, layers), *wrong.values()]
    faults += _frozen_on_sheets(document, closed, named)
    if not closed and not faults:
        faults = [Fault("layer", _nothing(document, placed))]
    used = [o for o in closed if id(o) not in wrong]

    idle = [name for name in layers if _key(name) not in holding]
    if (own := units.unit_name(document.units)) not in {"Unitless", "unitless", INSUNITS[unit]}:
        warnings.append(
            message(
                "$INSUNITS says {own}, the project {unit}, which is used; check the sizes", own=own, unit=unit
            )
        )
    warnings += [
        message('layer "{name}" holds no block: what the project says of it has no effect', name=name)
        for name in idle
    ]
    warnings += _left_out(placed, clipped, [o for o in outlines if not o.closed])

    return Drawing(
        tuple(block_of(o, layer_of(o, named, default), scale) for o in used),
        tuple(headed(path.name, warning) for warning in warnings),
        scale * max((o.sagitta for o in used), default=0.0),
        tuple(faults),
        tuple(
            Outline(
                scale * o.points[:, :2],
                o.source.layer,
                o.closed,
                layer_of(o, named, default).support is not None,
            )
            for o in needed
            if not o.broken and len(o.points) > 1
        ),
    )


def by_key(layers: Mapping[str, Layer]) -> dict[str, Layer]:
    """Return layers by name in the case of letters in which names are compared."""
    return {_key(name): layer for name, layer in layers.items()}


def layer_of(outline: PlacedOutline, named: Mapping[str, Layer], default: Layer) -> Layer:
    """Return the layer of an outline among those `named` by key, or the default."""
    return named.get(_key(outline.source.layer), default)


def meant_as_blocks(outlines: Sequence[PlacedOutline], layers: Mapping[str, Layer]) -> list[PlacedOutline]:
    """Return the outlines that are or should be blocks: of open ones, where layers are named, those beside blocks."""
    closed = {_key(o.source.layer) for o in outlines if o.closed}
    with_blocks = closed | {_key(name) for name in layers}
    return [o for o in outlines if not layers or not closed or _key(o.source.layer) in with_blocks]


def open_document(path: Path) -> tuple[Document, list[Message]]:
    """Return the document, repaired where that loses nothing, and warnings of that.

    Raises DrawingError where it cannot be read.
    """
    try:
        size = path.stat().st_size
        data = path.read_bytes() if 0 < size <= MOST_BYTES else b""  # what has no size may have no end
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", error)
        raise DrawingError(f"{path}: cannot be read ({why}); give the path of a DXF file") from None
    if size > MOST_BYTES:
        raise DrawingError(
            f"{path}: {size:.3g} bytes, at most {MOST_BYTES:.3g}; keep only what is to be analysed"
        )
    if data.startswith(b"AC10"):
        raise DrawingError(f"{path}: this is a DWG drawing; save it as DXF")
    if b"SECTION" not in data:
        raise DrawingError(f"{path}: this is no DXF drawing; export the drawing as DXF")
    begin = ENTITIES.search(data)
    if begin is None or END.search(data, begin.end()) is None:
        raise DrawingError(f"{path}: the file is cut off before the end of its entities; export it again")
    try:
        if data.startswith(b"AutoCAD Binary DXF"):
            document = readfile(path)  # recover mode is for text only
            auditor = document.audit()
        else:
            document, auditor = recover.read(BytesIO(data))
    except (*UNPARSED, ValueError, LookupError, TypeError, AttributeError) as error:
        why = f" ({visible(str(error))[:LONGEST_REASON]})" if isinstance(error, DXFStructureError) else ""
        raise DrawingError(f"{path}: the file is damaged{why}; export it again") from error
    faults = [*auditor.errors, *auditor.fixes]
    if fatal := [visible(fault.message)[:LONGEST_REASON] for fault in faults if fault.code in MISLEADING]:
        raise DrawingError(f"{path}: the file is damaged: {'; '.join(fatal[:3])}; export it again")
    if not faults:
        return document, []
    return document, [
        message(
            "the file was damaged and has been repaired ({count} faults, first: {found}); "
            "compare the model with the drawing",
            count=len(faults),
            found=visible(faults[0].message)[:LONGEST_REASON],
        )
    ]


def placed_outlines(
    document: Document, placed: Sequence[Placed], scale: float, sagitta: float | None, path: Path
) -> tuple[list[PlacedOutline], list[Placed]]:
    """Return the outlines of the polylines that are shown, and the polylines that clips of INSERTs hide.

    `scale`: m per drawing unit; `sagitta` in m. Raises DrawingError for more than MOST_POINTS vertices.
    """
    outlines: list[PlacedOutline] = []
    clipped, count = [], 0
    for source in placed:
        if source.hidden or not is_polyline(source.entity):
            continue
        outline = placed_outline(source, scale, sagitta)
        seen, insert = ("whole", "") if outline.broken else source.cut(outline.line)
        if seen == "nothing":
            clipped.append(source)
            continue
        if seen == "part":
            why = f"is cut by the clip of INSERT {insert}; draw what is left of it, or take the clip off"
            outline = replace(outline, broken=why)
        outlines.append(outline)
        count += len(outline.points)
        if count > MOST_POINTS:
            raise DrawingError(
                f"{path}: more than {MOST_POINTS} vertices, those of arcs included; simplify the outlines, "
                "or write a larger geometry.sagitta_m"
            )
    drawn = [(o.source, o.line) for o in outlines]
    for number, wipeout in covered(drawn, placed, document.modelspace()):
        why = f"is covered by WIPEOUT {wipeout}; delete the one or the other"
        outlines[number] = replace(outlines[number], broken=why)
    return outlines, clipped


def _layer_faults(
    document: Document, placed: Sequence[Placed], layers: Mapping[str, Layer]
) -> Iterator[Fault]:
    """Name the layers of the project that the drawing does not have or does not show."""
    names = [*(visible(layer.dxf.name) for layer in document.layers), *(p.layer for p in placed)]
    drawn = {_key(name): name for name in names}
    hidden = Counter(_key(p.layer) for p in placed if p.hidden and is_polyline(p.entity))
    for name in layers:
        if _key(name) not in drawn:
            nearest = [drawn[key] for key in get_close_matches(_key(name), drawn, n=1)]
            has = ", ".join(listed(sorted(drawn.values())))
            hint = f'did you mean "{nearest[0]}"?' if nearest else f"it has {has}"
            yield Fault("layer", f'layer "{name}" is not in the drawing; {hint}')
        elif n := hidden[_key(name)]:
            remedy = "show them, or take the layer out of the project"
            text = f'layer "{name}" has {n} polylines that are frozen, off or invisible; {remedy}'
            yield Fault("layer", text)


def _frozen_on_sheets(
    document: Document, closed: Sequence[PlacedOutline], named: Mapping[str, Layer]
) -> Iterator[Fault]:
    """Name the layers with outlines that every viewport hides, and that the project does not name."""
    views: list[Any] = [v for sheet in document.layouts for v in sheet.query("VIEWPORT") if v.dxf.id != 1]
    hidden = (
        set.intersection(*({_key(name) for name in view.frozen_layers} for view in views)) if views else ()
    )
    for name in sorted({o.source.layer for o in closed}):
        if _key(name) in hidden and _key(name) not in named:
            remedy = f'freeze it there too, or write [layers."{name}"] in the project'
            text = f'layer "{name}" is frozen in every viewport and shown in model space; {remedy}'
            yield Fault("layer", text)


def _nothing(document: Document, placed: Sequence[Placed]) -> str:
    """Describe what a drawing without polylines in model space has instead."""
    paper = [
        f'layer "{visible(e.dxf.layer)}", {e.dxftype()} {e.dxf.handle} of layout "{layout.name}"'
        for layout in document.layouts
        for e in layout
        if not layout.is_modelspace and is_polyline(e)
    ]
    if paper:
        return f"the polylines are in paper space ({paper[0]}, {len(paper)} in all); move them to model space"
    counts = Counter(("hidden " if p.hidden else "") + p.entity.dxftype() for p in placed)
    found = (
        ", ".join(listed([f"{n} {visible(kind)}" for kind, n in counts.most_common()])) or "nothing at all"
    )
    return f"nothing closed is in model space, but {found}; draw each block as one closed polyline"


def _left_out(
    placed: Sequence[Placed], clipped: Sequence[Placed], open_: Sequence[PlacedOutline]
) -> list[Message]:
    """Warn of what looks like a block and is none."""
    hidden = Counter(p.layer for p in placed if p.hidden and is_polyline(p.entity))
    warnings = [
        message(
            'layer "{name}": frozen, off or invisible polylines left out: {count}', name=name, count=count
        )
        for name, count in hidden.items()
    ]
    warnings += [
        message(
            'layer "{name}": polylines left out that clips of INSERTs hide: {count}', name=name, count=count
        )
        for name, count in Counter(p.layer for p in clipped).items()
    ]
    if open_:
        first = open_[0].source.at(*open_[0].points[[0, -1]])
        warnings.append(
            message(
                "open polylines on layers without blocks left out: {count}, first: {where}",
                count=len(open_),
                where=first,
            )
        )
    rest = [p for p in placed if not (p.hidden or is_polyline(p.entity))]
    shapes = [p for p in rest if p.entity.dxftype() in SHAPES or isinstance(p.entity, DXFTagStorage)]
    if shapes:
        kinds = Counter(p.entity.dxftype() for p in shapes)
        warnings.append(
            message(
                "left out, being no closed polylines: {found}, on layers {layers}",
                found=listed([f"{n} {visible(kind)}" for kind, n in kinds.most_common()]),
                layers=listed(sorted({p.layer for p in shapes})),
            )
        )
    return warnings


def block_of(outline: PlacedOutline, layer: Layer, scale: float) -> Block:
    """Return the block of an outline on a layer; `scale`: m per drawing unit."""
    of_layer = {field.name: getattr(layer, field.name) for field in fields(layer)}
    source = outline.source
    return Block(scale * outline.points[:, :2], **of_layer, layer=source.layer, handle=source.handle)
