"""Factors of the matrices of the program and their substitutions, compiled: quicker than LAPACK.

A matrix is stored as its pattern says (see elimination): in a band, entry (i, j), i ≥ j, at j places + i − j, or in the
panels of fronts. Cholesky's LLᵀ is made of the lower triangle. LU has L in the place of the lower triangle, and Uᵀ in
that of the upper one, which is stored by rows as the lower one is by columns: U = Lᵀ where the matrix is symmetric and
definite. Without pivots; |Lᵢᵢ| = |Uᵢᵢ|. Of a factor the inverse stands on the diagonal.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mechanics.kernels.jit import compiled, looped
from mechanics.kernels.linalg.simd_tiles import BYTES, COLUMNS, ROWS, below, half_below, sums
from mechanics.types import Array, Index

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


@looped
def cholesky(matrix: Array, pattern: Any) -> bool:
    """The factor L of LLᵀ in place of a positive definite matrix; False if it is none."""
    return bool(_factor(matrix, matrix, pattern, False) == 0)


@looped
def lu(lower: Array, upper: Array, pattern: Any) -> int:
    """L and Uᵀ in place of the triangles of a matrix; the number of negative pivots, −1 where one vanishes.

    The negative pivots of a symmetric matrix are as many as its negative eigenvalues (Sylvester).
    """
    return int(_factor(lower, upper, pattern, True))


@looped
def substitute(lower: Array, upper: Array, pattern: Any, x: Array) -> None:
    """The solution of LUx = b in place of b (m,), three rows a block; nothing is done to an empty b."""
    if len(x) == 0:
        return
    fronts = pattern.fronts
    if len(fronts.first) == 0:
        _forward(lower, pattern.places - 1, len(x), pattern.last, x)
        _backward(upper, pattern.places - 1, len(x), pattern.last, x)
    else:
        _through(lower, upper, fronts, x)


@compiled
def _through(lower: Array, upper: Array, fronts: Any, x: Array) -> None:
    """Substitute front by front, forward and backward, in the part of x that each of them reaches."""
    tallest = fronts.height.max()
    seen, last = np.empty(tallest), np.empty(tallest, np.intp)
    for k in range(len(fronts.base)):
        first, own = _see(fronts, k, x, seen, last)
        _forward(lower[fronts.base[k] :], fronts.height[k], own, last, seen)
        x[first : first + own] = seen[:own]
        at = own
        for i in range(fronts.start[k], fronts.start[k + 1]):
            row = fronts.below[i]
            x[row], x[row + 1], x[row + 2] = seen[at], seen[at + 1], seen[at + 2]
            at += 3
    for k in range(len(fronts.base) - 1, -1, -1):
        first, own = _see(fronts, k, x, seen, last)
        _backward(upper[fronts.base[k] :], fronts.height[k], own, last, seen)
        x[first : first + own] = seen[:own]


@looped
def _factor(lower: Array, upper: Array, pattern: Any, two: bool) -> int:
    """Factors of a matrix, of `two` triangles or of one.

    Returns the number of negative pivots, −1 where one vanishes, or where one of one triangle is negative.
    """
    fronts = pattern.fronts
    if len(fronts.first) == 0:
        return int(_band(lower, upper, pattern.places, pattern.first, pattern.last, two))
    return int(_fronts(lower, upper, fronts, two))


@compiled
def _band(lower: Array, upper: Array, places: int, reached: Any, last: Any, two: bool) -> int:
    n, negative = len(last), 0
    tiles, inverse = np.empty((2, COLUMNS, ROWS)), np.empty((2, COLUMNS))
    stride = BYTES * (places - 1)
    for j in range(0, n, COLUMNS):
        columns = min(COLUMNS, n - j)
        end = last[j + columns - 1] + 1
        first = _first(reached, j, end)
        found = _tile(
            lower, upper, j * places, places - 1, BYTES * (first * places + j - first), j - first, columns, two,
            tiles, inverse,
        )  # fmt: skip
        if found < 0:
            return -1
        negative += found
        for i in range(j + ROWS, end, ROWS):
            first = min(j, _first(reached, i, end))
            at, diagonal = BYTES * (first * places + j - first), BYTES * j * places
            _rows(lower, upper, at, j - first, stride, BYTES * (i - j), diagonal, COLUMNS, two, inverse)
    return negative


@looped
def _rows(
    lower: Array, upper: Array, at: int, count: int, stride: int, down: int, diagonal: int, columns: int, two: bool,
    inverse: Array,
) -> None:  # fmt: skip
    """Rows of the factors below a tile on the diagonal, `down` from it; places are bytes from an array's begin."""
    low, up = lower.ctypes.data, upper.ctypes.data
    by_u, by_l = inverse.ctypes.data, inverse.ctypes.data + BYTES * COLUMNS
    if columns == COLUMNS:
        below(up + at, count, stride, down + low - up, up + diagonal, by_u)
        if two:
            below(low + at, count, stride, down + up - low, low + diagonal, by_l)
    else:
        half_below(up + at, count, stride, down + low - up, up + diagonal, by_u)
        if two:
            half_below(low + at, count, stride, down + up - low, low + diagonal, by_l)


@looped
def _tile(
    lower: Array, upper: Array, at: int, height: int, column: int, count: int, columns: int, two: bool, tiles: Array,
    inverse: Array,
) -> int:  # fmt: skip
    """The factors of the tile on the diagonal, whose first number is `at`, and the sign of its pivots.

    `column`: bytes to the row of the tile in the first of the `count` columns before it. Returns the number of negative
    pivots, −1 where one vanishes, or is negative in one triangle. Columns are whole vectors: what stands above their
    diagonal is computed with them and not kept.
    """
    low, up = lower.ctypes.data, upper.ctypes.data
    left, right = tiles[0], tiles[1]  # L and Uᵀ
    sums(up + column, count, BYTES * height, low - up, left.ctypes.data, BYTES * ROWS)
    for c in range(columns):
        for r in range(ROWS):
            left[c, r] = lower[at + c * height + r] - left[c, r]
    if two:
        sums(low + column, count, BYTES * height, up - low, right.ctypes.data, BYTES * ROWS)
        for c in range(columns):
            for r in range(ROWS):
                right[c, r] = upper[at + c * height + r] - right[c, r]
    negative = 0
    for c in range(columns):
        pivot = left[c, c]
        if not (pivot > 0.0 or (two and pivot < 0.0)):
            return -1
        own = 1.0 / np.sqrt(abs(pivot))
        other = own
        if pivot < 0.0:
            negative, other = negative + 1, -own
        inverse[0, c], inverse[1, c] = other, own  # of Uᵢᵢ, by which L is divided, and of Lᵢᵢ
        for r in range(ROWS):
            left[c, r] *= other
        for r in range(c, ROWS):
            lower[at + c * height + r] = left[c, r]
        if two:
            for r in range(ROWS):
                right[c, r] *= own
            for r in range(c, ROWS):
                upper[at + c * height + r] = right[c, r]
            upper[at + c * height + c] = other
        lower[at + c * height + c] = own
        across = right if two else left
        for d in range(c + 1, columns):
            in_left, in_right = across[c, d], left[c, d]
            for r in range(ROWS):
                left[d, r] -= in_left * left[c, r]
            if two:
                for r in range(ROWS):
                    right[d, r] -= in_right * right[c, r]
    return negative


@looped
def _first(reached: Any, i: int, end: int) -> int:
    """The first column that the rows of a tile reach."""
    first = i
    for r in range(i, min(i + ROWS, end)):
        first = min(first, reached[r])
    return int(first)


@compiled
def _fronts(lower: Array, upper: Array, fronts: Any, two: bool) -> int:
    """Front by front: its own columns, and what later fronts lose by them (supernodal, right-looking)."""
    tiles, inverse = np.empty((2, COLUMNS, ROWS)), np.empty((2, COLUMNS))
    update = np.empty(fronts.largest)
    negative = 0
    for k in range(len(fronts.base)):
        base, height, own = fronts.base[k], fronts.height[k], fronts.first[k + 1] - fronts.first[k]
        found = _panel(lower, upper, base, height, own, two, tiles, inverse)
        if found < 0:
            return -1
        negative += found
        _update(lower, upper, base, height, own, update)
        _take_off(lower, fronts, k, update, height - own)
        if two:
            _update(upper, lower, base, height, own, update)
            _take_off(upper, fronts, k, update, height - own)
    return negative


@looped
def _panel(
    lower: Array, upper: Array, base: int, height: int, own: int, two: bool, tiles: Array, inverse: Array
) -> int:
    """The columns of the factors in a panel of so many columns of its own; returns as `_tile` does."""
    negative, stride = 0, BYTES * height
    for j in range(0, own, COLUMNS):
        columns, column = min(COLUMNS, own - j), BYTES * (base + j)
        found = _tile(lower, upper, base + j * height + j, height, column, j, columns, two, tiles, inverse)
        if found < 0:
            return -1
        negative += found
        for i in range(j + ROWS, height - ROWS + 1, ROWS):
            _rows(
                lower, upper, column, j, stride, BYTES * (i - j), column + j * stride, columns, two, inverse
            )
    return negative


@looped
def _update(rows: Array, columns: Array, base: int, height: int, own: int, update: Array) -> None:
    """The products of the rows below, the lower triangle by columns: Σ rows[i] columns[j]."""
    tall = height - own
    first, across = columns.ctypes.data + BYTES * (base + own), rows.ctypes.data - columns.ctypes.data
    for j in range(0, tall - ROWS + 1, COLUMNS):
        for i in range(j, tall - ROWS + 1, ROWS):
            sums(
                first + BYTES * j, own, BYTES * height, across + BYTES * (i - j),
                update.ctypes.data + BYTES * (j * tall + i), BYTES * tall,
            )  # fmt: skip


@looped
def _take_off(panels: Array, fronts: Any, k: int, update: Array, tall: int) -> None:
    """Take the products off the panels of the later fronts."""
    begin = fronts.start[k]
    count = fronts.start[k + 1] - begin
    for aim in range(fronts.aim[k], fronts.aim[k + 1]):
        later, first, end, laid = fronts.targets[aim]
        for j in range(first, end):
            height = fronts.height[later]
            column = fronts.base[later] + fronts.place[laid + j - first] * height
            i = j
            while i < count:
                beside = fronts.together[laid + i - first]
                at, of = column + fronts.place[laid + i - first], 3 * (j * tall + i)
                p, q, r = panels[at:], panels[at + height :], panels[at + 2 * height :]
                u, v, w = update[of:], update[of + tall :], update[of + 2 * tall :]
                for e in range(beside):
                    p[e] -= u[e]
                    q[e] -= v[e]
                    r[e] -= w[e]
                i += beside // 3


@compiled
def _see(fronts: Any, k: int, x: Array, seen: Array, last: Any) -> tuple[int, int]:
    """The first row of a front and the number of its own: the part of x that it reaches is copied to `seen`."""
    first = fronts.first[k]
    own = fronts.first[k + 1] - first
    seen[:own] = x[first : first + own]
    at = own
    for i in range(fronts.start[k], fronts.start[k + 1]):
        row = fronts.below[i]
        seen[at], seen[at + 1], seen[at + 2] = x[row], x[row + 1], x[row + 2]
        at += 3
    last[:own] = at - 1
    return first, own


@looped
def _forward(matrix: Array, height: int, own: int, last: Any, x: Array) -> None:
    """Substitute forward in so many columns by threes, each from the diagonal to its `last` row, and in the rows below.

    `height`: from a number of the matrix to its neighbour in the same row.
    """
    step = height + 1
    for j in range(0, own, 3):
        p, q, r = matrix[j * step :], matrix[(j + 1) * step :], matrix[(j + 2) * step :]
        a = x[j] * p[0]
        b = (x[j + 1] - p[1] * a) * q[0]
        c = (x[j + 2] - p[2] * a - q[1] * b) * r[0]
        x[j], x[j + 1], x[j + 2] = a, b, c
        below = x[j + 3 : last[j + 2] + 1]
        p, q, r = p[3 : 3 + len(below)], q[2 : 2 + len(below)], r[1 : 1 + len(below)]
        for e in range(len(below)):
            below[e] -= a * p[e] + b * q[e] + c * r[e]


@looped
def _backward(matrix: Array, height: int, own: int, last: Any, x: Array) -> None:
    """The same from the last columns to the first, each less what the rows below bring."""
    step = height + 1
    for j in range(own - 3, -1, -3):
        p, q, r = matrix[j * step :], matrix[(j + 1) * step :], matrix[(j + 2) * step :]
        below = x[j + 3 : last[j + 2] + 1]
        u, v, w = p[3 : 3 + len(below)], q[2 : 2 + len(below)], r[1 : 1 + len(below)]
        a, b, c = 0.0, 0.0, 0.0
        for e in range(len(below)):
            a += u[e] * below[e]
            b += v[e] * below[e]
            c += w[e] * below[e]
        c = (x[j + 2] - c) * r[0]
        b = (x[j + 1] - b - q[1] * c) * q[0]
        x[j], x[j + 1], x[j + 2] = (x[j] - a - p[1] * b - p[2] * c) * p[0], b, c
