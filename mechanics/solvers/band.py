"""Order of the blocks for a narrow band of the program's matrices."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechanics.types import Array, Index

SWEEPS, TILT = 16, 0.01  # directions (of π), and the angle (rad) that keeps the blocks of a course in order


def narrowest_order(linked: Index, blocks: int, centres: Array | None) -> Index:
    """Return the order of the blocks (b,) with the narrowest band for linked pairs (l, 2).

    Reverse Cuthill–McKee is compared with sweeps of the plane in several directions: a sweep meets the courses of a
    wall one by one, and its band is narrower by a quarter to a third.
    """
    graph = sparse.coo_matrix((np.ones(len(linked)), (linked[:, 0], linked[:, 1])), shape=(blocks, blocks))
    orders = [reverse_cuthill_mckee(sparse.csr_matrix(graph + graph.T), symmetric_mode=True).astype(np.intp)]
    if centres is not None:
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
