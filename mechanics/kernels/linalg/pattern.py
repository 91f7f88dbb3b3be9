"""Where the numbers of a matrix stand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechanics.types import Index

OVERHANG = 7  # rows of zeros below a panel, for tiles that reach over its edge
NONE: Index = np.zeros(0, np.intp)


class Fronts(NamedTuple):
    """The panels of f fronts, in the order of their elimination, in one array of `size` numbers.

    `first` (f + 1,): first row of each front; `base` (f,): place of its panel's first number, `height` (f,): from
    there to the next column, OVERHANG included. Below its own rows a panel has those of the later blocks reached,
    whose first rows are below[start[k]:start[k + 1]]. What a front takes from later ones, its targets, from
    targets[aim[k]] to targets[aim[k + 1]] (t, 4): the later front, the first and the end of the blocks below that are
    its own, and where in `place` the rows in that later panel begin, of these blocks and of those that follow;
    `together` counts, from each of them, the rows that lie side by side there as well. `largest`: numbers that a front
    takes from later ones, by whole tiles.
    """

    first: Index
    base: Index
    height: Index
    start: Index
    below: Index
    aim: Index
    targets: Index
    place: Index
    together: Index
    size: int
    largest: int

    def products(self) -> float:
        """Of a factorisation."""
        own, rows = np.diff(self.first), self.height - OVERHANG
        below = rows - own
        total = (rows * (rows + 1.0) * (2 * rows + 1.0) - below * (below + 1.0) * (2 * below + 1.0)).sum()
        return float(total) / 12.0

    def where(self, row: Index, column: Index) -> tuple[Index, Index]:
        """Place of these entries of the lower triangle (n,) by rows of blocks, and the step to the next column."""
        count = len(self.base)
        k = np.searchsorted(self.first, column, side="right") - 1
        # a front's own rows and those below it, ascending, then the next front's: one list to search
        owner = np.repeat(np.arange(count), np.diff(self.start))
        far = self.first[-1] + 1
        at = np.searchsorted(owner * far + self.below, k * far + row) - self.start[k]
        inside = row < self.first[k + 1]
        position = np.where(inside, row - self.first[k], self.first[k + 1] - self.first[k] + 3 * at)
        place: Index = self.base[k] + (column - self.first[k]) * self.height[k] + position
        return place, self.height[k]


NO_FRONTS = Fronts(NONE, NONE, NONE, NONE, NONE, NONE, NONE.reshape(0, 4), NONE, NONE, 0, 0)


class Pattern(NamedTuple):
    """Where the lower triangle of a matrix stands in an array of numbers.

    Its blocks of three by three are stored by columns. `own` (m/3,): place of the first number of those on the
    diagonal, `step` (m/3,) from there to the next column; `between`, `stride` (c,): the same of those between the two
    blocks of a contact point, −1 where one is a support. In a band a column takes `places`, of which the factor fills
    those from the diagonal to its `last` (m,) row, and a row begins at its `first` (m,) column (see band); or there
    are `fronts` (see dissection).
    """

    own: Index
    step: Index
    between: Index
    stride: Index
    places: int
    first: Index
    last: Index
    fronts: Fronts
