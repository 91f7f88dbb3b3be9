"""Blocks in an order that makes the matrices of the program narrow-banded (design.md §3)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechanics.joints import Index


@dataclass(frozen=True, eq=False)
class Band:
    """Rows of equilibrium in reverse Cuthill–McKee order of their blocks.

    `order` (m,): the program's row at each place of the band, `back` (m,) its inverse; `row` (c, 2): first of the three
    places of block a and of block b of each contact point, −1 for a support; `width`: places below and on the diagonal.
    """

    order: Index
    back: Index
    row: Index
    width: int


def band(dof: Index) -> Band:
    """The order for contact points whose rows are `dof` (c, 6), as in Program."""
    return _band(dof.tobytes())


@lru_cache(maxsize=16)
def _band(buffer: bytes) -> Band:
    dof = np.frombuffer(buffer, dtype=np.intp).reshape(-1, 6)
    size = int(dof.max(initial=-1)) + 1
    pairs = dof[:, [0, 3]] // 3
    linked = pairs[(pairs >= 0).all(axis=1)]
    shape = (size // 3, size // 3)
    graph = sparse.coo_matrix((np.ones(len(linked)), (linked[:, 0], linked[:, 1])), shape=shape)
    blocks = reverse_cuthill_mckee(sparse.csr_matrix(graph + graph.T), symmetric_mode=True)
    rank = np.empty(len(blocks), dtype=np.intp)
    rank[blocks] = np.arange(len(blocks))
    order = (3 * blocks[:, None].astype(np.intp) + np.arange(3)).ravel()
    row = np.where(pairs >= 0, 3 * rank[pairs], -1).astype(np.intp)
    apart = abs(row[:, 0] - row[:, 1])[(row >= 0).all(axis=1)]
    return Band(order, np.argsort(order), row, int(apart.max(initial=0)) + 3)
