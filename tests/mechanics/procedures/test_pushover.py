"""Curves of settled states, of joints that slide, their peaks, control points and ends, in any frame."""

import re
from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.measure import assembly, template
from mechanics import (
    Assembly,
    Block,
    ControlError,
    Material,
    UnstableError,
    limit_analysis,
    pushdown,
    pushover,
)
from mechanics.model.assembly import State
from mechanics.procedures import Mirror, farthest_corner, limit_in, static_theorem
from mechanics.procedures.peaks import may_peak
from mechanics.steps.equilibrium import reaction
from tests.support.drawn_projects import drawn, tables
from tests.support.random_masonry import small_wall
from tests.support.structures import (
    block_on_base,
    built,
    in_bond,
    in_frame,
    on_base,
    rectangle,
    running_bond,
    springing_arch,
)

MOVED = (0.03, -0.02)


def portal(strength: float = np.inf, stiffness: float | None = None) -> Assembly:
    stone = Material(20.0, 0.7, stiffness, compressive_strength=strength)
    shapes = [
        ((-2.4, -0.3, -1.0, 0.0), "left"), ((1.0, -0.3, 2.4, 0.0), "right"), ((-2.0, 0.0, -1.4, 3.0), None),
        ((1.4, 0.0, 2.0, 3.0), None), ((-2.0, 3.0, 2.0, 3.5), None),
    ]  # fmt: skip
    return Assembly([Block(rectangle(*corners), 1.0, stone, support=support) for corners, support in shapes])


def onset(strength: float) -> float:
    model = portal(strength)
    return limit_analysis(model, "+x", pushdown(model, "right", MOVED, increment=0.002).final).alpha


def test_crushing_vanishes_with_the_inverse_of_the_strength():
    """A hinge lies N/2s within its edge, s the strength per length: the multiplier falls by what is proportional to it.

    Where it had turned, no strength was large enough: the structure "could not stand", or α was that of another push.
    """
    whole = onset(np.inf)
    lost = [whole - onset(strength) for strength in (1e6, 1e5, 1e4)]
    assert 0.0 < lost[0] < 1e-3 * whole
    assert lost[1:] == pytest.approx([10.0 * lost[0], 100.0 * lost[0]], rel=0.01)


@pytest.mark.parametrize("sliding", ["coulomb", "associative"])
def test_a_corner_that_meets_a_face_bears_nothing_before_it_has_crushed(sliding):
    """The foot of the intrados on the corner of a pier bore any force, and α was 15 % larger than at the next point."""
    touching, apart = (
        limit_analysis(springing_arch(strength=200.0, collisions=collisions), "+x", sliding=sliding).alpha
        for collisions in (True, False)
    )
    assert touching == pytest.approx(apart, rel=1e-6)


def test_a_corner_beside_a_joint_that_crushes_makes_no_structure_stand():
    """Where corners bore what joints did not, α was 0.011 of an arch whose joints crush under its weight."""
    with pytest.raises(UnstableError, match="cannot stand under its own weight"):
        limit_analysis(springing_arch(strength=110.0), "+x")


@pytest.mark.parametrize("strength", [300.0, 1e6])
def test_a_block_on_two_corners_stands_on_what_they_have_crushed_and_slides_at_its_friction(strength):
    """Drawn so it was told that it cannot stand, at any strength."""
    feet = [(0.0, 0.0), (0.3, 0.3), (0.7, 0.3), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    model = on_base(Material(20.0, 0.7, compressive_strength=strength), (-1.0, -0.5, 2.0), feet)
    assert limit_analysis(model, "+x").alpha == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize(("lip", "ledge"), [(0.0, 0.0), (0.1, 0.05), (0.0, 0.05)])
def test_the_corner_of_a_springing_refuses_no_strength(lip, ledge):
    """Any strength was refused: a corner on a third block crushes at once where it is pressed, or bears a share.

    With elastic joints Newton crept, with rigid ones the hinges did not settle, or a narrow ledge was no equilibrium.
    """
    models = [springing_arch(lip, ledge, strength, 1e6) for strength in (np.inf, 1e5, 5000.0, 1000.0)]
    asked = {"control": (1.9, 2.0), "increment": 0.005, "until": 0.9, "sliding": "associative"}
    rigid, elastic = (
        [pushover(model, contacts=contacts, **asked).alpha_0 for model in models]
        for contacts in ("rigid", "elastic")
    )
    lost = rigid[0] - np.array(rigid[1:])
    assert 0.0 < lost[0] < 2e-3 * rigid[0]
    assert 0.7 * 20.0 < lost[1] / lost[0] < 1.3 * 20.0 and 0.7 * 5.0 < lost[2] / lost[1] < 1.3 * 5.0
    # so soft, their edges bear more than they crush
    assert elastic == pytest.approx([elastic[0]] * 4, rel=2e-3)


@pytest.mark.parametrize(
    ("ledge", "increment", "elastic"), [(0.0, 0.003, (0.1606, 0.1573)), (0.05, 0.002, (0.1399, 0.1370))]
)
def test_faces_that_share_a_springing_crush_in_a_settled_state(ledge, increment, elastic):
    """To 5 % they bear what elastic joints do, 10⁷ kN/m³: α_u falls with the stiffness of what does not crush.

    Movements were refused at some increments. Hinges of the two faces took the force in turns, which was refused too.
    Where a hinge of the settlement closes the motion was not solved, and the curve ended: α_0 was 0.031.
    """
    model = springing_arch(ledge=ledge, strength=800.0)
    settled = pushdown(model, "+1", (0.05, -0.03), increment=increment).final
    ways = [pushover(model, None, way, "rigid", 0.003, settled).alpha_0 for way in ("+x", "-x")]
    assert ways == pytest.approx(elastic, rel=0.05)


@pytest.mark.parametrize(("direction", "sliding"), [("+x", "associative"), ("-x", "coulomb")])
def test_a_settled_curve_begins_where_it_goes_on(direction, sliding):
    """The onset follows from the closed joints, the next points from the geometry: they are one curve.

    The onset of a structure that crushes was 0.33 where the next point was at 0.002.
    """
    model = portal(3000.0)
    settled = pushdown(model, "right", MOVED, increment=0.002, sliding=sliding).final
    curve = pushover(model, (2.0, 3.5), direction, increment=2e-4, state=settled, until=0.9, sliding=sliding)
    begins = 2.0 * curve.multiplier[1] - curve.multiplier[2]
    # by Coulomb's law a settled curve begins with the multiplier of its first step
    assert curve.multiplier[0] == pytest.approx(begins, rel=1e-3 if sliding == "associative" else 3e-3)


def test_a_leaning_panel_crushes_its_toe():
    """Turned by θ, α = tan(arctan((b/2 − N/2s)/(h/2)) − θ), N = W (cos θ − α sin θ)."""
    stone = Material(20.0, 0.7, compressive_strength=2000.0)
    model, turned = on_base(stone, (-3.0, -0.3, 3.0), (-0.3, 0.0, 0.3, 3.0)), 0.02
    settled = pushdown(model, "base", rotation=-turned, increment=0.005).final
    normal = model.weight * np.cos(turned)
    for _ in range(20):  # N is the part of weight and push across the joint
        toe = 0.3 - normal / (2.0 * 2000.0)
        alpha = np.tan(np.arctan(toe / 1.5) - turned)
        normal = model.weight * (np.cos(turned) - alpha * np.sin(turned))
    assert limit_analysis(model, "+x", settled).alpha == pytest.approx(alpha, rel=1e-6)


@pytest.mark.parametrize("increment", [0.0051, 0.01])
def test_a_push_back_closes_the_hinges_and_goes_on_at_any_increment(increment):
    """With 5 mm the curve ended at α = 0 after 15 mm, 0.4 mm before a hinge closes, with 0.005 for 0.195."""
    model = portal()
    settled = pushdown(model, "right", MOVED, increment=0.002).final
    curve = pushover(model, (2.0, 3.5), "-x", increment=increment, state=settled)
    assert curve.multiplier.max() == pytest.approx(0.19534, rel=1e-3)
    assert curve.displacement[-1] == pytest.approx(0.61671, rel=1e-4)


def test_the_elastic_curve_of_a_settled_structure_begins_however_far_its_hinges_have_opened():
    """Hinges close by millimetres under a hundredth of the load; joints are compressed by micrometres.

    The stiffer the joints were, the surer was the message that the structure falls.
    """
    model = portal(stiffness=3e8)
    settled = pushdown(model, "right", MOVED, increment=0.002, contacts="elastic").final
    curves = [
        pushover(model, (2.0, 3.5), "-x", "elastic", increment, settled, until=0.9)
        for increment in (0.001, 0.003)
    ]
    peaks = [curve.multiplier.max() for curve in curves]
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)
    rigid = pushdown(portal(), "right", MOVED, increment=0.002).final
    highest = pushover(portal(), (2.0, 3.5), "-x", increment=0.01, state=rigid).multiplier.max()
    assert 0.9 * highest < peaks[0] < 1.01 * highest


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("movement", [(0.01, -0.02)])
def test_cracks_of_a_settled_state_are_open(direction, movement):
    """However narrow: the onset is the multiplier that the curve goes on with, and that of the static theorem.

    Ends open by less than a thousandth of a block counted as closed: an onset up to fourteen times too large.
    """
    model = portal()
    moved = pushdown(model, "right", movement, increment=0.1 * abs(movement[1]))
    curve = pushover(model, direction=direction, increment=1e-4, state=moved.final, until=0.99)
    assert curve.multiplier[0] == pytest.approx(curve.multiplier[1], rel=0.02)
    assert limit_analysis(model, direction, moved.final).alpha == pytest.approx(curve.multiplier[0], rel=1e-6)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_walls_that_slide_neither_penetrate_nor_exceed_the_associative_law(contacts):
    """Joints yield to changes of their forces by less than 10⁻⁴ of a block."""
    model = running_bond(3, 4, 0.5, 0.3, 0.6)
    curve, other = (
        pushover(model, (1.5, 1.2), "+x", contacts, 0.01, until=0.7, sliding=law)
        for law in ("coulomb", "associative")
    )
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
    bricks = in_bond(2 * [(0.0, 0.4, 0.8, 1.2), (0.0, 0.2, 0.6, 1.0, 1.2)], 0.25)
    model = built(Material(18.0, 0.6), *bricks, left=(0.0, -0.3, 0.6, 0.0), right=(0.6, -0.3, 1.2, 0.0))
    settled = pushdown(model, "right", (0.0, -0.005), increment=0.001).final
    curve = pushover(model, (0.0, 1.0), "-x", increment=0.004, state=settled, until=0.7)
    drawn = limit_analysis(model, "-x").alpha
    assert curve.alpha_onset == pytest.approx(limit_analysis(model, "-x", settled).alpha, rel=1e-6)
    assert curve.alpha_0 < (1.0 + 1e-3) * drawn


CROWN = tables("arch_campaign")["control"][0]["point_m"]


def spread(movement):
    """Return the arch of the campaign at rest, its right support moved out (m)."""
    model = drawn("arch_campaign")
    return model, pushdown(model, "destro", (movement, 0.0), increment=0.003).final


def test_alpha_0_falls_as_the_movement_grows_and_is_that_of_the_mirror_image():
    """By steps of 3 mm it was 0.220, 0.221, 0.222, 0.223, 0.209 from 24 to 48 mm: where the step ended.

    The arch as drawn is its own mirror image, and so are the two states that it may settle into; a push towards +x
    takes it from one to the other, or the other way.
    """
    found = []
    for movement in (0.018, 0.030, 0.042):
        model, state = spread(movement)
        own, image = (pushover(model, CROWN, side, increment=0.003, state=state) for side in ("+x", "-x"))
        assert len(own.crossed) != len(image.crossed) and own.multiplier.max() == pytest.approx(
            image.multiplier.max(), rel=4e-4
        )
        found.append(own.multiplier.max())
    assert limit_analysis(drawn("arch_campaign")).alpha > found[0]
    np.testing.assert_allclose(np.diff(found), np.mean(np.diff(found)), rtol=0.1)
    assert found[-1] < found[0]


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_the_point_added_is_an_equilibrium_and_two_programs_find_its_multiplier(direction):
    model, state = spread(0.03)
    curve = pushover(model, CROWN, direction, increment=0.003, state=state)
    at, alpha = curve.states[curve.peak], curve.multiplier[curve.peak]
    assert curve.formed == curve.peak > 0
    assert limit_in(model, direction, at).alpha == pytest.approx(alpha, rel=1e-6)
    assert static_theorem(model, direction, at) == pytest.approx(alpha, rel=1e-6)
    assert curve.certificates[curve.peak].equilibrium < 1e-8
    assert curve.steps[curve.peak - 1].state is at
    moved = curve.displacement - curve.displacement[curve.peak]
    assert 0.0 < moved[curve.peak + 1] < 0.003 and (np.diff(curve.displacement) > 0.0).all()
    assert len({len(curve.states), len(curve.steps) + 1, len(curve.certificates), len(curve.multiplier)}) == 1


def test_alpha_may_be_largest_where_the_fall_behind_a_point_carried_back_exceeds_all_points():
    """1 mm behind the point at 2 mm α has fallen by 0.01: it may have been 0.22 in the 2 mm before."""
    displacement = np.array([0.0, 2.0, 3.0, 4.0])
    assert may_peak(np.array([0.1, 0.2, 0.19, 0.18]), displacement, 1e-3) == [(pytest.approx(0.22), 1)]
    assert may_peak(np.array([0.21, 0.2, 0.19, 0.18]), displacement, 1e-3) == [(pytest.approx(0.22), 1)]
    assert may_peak(np.array([0.1, 0.11, 0.12, 0.2]), displacement, 1e-3) == [(pytest.approx(0.2), 3)]
    assert may_peak(np.array([0.25, 0.2, 0.19, 0.18]), displacement, 1e-3) == []
    assert may_peak(np.array([0.1, 0.1005, 0.1002, 0.0999]), displacement, 1e-3) == []


FRAME = (1000.0, (137.3, -41.9), 37.0)  # length, origin (m), weight
WALLS = {  # columns, courses, length and height of a brick (m), friction; law of sliding
    "low": ((3, 3, 0.40, 0.175, 3.16), "associative"),
    "falls before α = 0": ((2, 5, 0.28, 0.16, 0.9), "associative"),
    "rocks in the end": ((2, 4, 0.29, 0.129, 0.869), "coulomb"),
    "slides on its base": ((3, 3, 0.531, 0.182, 0.63), "associative"),
}


def ended(model: Assembly, length: float, sliding: str) -> tuple[str, bool, bool, float]:
    """The reason for the end of a curve without its numbers, whether that is a collapse, and where, per length."""
    curve = pushover(model, model.blocks[-1].centroid, "+x", "rigid", 0.1 * model.size, sliding=sliding)
    reason = re.sub(r"\d[\d.e+-]*", "#", re.sub(r"\(.*\)", "", curve.end))
    return reason, curve.reached_zero, curve.lost, curve.displacement[-1] / length


@pytest.mark.parametrize("name", WALLS)
def test_walls_end_for_the_same_reason_and_at_the_same_displacement_where_they_only_turn(name):
    bricks, sliding = WALLS[name]
    wall = running_bond(*bricks)
    if name == "slides on its base":  # not on a course: rounding would choose
        base, *others = wall.blocks
        wall = Assembly([replace(base, material=replace(base.material, friction=0.6)), *others])
    expected = ended(wall, 1.0, sliding)
    found = ended(in_frame(wall, *FRAME), FRAME[0], sliding)
    assert found[:3] == expected[:3]
    if name in ("low", "falls before α = 0"):
        assert found[3] == pytest.approx(expected[3], rel=1e-6)


STONE = Material(18.0, 0.7, 5e5)


def wall_on_base() -> Assembly:
    return on_base(STONE, (-1.0, -0.3, 1.0), (-0.3, 0.0, 0.3, 4.2))


@pytest.mark.parametrize(
    ("direction", "foremost", "contacts"), [("+x", 0.3, "rigid"), ("-x", -0.3, "elastic")]
)
def test_without_a_control_point_the_top_of_a_wall_is_followed(direction, foremost, contacts):
    model = wall_on_base()
    chosen = pushover(model, direction=direction, contacts=contacts, increment=0.02)
    assert chosen.control == pytest.approx([foremost, 4.2]) and chosen.block == 1
    given = pushover(model, chosen.control, direction, contacts, 0.02)
    assert chosen.displacement == pytest.approx(given.displacement, abs=1e-12)
    assert chosen.multiplier == pytest.approx(given.multiplier, abs=1e-12)


def test_a_corner_that_two_blocks_share_is_not_chosen():
    """Which of the two a drawn point is of would be luck."""
    model = on_base(STONE, (-1.0, -0.3, 1.0), *((-0.3, z, 0.3, z + 0.5) for z in (0.0, 0.5, 1.0)))
    begun = model.initial.positions
    moved = begun.copy()
    moved[2, 0] += 0.1  # its lower corners are of the block below, its upper ones of that above
    point, block = farthest_corner(model, begun, moved, "+x")
    assert block == 2 == model.block_at(point)


def test_corners_go_equally_far_where_others_go_farther_against_the_push():
    walls = ((x, 0.0, x + 0.5, height) for x, height in ((0, 1.0), (1, 1.2), (2, 1.0)))
    model = on_base(STONE, (-1.0, -0.3, 3.0), *walls)
    begun = model.initial.positions
    moved = begun + np.array([[0.0] * 3, [0.1 + 1e-9, 0.0, 0.0], [0.1, 0.0, 0.0], [-0.2, 0.0, 0.0]])
    point, block = farthest_corner(model, begun, moved, "+x")
    assert block == 2 and point.tolist() == [1.5, 1.2], "the highest, and of these the foremost"


def test_the_image_of_a_push_has_the_image_of_its_control_point():
    model = wall_on_base()
    path = pushover(model, increment=0.1)
    image = Mirror.of(model, "rigid").pushover(path)
    other = pushover(model, direction="-x", increment=0.1)
    assert image.control == pytest.approx(other.control) and image.block == other.block


def test_where_the_first_mechanism_is_local_the_curve_is_of_what_goes_farthest():
    """From a settled state the first motion may close a hinge; the point chosen moves with the curve all the same."""
    project, model = template("buttressed-arch"), assembly("buttressed-arch", 1)
    (table,) = project.settlements
    state = pushdown(model, table.support, table.displacement_m, increment=0.004).final
    for direction in ("+x", "-x"):
        path = pushover(model, direction=direction, increment=0.005, state=state)
        assert path.displacement.max() > 0.01 and path.multiplier.max() > 0.1


def settled_portal(*beside: Block) -> tuple[Assembly, State]:
    """A portal whose left support has moved out and down, and blocks on it or on its right support."""
    stone = Material(20.0, 0.7)
    supports = [
        Block(rectangle(left, -0.3, right, 0.0), 1.0, stone, support=name)
        for name, left, right in (("left", -0.5, 0.1), ("right", 1.0, 2.8))
    ]
    boxes = ((-0.4, 0.0, 0.0, 1.1), (1.1, 0.0, 1.7, 1.1), (-0.3, 1.1, 1.7, 1.5))
    model = Assembly([*supports, *(Block(rectangle(*box), 1.0, stone) for box in boxes), *beside])
    return model, pushdown(model, "left", (0.03, -0.02), increment=0.01).final


def test_a_corner_that_moves_only_as_a_settlement_closes_is_not_followed():
    model, moved = settled_portal(Block(rectangle(1.3, 1.5, 1.7, 2.1), 1.0, Material(20.0, 0.4)))
    curve = pushover(
        model, increment=0.02, state=moved
    )  # a pier closes on its support, then the block slides off
    assert curve.block == 5
    assert curve.displacement[-1] > 0.2  # half of the block hangs over; the pier has gone 0.03 m
    with pytest.raises(ControlError, match="takes no part"):
        pushover(model, (0.0, 1.5), increment=0.02, state=moved)


def test_a_corner_that_goes_back_as_another_block_goes_over_is_not_chosen():
    model, moved = settled_portal(Block(rectangle(2.2, 0.0, 2.4, 0.6), 1.0, Material(20.0, 0.7)))
    curve = pushover(model, direction="-x", increment=0.02, state=moved)  # the pier comes back as α falls
    assert curve.block == 5
    assert curve.displacement[-1] == pytest.approx(0.2, rel=0.01)


def test_a_voussoir_that_falls_back_on_its_springing_as_the_arch_goes_over_is_not_chosen():
    stone, angles = Material(18.0, 0.6), np.linspace(0.215, np.pi - 0.215, 8)
    corners = np.stack(
        [np.outer((1.0, 1.207), np.cos(angles)), np.outer((1.0, 1.207), np.sin(angles))], axis=2
    )
    inner, outer = corners
    voussoirs = [
        Block([inner[k], outer[k], outer[k + 1], inner[k + 1]], 1.0, stone) for k in range(len(inner) - 1)
    ]
    (near, far), side = corners[:, 0], np.array([-1.0, 1.0])
    under = [near, near - (0.0, 0.3), (far[0] + 0.2, near[1] - 0.3), (far[0] + 0.2, far[1]), far]
    supports = {"right": under, "left": under[::-1] * side}
    model = Assembly([*voussoirs, *(Block(at, 1.0, stone, support=name) for name, at in supports.items())])
    moved = pushdown(model, "left", (-0.003, -0.005), increment=0.001).final
    curve = pushover(model, direction="-x", increment=0.01, state=moved)
    assert curve.block != 0 and curve.displacement[-1] == pytest.approx(0.124, rel=0.01)


@pytest.mark.parametrize("width", [0.1, 0.05, 0.02])
def test_a_pinnacle_on_a_block_of_up_to_four_thousand_times_its_weight_turns_over(width):
    """α = tan(atan(b/h) − θ) until its centre is above its toe: the corner there has moved by h sin(atan(b/h))."""
    pinnacle = (-0.5 * width, 3, 0.5 * width, 3 + 5 * width)
    model = on_base(Material(18.0, 0.6), (-2, -0.3, 2), (-1.5, 0, 1.5, 3), pinnacle)
    curve = pushover(model, increment=0.001)
    assert curve.alpha_0 == pytest.approx(0.2, rel=1e-6) and curve.reached_zero
    assert curve.displacement[-1] == pytest.approx(5 * width * np.sin(np.arctan(0.2)), rel=1e-3)


def test_an_elastic_pinnacle_on_a_block_of_2000_times_its_weight_bears_what_it_bears_on_a_support():
    """Programs that are rough beside the mean weight do not see it: it was told to fall at a twentieth of that."""
    stone = Material(18.0, 0.6, 1e6, 4e5)
    base, block = rectangle(-4, -0.5, 4, 0), rectangle(-1.5, 0, 1.5, 4)
    pinnacle = [Block(rectangle(-0.1, z, 0.1, z + 0.8), 0.2, stone) for z in (0, 4)]
    alone = Assembly([Block(base, 5.0, stone, support="base"), pinnacle[0]])
    above = Assembly([Block(base, 5.0, stone, support="base"), Block(block, 5.0, stone), pinnacle[1]])
    one, two = (
        pushover(model, increment=0.005, contacts="elastic", until=0.25).alpha_0 for model in (alone, above)
    )
    assert two == pytest.approx(one, rel=5e-3)


def test_where_a_block_slides_the_first_of_equal_multipliers_is_the_activation():
    model = block_on_base(0.6, 4.2, friction=0.1)
    curve = pushover(model, (0.6, 4.2), increment=0.1)
    assert np.ptp(curve.multiplier) < 1e-6
    assert (curve.peak, curve.formed) == (0, 0)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_forces_at_every_point_of_a_settled_curve_balance_its_loads(direction):
    """Where the arch came to rest under gravity and is pushed again, the forces were those of the rest, without α."""
    project, model = template("buttressed-arch"), assembly("buttressed-arch", 1)
    (table,) = project.settlements
    state = pushdown(model, table.support, table.displacement_m, increment=0.001).final
    control = project.pushover_control(direction).point_m
    curve = pushover(model, control, direction, "rigid", 0.0005, state, until=0.7)
    for step, alpha in zip(curve.steps, curve.multiplier[1:], strict=True):
        carried = reaction(step, np.flatnonzero(~model.movable))[0]
        assert abs(carried) == pytest.approx(alpha * model.weight, abs=1e-4 * model.weight)
