"""Movements of supports: in succession, led by hand, several at once."""

import numpy as np
import pytest

from mechanics import ArgumentError, Assembly, Block, Following, Material, limit_analysis, pushdown
from mechanics.procedures import SupportMovement, pushdown_together
from tests.support.structures import arch_on_piers, column

MOVED = np.array([0.012, -0.008])


@pytest.fixture(scope="module")
def arch():
    return arch_on_piers(voussoirs=9, courses=3)


@pytest.mark.parametrize("sliding", ["associative", "coulomb"])
def test_forth_and_back_is_the_support_led_by_hand(arch, sliding):
    """Two formulations: increments of a movement from a state, and a support led along the same way."""
    forth = pushdown(arch, "right", MOVED, increment=0.002, sliding=sliding)
    back = pushdown(arch, "right", -0.75 * MOVED, increment=0.002, sliding=sliding, state=forth.final)
    follow = Following(arch, "right", sliding=sliding, increment=0.002)
    follow.to(MOVED)
    assert follow.reaction == pytest.approx(forth.reaction[-1], rel=1e-3)
    assert (follow.reached.tolist(), follow.fallen, follow.stopped) == ([*MOVED, 0.0], False, None)
    state = follow.to(0.25 * MOVED)
    assert abs(state.positions - back.final.positions).max() < 1e-9
    assert back.movement[0] == 0.0 and back.movement[-1] == pytest.approx(0.75 * MOVED[0])
    assert back.states[0].positions == pytest.approx(forth.final.positions, abs=1e-9)


def test_a_turned_support_turns_on_from_where_it_is():
    """A column goes with its base as a rigid body, by the sum of two movements: displacements and rotations add up."""
    model = column(1.0, 2.0, 3)
    first = pushdown(model, "base", (0.02, 0.01), rotation=0.02, increment=0.01)
    second = pushdown(model, "base", (-0.05, 0.0), rotation=-0.03, increment=0.01, state=first.final)
    once = pushdown(model, "base", (-0.03, 0.01), rotation=-0.01, increment=0.01)
    assert second.final.positions == pytest.approx(once.final.positions, abs=1e-7)
    where, turn = model.support_movement(second.final.positions, "base")
    assert [*where, turn] == pytest.approx([-0.03, 0.01, -0.01], abs=1e-12)


def test_another_support_leaves_the_first_one_where_it_is(arch):
    first = pushdown(arch, "right", MOVED, increment=0.004)
    both = pushdown(arch, "left", (-0.004, 0.0), increment=0.004, state=first.final).final.positions
    assert arch.support_movement(both, "right")[0] == pytest.approx(MOVED, abs=1e-12)
    assert arch.support_movement(both, "left")[0] == pytest.approx([-0.004, 0.0], abs=1e-12)


def test_a_state_of_other_blocks_is_refused(arch):
    with pytest.raises(ArgumentError, match="state"):
        pushdown(arch, "right", MOVED, state=column(1.0, 2.0, 3).initial)


def test_it_stops_before_the_ultimate_movement_and_goes_back_from_there(arch):
    increment = 0.02
    ultimate = pushdown(arch, "right", (increment, 0.0), increment=increment, to_collapse=True).ultimate
    follow = Following(arch, "right", increment=increment)
    follow.to((2.0 * ultimate, 0.0))
    assert follow.fallen
    assert follow.reached[0] == pytest.approx(ultimate, abs=increment / 16.0)
    back = follow.to((0.5 * ultimate, 0.0))
    assert not follow.fallen
    assert arch.support_centre("right")[0] + 0.5 * ultimate == pytest.approx(
        back.positions[arch.support("right")[0], 0]
    )


def test_a_way_in_two_legs_ends_where_the_support_is_led():
    """A column on a base that is shifted, turned and turned back stands on it as drawn: a rigid movement."""
    model = column(1.0, 2.0, 3)
    follow = Following(model, "base", increment=0.01)
    follow.to((0.05, 0.02))
    follow.to((0.05, 0.02), rotation=0.03)
    state = follow.to((-0.01, 0.0))
    assert follow.reached.tolist() == [-0.01, 0.0, 0.0]
    assert state.positions - model.initial.positions == pytest.approx(
        np.broadcast_to([-0.01, 0.0, 0.0], (4, 3)), abs=1e-6
    )
    assert follow.reaction == pytest.approx([0.0, model.weight], abs=1e-6 * model.weight)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"support": "middle"}, "support"),
        ({"increment": 0.0}, "increment"),
        ({"contacts": "soft"}, "contacts"),
    ],
)
def test_wrong_arguments_are_named(arch, given, named):
    with pytest.raises(ArgumentError, match=named):
        Following(arch, **{"support": "right", **given})


def test_supports_that_move_alike_carry_the_structure_with_them(arch):
    # equilibrium is solved to 1e-8 of a weight, positions to 1e-8 of a block: 1e-7 m
    by = (0.004, -0.003)
    found = pushdown_together(arch, [SupportMovement("right", by), SupportMovement("left", by)], 0.001)
    moved = found.final.positions - arch.initial.positions
    assert moved == pytest.approx(np.tile([*by, 0.0], (len(moved), 1)), abs=1e-7)


def test_what_one_support_spreads_is_what_two_share():
    """In another frame the right support alone moves by 8 mm: shapes differ by a translation of half of it.

    The arch has a joint at its crown: beside a keystone the hinge would open on either side, as rounding chooses.
    """
    arch = arch_on_piers(voussoirs=8, courses=3)
    both = pushdown_together(
        arch, [SupportMovement("right", (0.004, 0.0)), SupportMovement("left", (-0.004, 0.0))], 0.001
    )
    one = pushdown(arch, "right", (0.008, 0.0), increment=0.002)
    shift = one.final.positions - both.final.positions
    assert shift == pytest.approx(np.tile([0.004, 0.0, 0.0], (len(shift), 1)), abs=1e-6)


def test_wrong_movements_are_named(arch):
    with pytest.raises(ArgumentError, match="movements"):
        pushdown_together(arch, [], 0.001)
    with pytest.raises(ArgumentError, match="one of left, right"):
        pushdown_together(arch, [SupportMovement("middle", (0.1, 0.0))], 0.001)


@pytest.mark.parametrize("increments", [1, 5])
def test_a_settled_state_stands_by_coarse_increments_too(increments):
    """The points of steps that were divided into short ones had forces on joints open by up to 0.7 mm."""
    foot, stone = 0.0891, Material(20.0, 0.4)
    angle = np.linspace(np.arcsin(foot), np.pi - np.arcsin(foot), 7)
    inside, outside = (r * np.column_stack([np.cos(angle), np.sin(angle)]) for r in (1.0, 1.3392))
    right = np.array([inside[0], (0.996, -0.211), (1.534, -0.211), (1.534, outside[0][1]), outside[0]])
    stones = [
        Block(np.array([inside[k], outside[k], outside[k + 1], inside[k + 1]]), 1.0, Material(18.0, mu))
        for k, mu in enumerate((0.35, 0.35, 0.4, 0.4, 0.4, 0.4))
    ]
    supports = [
        Block(right, 1.0, stone, support="right"),
        Block(right * (-1.0, 1.0), 1.0, stone, support="left"),
    ]
    model, movement = Assembly([*supports, *stones]), np.array([0.00618, -0.00695])
    settled = pushdown(model, "right", movement, 0.004, increment=0.00695 / increments * (1.0 + 1e-9)).final
    assert limit_analysis(model, "+x", settled).alpha == pytest.approx(0.0001, abs=2e-4)
    assert limit_analysis(model, "-x", settled).alpha == pytest.approx(0.1276, rel=1e-2)
