"""Paths on which joints slide by Coulomb's law: what sliding does not lift must not sink either."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover
from tests.support.random_masonry import small_wall
from tests.support.structures import rectangle, running_bond


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_walls_that_slide_neither_penetrate_nor_exceed_the_associative_law(contacts):
    """Joints yield to changes of their forces by less than 10⁻⁴ of a block."""
    model = running_bond(4, 5, 0.5, 0.3, 0.6)
    curve = pushover(model, (2.0, 1.5), "+x", contacts, 0.01, until=0.7, sliding="coulomb")
    other = pushover(model, (2.0, 1.5), "+x", contacts, 0.01, until=0.7, sliding="associative")
    assert max(step.penetration for step in curve.steps) < 1e-4 * model.size
    assert 0.9 * other.multiplier.max() < curve.multiplier.max() < 1.001 * other.multiplier.max()


def test_a_curve_goes_on_along_its_flow_whatever_the_increment():
    """Programs alone go over to other flows: α 0.335 for 0.310 after the first step of wall 60, 2.7 times its d_0."""
    model = small_wall(60)
    curves = [pushover(model, increment=increment) for increment in (0.02, 0.04)]
    least = limit_analysis(model).alpha
    assert [curve.alpha_0 for curve in curves] == pytest.approx([least, least], rel=1e-6)
    far = [curve.displacement[-1] for curve in curves]
    assert far[0] == pytest.approx(far[1], rel=1e-5)
    assert all(curve.reached_zero and curve.lifting == 0 for curve in curves)
    worst = max(c.worst(0.01) for curve in curves for c in curve.certificates)
    assert worst < 1e-7
    pressed = [step.forces[:, 0].min() for curve in curves for step in curve.steps]
    assert np.min(pressed) > -1e-9 * model.weight


def test_forces_that_a_settlement_has_left_do_not_raise_the_curve():
    """A wall in bond on two supports: what friction has pressed in held it up to 5 % above its least flow."""
    stone = Material(18.0, 0.6)
    bases = [
        Block(rectangle(left, -0.3, left + 0.6, 0.0), 1.0, stone, support=name)
        for left, name in ((0.0, "left"), (0.6, "right"))
    ]
    rows = [(0.0, 0.4, 0.8, 1.2), (0.0, 0.2, 0.6, 1.0, 1.2)]
    bricks = [
        Block(rectangle(left, 0.25 * course, right, 0.25 * (course + 1)), 1.0, stone)
        for course in range(4)
        for left, right in pairwise(rows[course % 2])
    ]
    model = Assembly([*bases, *bricks])
    settled = pushdown(model, "right", (0.0, -0.005), increment=0.001).final
    curve = pushover(model, (0.0, 1.0), "-x", increment=0.004, state=settled, until=0.7)
    drawn = limit_analysis(model, "-x").alpha
    assert curve.alpha_onset == pytest.approx(limit_analysis(model, "-x", settled).alpha, rel=1e-6)
    assert curve.alpha_0 < (1.0 + 1e-3) * drawn
