"""Order of elimination of the equilibrium rows, and storage of the matrices.

They are stored in a band if it is narrow, for large models in the fronts of a nested dissection.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechanics.kernels.linalg.pattern import NO_FRONTS, Fronts, Pattern, packed
from mechanics.solvers.band import envelope, half_band, narrowest_order
from mechanics.solvers.dissection import dissected, fronts
from mechanics.types import Array, Index

PADDING = 13  # places of a band beyond its width, for tiles that reach over its edge


@dataclass(frozen=True, slots=True)
class Storage:
    """When matrices are stored in fronts.

    `worth_while`: products of a factorisation in the band from which dissection is tried; `dearer`: cost of a product
    in a front over that of one in the band.
    """

    worth_while: float = 4e6
    dearer: float = 1.5


CHEAPER = Storage()
BANDED = Storage(worth_while=np.inf)
"""Without fronts, whatever the size."""


@dataclass(frozen=True, eq=False)
class Elimination:
    """Rows of equilibrium in the order of their blocks.

    `order` (m,): the program's row at each place, `back` (m,) its inverse; `row` (c, 2): first of the three places of
    block a and of block b of each contact point, −1 for a support; `places`: of a column in the band; `fronts`: empty
    where the matrix is banded.
    """

    order: Index
    back: Index
    row: Index
    places: int
    fronts: Fronts

    @classmethod
    def of(cls, dof: Index, centres: Array | None = None, storage: Storage = CHEAPER) -> Elimination:
        """Return the order for joints with the rows `dof` (c, 6), as in Program; `centres` (m/3, 2), m: of blocks."""
        blocks = (int(dof.max(initial=-1)) + 1) // 3 if centres is None else len(centres)
        pairs = dof[:, [0, 3]] // 3
        linked = np.unique(np.sort(pairs[(pairs >= 0).all(axis=1)], axis=1), axis=0)
        order, found = narrowest_order(linked, blocks, centres), NO_FRONTS
        width = 3 * half_band(linked, order) + 3
        in_band = 0.5 * 3 * blocks * width**2
        if centres is not None and in_band >= storage.worth_while:
            other, bounds = dissected(linked, centres)
            panels = fronts(np.argsort(other)[linked], bounds)
            if storage.dearer * panels.products() < in_band:
                order, found = other, panels
        rank = np.argsort(order)
        rows = (3 * order[:, None] + np.arange(3)).ravel()
        # contiguous by points: compiled loops are compiled once for each layout of their arrays
        row = np.ascontiguousarray(np.where(pairs >= 0, 3 * rank[pairs], -1), dtype=np.intp)
        return cls(rows, np.argsort(rows), row, width + PADDING, found)

    def take(self, index: Index) -> Elimination:
        """Return the same order for the joints `index` (k,)."""
        return Elimination(self.order, self.back, self.row[index], self.places, self.fronts)

    def triangle(self) -> Array:
        """Return new work space (n,) for one triangle of a matrix."""
        return np.zeros(self.fronts.size or len(self.order) * self.places)

    @cached_property
    def work_space(self) -> Array:
        """Work space (2n,) for both triangles, used again; only one solve at a time may use it."""
        return np.concatenate([self.triangle(), self.triangle()])

    @cached_property
    def pattern(self) -> Pattern:
        """Places of the entries of a matrix."""
        size = len(self.order)
        first = 3 * np.arange(size // 3)
        low, high = self.row.min(axis=1), self.row.max(axis=1)
        if len(self.fronts.first):
            (own, step), (between, stride) = self.fronts.where(first, first), self.fronts.where(high, low)
        else:
            own, step = first * self.places, np.full(len(first), self.places - 1)
            between, stride = low * self.places + high - low, np.full(len(low), self.places - 1)
        between = np.where(low >= 0, between, -1)
        return Pattern(own, step, between, stride, self.places, *envelope(self.row, size), self.fronts)

    @cached_property
    def packed(self) -> Index:
        """The pattern in one array, for compiled iterations."""
        return packed(self.pattern)
