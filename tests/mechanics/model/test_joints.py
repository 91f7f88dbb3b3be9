"""Joints: which edges touch, and how they are split."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, Block, Material
from mechanics.model.block import default_tolerance, find_joints
from mechanics.model.contacts import end_gaps
from tests.support.structures import arch_on_piers, rectangle, running_bond, semicircular_arch

STONE = Material(18.0, 0.7, 1e6)
TOLERANCE = 1e-3


def joints_of(*polygons, tolerance=TOLERANCE):
    return find_joints([Block(p, 1.0, STONE) for p in polygons], tolerance)


def turned(polygon, angle, shift=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(polygon) @ np.array([[c, s], [-s, c]]) + shift


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


def test_t_contact():
    joints = joints_of(rectangle(0, 0, 5, 1), rectangle(2, 1, 3, 4))
    assert joints.length == pytest.approx([1.0])
    assert np.sort(joints.ends[0, :, 0]) == pytest.approx([2.0, 3.0])


def test_a_shared_corner_is_no_joint():
    assert len(joints_of(rectangle(0, 0, 1, 1), rectangle(1, 1, 2, 2)).a) == 0


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


@pytest.mark.parametrize("angle", [0.7, np.pi, -1.3])
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


@pytest.mark.parametrize("model", [running_bond(), arch_on_piers(), semicircular_arch(15, 0.15)])
def test_as_drawn_every_contact_is_closed(model):
    assert initial_gap(model) == pytest.approx(0.0, abs=1e-12)


def test_default_tolerance_is_a_thousandth_of_the_median_edge():
    assert default_tolerance([Block(rectangle(0, 0, 2, 2), 1.0, STONE)]) == pytest.approx(2e-3)
