"""Order of elimination of the equilibrium rows, and storage of the matrices.

They are stored in a band if it is narrow, for large models in the fronts of a nested dissection, which has fewer
entries (George, 1973): a line of blocks whose removal leaves two parts that do not touch is eliminated last, and so on
in either part. The blocks of a line, or of a part too small to divide, are a front: what they fill, among themselves
and in the rows of the later blocks that they reach, is stored as one dense panel by columns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechanics.kernels.linalg.factors import NO_FRONTS, NONE, OVERHANG, Fronts, Pattern
from mechanics.types import Array, Index, Mask

PADDING = 13  # places of a band beyond its width, for tiles that reach over its edge
SWEEPS = 16  # directions (of π) of a sweep
SMALLEST = 10  # blocks: parts that are not divided any more
DIRECTIONS, TILT = 8, 0.01  # lines that are tried (of π), and the angle (rad) that keeps them off the joints
SHARES = (0.42, 0.5, 0.58)  # of the blocks before the line
UNEVEN = 0.15  # of the blocks: a line that divides them as unevenly counts as longer by as much again


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
    where the matrix is banded; `work_space` (2n,): of both triangles of a matrix, shared by what is taken from it: only
    one solve at a time may use it.
    """

    order: Index
    back: Index
    row: Index
    places: int
    fronts: Fronts
    work_space: Array

    @classmethod
    def of(cls, dof: Index, centres: Array | None = None, storage: Storage = CHEAPER) -> Elimination:
        """Return the order for joints with the rows `dof` (c, 6), as in Program; `centres` (m/3, 2), m: of blocks."""
        blocks = (int(dof.max(initial=-1)) + 1) // 3 if centres is None else len(centres)
        pairs = dof[:, [0, 3]] // 3
        linked = np.unique(np.sort(pairs[(pairs >= 0).all(axis=1)], axis=1), axis=0)
        of_centres = None if centres is None else centres.tobytes()
        order, found = narrowest_order(linked.tobytes(), blocks, of_centres), NO_FRONTS
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
        entries = found.size or len(rows) * (width + PADDING)
        return cls(rows, np.argsort(rows), row, width + PADDING, found, np.zeros(2 * entries))

    def take(self, index: Index) -> Elimination:
        """Return the same order for the joints `index` (k,)."""
        return _taken(self, index.tobytes())

    def triangle(self) -> Array:
        """Return new work space (n,) for one triangle of a matrix."""
        return np.zeros(len(self.work_space) // 2)

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


@lru_cache(maxsize=16)  # the joints of a program are mostly those of the one before
def _taken(layout: Elimination, index: bytes) -> Elimination:
    return replace(layout, row=layout.row[np.frombuffer(index, dtype=np.intp)])


@lru_cache(maxsize=32)  # paths and motions of a model meet the same pairs again and again
def narrowest_order(of_pairs: bytes, blocks: int, of_centres: bytes | None) -> Index:
    """Return the order of the blocks (b,) with the narrowest band for linked pairs (l, 2); both arrays as bytes.

    Reverse Cuthill–McKee is compared with sweeps of the plane in several directions: a sweep meets the courses of a
    wall one by one, and its band is narrower by a quarter to a third.
    """
    linked = np.frombuffer(of_pairs, dtype=np.intp).reshape(-1, 2)
    graph = sparse.coo_matrix((np.ones(len(linked)), (linked[:, 0], linked[:, 1])), shape=(blocks, blocks))
    orders = [reverse_cuthill_mckee(sparse.csr_matrix(graph + graph.T), symmetric_mode=True).astype(np.intp)]
    if of_centres is not None:
        centres = np.frombuffer(of_centres).reshape(-1, 2)
        for angle in np.pi * np.arange(SWEEPS) / SWEEPS + TILT:
            orders += [np.argsort(centres @ (np.cos(angle), np.sin(angle)), kind="stable")]
    return min(orders, key=lambda order: half_band(linked, order))


def half_band(linked: Index, order: Index) -> int:
    """Return the largest distance of linked blocks (l, 2) in an order (b,)."""
    rank = np.argsort(order)
    return int(abs(rank[linked[:, 0]] - rank[linked[:, 1]]).max(initial=0))


def envelope(row: Index, size: int) -> tuple[Index, Index]:
    """Return the first column of each row and the last row of each column of the factor, (size,) each.

    No row of a Cholesky factor begins before that of its matrix; a column ends with the last row that has begun.
    """
    first = 3 * (np.arange(size) // 3)
    pairs = np.sort(row[(row >= 0).all(axis=1)], axis=1)
    for e in range(3):
        np.minimum.at(first, pairs[:, 1] + e, pairs[:, 0])
    last = np.arange(size)
    np.maximum.at(last, first, np.arange(size))
    return first.astype(np.intp), np.maximum.accumulate(last).astype(np.intp)


def dissected(linked: Index, centres: Array) -> tuple[Index, Index]:
    """Return an order of the blocks (b,) at `centres` (b, 2), m, linked by pairs (l, 2), and the bounds of the fronts.

    The bounds are the first place of each front, and b at the end.
    """
    parts: list[Index] = []
    _divide(np.arange(len(centres)), np.unique(np.sort(linked, axis=1), axis=0), centres, parts)
    lengths = [len(part) for part in parts]
    return np.concatenate(parts), np.cumsum([0, *lengths])


def _divide(blocks: Index, linked: Index, centres: Array, parts: list[Index]) -> None:
    """Append to `parts` the fronts of some blocks, linked by pairs of places in `blocks`."""
    if len(blocks) <= SMALLEST:
        if len(blocks):
            parts.append(blocks)
        return
    line, before = _shortest_line(linked, centres[blocks])
    for side in (before & ~line, ~before & ~line):
        place = np.cumsum(side) - 1
        _divide(blocks[side], place[linked[side[linked].all(axis=1)]], centres, parts)
    if line.any():
        parts.append(blocks[line])


def _shortest_line(linked: Index, centres: Array) -> tuple[Mask, Mask]:
    """Return the blocks (b,) of the shortest line that divides them about evenly, and those on one side of it."""
    best, found = np.inf, None
    b = len(centres)
    for angle in np.pi * np.arange(DIRECTIONS) / DIRECTIONS + TILT:
        rank = np.empty(b, dtype=np.intp)
        rank[np.argsort(centres @ (np.cos(angle), np.sin(angle)), kind="stable")] = np.arange(b)
        for share in SHARES:
            before = rank < share * b
            crossing = linked[before[linked[:, 0]] != before[linked[:, 1]]]
            for side in (before, ~before):
                line = np.zeros(b, dtype=bool)
                line[crossing[side[crossing]]] = True
                uneven = abs((before & ~line).sum() - (~before & ~line).sum()) / b
                length = line.sum() * (1.0 + uneven / UNEVEN)
                if length < best:
                    best, found = length, (line, before)
    assert found is not None
    return found


def fronts(linked: Index, bounds: Index) -> Fronts:
    """Return the fronts of blocks in their order of elimination, linked by pairs (l, 2); `bounds`: of `dissected`."""
    reached = _reached(linked, bounds)
    count = np.array([len(rows) for rows in reached])
    width = 3 * np.diff(bounds)
    height = width + 3 * count + OVERHANG
    base = np.cumsum([0, *(width * height)])
    aim, targets, place, together = [0], [NONE.reshape(0, 4)], [NONE], [NONE]
    laid = 0
    for rows in reached:
        for k, begin, end in _spans(np.searchsorted(bounds, rows, side="right") - 1):
            there = np.concatenate([np.arange(bounds[k], bounds[k + 1]), reached[k]])
            at = np.searchsorted(there, rows[begin:])
            targets.append(np.array([[k, begin, end, laid]]))
            place.append(3 * at)
            # of every place in them the distance to the end of its span
            spans = _spans(at - np.arange(len(at)))
            together.append(3 * np.concatenate([np.arange(e - b, 0, -1) for _, b, e in spans]))
            laid += len(at)
        aim.append(len(targets) - 1)
    return Fronts(
        first=3 * bounds.astype(np.intp), base=base[:-1].astype(np.intp), height=height.astype(np.intp),
        start=np.cumsum([0, *count]).astype(np.intp), below=3 * np.concatenate([NONE, *reached]),
        aim=np.array(aim, np.intp), targets=np.concatenate(targets).astype(np.intp),
        place=np.concatenate(place).astype(np.intp), together=np.concatenate(together).astype(np.intp),
        size=int(base[-1]), largest=int(((3 * count + OVERHANG - 1) * (3 * count + OVERHANG)).max(initial=0)),
    )  # fmt: skip


def _reached(linked: Index, bounds: Index) -> list[Index]:
    """Return the later blocks that each front fills: those linked with its own, and those passed on by earlier fronts.

    A front passes all blocks that it reaches on to the first front among them.
    """
    pairs = np.sort(linked, axis=1)
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    begins = np.searchsorted(pairs[:, 0], bounds)
    reached: list[Index] = []
    left: list[list[Index]] = [[] for _ in bounds[1:]]
    for k, end in enumerate(bounds[1:]):
        rows = np.unique(np.concatenate([pairs[begins[k] : begins[k + 1], 1], *left[k]]))
        rows = rows[rows >= end].astype(np.intp)
        reached.append(rows)
        if len(rows):
            left[int(np.searchsorted(bounds, rows[0], side="right")) - 1].append(rows)
    return reached


def _spans(values: Index) -> list[tuple[int, int, int]]:
    """Return the value, the first place and the end of each run of equal values."""
    bounds = [0, *(1 + np.flatnonzero(np.diff(values))), len(values)]
    return [(int(values[i]), int(i), int(j)) for i, j in pairwise(bounds) if i < j]
