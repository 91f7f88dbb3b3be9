"""Paths on which joints slide by Coulomb's law: what sliding does not lift must not sink either."""

from __future__ import annotations

import pytest

from mechanics import pushover
from tests.support.structures import running_bond


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize(("columns", "courses"), [(4, 5), (3, 6)])
def test_walls_that_slide_neither_penetrate_nor_exceed_the_associative_law(contacts, columns, courses):
    """Joints yield to changes of their forces by less than 10⁻⁴ of a block."""
    model = running_bond(columns, courses, 0.5, 0.3, 0.6)
    curve = pushover(model, (0.5 * columns, 0.3 * courses), "+x", contacts, 0.01, sliding="coulomb")
    other = pushover(model, (0.5 * columns, 0.3 * courses), "+x", contacts, 0.01, sliding="associative")
    assert max(step.penetration for step in curve.steps) < 1e-4 * model.size
    assert 0.9 * other.multiplier.max() < curve.multiplier.max() < 1.001 * other.multiplier.max()
