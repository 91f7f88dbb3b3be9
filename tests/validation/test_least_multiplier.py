"""The least multiplier by Coulomb's law against mixed-integer programming, which searches all flows."""

from dataclasses import replace

import pytest

from mechanics import limit_analysis
from tests.support.integer_program import least_multiplier
from tests.support.random_masonry import random_masonry, small_wall


def test_no_flow_has_a_lesser_multiplier():
    """A wall of up to nine blocks whose joints slide: the search finds the global optimum (0.247 before)."""
    model = small_wall(323)
    assert limit_analysis(model).alpha == pytest.approx(least_multiplier(model), rel=1e-4)


@pytest.mark.parametrize("seed", [41, 323])
def test_no_strength_raises_it(seed):
    """Of joints that crush the program is not linear, and the central flow was taken: 66 % above in a settled wall."""
    model = small_wall(seed)
    whole, alphas = limit_analysis(model).alpha, []
    for strength in (1e7, 1e3, 1e2):
        blocks = [
            replace(block, material=replace(block.material, compressive_strength=strength))
            for block in model.blocks
        ]
        alphas.append(limit_analysis(replace(model, blocks=blocks)).alpha)
    assert alphas[0] == pytest.approx(whole, rel=1e-4)
    assert max(alphas) <= (1.0 + 1e-6) * whole and alphas[2] < alphas[0]


@pytest.mark.parametrize(
    ("model", "least"),
    [
        (small_wall(41), 0.38376),
        (small_wall(60), 0.31017),
        (random_masonry(226), 0.48884),  # no central flow: 0.5261 with a dilation
    ],
)
def test_the_search_leaves_a_local_least_multiplier(model, least):
    """A descent alone ended at 0.40683 and 0.31501; the first wall falls below 0.98 of that."""
    assert limit_analysis(model).alpha == pytest.approx(least, abs=1e-5)
