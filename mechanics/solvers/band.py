"""Blocks in an order that makes the matrices of the program narrow-banded (design.md §3)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechanics.block import Array
from mechanics.joints import Index

PART = 512  # contact points: what passes between loops over so many stays in the fastest memory
SWEEPS, TILT = 16, 0.01  # directions (of π), and the angle (rad) that keeps the blocks of a course in order


def narrowest_order(linked: Index, blocks: int, centres: Array | None) -> Index:
    """The order of the blocks (b,) in which linked pairs (l, 2) lie closest: reverse Cuthill–McKee's, or a sweep's.

    A sweep of the plane in a direction meets the courses of a wall one by one: a band by a quarter to a third narrower.
    """
    graph = sparse.coo_matrix((np.ones(len(linked)), (linked[:, 0], linked[:, 1])), shape=(blocks, blocks))
    orders = [reverse_cuthill_mckee(sparse.csr_matrix(graph + graph.T), symmetric_mode=True).astype(np.intp)]
    if centres is not None:
        for angle in np.pi * np.arange(SWEEPS) / SWEEPS + TILT:
            orders += [np.argsort(centres @ (np.cos(angle), np.sin(angle)), kind="stable")]
    return min(orders, key=lambda order: half_band(linked, order))


def half_band(linked: Index, order: Index) -> int:
    """The largest distance between linked blocks in that order."""
    rank = np.argsort(order)
    return int(abs(rank[linked[:, 0]] - rank[linked[:, 1]]).max(initial=0))


def envelope(row: Index, size: int) -> Index:
    """First column and last row that rows and columns of the factor reach, (size, 2); contact points as in Band.row.

    No row of a Cholesky factor begins before that of its matrix; a column ends with the last row that has begun.
    """
    first = 3 * (np.arange(size) // 3)
    pairs = np.sort(row[(row >= 0).all(axis=1)], axis=1)
    for e in range(3):
        np.minimum.at(first, pairs[:, 1] + e, pairs[:, 0])
    last = np.arange(size)
    np.maximum.at(last, first, np.arange(size))
    return np.stack([first, np.maximum.accumulate(last)], axis=1).astype(np.intp)


class Runs(NamedTuple):
    """Runs of contact points between the same two blocks, seen from either; as many points, side by side.

    `ends` (j, 2): rows of a run's first block, movable where one is, and of the other, as in Band.row; `start` (j,):
    its first contact point. `parts` (p, 4): of runs of one length the first and the end, the length, and the first of
    their columns. `column` (c,): of each contact point: in a part the first ones of its runs, then the second ones.
    """

    ends: Index
    start: Index
    parts: Index
    column: Index


def runs(row: Index) -> Runs:
    """The runs of contact points (c, 2), in parts of PART points."""
    pairs = np.sort(row, axis=1)
    changes = 1 + np.flatnonzero((pairs[1:] != pairs[:-1]).any(axis=1))
    bounds = np.concatenate([[0], changes, [len(row)]]) if len(row) else np.zeros(1, np.intp)
    lengths = np.diff(bounds)
    order = np.argsort(lengths, kind="stable")
    start, lengths = bounds[:-1][order], lengths[order]
    ends = np.where(row[start, :1] >= 0, row[start], row[start, ::-1])
    parts, column, at, first = [], np.empty(len(row), np.intp), 0, 0
    while first < len(start):
        length = lengths[first]
        alike = int(np.searchsorted(lengths, length, side="right"))
        last = min(alike, first + max(PART // length, 1))
        parts.append((first, last, length, at))
        places = at + np.arange(length * (last - first)).reshape(length, -1)
        column[start[first:last] + np.arange(length)[:, None]] = places
        at, first = at + places.size, last
    return Runs(
        np.ascontiguousarray(ends, dtype=np.intp), start.astype(np.intp),
        np.array(parts, np.intp).reshape(-1, 4), column,
    )  # fmt: skip
