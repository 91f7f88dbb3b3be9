"""What model space shows: entities where INSERTs put them, and what layers, flags, clips and states of blocks hide.

Whatever a drawing does not show is left out, or refused by name where what is meant cannot be told.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import shapely
from ezdxf.document import Drawing as Document
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.entities.insert import Insert
from ezdxf.math import Matrix44, Vec3
from ezdxf.xclip import (
    ACAD_INVERTEDCLIP_ROUNDTRIP,
    get_roundtrip_vertices,
    get_roundtrip_xrecord,
    get_spatial_filter,
)

from mechanics.errors import DrawingError
from mechanics.faults import visible
from mechanics.messages import Message, layer_key, message
from mechanics.types import Array

MOST_ENTITIES = 100_000  # of model space, those of INSERTs as often as they are inserted
DEEPEST = 30  # INSERTs within INSERTs
LONGEST_NAME = 255  # of a layer, as in DXF itself
SAME_POINT = 1e-6  # of an outline's size: vertices closer than this are one vertex

Seen = Literal["whole", "part", "nothing"]


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
        return (
            "whole"
            if (outside if self.inverted else inside)
            else ("nothing" if (inside if self.inverted else outside) else "part")
        )


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
        places = [f"({p[0]:.9g}, {p[1]:.9g})" for p in points]
        place = message("no point") if not places else places[0]
        if len(places) == 2:
            place = message("{first} and {second}", first=places[0], second=places[1])
        return message(
            'layer "{name}", {kind} {handle} at {place}',
            name=self.layer,
            kind=self.entity.dxftype(),
            handle=self.handle,
            place=place,
        )

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
        space: Iterable[Any],
        to_model: Matrix44,
        outer: str,
        above: str,
        hidden: bool,
        clips: tuple[Clip, ...],
    ) -> Iterator[Placed]:
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

            def refused(why: str, name: str = f"{path}: INSERT {handle}") -> DrawingError:
                return DrawingError(f"{name}: {why}")

            if not has_direction(entity):
                raise refused("its extrusion is no direction; insert it again")
            if handle.count("/") >= DEEPEST:
                raise refused(f"more than {DEEPEST} one in another; explode them")
            count += max(1, entity.mcount)
            if count > MOST_ENTITIES:
                raise DrawingError(
                    f"{path}: INSERT {handle} ({entity.mcount} copies): more than {MOST_ENTITIES} entities "
                    "in model space, those of INSERTs as often as they are inserted; leave out what is no block"
                )
            if not gone and _is_undecided(block, states):
                raise refused(
                    f'which parts of the dynamic block "{visible(block.name)}" its visibility state shows cannot be '
                    "told; explode it"
                )
            for single in entity.multi_insert() if entity.mcount > 1 else [entity]:
                inner = single.matrix44() * to_model
                try:
                    clip = _clip_of(entity, inner, handle)
                except DrawingError as error:
                    raise refused(f"{error}; explode it and trim it") from None
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
    corners = [(v.x, v.y) for v in kept.boundary_vertices]
    record = get_roundtrip_xrecord(kept)
    inverted = record is not None and record.has_section(ACAD_INVERTEDCLIP_ROUNDTRIP)
    rings = [corners]
    if record is not None and inverted:
        inner = get_roundtrip_vertices(record, ACAD_INVERTEDCLIP_ROUNDTRIP, Matrix44())
        rings.append([(v.x, v.y) for v in inner])
    polygons = [_polygon(ring) for ring in rings]
    polygon = min(polygons, key=lambda each: float(each.area))  # of an inverted one the hole
    if kept.dxf.has_front_clipping_plane or kept.dxf.has_back_clipping_plane:
        raise DrawingError("is clipped in depth")
    try:
        back = [np.array(list(m)).reshape(4, 4) for m in (to_model, kept.inverse_insert_matrix)]
        own = np.array(list(kept.transform_matrix)).reshape(4, 4)
        to_clip = np.linalg.inv(back[0]) @ np.linalg.inv(back[1]) @ own
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
    """Yield the number of each of the outlines (n, 3) that a WIPEOUT drawn over it covers, and the handle of that.

    `view` (3, 3): the axes of the drawing's plane, in columns, in which the outlines are.
    """
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
