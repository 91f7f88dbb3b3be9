"""A movement that begins where another one ended: the state of a support that is led by hand, and beyond it."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import ArgumentError, Following, pushdown
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
