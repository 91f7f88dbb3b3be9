"""Joints: which edges touch, how they are split, and the contact points on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assessment.benchmark.structures import segments_apart
from mechanics import Assembly, Block, Material
from mechanics.joints import default_tolerance, find_joints
from tests.structures import arch_on_piers, rectangle, running_bond, semicircular_arch

STONE = Material(18.0, 0.7, 1e6)
TOLERANCE = 1e-3


def joints_of(*polygons, tolerance=TOLERANCE):
    return find_joints([Block(p, 1.0, STONE) for p in polygons], tolerance)


def turned(polygon, angle, shift=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(polygon) @ np.array([[c, s], [-s, c]]) + shift


def initial_gap(model):
    return model.kinematics("rigid", model.initial.positions).gap


def test_two_blocks_side_by_side_share_one_joint_with_the_whole_face():
    joints = joints_of(rectangle(0, 0, 1, 2), rectangle(1, 0, 2, 2))
    assert (joints.a.tolist(), joints.b.tolist()) == ([0], [1])
    assert joints.length == pytest.approx([2.0])


def test_the_normal_points_from_b_into_a():
    joints = joints_of(rectangle(0, 1, 1, 2), rectangle(0, 0, 1, 1))
    t = joints.tangent[0]
    assert np.array([-t[1], t[0]]) == pytest.approx([0.0, 1.0])


def test_running_bond_needs_no_extra_vertices():
    joints = joints_of(rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1), rectangle(0.3, 1, 1.7, 2))
    found = dict(zip(zip(joints.a, joints.b, strict=True), joints.length, strict=True))
    assert found == pytest.approx({(0, 1): 1.0, (0, 2): 0.7, (1, 2): 0.7})


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


def test_t_contact():
    joints = joints_of(rectangle(0, 0, 5, 1), rectangle(2, 1, 3, 4))
    assert joints.length == pytest.approx([1.0])
    assert np.sort(joints.ends[0, :, 0]) == pytest.approx([2.0, 3.0])


def test_a_shared_corner_is_no_joint():
    assert len(joints_of(rectangle(0, 0, 1, 1), rectangle(1, 1, 2, 2)).a) == 0


def test_edges_that_run_the_same_way_are_no_joint():
    assert len(joints_of(rectangle(0, 0, 1, 1), rectangle(0, 0, 1, 1)).a) == 0


def test_supports_have_no_joint_between_them():
    supports = [Block(rectangle(k, 0, k + 1, 1), 1.0, STONE, support=f"s{k}") for k in (0, 1)]
    assert len(find_joints(supports, TOLERANCE).a) == 0


@pytest.mark.parametrize(("share", "found"), [(-0.9, 1), (0.0, 1), (0.9, 1), (1.1, 0), (-1.1, 0)])
def test_tolerance_bounds_the_gap(share, found):
    joints = joints_of(rectangle(0, 0, 1, 1), rectangle(1 + share * TOLERANCE, 0, 2, 1))
    assert len(joints.a) == found


@pytest.mark.parametrize(("share", "found"), [(0.9, 0), (1.1, 1)])
def test_tolerance_bounds_the_overlap(share, found):
    joints = joints_of(rectangle(0, 0, 1, 1), rectangle(1 - share * TOLERANCE, 1, 2, 2))
    assert len(joints.a) == found


@pytest.mark.parametrize(("share", "found"), [(0.9, 1), (1.1, 0)])
def test_nearly_parallel_edges_touch_if_both_ends_do(share, found):
    wedge = [[0, 1], [1, 1 + share * TOLERANCE], [1, 2], [0, 2]]
    assert len(joints_of(rectangle(0, 0, 1, 1), wedge).a) == found


@pytest.mark.parametrize("angle", [0.1, 0.7, 2.0, np.pi, -1.3])
def test_the_direction_of_a_joint_does_not_matter(angle):
    walls = rectangle(0, 0, 3, 1), rectangle(1, 1, 5, 2), rectangle(0, 1, 1, 3)
    upright, joints = joints_of(*walls), joints_of(*(turned(p, angle, (7.0, -2.0)) for p in walls))
    assert joints.length == pytest.approx(upright.length)
    assert joints.ends == pytest.approx(
        turned(upright.ends.reshape(-1, 2), angle, (7.0, -2.0)).reshape(-1, 2, 2)
    )


def test_collinear_vertices_are_passed_over():
    plain = rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)
    dotted = [[0, 0], [0.2, 0], [1, 0], [1, 0.5], [1, 1], [0.7, 1], [0.31, 1], [0, 1]]
    assert joints_of(dotted, plain[1]).length == pytest.approx(joints_of(*plain).length)


def test_clockwise_outlines_are_read_alike():
    walls = rectangle(0, 0, 1, 1), rectangle(0.5, 1, 1.5, 2)
    assert joints_of(*(p[::-1] for p in walls)).length == pytest.approx(joints_of(*walls).length)


@settings(max_examples=20, deadline=None)
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


@pytest.mark.parametrize("model", [running_bond(), arch_on_piers(), semicircular_arch(15, 0.15)])
def test_as_drawn_every_contact_is_closed(model):
    assert initial_gap(model) == pytest.approx(0.0, abs=1e-12)


def test_default_tolerance_is_a_thousandth_of_the_median_edge():
    assert default_tolerance([Block(rectangle(0, 0, 2, 2), 1.0, STONE)]) == pytest.approx(2e-3)


@pytest.mark.parametrize("segments", [1, 3, 8])
def test_contact_points_at_the_ends_of_every_segment_on_either_side(segments):
    """Four to a segment (paper, §2), less those that a neighbour has at the same place."""
    model = Assembly(running_bond().blocks, segments_per_joint=segments)
    assert len(model.elastic_contacts) == 2 * (segments + 1) * len(model.joints.a)
    assert len(segments_apart(model).elastic_contacts) == 4 * segments * len(model.joints.a)


@pytest.mark.parametrize("segments", [1, 5])
def test_stiffness_of_the_points_adds_up_to_that_of_the_joint(segments):
    model = Assembly(
        [Block(rectangle(0, 0, 2, 1), 0.7, STONE, support="base"), Block(rectangle(0, 1, 2, 2), 0.5, STONE)],
        segments,
    )
    assert model.elastic_contacts.stiffness[:, 0].sum() == pytest.approx(1e6 * 2.0 * 0.5)


def test_a_block_may_ask_for_its_own_segments():
    piers = [replace(b, segments=8) if k > 20 else b for k, b in enumerate(arch_on_piers().blocks)]
    model = Assembly(piers, segments_per_joint=2)
    per_joint = np.bincount(model.elastic_contacts.joint) // 2 - 1
    own = np.array([b.segments or 2 for b in piers])
    assert set(per_joint) == {2, 8}
    assert (
        per_joint.tolist()
        == model.segments.tolist()
        == np.maximum(own[model.joints.a], own[model.joints.b]).tolist()
    )


def test_rigid_contacts_are_one_segment_whatever_is_asked():
    model = Assembly(running_bond().blocks, segments_per_joint=6)
    assert len(model.rigid_contacts) == 4 * len(model.joints.a)


def test_contact_points_lie_on_the_joint_and_either_block_owns_half():
    model = arch_on_piers(segments=3)
    contacts = model.elastic_contacts
    point = model.initial.positions[contacts.a, :2] + contacts.p
    ends = model.joints.ends[contacts.joint]
    length = model.joints.length[contacts.joint]
    detour = np.hypot(*(point - ends[:, 0]).T) + np.hypot(*(point - ends[:, 1]).T)
    assert detour == pytest.approx(length)
    assert (contacts.a == model.joints.a[contacts.joint]).sum() == len(contacts) // 2
