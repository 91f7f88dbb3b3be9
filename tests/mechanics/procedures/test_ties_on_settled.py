"""A tie may have no tension: what a settlement leaves standing stands with a tie too."""

from __future__ import annotations

import pytest

from mechanics import Tie, limit_analysis, pushdown
from mechanics.errors import CollapseError
from tests.support.random_masonry import random_masonry


@pytest.mark.parametrize("seed", range(0, 90, 15))
def test_tie_on_settled(seed):
    """Thirty arches whose right support has spread, by either law; the tie is set after the movement."""
    model, sliding = random_masonry(seed), "associative" if seed % 2 else "coulomb"
    try:
        settled = pushdown(model, "right", (0.02, -0.01), increment=0.005, sliding=sliding).final
    except CollapseError as fall:
        settled = fall.path.states[len(fall.path.states) // 2]
    movable = [block for block in model.blocks if block.support is None]
    first, last = movable[0].centroid, movable[-1].centroid
    tie = Tie("chain", tuple(first), tuple(last), 50.0)
    without = limit_analysis(model, state=settled, sliding=sliding).alpha
    with_tie = limit_analysis(model.tied([tie]), state=settled, sliding=sliding).alpha
    assert with_tie >= (1.0 - 1e-6) * without
