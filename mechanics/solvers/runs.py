"""Contact points between the same two blocks, side by side: loops look up their blocks once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechanics.joints import Index

PART = 512  # contact points: what passes between loops over so many stays in the fastest memory


class Runs(NamedTuple):
    """Runs of contact points between the same two blocks, seen from either; as many points, side by side.

    `ends` (j, 2): rows of a run's first block, movable where one is, and of the other, as in Elimination.row; `start`
    (j,): its first contact point. `parts` (p, 4): of runs of one length the first and the end, the length, and the
    first of their columns. `column` (c,): of each contact point: in a part the first ones of its runs, then the second.
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
