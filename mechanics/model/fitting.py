"""Outlines that nearly touch, made to touch: their vertices are moved onto one another and onto edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechanics.types import Array, Index

EXACT = 1e-12  # of the outlines' extent: vertices closer than this are at one place
SHARE = 0.25  # of the distance from a vertex to other parts of its outline: it is moved no farther
CHUNK = 1000  # vertices whose distances are found at a time

Flags = NDArray[np.bool_]


class Fitting:
    """Outlines whose vertices are moved by at most `reach` (m); what touches within the `tolerance` (m) stays together.

    `points` (n, 2) m: all vertices; `owner` (n,): their outlines; `free` (n,): whether a vertex may be moved; `room`
    (n,) m: how far. That is less than the reach where an outline is thin or has short edges, which would be deformed.
    """

    def __init__(
        self, outlines: Sequence[Array], free: Sequence[Flags], reach: float, tolerance: float
    ) -> None:
        self.points, self.free = np.concatenate(outlines), np.concatenate(free)
        self.drawn = self.points.copy()
        self.first = np.concatenate([[0], np.cumsum([len(o) for o in outlines])])
        self.owner = np.repeat(np.arange(len(outlines)), np.diff(self.first))
        self.reach, self.tolerance = reach, tolerance
        self.exact = EXACT * float(np.ptp(self.points, axis=0).max())
        self.room = np.minimum(reach, SHARE * self._clearance(reach / SHARE))

    def outline(self, index: int) -> Array:
        """Return an outline (k, 2) m as it is now."""
        return self.points[self.first[index] : self.first[index + 1]]

    def _clearance(self, most: float) -> Array:
        """Return the distances (n,) m, at most `most`, of vertices from their next ones and from other edges.

        Those within the tolerance do not count: such vertices are one, and what is so thin is no block.
        """
        along = np.arange(len(self.points))
        after, before = along + 1, along - 1
        after[self.first[1:] - 1], before[self.first[:-1]] = self.first[:-1], self.first[1:] - 1
        edges = shapely.linestrings(np.stack([self.points, self.points[after]], axis=1))
        corners, tree = shapely.points(self.points), shapely.STRtree(edges)
        clearance = np.full(len(self.points), most)
        for first in range(0, len(self.points), CHUNK):
            k, edge = tree.query(corners[first : first + CHUNK], predicate="dwithin", distance=most)
            k += first
            other = (self.owner[k] == self.owner[edge]) & (edge != k) & (edge != before[k])
            apart = shapely.distance(corners[k[other]], edges[edge[other]])
            _take_least(clearance, k[other], apart, self.tolerance)
        for beside in (before, after):
            lengths = np.linalg.norm(self.points[beside] - self.points, axis=1)
            _take_least(clearance, along, lengths, self.tolerance)
        return clearance

    def fit(self, one: int, other: int) -> bool:
        """Make two outlines touch; return whether a vertex was moved. The first one stays where that suffices.

        Vertices are put onto vertices, then those that are left onto edges, each onto the nearest within reach. Nothing
        is changed where an outline would no longer be simple.
        """
        before = self.points.copy()
        for still, moved in ((one, other), (other, one)):
            self._onto_vertices(still, moved)
        for still, moved in ((one, other), (other, one)):
            self._onto_edges(still, moved)
        changed = (abs(self.points - before) > self.exact).any(axis=1)
        rings = [shapely.Polygon(self.outline(i)) for i in np.unique(self.owner[changed])]
        if not all(ring.is_valid and ring.area > self.tolerance**2 for ring in rings):
            self.points, changed = before, np.zeros_like(changed)
        return bool(changed.any())

    def _near(self, index: int, other: int) -> Index:
        """Return the vertices of an outline that are within reach of the bounds of the other."""
        ring, own = self.outline(other), np.arange(self.first[index], self.first[index + 1])
        low, high = ring.min(axis=0) - self.reach, ring.max(axis=0) + self.reach
        place = self.points[own]
        return np.asarray(own[((low <= place) & (place <= high)).all(axis=1)])

    def _onto_vertices(self, still: int, moved: int) -> None:
        """Put vertices of the outline `moved` onto those of the other, the nearest first, one onto one."""
        ours, theirs = self._near(moved, still), self._near(still, moved)
        if not len(ours) or not len(theirs):
            return
        near = cKDTree(self.points[ours]).sparse_distance_matrix(
            cKDTree(self.points[theirs]), self.reach, output_type="ndarray"
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

    def _onto_edges(self, still: int, moved: int) -> None:
        """Put vertices of the outline `moved` onto the nearest edge of the other."""
        for vertex in self._near(moved, still):
            start = self.outline(still)
            along = np.roll(start, -1, axis=0) - start
            length = np.maximum((along**2).sum(axis=1), 1e-300)  # 0 where vertices have become one
            share = ((self.points[vertex] - start) * along).sum(axis=1) / length
            foot = start + np.clip(share, 0.0, 1.0)[:, None] * along
            apart = np.linalg.norm(foot - self.points[vertex], axis=1)
            nearest = int(apart.argmin())
            if self.exact < apart[nearest] <= self.reach:
                self._move(vertex, foot[nearest])

    def _move(self, vertex: int, place: Array) -> None:
        """Move a vertex, and those that are at its place within the tolerance, unless one of them must stay.

        No vertex is moved farther than its room from where it is drawn, or onto another of its own outline.
        """
        together = np.linalg.norm(self.points - self.points[vertex], axis=1) <= self.tolerance
        there = np.linalg.norm(self.points - place, axis=1) <= self.exact
        if (
            self.free[together].all()
            and not np.isin(self.owner[there & ~together], self.owner[together & ~there]).any()
            and (np.linalg.norm(self.drawn[together] - place, axis=1) <= self.room[together]).all()
        ):
            self.points[together] = place


def _take_least(least: Array, where: Index, values: Array, above: float) -> None:
    """Put the values (k,) that are larger than `above` into `least` (n,) at the indices (k,) if they are smaller."""
    counts = values > above
    np.minimum.at(least, where[counts], values[counts])
