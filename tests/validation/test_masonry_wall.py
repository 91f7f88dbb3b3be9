"""Ferris and Tin-Loi's walls 1 and 2 (2001): bricks in running bond, lateral load equal to the weight.

Wall 1 has 33 bricks and 83 joints: α = 0.64286 for associative friction [computed independently with another code];
about 0.64 in the literature.

Of wall 2 the drawing is not at hand, and its geometry is inferred from the multiplier: the bricks and the bond of wall
1 in ten courses of five, 55 bricks, have the 0.58000 that is published for associative friction. No other number of
courses has it, but six bricks a course and more have. Without dilation: test_coulomb.
"""

from mechanics import limit_analysis
from tests.support.structures import running_bond


def test_numbers_of_bricks_and_joints():
    assert (int(running_bond().movable.sum()), len(running_bond().joints.a)) == (33, 83)
    assert int(running_bond(5, 10).movable.sum()) == 55


def test_a_course_less_or_more_is_another_wall():
    """What the inference of its geometry rests upon."""
    assert abs(limit_analysis(running_bond(5, 9), sliding="associative").alpha - 0.58000) > 2e-3
