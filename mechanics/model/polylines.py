"""A polyline of a drawing as an outline in the plane of the drawing, and what keeps it from being that of a block."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.entities.lwpolyline import LWPolyline
from ezdxf.entities.polyline import Polyline
from ezdxf.math import Vec3
from numpy.typing import NDArray

from mechanics.errors import Fault, Remedy
from mechanics.model.dxf import SAME_POINT, Placed, can_change, has_direction
from mechanics.types import Array, Index

SAGITTA = 1e-3  # of an arc's width: the default distance between an arc and its chords
SPLINE_FRAME = 16  # flag of a vertex that controls a spline-fitted polyline but is not on it
FARTHEST = 1e7  # m from the origin: beyond it rounding is no longer small beside a joint's tolerance
SMALLEST = 1e-6  # m: the width or height of an outline
MOST_BULGE = 1e4  # an arc that is a full circle but for a ten-thousandth of its radius
MOST_POINTS = 1_000_000  # of all outlines
MOST_VERTICES = 20_000  # of one outline: where they all are at one height the work grows with their square
FLAT = 0.01  # of an outline's size: less out of the drawing's plane changes no length by more than 5e-5
MOST_CROSSINGS = 20  # of an outline with itself, of which small loops are taken off
CHUNK = 64  # edges whose crossings are looked for at a time
SHARE = 0.25  # of the distance from a vertex to other parts of its outline: a repair moves it no farther
NOWHERE = Vec3(math.nan, math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class PlacedOutline:
    """A polyline in model space: distinct `points` (n, 3), drawing units, arcs replaced by chords within `sagitta`.

    `broken`: why there are no such points; they are then those of the file.
    """

    source: Placed
    points: Array
    closed: bool
    sagitta: float
    broken: str = ""

    @property
    def line(self) -> Array:
        """The points (m, 3) of the outline, of a closed one the first again at its end."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    def is_near(self, scale: float) -> bool:
        """Whether its points are numbers that a picture can hold; `scale`: m per drawing unit."""
        return bool((abs(self.points) <= FARTHEST / scale).all())


def is_polyline(entity: DXFGraphic) -> bool:
    """Whether an entity is a polyline; meshes of the same type are none."""
    if isinstance(entity, Polyline):
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return isinstance(entity, LWPolyline)


def placed_outline(source: Placed, scale: float, sagitta: float | None) -> PlacedOutline:
    """Place a polyline in model space, arcs as chords within `sagitta` (m; None: by width); `scale`: m per unit."""
    vertices, closed = _vertices(source.entity)
    xyz, bulges = vertices[:, :3], vertices[:, 3]

    def broken(why: str) -> PlacedOutline:
        return PlacedOutline(source, xyz, True, 0.0, why)

    if not len(vertices):
        return PlacedOutline(source, xyz, True, 0.0)
    if not has_direction(source.entity):
        return broken("has an extrusion that is no direction; draw it again")
    to_model = _to_model(source)
    with np.errstate(all="ignore"):
        placed = xyz @ to_model[:3, :3] + to_model[3, :3]
        far = float(abs(placed).max()) * scale
    if not (np.isfinite(vertices).all() and np.isfinite(placed).all()):
        return broken("has a coordinate that is no number; draw it again")
    if far > FARTHEST:
        return broken(f"lies {far:.3g} m from the origin, at most {FARTHEST:g} m; move the drawing there")
    if abs(bulges).max() > MOST_BULGE:
        return broken(f"has an arc of bulge {abs(bulges).max():.3g}, at most {MOST_BULGE:g}; draw it again")
    stretch = float(np.linalg.norm(to_model[:3, :3], 2))
    allowed = None if sagitta is None else sagitta / max(scale * stretch, 1e-99)
    counts, worst = _divisions(vertices, closed, allowed) if bulges.any() else (np.ones(len(vertices)), 0.0)
    if counts.sum() > MOST_VERTICES:
        text = f"has {counts.sum():.6g} vertices with its arcs, at most {MOST_VERTICES}"
        return broken(f"{text}; simplify it, write a larger sagitta_m, or freeze its layer if it is no block")
    points = _chords(vertices, counts.astype(np.intp)) @ to_model[:3, :3] + to_model[3, :3]
    same = SAME_POINT * float(np.ptp(points, axis=0).max())
    closed = closed or (len(points) > 2 and bool(np.linalg.norm(points[0] - points[-1]) <= same))
    distinct = points[np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) > same]
    return PlacedOutline(source, distinct if closed and len(distinct) else points, closed, worst * stretch)


def view_of(outlines: Sequence[PlacedOutline]) -> Array | None:
    """Return the axes (3, 3: along, z, normal) of the vertical plane of most drawn area; None: the XY plane."""
    areas = np.zeros((len(outlines), 3))
    for area, outline in zip(areas, outlines, strict=True):
        if outline.closed and not outline.broken and len(outline.points) > 2:
            arms = outline.points - outline.points[0]
            area[:] = 0.5 * np.cross(arms[:-1], arms[1:]).sum(axis=0)
    upright = areas[:, :2] * np.where(areas[:, :1] + 1e-9 * areas[:, 1:2] < 0.0, -1.0, 1.0)  # of one sense
    normal = upright.sum(axis=0)
    if not np.hypot(*normal) > abs(areas[:, 2]).sum():
        return None
    normal /= np.hypot(*normal)
    along = np.array([-normal[1], normal[0], 0.0])
    along *= -1.0 if along[0] + 1e-9 * along[1] < 0.0 else 1.0
    return np.stack([along, (0.0, 0.0, 1.0), np.cross(along, (0.0, 0.0, 1.0))], axis=1)


def fault_of(outline: PlacedOutline, scale: float, reach: float) -> Fault | None:
    """Describe what keeps an outline from being a block, where (text in drawing units, places in m), and what to do.

    Ends that are no farther apart than `reach` (m) can be closed, loops of less than its square (m²) taken off.
    """
    points, at, handle = outline.points, outline.source.at, outline.source.handle
    flat, line = points[:, :2], outline.line[:, :2]

    def fault(text: str, *places: Array, remedy: Remedy = "") -> Fault:
        remedy = remedy if can_change(handle) else ""
        where = np.array([p[:2] for p in places]).reshape(-1, 2)
        return Fault("outline", text, where, (line,), remedy, (handle,)).scaled(scale)

    if outline.broken:
        text = f"{at(points[0])} {outline.broken}"
        return fault(text, points[0]) if outline.is_near(scale) else Fault("outline", text)
    if not outline.closed:
        apart = float(np.linalg.norm(points[0] - points[-1]))
        what = "close it, or freeze its layer if it is no block"
        text = f"{at(points[0], points[-1])} is open, its ends {apart:.6g} apart; {what}"
        # of a thin outline the last edge may be what is missing, not what is too much
        meant = len(points) > 3 and scale * apart <= reach and _crossings(flat) <= MOST_CROSSINGS
        thin = meant and shapely.Polygon(flat).buffer(-0.5 * apart / SHARE).is_empty
        return fault(text, points[0], points[-1], remedy="close" if meant and not thin else "")
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if size and np.ptp(points[:, 2]) > FLAT * size:
        text = f"is not in the XY plane, nor in a vertical one with the others, by {np.ptp(points[:, 2]):.3g}"
        return fault(f"{at(points[0])} {text}; turn it there (ROTATE3D), or flatten it", points[0])
    if 0.0 < size * scale < SMALLEST:
        text = f"is {size * scale:.3g} m large, at least {SMALLEST:g} m; delete it or correct geometry.unit"
        return fault(f"{at(points[0])} {text}", points[0])
    polygon = shapely.Polygon(flat) if len(points) > 2 else shapely.Polygon()
    if polygon.convex_hull.area <= SAME_POINT * size**2:
        text = f"has no area, {len(points)} vertices in line; delete it or draw it again"
        return fault(f"{at(*points[:1])} {text}", *points[:1])
    if not polygon.is_valid:
        place = np.array(shapely.is_valid_reason(polygon).partition("[")[2].strip("]").split(), dtype=float)
        text = f"{at(place)} crosses or touches itself there; draw it as one simple outline"
        return fault(text, place, remedy="" if without_loops(outline, reach / scale) is None else "trim")
    return None


def without_loops(outline: PlacedOutline, reach: float) -> Array | None:
    """Return the ring (n, 3) that is left of an outline without loops and spikes of less than reach², drawing units².

    None where that is not what was meant: several large parts, a hole, more vertices than before, arcs, or more than
    MOST_CROSSINGS.
    """
    drawn = shapely.Polygon(outline.points[:, :2])
    arcs = _vertices(outline.source.entity)[0][:, 3].any()
    if drawn.is_valid or arcs or _crossings(outline.points[:, :2]) > MOST_CROSSINGS:
        return None
    parts = shapely.get_parts(shapely.make_valid(drawn, method="structure", keep_collapsed=False))
    areas = shapely.area(parts)
    if not areas.any() or areas.sum() - areas.max() > reach**2 or len(parts[areas.argmax()].interiors):
        return None
    ring = shapely.get_coordinates(shapely.get_exterior_ring(parts[areas.argmax()]))[:-1]
    if len(ring) > len(file_points(outline)):
        return None
    return np.column_stack([ring, np.full(len(ring), outline.points[0, 2])])


def _crossings(ring: Array) -> int:
    """Return how often edges of a ring (n, 2) that do not follow each other meet; it stops beyond MOST_CROSSINGS."""
    edges = shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
    tree, last, found = shapely.STRtree(edges), len(edges) - 1, 0
    for first in range(0, len(edges), CHUNK):
        one, other = tree.query(edges[first : first + CHUNK], predicate="intersects")
        apart = other - (one + first)
        found += int(((apart > 1) & (apart < last)).sum())
        if found > MOST_CROSSINGS:
            break
    return found


def file_points(outline: PlacedOutline) -> Array:
    """Return the vertices (n, 3) that the file has of an outline, in model space and drawing units."""
    vertices, _ = _vertices(outline.source.entity)
    to_model = _to_model(outline.source)
    return np.asarray(vertices[:, :3] @ to_model[:3, :3] + to_model[3, :3])


def ends_major_arc(outline: PlacedOutline) -> NDArray[np.bool_]:
    """Return which vertices (n,) of the file end an arc of more than half a circle: it moves farther than they do."""
    vertices, closed = _vertices(outline.source.entity)
    major = abs(vertices[:, 3]) > 1.0
    major[-1] &= closed
    return np.asarray(major | np.roll(major, 1))


def redraw(outline: PlacedOutline, points: Array) -> None:
    """Give the entity of an outline, in no INSERT, the vertices (n, 3) of model space in place of its own, no fewer."""
    entity: Any = outline.source.entity
    to_model = _to_model(outline.source)
    own = (points - to_model[3, :3]) @ np.linalg.inv(to_model[:3, :3])
    if isinstance(entity, LWPolyline):
        kept = entity.get_points("seb")[: len(own)]
        moved = [(x, y, *rest) for (x, y, _), rest in zip(own.tolist(), kept, strict=True)]
        entity.set_points(moved, "xyseb")
    else:
        on_it = [v for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
        for vertex, place in zip(on_it, own.tolist(), strict=False):
            vertex.dxf.location = Vec3(place)
        gone = set(map(id, on_it[len(own) :]))
        entity.vertices[:] = [v for v in entity.vertices if id(v) not in gone]
    if np.linalg.norm(points[-1] - points[0]) > SAME_POINT * float(np.ptp(points, axis=0).max()):
        entity.close(True)


def _is_flat(entity: Any) -> bool:
    """Whether a polyline is drawn in its own plane, and may have arcs."""
    return isinstance(entity, LWPolyline) or bool(entity.is_2d_polyline)


def _vertices(entity: Any) -> tuple[Array, bool]:
    """Return the vertices (n, 4: x, y, z, bulge) of a polyline as drawn, and whether they close."""
    if isinstance(entity, LWPolyline):
        found = np.asarray(entity.lwpoints.values, dtype=float).reshape(-1, 5)[:, [0, 1, 2, 4]]
        found[:, 2] = 0.0  # a width
        return found, bool(entity.closed)
    on_it = [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
    rows = [(*v.get("location", NOWHERE).xyz, v.bulge if _is_flat(entity) else 0.0) for v in on_it]
    return np.array(rows, dtype=float).reshape(-1, 4), bool(entity.is_closed)


def _to_model(source: Placed) -> Array:
    """Return the matrix (4, 4), of row vectors, from what a polyline is drawn in to model space."""
    ocs = source.entity.ocs()
    drawn_apart = ocs is not None and ocs.transform and _is_flat(source.entity)
    matrix = ocs.matrix * source.to_model if ocs is not None and drawn_apart else source.to_model
    return np.array(list(matrix)).reshape(4, 4)


def _divisions(vertices: Array, closed: bool, sagitta: float | None) -> tuple[Array, float]:
    """Return the chords (n,) that each edge of a polyline (n, 4) takes, and how far arcs are from theirs.

    Of an arc of radius R and angle θ n chords are within 2R sin²(θ/4n). An arc no deeper than allowed is one chord.
    """
    w, b = vertices[:, 0] + 1j * vertices[:, 1], abs(vertices[:, 3])
    chord = abs(np.roll(w, -1) - w)
    allowed = SAGITTA * chord * np.maximum(1.0, 0.5 * (b + 1.0 / np.maximum(b, 1.0)))
    if sagitta is not None:
        allowed = np.full(len(w), sagitta)
    deep = (chord > 0.0) & ((0.5 * b * chord > allowed) | (b > 1.0))
    deep[-1] &= closed
    flat = (chord > 0.0) & ~deep
    flat[-1] &= closed
    theta = 4.0 * np.arctan(b[deep])
    radius = 0.25 * chord[deep] * (1.0 / b[deep] + b[deep])
    counts = np.ones(len(w))
    half = np.arcsin(np.sqrt(0.5 * np.minimum(allowed[deep] / radius, 0.5)))
    counts[deep] = np.ceil(theta / (4.0 * np.maximum(half, 1e-99)))
    sagittas = [2.0 * radius * np.sin(theta / (4.0 * counts[deep])) ** 2, 0.5 * (b * chord)[flat]]
    return counts, float(np.concatenate(sagittas).max(initial=0.0))


def _chords(vertices: Array, counts: Index) -> Array:
    """Return the points (m, 3) of a polyline (n, 4: x, y, z, bulge), each edge divided into its chords.

    A bulge b is the tangent of a quarter of the arc's angle, positive with the arc right of its chord p →
    q; the point at the angle φ of the arc θ is p + (q − p) · sin ½φ / sin ½θ · exp ½i(φ − θ).
    """
    if counts.max() == 1:
        return vertices[:, :3]
    w = vertices[:, 0] + 1j * vertices[:, 1]
    edge = np.repeat(np.arange(len(w)), counts)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edge]
    theta = np.where(counts > 1, 4.0 * np.arctan(vertices[:, 3]), 1.0)[edge]
    phi = share * theta
    along = np.sin(phi / 2.0) / np.sin(theta / 2.0) * np.exp(0.5j * (phi - theta))
    points = w[edge] + (np.roll(w, -1) - w)[edge] * along
    return np.column_stack([points.real, points.imag, np.full(len(edge), vertices[0, 2])])
