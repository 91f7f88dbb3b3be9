"""The envelope of a banded matrix."""

from __future__ import annotations

import numpy as np

from mechanics.solvers.band import envelope


def test_envelope_of_a_few_links() -> None:
    """Five blocks, the first linked with the third, the second with the fourth; the last stands alone."""
    first, last = envelope(np.array([[0, 6], [9, 3], [-1, 12]]), 15)
    assert first.tolist() == [0] * 3 + [3] * 3 + [0] * 3 + [3] * 3 + [12] * 3
    assert last.tolist() == [8] * 3 + [11] * 9 + [14] * 3
