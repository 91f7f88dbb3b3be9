"""Order of the blocks by nested dissection: factors of large models have fewer entries than a band (George, 1973).

A line of blocks whose removal leaves two parts that do not touch is eliminated last, and so on in either part. The
blocks of a line, or of a part too small to divide, are a front: what they fill, among themselves and in the rows of
the later blocks that they reach, is stored as one dense panel by columns.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mechanics.kernels.linalg.pattern import NONE, OVERHANG, Fronts
from mechanics.types import Array, Index, Mask

SMALLEST = 10  # blocks: parts that are not divided any more
DIRECTIONS, TILT = 8, 0.01  # lines that are tried (of π), and the angle (rad) that keeps them off the joints
SHARES = (0.42, 0.5, 0.58)  # of the blocks before the line
UNEVEN = 0.15  # of the blocks: a line that divides them as unevenly counts as longer by as much again


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
            together.append(3 * _to_the_end_of_each(_spans(at - np.arange(len(at)))))
            laid += len(at)
        aim.append(len(targets) - 1)
    return Fronts(
        first=3 * bounds.astype(np.intp),
        base=base[:-1].astype(np.intp),
        height=height.astype(np.intp),
        start=np.cumsum([0, *count]).astype(np.intp),
        below=3 * np.concatenate([NONE, *reached]),
        aim=np.array(aim, np.intp),
        targets=np.concatenate(targets).astype(np.intp),
        place=np.concatenate(place).astype(np.intp),
        together=np.concatenate(together).astype(np.intp),
        size=int(base[-1]),
        largest=int(((3 * count + OVERHANG - 1) * (3 * count + OVERHANG)).max(initial=0)),
    )


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


def _to_the_end_of_each(spans: list[tuple[int, int, int]]) -> Index:
    """Return, for every place in the spans, the distance to the end of its span."""
    return np.concatenate([np.arange(end - begin, 0, -1) for _, begin, end in spans])
