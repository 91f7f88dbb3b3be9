"""Blocks: area, centroid and inertia of outlines against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Block, Material
from mechanics.types import GRAVITY


@pytest.mark.parametrize("at", [(0.0, 0.0), (498.1, -46.0)])
def test_a_triangle_has_the_inertia_of_its_closed_form(at):
    """Legs b and h: A = bh/2, J = A (b² + h²)/18 about the centroid, a third of the legs from the corner.

    Of a rectangle the products of successive corners cancel: it cannot tell a wrong one.
    """
    b, h, depth = 1.3, 0.7, 0.4
    block = Block(np.array([(0.0, 0.0), (b, 0.0), (0.0, h)]) + at, depth, Material(18.0, 0.6, 1e6))
    assert block.area == pytest.approx(0.5 * b * h, rel=1e-9)
    assert block.centroid == pytest.approx(np.add(at, (b / 3.0, h / 3.0)), abs=1e-9)
    assert block.mass == pytest.approx(18.0 * 0.5 * b * h * depth / GRAVITY, rel=1e-9)
    assert block.inertia == pytest.approx(block.mass * (b**2 + h**2) / 18.0, rel=1e-8)
