"""The outlines of blocks in any configuration, as arrays ready to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.path import Path as Outline
from numpy.typing import ArrayLike

from mechanics.types import Array, Index, Mask


@dataclass(frozen=True, eq=False)
class Shape:
    """The blocks (b,) in a configuration.

    Vertices `points` (n, 2) in m, the block `owner` (n,) of each; `centroids` (b, 2), m; whether they are `supports`.
    """

    points: Array
    owner: Index
    centroids: Array
    supports: Mask

    @classmethod
    def of(cls, rings: Sequence[ArrayLike], centroids: ArrayLike, supports: Sequence[bool]) -> Shape:
        """Return the shape of blocks from the vertices (n, 2) of each."""
        corners = [np.asarray(ring, dtype=float) for ring in rings]
        owner = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
        middles = np.asarray(centroids, dtype=float)
        return cls(np.vstack(corners), owner, middles, np.asarray(supports, dtype=bool))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Return (x0, z0, x1, z1) in m."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    @property
    def size(self) -> float:
        """Return the larger side of the bounds, in m."""
        x0, z0, x1, z1 = self.bounds
        return max(x1 - x0, z1 - z0)

    def moved(self, configuration: ArrayLike, magnification: float = 1.0) -> Shape:
        """Return the outlines displaced by (b, 3) finite motions about the centroids, magnified."""
        motion = np.asarray(configuration, dtype=float)
        shift = magnification * (place(self.points, self.owner, self.centroids, motion) - self.points)
        return replace(
            self, points=self.points + shift, centroids=self.centroids + magnification * motion[:, :2]
        )

    def swept(self, velocity: ArrayLike, amount: float) -> Shape:
        """Return the outlines displaced by `amount` times the (b, 3) infinitesimal motions `velocity`."""
        rate = np.asarray(velocity, dtype=float)
        shift = amount * field(self.points, self.owner, self.centroids, rate)
        return replace(self, points=self.points + shift, centroids=self.centroids + amount * rate[:, :2])

    def path(self, chosen: Sequence[int] | Index) -> Outline:
        """Return one compound path of the chosen blocks: one element of the SVG, however many blocks."""
        closed = [Outline(np.vstack([ring, ring[:1]]), closed=True) for ring in self.rings(chosen)]
        return Outline.make_compound_path(*closed)

    def nearest(self, point: ArrayLike) -> int:
        """Return the block whose outline passes nearest to a point (2,) m."""
        start = self.points
        first = np.r_[True, self.owner[1:] != self.owner[:-1]]
        heads = np.flatnonzero(first)
        following = np.arange(1, len(start) + 1)
        following[np.r_[heads[1:] - 1, len(start) - 1]] = heads
        edge, offset = start[following] - start, np.asarray(point, dtype=float) - start
        along = np.clip(np.sum(edge * offset, axis=1) / np.maximum(np.sum(edge**2, axis=1), 1e-300), 0.0, 1.0)
        distance = np.linalg.norm(offset - along[:, None] * edge, axis=1)
        return int(self.owner[np.argmin(distance)])

    @property
    def every(self) -> Index:
        """Numbers of all blocks."""
        return np.arange(len(self.centroids))

    def rings(self, chosen: Sequence[int] | Index) -> list[Array]:
        """Return the vertices (n, 2) of each of the chosen blocks."""
        cuts = np.searchsorted(self.owner, np.arange(len(self.centroids) + 1))
        return [self.points[cuts[block] : cuts[block + 1]] for block in chosen]


def place(points: Array, owner: Index, centroids: Array, motion: Array) -> Array:
    """Move points (n, 2) with their blocks by finite motions (b, 3): dx, dz in m, rotation in rad."""
    arm = points - centroids[owner]
    cosine, sine = np.cos(motion[owner, 2]), np.sin(motion[owner, 2])
    turned = np.column_stack(
        [cosine * arm[:, 0] - sine * arm[:, 1], sine * arm[:, 0] + cosine * arm[:, 1]],
    )
    placed: Array = centroids[owner] + turned + motion[owner, :2]
    return placed


def field(points: Array, owner: Index, centroids: Array, rate: Array) -> Array:
    """Return the displacement (n, 2) of points under infinitesimal motions (b, 3) of their blocks."""
    arm = points - centroids[owner]
    turn = rate[owner, 2][:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
    moved: Array = rate[owner, :2] + turn
    return moved


def through_blocks(pairs: Index, points: Array, loaded: ArrayLike) -> list[Array]:
    """Return a line (2, 2) m through each block that exactly two loaded joints press: there the line of thrust is one.

    `pairs` (j, 2): blocks of the joints; `points` (j, 2) m: where the resultants cross them; `loaded` (j,): which are.
    """
    pressed: dict[int, list[int]] = {}
    for number in np.flatnonzero(loaded).tolist():
        for block in pairs[number].tolist():
            pressed.setdefault(block, []).append(number)
    return [points[both] for both in pressed.values() if len(both) == 2]
