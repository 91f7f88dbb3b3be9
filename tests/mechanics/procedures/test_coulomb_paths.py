"""Paths on which joints slide by Coulomb's law: what sliding does not lift must not sink either."""

from __future__ import annotations

import pytest

from mechanics import pushover
from tests.support.structures import running_bond


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize(("columns", "courses"), [(4, 8), (5, 6)])
def test_walls_that_slide_penetrate_by_no_more_than_the_lift_that_is_left(contacts, columns, courses):
    """The lift left of slips that do not settle is bounded by 1/500 of a block: it was 3.7 mm on elastic joints."""
    model = running_bond(columns, courses, 0.5, 0.3, 0.6)
    curve = pushover(model, (0.5 * columns, 0.3 * courses), "+x", contacts, 0.01, sliding="coulomb")
    other = pushover(model, (0.5 * columns, 0.3 * courses), "+x", contacts, 0.01)
    assert max(step.penetration for step in curve.steps) < 2e-3 * model.size
    assert 0.95 * other.multiplier.max() < curve.multiplier.max() < 1.001 * other.multiplier.max()
