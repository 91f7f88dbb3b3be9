"""Contact kinematics: rows against finite differences, invariance, and what a joint takes from its two stones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, Block, Material
from tests.structures import arch_on_piers, rectangle, running_bond

MODELS = [arch_on_piers(voussoirs=7, courses=2, segments=2), running_bond(columns=3, courses=3)]
seeds = st.integers(0, 2**32 - 1)
models = st.sampled_from(MODELS)


def scattered(model, seed, amount=0.5):
    """Positions far from the drawn ones: every block moved and turned by its own random amount."""
    off = np.random.default_rng(seed).uniform(-amount, amount, model.initial.positions.shape)
    return model.initial.positions + off


@settings(max_examples=15, deadline=None)
@given(model=models, seed=seeds, turn=st.floats(-4.0, 4.0), dx=st.floats(-3.0, 3.0), dz=st.floats(-3.0, 3.0))
def test_gaps_and_slides_do_not_feel_a_rigid_motion_of_everything(model, seed, turn, dx, dz):
    positions = scattered(model, seed)
    c, s = np.cos(turn), np.sin(turn)
    moved = np.column_stack(
        [positions[:, :2] @ np.array([[c, s], [-s, c]]) + (dx, dz), positions[:, 2] + turn]
    )
    before, after = model.kinematics("elastic", positions), model.kinematics("elastic", moved)
    assert after.gap == pytest.approx(before.gap, abs=1e-12)
    assert after.slide == pytest.approx(before.slide, abs=1e-12)


@settings(max_examples=10, deadline=None)
@given(model=models, seed=seeds)
def test_rows_are_the_derivatives_of_gap_and_slide(model, seed):
    positions = scattered(model, seed)
    contacts, rows = model.elastic_contacts, model.kinematics("elastic", positions)
    h = 1e-6
    for k in range(3):
        for first, owner in ((0, contacts.a), (3, contacts.b)):
            # each contact sees the movement of its own block alone, if only every other block of the pair moves
            for block in np.unique(owner):
                on = owner == block
                step = np.zeros_like(positions)
                step[block, k] = h
                plus, minus = (model.kinematics("elastic", positions + sign * step) for sign in (1, -1))
                assert (plus.gap - minus.gap)[on] / (2 * h) == pytest.approx(
                    rows.normal[on, first + k], abs=1e-8
                )
                assert (plus.slide - minus.slide)[on] / (2 * h) == pytest.approx(
                    rows.tangent[on, first + k], abs=1e-8
                )


@settings(max_examples=10, deadline=None)
@given(model=models, seed=seeds)
def test_rows_do_no_work_in_a_rigid_motion(model, seed):
    positions = scattered(model, seed)
    rows, contacts = model.kinematics("elastic", positions), model.elastic_contacts
    x, z = positions[:, :2].T
    one, none = np.ones_like(x), np.zeros_like(x)
    for motion in (np.stack(m, axis=1) for m in ((one, none, none), (none, one, none), (-z, x, one))):
        both = np.concatenate([motion[contacts.a], motion[contacts.b]], axis=1)
        assert (rows.normal * both).sum(axis=1) == pytest.approx(0.0, abs=1e-12)
        assert (rows.tangent * both).sum(axis=1) == pytest.approx(0.0, abs=1e-12)


def stacked(lower: Material, upper: Material, depths=(1.0, 1.0)):
    return Assembly(
        [
            Block(rectangle(0, 0, 2, 1), depths[0], lower, support="base"),
            Block(rectangle(0, 1, 2, 2), depths[1], upper),
        ]
    )


@pytest.mark.parametrize("lift", [-0.01, 0.02])
def test_a_lifted_block_opens_its_joint_by_as_much(lift):
    model = stacked(Material(18.0), Material(18.0))
    positions = model.initial.positions + np.array([[0.0, 0.0, 0.0], [0.0, lift, 0.0]])
    assert model.kinematics("rigid", positions).gap == pytest.approx(lift)


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_within_its_room_a_point_faces_the_edge(turn):
    c, s = np.cos(turn), np.sin(turn)
    along, rotation = np.array([c, s, 0.0]), np.array([[c, s], [-s, c]])
    stone = Material(18.0)
    base = Block(np.array(rectangle(0, 0, 2, 1)) @ rotation, 1.0, stone, support="base")
    model = Assembly([base, Block(np.array(rectangle(0.5, 1, 1.0, 2)) @ rotation, 1.0, stone)])
    contacts, moved = model.rigid_contacts, model.initial.positions.copy()
    for by in (-1.2, -0.6, -0.4, 0.9, 1.2):
        moved[1] = model.initial.positions[1] + by * along
        slide = model.kinematics("rigid", moved).slide
        faces = (contacts.room[:, 0] <= slide) & (slide <= contacts.room[:, 1])
        # two corners of the block above the base's edge, 2 m long; two points of that edge below the block's, 0.5 m
        upper = sorted(0.0 <= x + by <= 2.0 for x in (0.5, 1.0))
        lower = sorted(0.5 <= x - by <= 1.0 for x in (0.5, 1.0))
        assert sorted(faces[contacts.a == 1]) == upper
        assert sorted(faces[contacts.a == 0]) == lower


def test_the_smaller_friction_governs_whichever_block_has_it():
    for materials in ((Material(18.0, 0.3), Material(18.0, 0.7)), (Material(18.0, 0.7), Material(18.0, 0.3))):
        assert stacked(*materials).rigid_contacts.friction == pytest.approx(0.3)


def test_half_joints_of_unlike_stones_act_in_series():
    soft, hard = Material(18.0, 0.6, 1e6, 4e5), Material(18.0, 0.6, 3e6)
    stiffness = stacked(soft, hard).elastic_contacts.stiffness.sum(axis=0) / 2.0
    assert stiffness == pytest.approx([1.5e6, 8e5])


def test_the_smaller_depth_carries():
    stone = Material(18.0, 0.6, 1e6)
    assert stacked(stone, stone, (1.0, 0.25)).elastic_contacts.stiffness[:, 0].sum() == pytest.approx(
        1e6 * 2.0 * 0.25
    )


def test_one_stone_without_stiffness_refuses_elastic_contacts():
    with pytest.raises(ValueError, match="normal_stiffness"):
        stacked(Material(18.0, 0.6, 1e6), Material(18.0)).contacts("elastic")
