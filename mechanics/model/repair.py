"""A drawing with small faults, repaired: the remedies of what a survey finds, applied to a copy of the document."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from scipy.spatial import cKDTree

from mechanics.errors import DrawingError, FaultyDrawingError
from mechanics.model.block import Block, default_tolerance, following, preceding, ring_edges
from mechanics.model.drawing import Layer, Sheet
from mechanics.model.dxf import SAME_POINT, can_change, dxf_bytes, reproducible
from mechanics.model.layout import NEAR, misfits, name_of, place_of, survey_layout, touching
from mechanics.model.polylines import SHARE, PlacedOutline, ends_major_arc, file_points, redraw, without_loops
from mechanics.types import Array, Index, Mask

FIRST = 2.0  # times what blocks are apart in the median: how far vertices are moved at first, then twice as far, …
# rounds of fitting all pairs that make nothing better: a vertex that is moved may open the next joint
IDLE = 5
FINE = 0.1  # of the tolerance: less is no misfit in a drawing that is repaired
EXACT = 1e-12  # of the outlines' extent: vertices closer than this are at one place
CHUNK = 1000  # vertices whose distances are found at a time


@dataclass(frozen=True)
class Repair:
    """A repaired drawing: the DXF file, and a line for each of its `changes`."""

    file: bytes
    changes: tuple[str, ...]


def repair_drawing(
    path: str | Path, unit: str, default: Layer, layers: Mapping[str, Layer] = {},
    sagitta: float | None = None, tolerance: float | None = None,
) -> Repair:  # fmt: skip
    """Return a drawing repaired where it is clear what was meant; the arguments are those of `survey_drawing`.

    Within `NEAR` tolerances ends of outlines are closed, loops taken off, and vertices moved onto those or the edges of
    blocks that they overlap or leave a gap to; of outlines drawn twice in one role the first is kept. No blocks that
    touch lose their joint, none come to overlap or to leave a gap; what is inside an INSERT is not changed. Raises
    DrawingError where the file cannot be read, or is too large or too fine for the search.
    """
    sheet = Sheet.of(path, unit, default, layers, sagitta, tolerance)
    if not sheet.reach:
        raise DrawingError(f"{path}: no outline is a block; write geometry.tolerance_m to have it repaired")
    changes: list[str] = []
    try:
        for mend in (_outlines, _copies, _fit, _copies):
            while found := list(mend(sheet)):
                changes += found
                sheet = replace(sheet)  # of the document as it is now
                if mend is _fit:
                    break
    except FaultyDrawingError as faulty:
        raise FaultyDrawingError(str(path), faulty.faults, sheet.drawing.outlines) from None
    with reproducible():
        return Repair(dxf_bytes(sheet.document), (*sheet.damage, *changes) if changes else ())


def _outlines(sheet: Sheet) -> Iterator[str]:
    """Close outlines and take loops off them; yield a line for each."""
    for outline in sheet.outlines:
        fault = sheet.wrong.get(outline.source.handle)
        if fault is None or not fault.remedy:
            continue
        points, at = file_points(outline), outline.source.at
        if fault.remedy == "close":
            redraw(outline, points[:-1])
            way = 1e3 * sheet.scale * float(np.linalg.norm(points[0] - points[-1]))
            where = at(points[0], points[-1])
            yield f"{where}: closed, its ends were {way:.3g} mm apart; the last vertex is deleted"
        elif (
            fault.remedy == "trim" and (ring := without_loops(outline, sheet.reach / sheet.scale)) is not None
        ):
            redraw(outline, ring)
            yield f"{at(outline.points[0])}: a loop or spike where it crossed itself is taken off"


def _copies(sheet: Sheet) -> Iterator[str]:
    """Delete copies of outlines; yield a line for each."""
    if not (blocks := sheet.drawing.blocks):
        return
    sources = {o.source.handle: o for o in sheet.sources}
    for fault in survey_layout(blocks, sheet.tolerance or default_tolerance(blocks), whole=False).faults:
        if fault.kind == "short":
            raise FaultyDrawingError("", [fault])
        for handle in fault.handles[1:] if fault.remedy == "delete" else ():
            outline = sources[handle]
            sheet.document.modelspace().delete_entity(outline.source.entity)
            where = outline.source.at(outline.points[0])
            yield f"{where}: deleted, the same outline as {fault.handles[0]}"


def _fit(sheet: Sheet) -> Iterator[str]:
    """Move vertices of blocks that overlap or leave a gap; yield a line for each vertex."""
    blocks, sources = sheet.drawing.blocks, sheet.sources
    if not blocks:
        return
    tolerance = sheet.tolerance or default_tolerance(blocks)
    reach = NEAR * tolerance
    pairs, wide = misfits(blocks, tolerance, reach)
    if not len(pairs):
        return
    joined, wrong = touching(blocks, tolerance), set(map(tuple, pairs.tolist()))
    drawn = [sheet.scale * o.points[:, :2] for o in sources]
    fitting = Fitting(drawn, [_movable(o) for o in sources], reach, tolerance)

    def fitted() -> list[Block]:
        return [replace(block, vertices=fitting.outline(i)) for i, block in enumerate(blocks)]

    within = float(np.median(wide))
    while within < reach and len(wide):
        within = min(FIRST * within, reach)
        least, idle = np.inf, 0
        while idle < IDLE:
            now = fitted()
            pairs, wide = misfits(now, FINE * tolerance, reach)
            least, idle = min(least, wide.sum()), 0 if wide.sum() < least else idle + 1
            moved = False
            for i, j in pairs.tolist():  # a support stays where it is if the other can be moved
                pair = (j, i) if now[j].support and not now[i].support else (i, j)
                moved |= fitting.fit(*pair, within)
            if not moved:
                break
    while True:  # nothing is worse than before
        now = fitted()
        lost = joined - touching(now, tolerance)
        lost |= set(map(tuple, misfits(now, tolerance, reach)[0].tolist())) - wrong
        if not fitting.restore({block for pair in lost for block in pair}):
            break
    for i, outline in enumerate(sources):
        yield from _moved(
            outline, name_of(blocks, i), drawn[i], fitting.outline(i), sheet.scale, fitting.exact
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


def _movable(outline: PlacedOutline) -> Mask:
    """Whether each point of an outline is a vertex that can be moved: none that divides an arc or ends a major one."""
    apart, nearest = cKDTree(file_points(outline)).query(outline.points)
    free = (apart <= _same(outline)) & ~ends_major_arc(outline)[nearest]
    return np.asarray(free & can_change(outline.source.handle))


def _same(outline: PlacedOutline) -> float:
    """Return the distance, drawing units, up to which vertices of an outline are one."""
    return SAME_POINT * float(np.ptp(outline.points, axis=0).max())


class Fitting:
    """Outlines whose vertices are moved by at most `reach` (m); what touches within the `tolerance` (m) stays together.

    `points` (n, 2) m: all vertices; `owner` (n,): their outlines; `free` (n,): whether a vertex may be moved; `room`
    (n,) m: how far. That is less than the reach where an outline is thin or has short edges, which would be deformed.
    """

    def __init__(
        self, outlines: Sequence[Array], free: Sequence[Mask], reach: float, tolerance: float
    ) -> None:
        self.points, _, self.owner = ring_edges(outlines)
        self.drawn, self.tree, self.free = self.points.copy(), cKDTree(self.points), np.concatenate(free)
        self.first = np.searchsorted(self.owner, np.arange(len(outlines) + 1))
        self.reach, self.tolerance = reach, tolerance
        self.exact = EXACT * float(np.ptp(self.points, axis=0).max())
        self.room = np.minimum(reach, SHARE * self._clearance(reach / SHARE))

    def outline(self, index: int) -> Array:
        """Return an outline (k, 2) m as it is now."""
        return self.points[self.first[index] : self.first[index + 1]]

    def restore(self, outlines: set[int]) -> bool:
        """Draw outlines as they were; return whether any of them had been changed."""
        of = np.isin(self.owner, list(outlines))
        changed = bool((self.points[of] != self.drawn[of]).any())
        self.points[of] = self.drawn[of]
        return changed

    def _clearance(self, most: float) -> Array:
        """Return distances (n,) m, at most `most`, of vertices from their outline beyond the tolerance."""
        along, after, before = np.arange(len(self.points)), following(self.owner), preceding(self.owner)
        edges = shapely.linestrings(np.stack([self.points, self.points[after]], axis=1))
        corners, tree = shapely.points(self.points), shapely.STRtree(edges)
        clearance = np.full(len(self.points), most)

        def take_least(where: Index, values: Array) -> None:
            counts = values > self.tolerance
            np.minimum.at(clearance, where[counts], values[counts])

        for first in range(0, len(self.points), CHUNK):
            k, edge = tree.query(corners[first : first + CHUNK], predicate="dwithin", distance=most)
            k += first
            other = (self.owner[k] == self.owner[edge]) & (edge != k) & (edge != before[k])
            take_least(k[other], shapely.distance(corners[k[other]], edges[edge[other]]))
        for beside in (before, after):
            take_least(along, np.linalg.norm(self.points[beside] - self.points, axis=1))
        return clearance

    def fit(self, one: int, other: int, within: float) -> bool:
        """Make two outlines touch; return whether a vertex was moved. The first one stays where that suffices.

        Vertices are put onto vertices `within` m, one onto one, and those that are left onto the nearest edge. Nothing
        is changed where an outline would no longer be simple.
        """
        before = self.points.copy()
        for onto in (self._onto_vertices, self._onto_edges):
            for still, moved in ((one, other), (other, one)):
                onto(still, moved, within)
        changed = (abs(self.points - before) > self.exact).any(axis=1)
        rings = [shapely.Polygon(self.outline(i)) for i in np.unique(self.owner[changed])]
        if not all(ring.is_valid and ring.area > self.tolerance**2 for ring in rings):
            self.points, changed = before, np.zeros_like(changed)
        return bool(changed.any())

    def _near(self, index: int, other: int, within: float) -> Index:
        """Return the vertices of an outline that are `within` m of the bounds of the other."""
        ring, own = self.outline(other), np.arange(self.first[index], self.first[index + 1])
        low, high = ring.min(axis=0) - within, ring.max(axis=0) + within
        place = self.points[own]
        return np.asarray(own[((low <= place) & (place <= high)).all(axis=1)])

    def _onto_vertices(self, still: int, moved: int, within: float) -> None:
        """Put vertices of the outline `moved` onto those of the other, the nearest first, one onto one."""
        ours, theirs = self._near(moved, still, within), self._near(still, moved, within)
        if not len(ours) or not len(theirs):
            return
        near = cKDTree(self.points[ours]).sparse_distance_matrix(
            cKDTree(self.points[theirs]), within, output_type="ndarray"
        )
        near.sort(order="v", kind="stable")
        put, taken = set[int](), set[int]()
        for i, j, apart in near.tolist():
            if i in put or j in taken:
                continue
            put.add(i)
            taken.add(j)
            if apart > self.exact:
                self._move(ours[i], self.points[theirs[j]].copy())

    def _onto_edges(self, still: int, moved: int, within: float) -> None:
        """Put vertices of the outline `moved` onto the nearest edge of the other."""
        for vertex in self._near(moved, still, within):
            ring, place = shapely.linearrings(self.outline(still)), shapely.Point(self.points[vertex])
            foot = shapely.get_coordinates(shapely.shortest_line(ring, place))[0]
            if self.exact < np.linalg.norm(foot - self.points[vertex]) <= within:
                self._move(vertex, foot)

    def _move(self, vertex: int, place: Array) -> None:
        """Move a vertex, with those at its place, within their room, unless one must stay or two would become one."""
        near = np.array(self.tree.query_ball_point(self.points[vertex], 3.0 * self.reach + self.tolerance))
        here, points = self.points[vertex], self.points[near]
        together = near[np.linalg.norm(points - here, axis=1) <= self.tolerance]
        there = np.setdiff1d(near[np.linalg.norm(points - place, axis=1) <= self.exact], together)
        if (
            self.free[together].all()
            and not np.isin(self.owner[there], self.owner[together]).any()
            and (np.linalg.norm(self.drawn[together] - place, axis=1) <= self.room[together]).all()
        ):
            self.points[together] = place
