"""Friction that does not dilate: a wedge between two supports, a block on an incline, walls of Ferris and Tin-Loi.

Closed forms: each voussoir and block slides on both of its faces.
"""

import itertools

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover
from mechanics.steps.static_system import Behaviour, Sliding
from tests.support.random_masonry import random_masonry
from tests.support.structures import column, rectangle, running_bond

SLOPE = np.radians(20.0)  # of the wedge's faces from vertical


def wedge(friction: float) -> Assembly:
    """A voussoir, 1 m wide at the foot, between two supports."""
    stone, out = Material(20.0, friction), 0.4 * np.tan(SLOPE)
    return Assembly(
        [
            Block([[-0.5, 0.0], [0.5, 0.0], [0.5 + out, 0.4], [-0.5 - out, 0.4]], 1.0, stone),
            Block([[-1.5, 0.0], [-0.5, 0.0], [-0.5 - out, 0.4], [-1.5, 0.4]], 1.0, stone, support="left"),
            Block([[0.5, 0.0], [1.5, 0.0], [1.5, 0.4], [0.5 + out, 0.4]], 1.0, stone, support="right"),
        ]
    )


def opened(friction: float, increment: float) -> tuple[float, float]:
    """How far the wedge goes down, of the 20 mm by which its right support opens, and H/W at the end."""
    model = wedge(friction)
    path = pushdown(model, "right", (0.02, 0.0), increment=increment, sliding="coulomb")
    down = model.initial.positions[0, 1] - path.states[-1].positions[0, 1]
    return down / 0.02, abs(path.reaction[-1, 0]) / model.weight


def test_a_wedge_goes_down_along_its_faces() -> None:
    """dz = −δ/(2 tan φ), H/W = (cos φ − μ sin φ)/(2 (sin φ + μ cos φ))."""
    down, thrust = opened(0.3, 0.005)
    assert down == pytest.approx(1.0 / (2.0 * np.tan(SLOPE)), rel=3e-4)
    sin, cos = np.sin(SLOPE), np.cos(SLOPE)
    assert thrust == pytest.approx((cos - 0.3 * sin) / (2.0 * (sin + 0.3 * cos)), rel=1e-6)


FALL, GRIP = float(np.tan(np.radians(20.0))), 0.5  # of the incline; friction of its block on both faces


def drawn_away(increment: float, sliding: Sliding = "coulomb", contacts: Behaviour = "rigid") -> np.ndarray:
    """A block on an incline that falls to the right, its upright face against a wall; the incline goes to the left.

    How far the block goes down, of the incline's way of 20 mm, and H/W and V/W of the incline at the end.
    """
    stone = Material(20.0, GRIP, 1e7)
    model = Assembly(
        [
            Block([[0.0, 0.0], [1.0, -FALL], [1.0, 1.0], [0.0, 1.0]], 1.0, stone),
            Block([[-1.0, -2.5], [3.0, -2.5], [3.0, -3.0 * FALL], [-1.0, FALL]], 1.0, stone, support="base"),
            Block(rectangle(-0.5, 0.45, 0.0, 3.0), 1.0, stone, support="wall"),
        ]
    )
    path = pushdown(model, "base", (-0.02, 0.0), increment=increment, sliding=sliding, contacts=contacts)
    down = path.states[0].positions[0, 1] - path.states[-1].positions[0, 1]
    return np.r_[down / 0.02, abs(path.reaction[-1]) / model.weight]


def test_a_block_goes_down_along_an_incline() -> None:
    """dz = −δ tan β, H/W = (μ − tan β)/(1 + μ²) = 0.10882, V/W = (1 + μ tan β)/(1 + μ²) = 0.94559."""
    down, horizontal, vertical = drawn_away(0.005)
    assert down == pytest.approx(FALL, rel=1e-5)
    assert horizontal == pytest.approx((GRIP - FALL) / (1.0 + GRIP**2), rel=1e-6)
    assert vertical == pytest.approx((1.0 + GRIP * FALL) / (1.0 + GRIP**2), rel=1e-6)


def test_on_elastic_joints_too_a_block_goes_down_along_an_incline() -> None:
    """Forces to 10⁻⁵; the way but for what the joints yield."""
    down, horizontal, vertical = drawn_away(0.001, contacts="elastic")
    assert down == pytest.approx(FALL, abs=4e-4)
    assert horizontal == pytest.approx(0.108824, rel=1e-5)
    assert vertical == pytest.approx(0.945588, rel=1e-5)


@pytest.mark.parametrize(("increment", "expected"), [(0.001, 0.339), (0.005, 0.239)])
def test_associative_friction_lifts_a_block_off_its_incline(increment: float, expected: float) -> None:
    """The more the longer its steps, in place of 0.364 δ; the forces are the same."""
    down, horizontal, _ = drawn_away(increment, "associative")
    assert down == pytest.approx(expected, abs=2e-3)
    assert horizontal == pytest.approx(0.108824, rel=1e-5)


def test_a_wall_that_slides() -> None:
    """Associative, central and least multiplier of a wall of 13; of Ferris and Tin-Loi's: test_printed_table."""
    model = running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False)
    assert limit_analysis(model, sliding="associative").alpha == pytest.approx(0.68098, abs=1e-5)
    found = limit_analysis(model, sliding="coulomb")
    assert (found.central, found.alpha) == pytest.approx((0.66848, 0.60798), abs=1e-5)
    assert found.certificate.worst(1e-3 * model.size) <= 1e-8 and found.dilation == 0.0


def test_a_wall_that_wedges_has_a_flow_of_slight_dilation() -> None:
    """Bricks that hang together by friction alone: by Coulomb's law no motion does work, and the limit says so."""
    wall = random_masonry(61)
    found = limit_analysis(wall, sliding="coulomb")
    assert found.dilation == 0.001 and found.certificate.worst(1e-3 * wall.size) <= 1e-8
    assert 0.9 < found.alpha / limit_analysis(wall, sliding="associative").alpha < 1.0


@pytest.mark.parametrize(("friction", "base"), [(0.8, 0.7), (0.7, 0.5)])
def test_the_end_brick_of_a_wall_rocks_off_alone(friction: float, base: float) -> None:
    """A half brick b × h: α_0 = b/h, d_0 = h sin arctan(b/h). Others press forces on it that hold it up to 0.61."""
    b, h = 0.15, 0.35
    stone, below = Material(20.0, friction), Material(20.0, base)
    courses = ((0.0, (0, 2, 4)), (h, (0, 1, 3, 4)))
    blocks = [
        Block(rectangle(b * left, z, b * right, z + h), 1.0, stone)
        for z, ends in courses
        for left, right in itertools.pairwise(ends)
    ]
    model = Assembly([*blocks, Block(rectangle(-0.4, -0.3, 1.0, 0.0), 1.0, below, support="base")])
    curve = pushover(model, increment=0.01)
    assert curve.alpha_0 == pytest.approx(b / h, rel=1e-6)
    assert curve.displacement[-1] == pytest.approx(h * np.sin(np.arctan(b / h)), rel=1e-5)


@pytest.mark.parametrize("courses", [2, 3, 5])
@pytest.mark.parametrize("increment", [0.006, 0.01, 0.016])
def test_of_courses_that_may_all_slide_the_one_that_has_begun_goes_on(courses: int, increment: float) -> None:
    """What lies on it slides under μ until its resultant is at the edge, and tips: rounding gave 0.506 to 0.536 m."""
    mu, width, course = 0.4, 1.0, 0.25
    model = column(width, courses * course, courses, friction=mu)
    curve = pushover(model, increment=increment)
    moved = abs(curve.states[1].positions - model.initial.positions)[:, 0] > 1e-3 * increment
    height = course * moved.sum()
    turn, arm = np.arctan(mu), 0.5 * (width - mu * height)
    end = arm * np.cos(turn) + height * np.sin(turn)
    assert curve.alpha_0 == pytest.approx(mu, rel=1e-6)
    assert curve.reached_zero is not bool(moved[model.movable].all())  # on its base it slides without end
    assert not curve.reached_zero or curve.displacement[-1] == pytest.approx(end, rel=1e-4)


def test_a_brick_that_wedges_turns_in_steps_of_whole_increments() -> None:
    """Programs in held geometries sent it to and fro: 795 points, most of the shortest step, 24 s."""
    wall = random_masonry(7)
    curve = pushover(wall, increment=0.01 * wall.size)
    assert len(curve.steps) < 150
    assert curve.displacement[-1] == pytest.approx(0.331, rel=0.02)
