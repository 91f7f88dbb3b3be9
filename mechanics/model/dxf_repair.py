"""A drawing with small faults, repaired: a copy of the document in which outlines are closed, single, and touch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import numpy as np
import shapely
from ezdxf.document import Drawing as Document
from scipy.spatial import cKDTree

from mechanics.errors import DrawingError
from mechanics.faults import FaultyDrawingError
from mechanics.model.block import Block
from mechanics.model.dxf import (
    METRES,
    Layer,
    block_of,
    by_key,
    layer_of,
    meant_as_blocks,
    open_document,
    placed_outlines,
)
from mechanics.model.fitting import SHARE, Fitting, Flags
from mechanics.model.joints import default_tolerance
from mechanics.model.model_checks import NEAR, misfits
from mechanics.model.overlaps import name_of, place_of
from mechanics.model.polylines import (
    PlacedOutline,
    ends_major_arc,
    fault_of,
    file_points,
    has_arcs,
    redraw,
)
from mechanics.model.shown import SAME_POINT, placed_entities
from mechanics.types import Array

ROUNDS = 60  # of fitting all pairs: a vertex that is moved may open the next joint; up to 30 were seen
FINE = 0.1  # of the tolerance: less is no misfit in a drawing that is repaired


@dataclass(frozen=True)
class Repair:
    """A repaired drawing: the DXF file, and a line for each of its `changes`."""

    file: bytes
    changes: tuple[str, ...]


@dataclass(frozen=True)
class _Plan:
    """The `document` as it is now, and how its outlines become blocks.

    `scale`: m per drawing unit; `layers`: by key, see dxf.by_key; `sagitta` (m): of the chords of arcs.
    """

    document: Document
    path: Path
    scale: float
    default: Layer
    layers: Mapping[str, Layer]
    sagitta: float | None

    def outlines(self) -> list[PlacedOutline]:
        """Return the outlines that are or should be blocks."""
        entities = placed_entities(self.document, self.path)
        outlines, _ = placed_outlines(self.document, entities, self.scale, self.sagitta, self.path)
        return meant_as_blocks(outlines, self.layers)

    def blocks(self) -> tuple[list[PlacedOutline], list[Block]]:
        """Return the outlines without faults, and their blocks."""
        used = [o for o in self.outlines() if fault_of(o, self.scale) is None]
        return used, [block_of(o, self.layer(o), self.scale) for o in used]

    def layer(self, outline: PlacedOutline) -> Layer:
        """Return what the layer of an outline says of its block."""
        return layer_of(outline, self.layers, self.default)


def repair_drawing(
    path: str | Path,
    unit: str,
    default: Layer,
    layers: Mapping[str, Layer] = {},
    sagitta: float | None = None,
    tolerance: float | None = None,
) -> Repair:
    """Return a drawing repaired where it is clear what was meant; the arguments are those of `read_drawing`.

    With a reach of `NEAR` tolerances: an outline whose ends are less apart is closed; one that crosses itself by a
    smaller loop loses it; of outlines drawn more than once in one role the first is kept; where blocks overlap by less,
    or face each other across less, vertices are moved onto vertices or onto edges. `tolerance` (m) is that of the
    joints, default a thousandth of the median edge. What is inside an INSERT is not changed. What was mended to read a
    damaged file is the first line.

    Raises DrawingError where the file cannot be read, or is too large or too fine for the search.
    """
    document, damage = open_document(Path(path))
    plan = _Plan(document, Path(path), METRES[unit], default, by_key(layers), sagitta)
    tolerance = tolerance or _default_tolerance(plan)
    reach = NEAR * tolerance
    changes = [*_close(plan, reach), *_uncross(plan, reach)]
    try:
        if plan.blocks()[1]:
            changes += [*_keep_one(plan, tolerance), *_fit(plan, tolerance, reach)]
            changes += _keep_one(plan, tolerance)
    except FaultyDrawingError as faulty:
        raise FaultyDrawingError(str(path), faulty.faults, faulty.outlines) from None
    changes = [*damage, *changes] if changes else []
    text = StringIO()
    document.write(text)
    return Repair(text.getvalue().encode(document.output_encoding, errors="dxfreplace"), tuple(changes))


def _default_tolerance(plan: _Plan) -> float:
    """Return the default tolerance (m) of the joints of what are blocks already; raise DrawingError if nothing is."""
    _, blocks = plan.blocks()
    if not blocks:
        raise DrawingError(
            f"{plan.path}: no outline is a block; write geometry.tolerance_m to have it repaired"
        )
    return default_tolerance(blocks)


def _can_change(outline: PlacedOutline) -> bool:
    """Whether an outline can be drawn again: not one inside an INSERT, which may stand at several places."""
    return not outline.broken and "/" not in outline.source.handle


def _close(plan: _Plan, reach: float) -> Iterator[str]:
    """Close outlines whose ends are less than `reach` (m) apart; yield a line for each."""
    for outline in plan.outlines():
        if outline.closed or not _can_change(outline) or len(points := file_points(outline)) < 4:
            continue
        apart = float(np.linalg.norm(points[0] - points[-1]))
        # of a thin outline the last edge may be what is missing, not what is too much
        thin = shapely.Polygon(outline.points[:, :2]).buffer(-0.5 * apart / SHARE).is_empty
        if plan.scale * apart <= reach and not thin:
            redraw(outline, points[:-1])
            where, way = outline.source.at(points[0], points[-1]), f"{1e3 * plan.scale * apart:.3g} mm"
            yield f"{where}: closed, its ends were {way} apart; the last vertex is deleted"


def _uncross(plan: _Plan, reach: float) -> Iterator[str]:
    """Take loops and spikes of less than `reach`² (m²) off outlines that cross themselves; yield a line for each."""
    for outline in plan.outlines():
        if not (outline.closed and _can_change(outline)) or len(outline.points) < 3 or has_arcs(outline):
            continue
        drawn, size = shapely.Polygon(outline.points[:, :2]), np.ptp(outline.points, axis=0)
        if drawn.is_valid or size[2] > SAME_POINT * size.max():  # refused where it is not plane
            continue
        parts = shapely.get_parts(shapely.make_valid(drawn, method="structure", keep_collapsed=False))
        areas = plan.scale**2 * shapely.area(parts)
        if not areas.any() or areas.sum() - areas.max() > reach**2 or len(parts[areas.argmax()].interiors):
            continue
        ring = shapely.get_coordinates(shapely.get_exterior_ring(parts[areas.argmax()]))[:-1]
        if len(ring) <= len(file_points(outline)):
            height = np.full(len(ring), outline.points[0, 2])
            redraw(outline, np.column_stack([ring, height]))
            yield f"{outline.source.at(outline.points[0])}: a loop or spike where it crossed itself is taken off"


def _keep_one(plan: _Plan, tolerance: float) -> Iterator[str]:
    """Delete copies of outlines; yield a line for each."""
    used, blocks = plan.blocks()
    overlaps, _ = misfits(blocks, tolerance, NEAR * tolerance)
    for copy, original in enumerate(overlaps.original.tolist()):
        if original < 0 or not _can_change(used[copy]):
            continue
        # which of two layers with different properties was meant is not clear
        if plan.layer(used[copy]) == plan.layer(used[original]):
            plan.document.modelspace().delete_entity(used[copy].source.entity)
            where = used[copy].source.at(used[copy].points[0])
            yield f"{where}: deleted, the same outline as {blocks[original].handle}"


def _fit(plan: _Plan, tolerance: float, reach: float) -> Iterator[str]:
    """Move vertices of blocks that overlap or leave a gap; yield a line for each vertex."""
    used, blocks = plan.blocks()
    if not len(misfits(blocks, tolerance, reach)[1]):
        return
    drawn = [plan.scale * o.points[:, :2] for o in used]
    fitting = Fitting(drawn, [_movable(o) for o in used], reach, tolerance)
    for _ in range(ROUNDS):
        now = [replace(block, vertices=fitting.outline(i)) for i, block in enumerate(blocks)]
        pairs = misfits(now, FINE * tolerance, reach)[1].tolist()
        # a support stays where it is if the other can be moved; every pair is tried in each round
        moved = [fitting.fit(*sorted(pair, key=lambda i: (now[i].support is None, i))) for pair in pairs]
        if not any(moved):
            break
    for i, outline in enumerate(used):
        yield from _moved(
            outline, name_of(blocks, i), drawn[i], fitting.outline(i), plan.scale, fitting.exact
        )


def _moved(
    outline: PlacedOutline, name: str, drawn: Array, fitted: Array, scale: float, exact: float
) -> Iterator[str]:
    """Redraw an outline whose points (k, 2) m were `drawn` and are `fitted`; yield a line for each that has moved."""
    way = np.linalg.norm(fitted - drawn, axis=1)
    points = file_points(outline)
    for k in np.flatnonzero(way > exact):
        points[np.linalg.norm(points - outline.points[k], axis=1) <= _same(outline), :2] = fitted[k] / scale
        yield f"{name}: vertex at {place_of(drawn[k])} moved by {1e3 * way[k]:.3g} mm to {place_of(fitted[k])}"
    if (way > exact).any():
        redraw(outline, points)


def _movable(outline: PlacedOutline) -> Flags:
    """Whether each point of an outline is a vertex that can be moved: none that divides an arc or ends a major one."""
    apart, nearest = cKDTree(file_points(outline)).query(outline.points)
    return np.asarray((apart <= _same(outline)) & ~ends_major_arc(outline)[nearest] & _can_change(outline))


def _same(outline: PlacedOutline) -> float:
    """Return the distance, drawing units, up to which vertices of an outline are one."""
    return SAME_POINT * float(np.ptp(outline.points, axis=0).max())
