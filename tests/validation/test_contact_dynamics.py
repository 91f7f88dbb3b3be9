"""Structures that slide, against contact dynamics (tests/support/contact_dynamics.py): they stand below α0, fall above.

The referee itself against closed forms first. Between the least multiplier of a mechanism and the associative one,
equilibrium without any motion exists too, and a structure may do either: of 169 random walls and arches that slide, six
stood at 1.05 α0 and fell before 1.05 of the associative one; one fell at 0.99 α0: its search ended early.
"""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import Assembly, Material, limit_analysis
from mechanics.types import GRAVITY
from tests.support.contact_dynamics import farthest, motion
from tests.support.random_masonry import random_masonry
from tests.support.reference_loops import turned
from tests.support.structures import block_on_base, built, rectangle, running_bond

STANDS, FALLS = 3e-3, 3e-2  # of a block's size, in one second


@pytest.mark.parametrize(("alpha", "friction"), [(0.2, 0.1), (0.0, 0.65)])
def test_a_block_slides_down_an_incline(alpha: float, friction: float) -> None:
    """s = g (sin β + α cos β − μ (cos β − α sin β)) t²/2, or it stays."""
    slope = np.radians(20.0)
    base, block = (turned(rectangle(*box), -slope) for box in ((-3.0, -0.5, 3.0, 0.0), (-0.5, 0.0, 0.5, 0.4)))
    model = built(Material(20.0, friction), block, base=base)
    way = motion(model, np.full(500, alpha), 1e-3)[-1, 1] - motion(model, np.zeros(1), 1e-9)[-1, 1]
    sin, cos = np.sin(slope), np.cos(slope)
    pull = sin + alpha * cos - friction * (cos - alpha * sin)
    assert way @ np.array([cos, -sin, 0.0]) == pytest.approx(
        max(pull, 0.0) * GRAVITY * 0.5**2 / 2.0, rel=3e-3, abs=1e-6
    )
    assert way @ np.array([sin, cos, 0.0]) == pytest.approx(0.0, abs=1e-9)  # it does not lift


def test_a_wedge_leaves_its_groove_along_one_face() -> None:
    """s = g (α cos β − sin β − μ (cos β + α sin β)) t²/2 up the face; it stands to α = tan(β + arctan μ) = 1.76."""
    slope, friction, stone = np.radians(45.0), 0.275, Material(20.0, 0.275)
    right, left = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0]], [[0.0, 0.0], [-2.0, 0.0], [-2.0, 2.0]]
    model = built(stone, [[0.0, 0.0], [0.5, 0.5], [-0.5, 0.5]], right=right, left=left)
    start, end = motion(model, np.full(300, 1.2), 1e-3)[[0, -1], 2]
    sin, cos = np.sin(slope), np.cos(slope)
    pull = 1.2 * cos - sin - friction * (cos + 1.2 * sin)
    assert (end - start) @ np.array([cos, sin, 0.0]) == pytest.approx(
        max(pull, 0.0) * GRAVITY * 0.3**2 / 2.0, rel=1e-2, abs=1e-6
    )


def test_a_block_topples_from_its_slenderness_on() -> None:
    """0.2 × 1.0 m: α0 = 0.2; above, the work of the loads is the energy of turning about the corner."""
    block = block_on_base()
    assert farthest(block, 0.199) < 1e-6
    path = motion(block, np.full(1000, 0.21), 1e-3)[:, 1]
    x, z, turn = (path[1:] + path[:-1]).T / 2.0 - path[:1].T
    work = GRAVITY * (0.21 * x - z)
    speed = np.diff(path[:, 2]) / 1e-3
    assert abs(turn[-1]) > 0.05
    assert (0.2**2 + 1.0**2) / 6.0 * speed[-1] ** 2 == pytest.approx(work[-1], rel=5e-3)


def slippery(seed: int) -> Assembly:
    """Return a random wall or arch with a friction of 0.3 to 0.67."""
    blocks = random_masonry(seed).blocks
    return Assembly(
        [replace(b, material=replace(b.material, friction=0.75 * b.material.friction)) for b in blocks]
    )


SLIDE = {f"random {seed}": slippery(seed) for seed in (46,)}
SLIDE |= {f"rougher {seed}": random_masonry(seed) for seed in (67,)}
SLIDE["wall of 13"] = running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False)


@pytest.mark.parametrize("name", list(SLIDE))
def test_a_structure_that_slides_stands_below_its_multiplier_and_falls_above(name: str) -> None:
    alpha = limit_analysis(SLIDE[name]).alpha
    assert farthest(SLIDE[name], 0.98 * alpha) < STANDS
    assert farthest(SLIDE[name], 1.05 * alpha) > FALLS


def test_above_the_least_multiplier_a_wall_may_stand_still_up_to_the_associative_one() -> None:
    wall = slippery(5)
    least, most = (limit_analysis(wall, sliding=law).alpha for law in ("coulomb", "associative"))
    assert least < 0.9 * most
    assert farthest(wall, 1.05 * least) < STANDS < FALLS < farthest(wall, 1.05 * most)
