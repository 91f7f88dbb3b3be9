"""Cholesky's factorisation of the matrices of the program and its substitutions, compiled: quicker than LAPACK.

A matrix is stored as its pattern says (see elimination): in a band, entry (i, j), i ≥ j, at j places + i − j, or in the
panels of fronts. Of a factor the inverse stands on the diagonal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.jit import compiler
from mechanics.kernels.linalg.simd_tiles import BYTES, COLUMNS, ROWS, below, half_below, sums
from mechanics.types import Array

compiled = compiler("contract", "reassoc")


@compiled
def factorise(matrix: Array, pattern: Any) -> bool:
    """The factor L of LLᵀ in place of a positive definite matrix; False if it is none."""
    fronts = pattern.fronts
    if len(fronts.first) == 0:
        return _band(matrix, pattern.places, pattern.first, pattern.last)
    return _fronts(matrix, fronts, np.empty(0))


@compiled
def solve(matrix: Array, pattern: Any, x: Array) -> bool:
    """The factor in place of the matrix, and of b (m,) the solution of LLᵀx = b; False if the matrix has no factor.

    Each front is substituted into as soon as it is eliminated, while it is in fast memory.
    """
    fronts = pattern.fronts
    if len(fronts.first) == 0:
        found = _band(matrix, pattern.places, pattern.first, pattern.last)
        if found:
            substitute(matrix, pattern, x)
        return found
    if not _fronts(matrix, fronts, x):
        return False
    _backward_through(matrix, fronts, x)
    return True


@compiled
def substitute(matrix: Array, pattern: Any, x: Array) -> None:
    """The solution of LLᵀx = b in place of b (m,), three rows a block; nothing is done to an empty b."""
    if len(x) == 0:
        return
    fronts = pattern.fronts
    if len(fronts.first) == 0:
        _forward(matrix, pattern.places - 1, len(x), pattern.last, x)
        _backward(matrix, pattern.places - 1, len(x), pattern.last, x)
        return
    seen, last = _room(fronts)
    for k in range(len(fronts.base)):
        _forward_through(matrix, fronts, k, x, seen, last)
    _backward_through(matrix, fronts, x)


@compiled
def _band(band: Array, places: int, reached: Any, last: Any) -> bool:
    n = len(last)
    tile, inverse = np.empty((COLUMNS, ROWS)), np.empty(COLUMNS)
    base, stride = band.ctypes.data, BYTES * (places - 1)
    for j in range(0, n, COLUMNS):
        columns = min(COLUMNS, n - j)
        end = last[j + columns - 1] + 1
        first = _first(reached, j, end)
        column = base + BYTES * (first * places + j - first)
        if not _tile(band, j * places, places - 1, column, j - first, columns, tile, inverse):
            return False
        for i in range(j + ROWS, end, ROWS):
            first = min(j, _first(reached, i, end))
            below(
                base + BYTES * (first * places + j - first), j - first, stride, BYTES * (i - j),
                base + BYTES * j * places, inverse.ctypes.data,
            )  # fmt: skip
    return True


@compiled
def _tile(
    matrix: Array, at: int, height: int, column: int, count: int, columns: int, tile: Array, inverse: Array
) -> bool:
    """The factor of the tile on the diagonal, whose first number is `at`; the columns before it as in tiles.sums."""
    sums(column, count, BYTES * height, 0, tile.ctypes.data, BYTES * ROWS)
    for c in range(columns):
        for r in range(c, ROWS):
            tile[c, r] = matrix[at + c * height + r] - tile[c, r]
    for c in range(columns):
        if not tile[c, c] > 0.0:
            return False
        inverse[c] = 1.0 / np.sqrt(tile[c, c])
        for r in range(c, ROWS):
            tile[c, r] *= inverse[c]
            matrix[at + c * height + r] = tile[c, r]
        matrix[at + c * height + c] = inverse[c]
        for d in range(c + 1, columns):
            for r in range(d, ROWS):
                tile[d, r] -= tile[c, d] * tile[c, r]
    return True


@compiled
def _first(reached: Any, i: int, end: int) -> int:
    """The first column that the rows of a tile reach."""
    first = i
    for r in range(i, min(i + ROWS, end)):
        first = min(first, reached[r])
    return int(first)


@compiled
def _fronts(panels: Array, fronts: Any, x: Array) -> bool:
    """Front by front: its own columns, what later fronts lose by them (supernodal, right-looking), and x, if any."""
    tile, inverse = np.empty((COLUMNS, ROWS)), np.empty(COLUMNS)
    update = np.empty(fronts.largest)
    seen, last = _room(fronts)
    for k in range(len(fronts.base)):
        height, own = fronts.height[k], fronts.first[k + 1] - fronts.first[k]
        if not _panel(panels, fronts.base[k], height, own, tile, inverse):
            return False
        _update(panels, fronts.base[k], height, own, update)
        _take_off(panels, fronts, k, update, height - own)
        if len(x) > 0:
            _forward_through(panels, fronts, k, x, seen, last)
    return True


@compiled
def _panel(panels: Array, base: int, height: int, own: int, tile: Array, inverse: Array) -> bool:
    """The columns of the factor in a panel of so many columns of its own."""
    start, stride = panels.ctypes.data + BYTES * base, BYTES * height
    for j in range(0, own, COLUMNS):
        columns, column = min(COLUMNS, own - j), start + BYTES * j
        if not _tile(panels, base + j * height + j, height, column, j, columns, tile, inverse):
            return False
        diagonal = column + j * stride
        for i in range(j + ROWS, height - ROWS + 1, ROWS):
            if columns == COLUMNS:
                below(column, j, stride, BYTES * (i - j), diagonal, inverse.ctypes.data)
            else:
                half_below(column, j, stride, BYTES * (i - j), diagonal, inverse.ctypes.data)
    return True


@compiled
def _update(panels: Array, base: int, height: int, own: int, update: Array) -> None:
    """The products of the rows below, the lower triangle by columns."""
    tall = height - own
    first = panels.ctypes.data + BYTES * (base + own)
    for j in range(0, tall - ROWS + 1, COLUMNS):
        for i in range(j, tall - ROWS + 1, ROWS):
            sums(
                first + BYTES * j, own, BYTES * height, BYTES * (i - j),
                update.ctypes.data + BYTES * (j * tall + i), BYTES * tall,
            )  # fmt: skip


@compiled
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
def _room(fronts: Any) -> tuple[Array, Any]:
    """Work space for the part of x that a front uses, and for the last rows of its columns."""
    tallest = fronts.height.max()
    return np.empty(tallest), np.empty(tallest, np.intp)


@compiled
def _forward_through(panels: Array, fronts: Any, k: int, x: Array, seen: Array, last: Any) -> None:
    first, own = _see(fronts, k, x, seen, last)
    _forward(panels[fronts.base[k] :], fronts.height[k], own, last, seen)
    x[first : first + own] = seen[:own]
    at = own
    for i in range(fronts.start[k], fronts.start[k + 1]):
        row = fronts.below[i]
        x[row], x[row + 1], x[row + 2] = seen[at], seen[at + 1], seen[at + 2]
        at += 3


@compiled
def _backward_through(panels: Array, fronts: Any, x: Array) -> None:
    seen, last = _room(fronts)
    for k in range(len(fronts.base) - 1, -1, -1):
        first, own = _see(fronts, k, x, seen, last)
        _backward(panels[fronts.base[k] :], fronts.height[k], own, last, seen)
        x[first : first + own] = seen[:own]


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


@compiled
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


@compiled
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
