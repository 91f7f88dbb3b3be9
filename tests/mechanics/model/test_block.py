"""Blocks, their joints and ties: where they are found, elongations and their derivatives, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, Block, Material, Tie, limit_analysis, pushdown, pushover
from mechanics.kernels.joint import CURVED, U, V, curvature
from mechanics.model.block import default_tolerance, find_joints
from mechanics.model.contacts import end_gaps, rows
from mechanics.types import GRAVITY
from tests.support.reference_loops import derivative, scattered, turned
from tests.support.structures import (
    column,
    rectangle,
    running_bond,
    tied_arch,
)

STONE = Material(18.0, 0.7, 1e6)
TOLERANCE = 1e-3


def joints_of(*polygons, tolerance=TOLERANCE):
    return find_joints([Block(p, 1.0, STONE) for p in polygons], tolerance)


def initial_gap(model):
    return end_gaps(model.contacts.places(model.initial.positions))


def test_two_blocks_side_by_side_share_one_joint_with_the_whole_face():
    joints = joints_of(rectangle(0, 0, 1, 2), rectangle(1, 0, 2, 2))
    assert (joints.a.tolist(), joints.b.tolist()) == ([0], [1])
    assert joints.length == pytest.approx([2.0])


def test_partial_overlap_has_the_length_of_what_both_edges_cover():
    joints = joints_of(rectangle(0, 0, 3, 1), rectangle(1, 1, 5, 2))
    assert joints.length == pytest.approx([2.0])
    assert np.sort(joints.ends[0, :, 0]) == pytest.approx([1.0, 3.0])
    # the contact may slide until it leaves the facing edge
    assert np.ptp(joints.room_a, axis=1) == pytest.approx([3.0])
    assert np.ptp(joints.room_b, axis=1) == pytest.approx([4.0])


def test_l_contact():
    l_shape = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]]
    joints = joints_of(l_shape, rectangle(1, 1, 2, 2))
    assert joints.length == pytest.approx([1.0, 1.0])
    assert sorted(abs(joints.tangent[:, 0])) == pytest.approx([0.0, 1.0])


def test_supports_have_no_joint_between_them():
    supports = [Block(rectangle(k, 0, k + 1, 1), 1.0, STONE, support=f"s{k}") for k in (0, 1)]
    assert len(find_joints(supports, TOLERANCE).a) == 0


GAPS = [(-1.1, 0, 0), (-0.9, 0, 1), (0.0, 0, 1), (0.9, 0, 1), (1.1, 0, 0)]
CORNERS = [(0.0, 1, 0), (-0.9, 1, 0), (-1.1, 1, 1)]


@pytest.mark.parametrize(("share", "z", "found"), [*GAPS, *CORNERS])
def test_tolerance_bounds_the_gap_and_what_overlaps_beyond_a_shared_corner(share, z, found):
    joints = joints_of(rectangle(0, 0, 1, 1), rectangle(1 + share * TOLERANCE, z, 2, z + 1))
    assert len(joints.a) == found


@pytest.mark.parametrize(("share", "found"), [(0.9, 1), (1.1, 0)])
def test_nearly_parallel_edges_touch_if_both_ends_do(share, found):
    wedge = [[0, 1], [1, 1 + share * TOLERANCE], [1, 2], [0, 2]]
    assert len(joints_of(rectangle(0, 0, 1, 1), wedge).a) == found


@pytest.mark.parametrize("angle", [0.7, np.pi, -1.3])
def test_the_direction_of_a_joint_does_not_matter(angle):
    walls, shift = (
        (rectangle(0, 0, 3, 1), rectangle(1, 1, 5, 2), rectangle(0, 1, 1, 3)),
        np.array([7.0, -2.0]),
    )
    upright, joints = joints_of(*walls), joints_of(*(turned(p, angle) + shift for p in walls))
    assert joints.length == pytest.approx(upright.length)
    assert joints.ends == pytest.approx(
        (turned(upright.ends.reshape(-1, 2), angle) + shift).reshape(-1, 2, 2)
    )


def test_collinear_vertices_are_passed_over():
    plain = rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)
    dotted = [[0, 0], [0.2, 0], [1, 0], [1, 0.5], [1, 1], [0.7, 1], [0.31, 1], [0, 1]]
    assert joints_of(dotted, plain[1]).length == pytest.approx(joints_of(*plain).length)


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_inaccuracies_of_the_drawing_change_no_joint_and_open_no_gap(seed):
    exact = running_bond(columns=3, courses=3)
    noise = np.random.default_rng(seed)
    tolerance = exact.joint_tolerance

    def shaken(block):
        # two faces may part by both their errors, so each stays within a third of the tolerance
        off = noise.uniform(-tolerance / 3.0, tolerance / 3.0, np.shape(block.polygon))
        return replace(block, vertices=block.polygon + off)

    drawn = Assembly([shaken(b) for b in exact.blocks], tolerance=tolerance)
    assert [drawn.joints.a.tolist(), drawn.joints.b.tolist()] == [
        exact.joints.a.tolist(),
        exact.joints.b.tolist(),
    ]
    assert drawn.joints.length == pytest.approx(exact.joints.length, abs=2.0 * tolerance)
    assert initial_gap(drawn) == pytest.approx(0.0, abs=1e-14)


def test_default_tolerance_is_a_thousandth_of_the_median_edge():
    assert default_tolerance([Block(rectangle(0, 0, 2, 2), 1.0, STONE)]) == pytest.approx(2e-3)


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


UTM = np.array([498123.4, 4601237.7])  # m, of no use to binary fractions


def elsewhere(model: Assembly) -> Assembly:
    """The model drawn at UTM coordinates."""
    blocks = [replace(block, vertices=block.polygon + UTM) for block in model.blocks]
    ties = [replace(tie, start=tie.start + UTM, end=tie.end + UTM) for tie in model.ties]
    return Assembly(blocks, model.segments_per_joint, model.tolerance, model.collisions, ties)


def test_positions_count_from_whole_metres_near_what_is_drawn_far_away():
    near, far = column(0.5, 3.0, 4), elsewhere(column(0.5, 3.0, 4))
    assert near.origin.tolist() == [0.0, 0.0]
    assert far.origin.tolist() == [498122.0, 4601237.0]
    drawn = far.as_drawn(far.initial.positions[:, :2])
    assert drawn == pytest.approx(near.initial.positions[:, :2] + UTM, abs=2e-9)
    assert far.joints.ends == pytest.approx(near.joints.ends + UTM, abs=2e-9)
    assert far.block_at(np.add(UTM, (0.2, 2.9))) == near.block_at((0.2, 2.9)) == 4
    turned = far.rotated(1, np.add(UTM, (0.5, 0.0)), -0.1), near.rotated(1, (0.5, 0.0), -0.1)
    assert far.as_drawn(turned[0].positions[1, :2]) == pytest.approx(turned[1].positions[1, :2] + UTM)


def test_elastic_paths_are_those_at_the_origin():
    """Joints that are stiff beside the weight: a billionth of a metre would be a load."""
    near = column(0.5, 3.0, 3, 1e9)
    curves = [
        pushover(model, np.add(at, (0.5, 3.0)), "+x", "elastic", 0.005)
        for model, at in ((near, 0.0 * UTM), (elsewhere(near), UTM))
    ]
    assert curves[1].multiplier == pytest.approx(curves[0].multiplier, rel=1e-6)
    assert curves[1].displacement == pytest.approx(curves[0].displacement, rel=1e-6)
    assert curves[1].end.template == curves[0].end.template


def test_rigid_paths_movements_and_ties_are_those_at_the_origin():
    near = tied_arch(2.0)
    far = elsewhere(near)
    assert limit_analysis(far).alpha == pytest.approx(limit_analysis(near).alpha, rel=1e-7)
    settled = [pushdown(m, "right", (0.01, -0.01), increment=0.002, contacts="rigid") for m in (near, far)]
    assert settled[1].reaction == pytest.approx(settled[0].reaction, rel=1e-6, abs=1e-8)
    assert settled[1].final.positions + np.append(far.origin - UTM, 0.0) == pytest.approx(
        settled[0].final.positions, abs=1e-8
    )
    alphas = [limit_analysis(m, state=s.final).alpha for m, s in zip((near, far), settled, strict=True)]
    assert alphas[1] == pytest.approx(alphas[0], rel=1e-6)


MODEL = tied_arch()
TIES = np.flatnonzero(MODEL.contacts.ties)
seeds = st.integers(0, 2**32 - 1)


def ends(at, tie):
    """Both ends (2, 2) of a tie where its two blocks are at (6,)."""
    contacts, centroid = MODEL.contacts, MODEL.initial.positions[:, :2]
    found = []
    for block, point, place in zip(
        (contacts.a[tie], contacts.b[tie]), MODEL.ties[tie - TIES[0]].points, (at[:3], at[3:]), strict=True
    ):
        c, s = np.cos(place[2]), np.sin(place[2])
        found.append(place[:2] + np.array([[c, -s], [s, c]]) @ (point - centroid[block]))
    return np.array(found)


def closing(at, tie):
    """The length as drawn less the distance of the ends."""
    drawn = MODEL.ties[tie - TIES[0]].points
    one, other = ends(at, tie)
    return np.linalg.norm(drawn[1] - drawn[0]) - np.linalg.norm(other - one)


def anywhere(seed, amount, tie):
    """The place (PLACE,) of a tie in a random configuration, and where its blocks are, (6,)."""
    contacts, positions = MODEL.contacts, scattered(MODEL, seed, amount)
    return contacts.places(positions)[tie], np.r_[positions[contacts.a[tie]], positions[contacts.b[tie]]]


@settings(max_examples=25)
@given(seed=seeds, amount=st.sampled_from([1e-3, 0.05, 0.3]), tie=st.sampled_from(TIES.tolist()))
def test_the_elongation_of_a_tie_and_its_first_derivatives(seed, amount, tie):
    place, at = anywhere(seed, amount, tie)
    assert place[U] == pytest.approx(closing(at, tie), abs=1e-12)
    found = rows(place[None])[0]
    assert found[0] == pytest.approx(derivative(lambda x: closing(x, tie), at=at), abs=1e-8)
    assert not found[1].any()
    assert place[V] == 0.0


@settings(max_examples=25)
@given(seed=seeds, amount=st.sampled_from([1e-3, 0.05, 0.3]), tie=st.sampled_from(TIES.tolist()))
def test_the_curvature_of_a_tie_is_the_second_derivative_of_its_elongation(seed, amount, tie):
    place, at = anywhere(seed, amount, tie)
    out, force = np.empty(CURVED), 3.0
    curvature(place, force, 0.0, 0.0, out)
    full = np.zeros((6, 6))
    across = np.array([[out[7], out[8]], [out[8], out[9]]])
    full[:2, :2], full[3:5, 3:5], full[:2, 3:5], full[3:5, :2] = across, across, -across, -across
    for turn, lever in ((2, out[:2]), (5, out[2:4])):
        full[turn, :2] = full[:2, turn] = lever
        full[turn, 3:5] = full[3:5, turn] = -lever
    full[2, 2], full[2, 5], full[5, 2], full[5, 5] = out[4], out[5], out[5], out[6]
    gradient = lambda x: derivative(lambda y: force * closing(y, tie), 1e-4, x)  # noqa: E731
    assert derivative(gradient, 1e-4, at) == pytest.approx(full, abs=2e-5)


def test_ties_come_after_the_joints_and_stay_what_they_are_when_blocks_move_apart():
    contacts = MODEL.contacts
    assert TIES.tolist() == [len(MODEL.joints.a), len(MODEL.joints.a) + 1]
    assert MODEL.tie_blocks.tolist() == np.stack([contacts.a, contacts.b], axis=1)[TIES].tolist()
    assert not MODEL.tied([]).contacts.ties.any()


BASE = Block(rectangle(-1.0, -1.0, 3.0, 0.0), 1.0, STONE, support="base")
LEFT, RIGHT = (
    Block(rectangle(0.0, 0.0, 1.0, 2.0), 1.0, STONE),
    Block(rectangle(2.0, 0.0, 3.0, 2.0), 1.0, STONE),
)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"start": (1.5, 1.0)}, 'start of tie "chain" = .* in or on a block'),
        ({"end": (1.0, 2.0)}, 'tie "chain" = .*both ends in block 1.*two blocks that can move'),
        ({"start": (-0.5, -0.5), "end": (2.5, -0.5)}, "both ends in block 0"),
        ({"end": (0.5, 1.0)}, "end = .*another point than start"),
        ({"end": (np.nan, 1.0)}, r"end = .*a point \(x, z\) in m"),
        ({"yield_force": 0.0}, "yield_force = 0.0: must be positive, in kN"),
        ({"stiffness": 0.0}, "stiffness = 0.0: must be positive, in kN/m"),
        ({"pretension": 50.0}, "pretension = 50.0: must be from zero to less than yield_force"),
        ({"length": 0.0}, "length = 0.0: must be positive, in m"),
        ({"name": ""}, "name = ''"),
    ],
)
def test_a_tie_that_is_none_is_refused(wrong, told):
    right = {"name": "chain", "start": (0.5, 1.0), "end": (2.5, 1.0), "yield_force": 50.0}
    with pytest.raises(ValueError, match=told):
        Assembly([BASE, LEFT, RIGHT], ties=[Tie(**right | wrong)])
    assert len(Assembly([BASE, LEFT, RIGHT], ties=[Tie(**right)]).ties) == 1


def test_ties_are_a_sequence_of_ties():
    with pytest.raises(ValueError, match=r"ties = .*a sequence of Tie"):
        Assembly([BASE, LEFT, RIGHT], ties=["chain"])
