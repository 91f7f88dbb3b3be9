"""What is tried where a step of a path fails, before the path is said to end there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

HALVINGS = 5  # down to which the end of a path is located
ACROSS = 0.1  # of the block size: a part that moves by itself is held again within that


def other_shares(share: float, largest: float, widest: float) -> Iterator[float]:
    """What is tried of an increment where a share of it fails: a half, more, up to the `widest`, then smaller parts.

    These are not much less than the `largest` that has led on.
    """
    finer = [share * 0.5**k for k in range(1, HALVINGS + 1) if share * 0.5**k >= largest * 0.5**HALVINGS]
    yield from finer[:1]
    yield from (2.0**k for k in range(1, int(np.log2(max(widest, 1.0))) + 1))
    yield from finer[1:]
