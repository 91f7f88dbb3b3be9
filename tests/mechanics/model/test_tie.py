"""Ties: where they join blocks, their elongation and its derivatives, what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics import Assembly, Block, Material, Tie
from mechanics.kernels.joint import CURVED, U, V, curvature
from mechanics.model.contacts import rows
from tests.support.reference_loops import derivative, scattered
from tests.support.structures import rectangle, tied_arch

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


STONE = Material(20.0, 0.5)
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
