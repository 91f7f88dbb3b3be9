"""Where blocks touch as they move: touched faces, ends of surfaces, faces that meet, joints that come back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from mechanics import (
    Assembly,
    Block,
    CollapseError,
    Material,
    State,
    limit_analysis,
    pushdown,
    pushover,
    time_history,
)
from mechanics.procedures.collapse import passing_through
from mechanics.steps.static_system import static_system
from tests.support.structures import built, on_base, outlines, rectangle, springing_arch

NONE = 1e-6  # a friction that is next to none: associated sliding then lifts nothing


def deepest(model: Assembly, positions: np.ndarray) -> float:
    """The largest area (m²) in which two blocks, not both supports, lie in each other."""
    shapes = outlines(model, positions)
    return max(
        one.intersection(other).area
        for k, one in enumerate(shapes)
        for i, other in enumerate(shapes[:k])
        if model.movable[k] or model.movable[i]
    )


LEG = np.array([[0.57, 0.0], [0.67, 0.0], [0.0, 3.1], [0.0, 2.9]])  # feet and apex of the right leg


def a_frame(friction: float) -> Assembly:
    """Two slender legs, 3 m high, that lean against each other on two wide floors."""
    stone = Material(20.0, friction)
    return Assembly(
        [
            Block(LEG * (-1.0, 1.0), 1.0, stone),
            Block(LEG, 1.0, stone),
            Block(rectangle(-2.0, -0.5, -0.3, 0.0), 1.0, stone, support="left"),
            Block(rectangle(0.3, -0.5, 6.0, 0.0), 1.0, stone, support="right"),
        ]
    )


def sliding_lean(friction: float) -> float:
    """The turn of a leg at which T = μN at the feet: moments about its inner corner; it hangs at its upper one."""
    block = Block(LEG, 1.0, Material(20.0))
    foot, apex, centroid = LEG[0], LEG[2], block.centroid

    def turned(arm: np.ndarray, lean: float) -> np.ndarray:
        c, s = np.cos(lean), np.sin(lean)
        return np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])

    def slope(lean: float) -> float:
        arm, top = turned(centroid - foot, lean), turned(apex - foot, lean)
        return -arm[0] / top[1] - friction

    return brentq(slope, 0.0, 1.2)


def spread(lean: float) -> float:
    """How far the floors are apart where each leg has turned by `lean` about its upper corner, m."""
    x, z = LEG[2] - LEG[0]
    return -2.0 * float(np.cos(lean) * x - np.sin(lean) * z - x)


@pytest.mark.parametrize("friction", [0.15, 0.3])
def test_feet_on_spreading_floors_slide_and_carry_no_more_than_friction(friction, monkeypatch):
    """A corner on a flat floor is pushed by the floor's normal: points pushed it along the tilted leg's as well.

    The spreads are by the closed form of these legs. At the apex two corners meet: they slide off each other where each
    leg has turned by more than the angle of friction. A kick of 2 mm/s fells the frame up to 3 % before that.
    """
    told = pushdown(a_frame(friction), "right", (0.02, 0.0), increment=0.02, to_collapse=True).ultimate
    monkeypatch.setattr("mechanics.procedures.pushdown.KICKED", ())
    path = pushdown(a_frame(friction), "right", (0.02, 0.0), increment=0.02, to_collapse=True)
    feet = np.concatenate(
        [abs(step.forces[:, 2]) / np.maximum(step.forces[:, 0], 1e-9) for step in path.steps]
    )
    assert feet.max() <= friction * (1.0 + 1e-6)
    feet, apex = sliding_lean(friction), np.arctan(friction)
    assert path.ultimate == pytest.approx(spread(min(feet, apex)), rel=1e-2)
    assert 0.96 * path.ultimate < told <= path.ultimate
    slope = abs(path.reaction[:, 0]) / path.reaction[:, 1]
    assert slope.max() == pytest.approx(friction, rel=2e-3) if feet < apex else slope.max() < friction


@pytest.mark.parametrize("friction", [0.4, 0.5])
@pytest.mark.parametrize(
    ("lip", "ledge"), [(0.0, 0.0), (1e-4, -4e-6), (3.6e-4, -1e-4), (0.0, -6e-4), (3.6e-4, 2e-4)]
)
def test_a_corner_on_a_corner_holds_no_skewback_that_slides(friction, lip, ledge):
    """The foot of the intrados lies on the pier's corner: as that corner on the voussoir's face, it held the slide.

    α was 0.1695 for 0.044, 0.2064 for 0.158. On the pier's top, on which it may slide too, it bears some thousandths.
    The tolerance of the drawing is 0.4 mm.
    """
    held, apart = (
        limit_analysis(springing_arch(lip, ledge, friction=friction, collisions=collisions)).alpha
        for collisions in (True, False)
    )
    assert apart == pytest.approx({0.4: 0.0441, 0.5: 0.1575}[friction], rel=1e-2)
    assert held == pytest.approx(apart, rel=7e-3)


@pytest.mark.parametrize(
    ("voussoirs", "friction", "lean", "back", "alpha"),
    [
        (3, 0.3, 0.45, 0.0, 0.04097),
        (5, 0.3, 0.45, 0.0, 0.03422),
        (3, 0.4, 0.45, 0.0, 0.16133),
        (5, 0.3, 0.65, 1e-3, 0.09175),
    ],
)
def test_a_corner_on_a_corner_bears_nothing_that_one_face_does_not_admit(
    voussoirs, friction, lean, back, alpha
):
    """A flat arch between skewbacks, 0.4 m deep, that lean: α of the drawn joints alone.

    An independent linear program gives them; α was 0.0940 for the first one. The tolerance of the drawing is 0.5 mm: on
    piers that are set back by 1 mm the last one had 0.2226, and not on those set back by 0.9 or 1.2 mm.
    """
    low, high = np.linspace(0.0, 1.2, voussoirs + 1), np.linspace(-lean, 1.2 + lean, voussoirs + 1)
    stones = [
        [(low[k], 1.5), (low[k + 1], 1.5), (high[k + 1], 1.9), (high[k], 1.9)] for k in range(voussoirs)
    ]
    skewbacks = [
        [(-0.9, 1.5), (0.0, 1.5), (-lean, 1.9), (-0.9, 1.9)],
        [(1.2, 1.5), (2.1, 1.5), (2.1, 1.9), (1.2 + lean, 1.9)],
    ]
    piers = (-0.9, 0.0, -back, 1.5), (1.2 + back, 0.0, 2.1, 1.5)
    model = built(
        Material(20.0, friction), *piers, *skewbacks, *stones,
        left=(-1.1, -0.3, 0.2, 0.0), right=(1.0, -0.3, 2.3, 0.0),
    )  # fmt: skip
    assert limit_analysis(model).alpha == pytest.approx(alpha, rel=2e-3)


def beam(left: float, right: float) -> Assembly:
    """4 m long, on seats of 50 mm with a friction each, undercut so that it does not jam between them."""
    return Assembly(
        [
            Block(rectangle(-2.0, 0.0, 2.0, 0.4), 1.0, Material(20.0, 0.6)),
            Block(
                [(-3.0, -2.0), (-2.5, -2.0), (-1.95, 0.0), (-3.0, 0.0)], 1.0, Material(20.0, left),
                support="left",
            ),
            Block(
                [(2.5, -2.0), (3.0, -2.0), (3.0, 0.0), (1.95, 0.0)], 1.0, Material(20.0, right),
                support="right",
            ),
        ]
    )  # fmt: skip


def test_a_beam_falls_as_its_seat_ends():
    """It slides on the smooth seat, 50 mm; it was carried for 6 m where surfaces had no end."""
    model = beam(0.6, NONE)
    path = pushdown(model, "right", (0.01, 0.0), increment=0.002, to_collapse=True)
    assert path.ultimate == pytest.approx(0.05, abs=0.002)
    with pytest.raises(CollapseError):
        pushdown(model, "right", (0.06, 0.0), increment=0.002)


def test_a_beam_on_two_alike_seats_uses_up_both_at_the_most():
    """Associated sliding lifts the end that slides, and so it goes on in turns: to 0.1 m, not 0.05."""
    path = pushdown(beam(0.6, 0.6), "right", (0.01, 0.0), increment=0.002, to_collapse=True)
    assert 0.05 * (1.0 - 1e-3) <= path.ultimate <= 0.1


def neighbours() -> Assembly:
    """A wall of 2 m, and 50 mm beside it one of 1 m."""
    stone = Material(20.0, 0.6, 1e6)
    return on_base(stone, (-2.0, -0.5, 3.0), (0.0, 0.0, 0.3, 2.0), (0.35, 0.0, 0.85, 1.0))


def toppling(model: Assembly) -> State:
    """The taller wall on its corner, and falling."""
    state = model.rotated(1, (0.3, 0.0), -0.03)
    arm = state.positions[1, :2] - (0.3, 0.0)
    speed = np.zeros_like(state.positions)
    speed[1] = -2.0 * np.array([-arm[1], arm[0], 1.0])
    return State(state.positions, speed)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_wall_that_overturns_comes_to_lie_on_its_neighbour(contacts):
    """It passed through, 0.60 m² in the other at the end."""
    model = neighbours()
    motion = time_history(model, np.zeros(400), 0.005, contacts, toppling(model))
    assert max(deepest(model, at) for at in motion.positions[::5]) < (1e-3 if contacts == "rigid" else 2e-3)
    assert motion.positions[-1, 1, 2] < -0.04, "it leans on it"


def test_without_collisions_it_passes_through_and_this_is_said():
    model = Assembly(neighbours().blocks, collisions=False)
    motion = time_history(model, np.zeros(400), 0.005, "rigid", toppling(model))
    assert any("passes through" in note for note in motion.notes)


@pytest.mark.parametrize(("share", "passes"), [(0.009, False), (0.011, True)])
def test_blocks_pass_through_each_other_from_a_hundredth_of_the_smaller_one_on(share, passes):
    model = on_base(Material(20.0, 0.6), (-2.0, -0.5, 4.0), (0.0, 0.0, 1.0, 1.0), (1.0, 0.0, 3.0, 1.0))
    assert (
        bool(passing_through(model, model.initial.positions + np.outer([0, 1, 0], [share, 0, 0]))) is passes
    )


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_wall_pushed_against_its_neighbour_is_held_by_it(contacts):
    """A pushover in which faces meet: both move on together, and nothing is lost."""
    model = neighbours()
    path = pushover(model, (0.3, 2.0), "+x", contacts, 0.02)
    alone = pushover(Assembly(model.blocks[:2]), (0.3, 2.0), "+x", contacts, 0.02)
    assert max(deepest(model, state.positions) for state in path.states) < 1e-3
    meets = 0.05 * 2.0
    before = path.displacement < 0.8 * meets
    expected = np.interp(path.displacement[before], alone.displacement, alone.multiplier)
    np.testing.assert_allclose(path.multiplier[before], expected, atol=0.01)
    beyond = (path.displacement > 1.2 * meets) & (path.displacement < 2.0 * meets)
    expected = np.interp(path.displacement[beyond], alone.displacement, alone.multiplier)
    assert beyond.any() and (path.multiplier[beyond] > expected + 0.05).all()


def test_a_settlement_that_closes_a_gap_is_carried_by_both():
    """A wall on a base that turns comes to lean against its neighbour."""
    model = neighbours()
    path = pushdown(model, "base", rotation=-0.2, increment=0.01, contacts="rigid")
    assert max(deepest(model, state.positions) for state in path.states) < 1e-4


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_joint_that_was_lost_comes_back(contacts):
    """A block thrown up by half a metre, and one that slides off a shelf onto the floor."""
    stone = Material(20.0, 0.4, 1e6)
    model = on_base(stone, (-2.0, -0.5, 4.0), (0.0, 0.0, 1.0, 0.5))
    speed = np.zeros((2, 3))
    speed[1] = 1.0, 3.0, 0.0
    motion = time_history(model, np.zeros(400), 0.005, contacts, State(model.initial.positions, speed))
    height = motion.positions[:, 1, 1] - model.initial.positions[1, 1]
    assert height.max() > 0.4 and not motion.collapsed
    if contacts == "rigid":
        assert abs(height[-100:]).max() < 1e-4
    else:  # an elastic bed gives back what it stored: the block bounces on, and comes down each time
        assert height[200:].max() < height.max() and abs(height[200:]).min() < 0.1
    assert max(deepest(model, at) for at in motion.positions[::5]) < 1e-3


def test_a_block_that_slides_off_a_shelf_lands_on_the_floor():
    """On a face that it did not touch as drawn."""
    stone = Material(20.0, 0.05)
    floor = Block(rectangle(-3.0, -0.5, 6.0, 0.0), 1.0, stone, support="base")
    shelf = Block(rectangle(-2.0, 0.0, 0.0, 0.1), 1.0, stone, support="base")
    model = Assembly([floor, shelf, Block(rectangle(-0.8, 0.1, 0.0, 0.5), 1.0, stone)])
    speed = np.zeros((3, 3))
    speed[2, 0] = 2.0
    motion = time_history(model, np.zeros(500), 0.005, "rigid", State(model.initial.positions, speed))
    assert max(deepest(model, at) for at in motion.positions[::5]) < 1e-3
    assert motion.positions[-1, 2, 1] == pytest.approx(0.2, abs=5e-3)
    assert motion.positions[-1, 2, 0] > 0.4


@settings(max_examples=12)
@given(seed=st.integers(0, 10**6))
def test_contacts_about_a_configuration_hold_every_pair_that_touches(seed):
    """Blocks thrown about: two outlines that overlap are a pair that is known there, if no farther than the reach."""
    rng = np.random.default_rng(seed)
    stone = Material(20.0, 0.6)
    boxes = [(0.6 * i, 0.6 * j, 0.6 * i + 0.5, 0.6 * j + 0.5) for i in range(3) for j in range(3)]
    model = built(stone, *boxes, base=(-2.0, -1.0, 4.0, -0.1))
    positions = model.initial.positions.copy()
    positions[1:] += rng.uniform(-0.08, 0.08, (9, 3)) * (1.0, 1.0, 3.0)
    system = static_system(model, "rigid").around(positions, 0.05)
    known = {(int(a), int(b)) for a, b in zip(system.contacts.a, system.contacts.b, strict=True)}
    shapes = outlines(model, positions)
    for b in range(len(shapes)):
        for a in range(b):
            area = shapes[a].intersection(shapes[b]).area
            if 0.0 < area < 5e-3:
                assert (a, b) in known, (a, b, area)


@pytest.mark.parametrize("height", [0.001, 0.1])
def test_the_top_of_a_thin_slab_is_not_held_by_the_underside_of_its_floor(height):
    """A slab of 1 m on a floor as thin: it slides at μ; faces that look at each other through both wedged it."""
    model = on_base(Material(20.0, 0.7), (-5.0, -0.1 * height, 5.0), (0.0, 0.0, 1.0, height))
    assert limit_analysis(model).alpha == pytest.approx(0.7, abs=1e-7)
