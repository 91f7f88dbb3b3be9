"""A support that is led by hand: on a straight way the equilibria of a pushdown, on others some of their own."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import ArgumentError, Following, pushdown
from tests.support.structures import arch_on_piers, column

MOVED = (0.012, -0.008)


@pytest.fixture(scope="module")
def arch():
    return arch_on_piers(voussoirs=9, courses=3)


@pytest.mark.parametrize("sliding", ["associative", "coulomb"])
def test_the_straight_way_is_a_pushdown(arch, sliding):
    straight = pushdown(arch, "right", MOVED, increment=0.002, sliding=sliding)
    follow = Following(arch, "right", sliding=sliding, increment=0.002)
    state = follow.to(MOVED)
    assert abs(state.positions - straight.final.positions).max() < 1e-4 * max(map(abs, MOVED))
    assert follow.reaction == pytest.approx(straight.reaction[-1], rel=1e-3)
    assert (follow.reached.tolist(), follow.fallen, follow.stopped) == ([*MOVED, 0.0], False, None)


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
