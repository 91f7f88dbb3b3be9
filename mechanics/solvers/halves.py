"""A large model in two halves, at which two threads work: the line of blocks that divides it belongs to both.

Nested dissection eliminates that line last. Until then the halves know nothing of each other: either thread goes
through the interior point iteration on the blocks and contact points of its own half, and keeps of the line the part
that these bring. Where the line's rows are needed, the two add up what they have (see meeting).
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers.compiled_halves import interior_of_half, semismooth_of_half
from mechanics.solvers.compiled_iterations import handed
from mechanics.solvers.dissection import fronts
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.kernels import Residuals
from mechanics.solvers.runs import Runs

MOST = 0.7  # of the products of the whole: where the larger half needs more, one thread does as well
Shared = tuple[Index, Array, int, int]  # see meeting
GONE = np.iinfo(np.int64).max // 2  # more meetings than any loop makes: the other waits no longer


@dataclass(frozen=True, eq=False)
class Half:
    """Blocks on one side of the line, and those of the line, last.

    `layout`: of its matrices; `rows` (h,): its rows among those of the whole, in the order of elimination; `points`
    (k,): its contact points; `counted` (h,): the share of their masses and loads that counts here, half of the line's.
    """

    layout: Elimination
    rows: Index
    points: Index
    counted: Array

    @property
    def places(self) -> tuple[Index, Index, Index, Array]:
        """Its rows of each contact point, and what is the half's of the whole."""
        return self.layout.row, self.rows, self.points, self.counted


@dataclass(frozen=True, eq=False)
class Halves:
    """The two halves, `stored` for their matrices, and the `board` (2, 2, n) of their meetings (see meeting).

    `common`: rows of the line; `pool`: the second thread, kept from one program to the next.
    """

    halves: tuple[Half, Half]
    common: int
    stored: tuple[Array, Array]
    board: Array
    pool: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))

    @classmethod
    def of(cls, layout: Elimination) -> Halves | None:
        """Of a model laid out in fronts; None where it has none or falls into no two parts of about the same work."""
        count = len(layout.fronts.base)
        if count < 3:
            return None
        second = _second(layout)
        first, other = (_half(layout, np.flatnonzero(second == side), not side) for side in (False, True))
        if max(half.layout.fronts.products() for half in (first, other)) > MOST * layout.fronts.products():
            return None
        common = int(np.diff(layout.fronts.first)[-1])
        size = layout.fronts.size - layout.fronts.base[-1]
        return cls(
            (first, other), common, (first.layout.matrix(), other.layout.matrix()), np.empty((2, 2, size))
        )  # fmt: skip

    def semismooth(
        self, row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
        load: Array, x: Array, forces: Array, state: Index, stored: Array, pattern: Any, scale: Any, many: int,
    ) -> tuple[int, Residuals]:  # fmt: skip
        """As iterations.semismooth; rows and matrix are the halves' own."""
        posed = normal, tangent, gap, friction, compliance, mass, load

        def work(half: Half, stored: Array, shared: Shared) -> tuple[int, Residuals]:
            packed = handed(half.layout)
            return semismooth_of_half(
                half.places, posed, x, forces, state, stored, packed, scale, many, shared
            )

        return self._both(work)

    def interior(
        self, row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
        load: Array, x: Array, forces: Array, s: Array, z: Array, state: Index, runs: Runs, stored: Array,
        pattern: Any, scale: Any,
    ) -> tuple[int, Residuals]:  # fmt: skip
        """As iterations.interior; rows, runs and matrix are the halves' own."""
        posed = normal, tangent, gap, friction, compliance, mass, load

        def work(half: Half, stored: Array, shared: Shared) -> tuple[int, Residuals]:
            runs, packed = half.layout.runs, handed(half.layout)
            return interior_of_half(
                half.places, posed, x, forces, s, z, state, runs, stored, packed, scale, shared
            )

        return self._both(work)

    def _both(self, work: Callable[[Half, Array, Shared], tuple[int, Residuals]]) -> tuple[int, Residuals]:
        """The work at either half, in two threads, which come to the same result."""
        gate = np.zeros(2, np.int64)

        def at(member: int) -> tuple[int, Residuals]:
            try:
                return work(self.halves[member], self.stored[member], (gate, self.board, member, self.common))
            finally:
                gate[member] = GONE

        try:
            other = self.pool.submit(at, 1)
            found = at(0)
        finally:
            gate[0] = GONE  # whatever interrupts this thread: the other waits for it no longer
        other.result()
        return found


def _second(layout: Elimination) -> NDArray[np.bool_]:
    """Of every front but the last whether it belongs to the second half."""
    bounds = layout.fronts.first // 3
    line = bounds[-2]
    pairs = layout.row[(layout.row >= 0).all(axis=1)] // 3
    front = np.searchsorted(bounds, pairs[(pairs < line).all(axis=1)], side="right") - 1
    count = len(bounds) - 2
    graph = sparse.coo_matrix((np.ones(len(front)), (front[:, 0], front[:, 1])), shape=(count, count))
    parts, part = connected_components(graph, directed=False)
    blocks = np.bincount(part, np.diff(bounds[:-1]))
    second, filled = np.zeros(parts, dtype=bool), [0.0, 0.0]
    for k in np.argsort(-blocks, kind="stable"):  # the largest first, to the side that has less
        second[k] = filled[1] < filled[0]
        filled[int(second[k])] += blocks[k]
    sides: NDArray[np.bool_] = second[part]
    return sides


def _half(layout: Elimination, chosen: Index, first: bool) -> Half:
    """Of these fronts and the last one; the `first` half has the contact points within the line."""
    bounds = layout.fronts.first // 3
    line, blocks = bounds[-2], bounds[-1]
    kept = np.append(chosen, len(bounds) - 2)
    own = np.concatenate([np.arange(bounds[k], bounds[k + 1]) for k in kept])
    rank = np.full(blocks, -1)
    rank[own] = np.arange(len(own))
    block = np.where(layout.row >= 0, layout.row // 3, -1)
    inner = (block >= 0) & (block < line)
    here = inner & (rank[block] >= 0)
    points = np.flatnonzero(here.any(axis=1) | (first & ~inner.any(axis=1)))
    row = np.where(block[points] >= 0, 3 * rank[block[points]], -1)
    pairs = row[(row >= 0).all(axis=1)] // 3
    panels = fronts(np.unique(np.sort(pairs, axis=1), axis=0), np.cumsum([0, *np.diff(bounds)[kept]]))
    rows = (3 * own[:, None] + np.arange(3)).ravel()
    order = np.arange(len(rows))
    counted = np.where(rows < 3 * line, 1.0, 0.5)
    return Half(
        Elimination(order, order, np.ascontiguousarray(row, np.intp), 0, panels), rows, points, counted
    )
