"""Ferris and Tin-Loi's wall 1: 33 bricks in running bond, 83 joints, lateral load equal to the weight.

α = 0.64286 for associative friction [computed independently with another code]; about 0.64 in the literature.
"""

from __future__ import annotations

import pytest

from mechanics import limit_analysis
from tests.support.structures import running_bond


def test_number_of_bricks():
    assert int(running_bond().movable.sum()) == 33


def test_number_of_joints():
    assert len(running_bond().joints.a) == 83


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_multiplier(direction):
    assert limit_analysis(running_bond(), direction).alpha == pytest.approx(0.64286, abs=5e-6)
