"""A DXF file as a document: what can be read without loss is; and its entities as model space shows them."""

from __future__ import annotations

import logging
import re
import struct
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any, Literal

import numpy as np
import shapely
from ezdxf import recover
from ezdxf._options import options
from ezdxf.audit import AuditError
from ezdxf.document import Drawing as Document
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.entities.insert import Insert
from ezdxf.filemanagement import readfile
from ezdxf.lldxf.const import DXFError, DXFStructureError
from ezdxf.math import Matrix44, Vec3
from ezdxf.render.arrows import _Arrows
from ezdxf.xclip import (
    ACAD_INVERTEDCLIP_ROUNDTRIP,
    get_roundtrip_vertices,
    get_roundtrip_xrecord,
    get_spatial_filter,
)

from mechanics.errors import DrawingError
from mechanics.messages import Message, layer_key, message, visible
from mechanics.types import Array

MOST_BYTES = 200_000_000  # of a file: some 20 000 blocks take ten
LONGEST_REASON = 300  # letters of a message of ezdxf
ENTITIES = re.compile(rb"[2\x02][\s\x00]*ENTITIES[\s\x00]")
END = re.compile(rb"ENDSEC|SECTION|EOF")
UNPARSED = (DXFError, OSError, struct.error, AssertionError, StopIteration, ArithmeticError, RecursionError)
MISLEADING = {AuditError.INVALID_FLOATING_POINT_VALUE, AuditError.INVALID_BLOCK_REFERENCE_CYCLE}
VERSION = re.compile(rb"(\$ACADVER\s+1\s+)(AC\d+)")
HEADER = re.compile(rb"(?m)^([ \t]*2[ \t]*\r?\n[ \t]*HEADER[ \t]*\r?\n)")
# an LWPOLYLINE and its pairs of group code and value
LWPOLYLINE = re.compile(
    rb"(?m)^([ \t]*0[ \t]*\r?\n[ \t]*LWPOLYLINE[ \t]*\r?\n)((?:[ \t]*[1-9]\d*[ \t]*\r?\n[^\n]*\n)*)"
)
OF_DATABASE = {5, 102, 330, 360}  # group codes of what any entity has, before those of its kind
OF_ENTITY = {8, 6, 62, 48, 60, 67, 370, 420, 430, 440, 347, 348, 390, 410, 284, 92, 160, 310}
R13, R2000 = b"AC1012", b"AC1015"  # the first version with subclasses, and what older ones are read as
MOST_ENTITIES = 100_000  # of model space, those of INSERTs as often as they are inserted
DEEPEST = 30  # INSERTs within INSERTs
LONGEST_NAME = 255  # of a layer, as in DXF itself
SAME_POINT = 1e-6  # of an outline's size: vertices closer than this are one vertex

Seen = Literal["whole", "part", "nothing"]


_Arrows.__acad__ = dict.fromkeys(sorted(_Arrows.__acad__))  # type: ignore[assignment]  # a set: handles by chance
# its findings are reported here, in our own words
logging.getLogger("ezdxf").addHandler(logging.NullHandler())


def open_document(path: Path) -> tuple[Document, list[Message]]:
    """Return the document, repaired where that loses nothing, and warnings. Raises DrawingError if unreadable."""
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
    warnings: list[Message] = []
    try:
        if data.startswith(b"AutoCAD Binary DXF"):
            document = readfile(path)  # recover mode is for text only
            auditor = document.audit()
        else:
            data, warnings = _as_of_today(data if b"\n" in data else data.replace(b"\r", b"\n"))
            document, auditor = recover.read(BytesIO(data))
    except (*UNPARSED, ValueError, LookupError, TypeError, AttributeError) as error:
        why = f" ({visible(str(error))[:LONGEST_REASON]})" if isinstance(error, DXFStructureError) else ""
        raise DrawingError(f"{path}: the file is damaged{why}; export it again") from error
    faults = [*auditor.errors, *auditor.fixes]
    if warnings:  # older tables have no handles
        faults = [fault for fault in faults if fault.code != AuditError.INVALID_TABLE_HANDLE]
    if fatal := [visible(fault.message)[:LONGEST_REASON] for fault in faults if fault.code in MISLEADING]:
        raise DrawingError(f"{path}: the file is damaged: {'; '.join(fatal[:3])}; export it again")
    if faults:
        repaired = message(
            "the file was damaged and has been repaired ({count} faults, first: {found}); "
            "compare the model with the drawing",
            count=len(faults), found=visible(faults[0].message)[:LONGEST_REASON],
        )  # fmt: skip
        warnings.append(repaired)
    return document, warnings


@contextmanager
def reproducible() -> Iterator[None]:
    """Documents made or written within the context have no times and no random identifiers: the same each time."""
    before, options.write_fixed_meta_data_for_testing = options.write_fixed_meta_data_for_testing, True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def dxf_bytes(document: Document) -> bytes:
    """Return a document as a DXF text file."""
    text = StringIO()
    document.write(text)
    return text.getvalue().encode(document.output_encoding, errors="dxfreplace")


def _as_of_today(data: bytes) -> tuple[bytes, list[Message]]:
    """Return a text file with its LWPOLYLINEs as R2000 has them, which some programs write otherwise, and a warning."""
    named = VERSION.search(data)
    old = named is None or named[2] < R13
    if not (old or b"AcDbPolyline" not in data or data.count(b"LWPOLYLINE") > data.count(b"AcDbPolyline")):
        return data, []
    changed = 0

    def marked(found: re.Match[bytes]) -> bytes:
        nonlocal changed
        lines = found[2].split(b"\n")
        pairs = [(int(code), value) for code, value in zip(lines[:-1:2], lines[1::2], strict=True)]
        if not old and any(code == 100 and value.strip() == b"AcDbPolyline" for code, value in pairs):
            return found[0]
        changed += 1
        own = [pair for pair in pairs if pair[0] != 100]
        base = [pair for pair in own if pair[0] in OF_DATABASE]
        common = [pair for pair in own if pair[0] in OF_ENTITY]
        rest = [pair for pair in own if pair[0] not in OF_DATABASE | OF_ENTITY]
        whole = [*base, (100, b"AcDbEntity"), *common, (100, b"AcDbPolyline"), *rest]
        return found[1] + b"".join(b"%d\n%s\n" % pair for pair in whole)

    data = LWPOLYLINE.sub(marked, data)
    if not changed:
        return data, []
    variable = b"  9\n$ACADVER\n  1\n" + R2000 + b"\n"
    if named and old:
        data = VERSION.sub(rb"\g<1>" + R2000, data, count=1)
    elif named is None and HEADER.search(data):
        data = HEADER.sub(rb"\g<1>" + variable.replace(b"\\", b""), data, count=1)
    elif named is None:
        data = b"  0\nSECTION\n  2\nHEADER\n" + variable + b"  0\nENDSEC\n" + data
    told = message(
        "LWPOLYLINEs without their subclass, or in a file of version {version}: {count}, read as what they are",
        version=named[2].decode() if named else "–", count=changed,
    )  # fmt: skip
    return data, [told]


@dataclass(frozen=True, eq=False)
class Clip:
    """The boundary of an XCLIP: what lies in its `polygon` is shown, or, `inverted`, what does not.

    `to_clip` (4, 4): from model space to the plane of the polygon, of row vectors; `insert`: the handle of its INSERT.
    """

    polygon: shapely.Polygon
    to_clip: Array
    inverted: bool
    insert: str

    def seen(self, points: Array) -> Seen:
        """Return how much is shown of the outline of points (n, 3) of model space."""
        flat = (points @ self.to_clip[:3, :3] + self.to_clip[3, :3])[:, :2]
        slack = SAME_POINT * float(max(np.ptp(flat, axis=0).max(), 1e-300))
        line = shapely.linestrings(flat) if len(flat) > 1 else shapely.points(flat)[0]
        inside = bool(shapely.covers(self.polygon.buffer(slack), line))
        outside = not shapely.intersects(self.polygon.buffer(-slack), line)
        shown, hidden = (outside, inside) if self.inverted else (inside, outside)
        return "whole" if shown else "nothing" if hidden else "part"


@dataclass(frozen=True, slots=True)
class Placed:
    """An entity as model space shows it, inside INSERTs or not; `handle` is INSERT/…/entity.

    `hidden`: by its layer or its flag, or those of an INSERT around it; `clips`: those of the INSERTs around it.
    """

    entity: DXFGraphic
    to_model: Matrix44
    layer: str
    handle: str
    hidden: bool
    clips: tuple[Clip, ...] = ()

    def at(self, *points: Array) -> Message:
        """Return layer, type, handle and coordinates (drawing units) of none, one or two points, for a message."""
        told = np.where(abs(np.array(points)) < 1e-9, 0.0, points)  # what rounding leaves of 0 is 0
        places = [f"({x:.9g}, {y:.9g})" for x, y, *_ in told]
        place = message("no point") if not places else places[0]
        if len(places) == 2:
            place = message("{first} and {second}", first=places[0], second=places[1])
        return message(
            'layer "{name}", {kind} {handle} at {place}', name=self.layer, kind=self.entity.dxftype(),
            handle=self.handle, place=place,
        )  # fmt: skip

    def cut(self, points: Array) -> tuple[Seen, str]:
        """Return how much clips show of an outline of points (n, 3), and the INSERT whose clip takes the most away."""
        found = sorted((clip.seen(points), clip.insert) for clip in self.clips)  # nothing, part, whole
        return found[0] if found else ("whole", "")


def has_direction(entity: DXFGraphic) -> bool:
    """Whether the extrusion of an entity, the normal of its own axes, has a direction."""
    size = Vec3(entity.dxf.get("extrusion", Vec3(0.0, 0.0, 1.0))).magnitude
    return SAME_POINT < size < 1.0 / SAME_POINT


def can_change(handle: str) -> bool:
    """Whether the entity of a handle is an outline of its own: not one in an INSERT, or cut into blocks."""
    return bool(handle) and not set(handle) & set("/:")


def placed_entities(document: Document, path: Path) -> list[Placed]:
    """Return all entities of model space, those inside INSERTs where these put them.

    Raises DrawingError for more than MOST_ENTITIES, and naming an INSERT that has no place, or of which it cannot be
    told what it shows.
    """
    off = {layer_key(layer.dxf.name) for layer in document.layers if layer.is_off()}
    frozen = {layer_key(layer.dxf.name) for layer in document.layers if layer.is_frozen()}
    states = _visibility_states(document)
    count = 0

    def place(
        space: Iterable[Any], to_model: Matrix44, outer: str, above: str, hidden: bool,
        clips: tuple[Clip, ...],
    ) -> Iterator[Placed]:  # fmt: skip
        nonlocal count
        for entity in space:
            own = entity.graphic_properties().get("layer", "0")
            layer = outer if own == "0" else unicodedata.normalize("NFC", visible(own)[:LONGEST_NAME])
            handle = f"{above}{entity.dxf.handle}"
            gone = hidden or _is_invisible(entity) or layer_key(layer) in frozen
            block = entity.block() if isinstance(entity, Insert) else None
            if block is None or block.block is None or block.block.is_xref:
                count += 1
                yield Placed(entity, to_model, layer, handle, gone or layer_key(layer) in off, clips)
                continue

            refused = f"{path}: INSERT {handle}"
            if not has_direction(entity):
                raise DrawingError(f"{refused}: its extrusion is no direction; insert it again")
            if handle.count("/") >= DEEPEST:
                raise DrawingError(f"{refused}: more than {DEEPEST} one in another; explode them")
            count += max(1, entity.mcount)
            if count > MOST_ENTITIES:
                raise DrawingError(
                    f"{refused} ({entity.mcount} copies): more than {MOST_ENTITIES} entities "
                    "in model space, those of INSERTs as often as they are inserted; leave out what is no block"
                )
            if not gone and _is_undecided(block, states):
                text = f'which parts of the dynamic block "{visible(block.name)}" its visibility state shows'
                raise DrawingError(f"{refused}: {text} cannot be told; explode it")
            for single in entity.multi_insert() if entity.mcount > 1 else [entity]:
                inner = single.matrix44() * to_model
                try:
                    clip = _clip_of(entity, inner, handle)
                except DrawingError as error:
                    raise DrawingError(f"{refused}: {error}; explode it and trim it") from None
                yield from place(block, inner, layer, f"{handle}/", gone, (*clips, *clip))

    return list(place(document.modelspace(), Matrix44(), "0", "", hidden=False, clips=()))


def _is_invisible(entity: DXFGraphic) -> bool:
    return bool(entity.dxf.hasattr("invisible") and entity.dxf.invisible)


def _clip_of(insert: Insert, to_model: Matrix44, handle: str) -> list[Clip]:
    """Return the clip of an INSERT, none where it has none that is switched on.

    A point of the block, taken by the INSERT as it was when it was clipped and then by the filter's own matrix, lies in
    the plane of the boundary. Raises DrawingError for a clip that is no polygon in the plane of the block.
    """
    kept = get_spatial_filter(insert)
    if kept is None or not kept.dxf.is_clipping_enabled:
        return []
    if insert.mcount > 1:
        raise DrawingError("is an array with a clip")
    rings, record = [list(kept.boundary_vertices)], get_roundtrip_xrecord(kept)
    inverted = record is not None and record.has_section(ACAD_INVERTEDCLIP_ROUNDTRIP)
    if record is not None and inverted:
        rings.append(list(get_roundtrip_vertices(record, ACAD_INVERTEDCLIP_ROUNDTRIP, Matrix44())))
    polygons = [_polygon([(v.x, v.y) for v in ring]) for ring in rings]
    polygon = min(polygons, key=lambda each: float(each.area))  # of an inverted one the hole
    if kept.dxf.has_front_clipping_plane or kept.dxf.has_back_clipping_plane:
        raise DrawingError("is clipped in depth")
    try:
        matrices = (to_model, kept.inverse_insert_matrix, kept.transform_matrix)
        placed, back, own = (np.array(list(m)).reshape(4, 4) for m in matrices)
        to_clip = np.linalg.inv(placed) @ np.linalg.inv(back) @ own
    except np.linalg.LinAlgError:
        raise DrawingError("has a clip, and no extent") from None
    if not (polygon.area > 0.0 and polygon.is_valid and np.isfinite(to_clip).all()):
        raise DrawingError("has a clip whose boundary is no polygon")
    return [Clip(polygon, to_clip, inverted, handle)]


def _polygon(corners: list[tuple[float, float]]) -> shapely.Polygon:
    """Return the polygon of corners, of two of them the rectangle."""
    if len(corners) == 2:
        return shapely.box(*np.min(corners, axis=0), *np.max(corners, axis=0))
    return shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()


def _visibility_states(document: Document) -> dict[str, list[set[str]]]:
    """Return, for each entity whose dynamic block has visibility states, the entities that each of them shows."""
    found: dict[str, list[set[str]]] = {}
    parameters: Iterable[Any] = document.objects.query("BLOCKVISIBILITYPARAMETER")
    for parameter in parameters:
        states: list[set[str]] = []
        governed: set[str] = set()
        for subclass in parameter.xtags.subclasses:
            for code, value in subclass:
                if code == 303:  # the name of a state; its entities follow
                    states.append(set())
                elif code == 331:
                    governed.add(value)
                elif code == 332 and states:
                    states[-1].add(value)
        found |= dict.fromkeys(governed.union(*states), states)
    return found


def _is_undecided(block: Any, states: dict[str, list[set[str]]]) -> bool:
    """Whether a block has visibility states, and what is flagged as invisible in it is none of them."""
    governed = {e.dxf.handle: e for e in block if e.dxf.handle in states} if states else {}
    if not governed:
        return False
    shown = {handle for handle, entity in governed.items() if not _is_invisible(entity)}
    return all(shown != state & governed.keys() for state in states[next(iter(governed))])


def covered(
    outlines: Iterable[tuple[Placed, Array]], placed: Sequence[Placed], space: Any, view: Array
) -> Iterator[tuple[int, str]]:
    """Yield each of the outlines (n, 3), by number, that a WIPEOUT covers in the `view` (3, 3), and its handle."""
    wipeouts = [p for p in placed if p.entity.dxftype() == "WIPEOUT" and not p.hidden]
    if not wipeouts:
        return
    order = {entity.dxf.handle: k for k, entity in enumerate(space.entities_in_redraw_order())}
    place = {p.handle: (order.get(p.handle.partition("/")[0], 0), k) for k, p in enumerate(placed)}
    rings = []
    for wipeout in wipeouts:
        entity: Any = wipeout.entity
        corners = wipeout.to_model.transform_vertices(entity.boundary_path_wcs())
        rings.append(_polygon((np.array([v.xyz for v in corners]) @ view)[:, :2].tolist()))
    for number, (source, points) in enumerate(outlines):
        for wipeout, ring in zip(wipeouts, rings, strict=True):
            over = place[wipeout.handle] > place[source.handle]
            if over and ring.is_valid and ring.covers(shapely.LineString(points[:, :2])):
                yield number, wipeout.handle
                break
