"""Motions to rest, on the way of a support and of a push."""

import pytest

from mechanics import pushdown, pushover
from tests.support.random_masonry import random_masonry
from tests.support.template_assembly import template_assembly


@pytest.mark.parametrize("increment", [0.0021, 0.0027])
def test_a_wall_with_openings_settles_by_coulombs_law_alone(increment: float) -> None:
    """It rests wherever it slides: contact dynamics written apart comes to rest after 30 mm too."""
    wall = template_assembly("wall-with-openings", storeys=1)
    settled = pushdown(wall, "destro", (0.0, -0.03), increment=increment)
    assert settled.movement[-1] == pytest.approx(0.03) and settled.lifting == 0


def test_a_part_that_slips_by_a_quarter_of_a_block_rests_there() -> None:
    """With steps of a tenth of the length too; longer ones led beyond, and the curve ended at 0.218 m."""
    masonry = random_masonry(14)
    curve = pushover(masonry, None, "+x", increment=0.03 * masonry.size, until=0.5)
    assert len(curve.crossed) == 1 and curve.displacement[-1] > 0.28
