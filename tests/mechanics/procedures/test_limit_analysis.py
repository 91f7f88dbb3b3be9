"""Limit analysis beside a linear program written apart: closed forms, settled states, ties, bounds."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mechanics import ArgumentError, Assembly, Material, Tie, limit_analysis, pushdown, pushover
from mechanics.kernels.joint import H
from mechanics.model.contacts import end_gaps, forces_on_blocks
from mechanics.procedures import limit_in, static_theorem
from mechanics.procedures.limit_analysis import friction_work, hinges, virtual_work_multiplier
from mechanics.procedures.push_path import PUSHOVER
from mechanics.procedures.static_theorem import PointForces
from mechanics.program import end_forces
from tests.support.drawn_projects import drawn, tables
from tests.support.random_masonry import random_masonry, small_wall
from tests.support.structures import (
    arch_on_piers,
    block_on_base,
    built,
    column,
    running_bond,
    semicircular_arch,
)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize(
    "model",
    [arch_on_piers(), column(0.5, 1.0, 4, friction=0.3), semicircular_arch(15, 0.2), running_bond()],
    ids=["turns", "slides", "arch", "wall"],
)
def test_as_drawn_it_is_the_multiplier_of_limit_analysis(model, direction):
    assert static_theorem(model, direction) == pytest.approx(
        limit_analysis(model, direction, sliding="associative").alpha, rel=1e-8
    )


@pytest.mark.parametrize("movement", [0.02, 0.0002])
def test_in_a_settled_state_whose_hinges_have_opened_far_or_a_little(movement):
    model = arch_on_piers()
    state = pushdown(model, "right", (movement, -movement), increment=0.1 * movement).final
    expected = limit_in(model, "-x", state).alpha
    assert expected < 0.95 * limit_analysis(model, "-x").alpha  # the settlement counts
    assert static_theorem(model, "-x", state) == pytest.approx(expected, rel=1e-6)


def test_where_sliding_has_lifted_blocks_the_forces_act_at_the_corners_that_touch():
    """The tuff panel, whose joints slide in the settlement and lift by it; midway of the gaps α is 5e-5 off."""
    model, movement = drawn("tuff_panel"), tables("tuff_panel")["settlements"][0]
    moved = pushdown(
        model, movement["support"], movement["displacement_m"], increment=movement["increment_m"],
        sliding="associative",
    )  # fmt: skip
    control = tables("tuff_panel")["control"][0]["point_m"]
    whole = replace(PUSHOVER, flat=0.5)  # no motion is asked what is borne of the rise behind a trough
    path = pushover(model, control, "+x", "rigid", 0.002, moved.final, 0.95, "associative", whole)
    peak = int(path.multiplier.argmax())
    at = path.states[peak]
    expected = limit_in(model, "+x", at, "associative").alpha
    assert peak > 0 and static_theorem(model, "+x", at) == pytest.approx(expected, rel=1e-6)
    assert path.multiplier[peak] == pytest.approx(expected, rel=2e-3)  # docs/accuracy.md


def test_joints_that_crush_make_no_linear_program():
    with pytest.raises(ArgumentError, match="crush"):
        static_theorem(column(0.5, 1.0, 2, strength=100.0))


def test_a_fiftieth_of_the_largest_motion_makes_a_hinge_or_a_slide():
    """Of three blocks each above the other the second joint has 1.4 % of the turn or the way, the third 2.4 %."""
    model = column(0.5, 3.0, 3)
    pressed = np.tile([model.weight, 0.0, 0.0], (3, 1))
    for component, hinged, sliding in ((2, 2, None), (0, 0, [0, 2])):
        mechanism = np.zeros((4, 3))
        mechanism[model.movable, component] = 1.0, 1.015, 1.04
        found = hinges(model, model.contacts, model.initial, mechanism, pressed)
        assert len(found.points) == hinged
        assert sliding is None or found.sliding.tolist() == sliding


def test_every_force_acts_on_both_blocks_and_balances():
    """Unit forces at (1, 2) m along the normal (0, 1) and the tangent (1, 0) on a block centred at (0.5, 1.5)."""
    points = PointForces(
        a=np.array([1]), b=np.array([0]), normal=np.array([[0.0, 1.0]]), friction=np.array([0.5]),
        joint=np.array([0]), pressure_at=np.array([[1.0, 2.0]]), friction_at=np.array([[1.0, 2.0]]),
        most=np.array([np.inf]),
    )  # fmt: skip
    centroids = np.array([[0.0, 0.0], [0.5, 1.5]])
    matrix = points.equilibrium(centroids, np.array([True, True]), 1.0).toarray()
    on_a, on_b = matrix[3:], matrix[:3]
    assert on_a.T.tolist() == [[0.0, 1.0, 0.5], [1.0, 0.0, -0.5]]
    assert on_b[:2] == pytest.approx(-on_a[:2])
    assert on_b[2].tolist() == [-1.0, 2.0]


def flat_arch(voussoirs: int, span: float, height: float, friction: float) -> Assembly:
    """Voussoirs between two piers whose inner faces lean outwards above the springing."""
    stone, deep, wide = Material(20.0, friction), 0.6, 0.5
    below, above = (share * span * np.linspace(-0.5, 0.5, voussoirs + 1) for share in (1.0, 1.24))
    pier = np.array([(below[0] - wide, -deep), (below[0], -deep), (below[0], 0.0), (above[0], height),
                     (below[0] - wide, height)])  # fmt: skip
    inner, outer = below[0] + 0.2, below[0] - wide - 0.2
    stones = [
        [(a, 0.0), (b, 0.0), (d, height), (c, height)]
        for (a, b), (c, d) in zip(pairwise(below), pairwise(above), strict=True)
    ]
    return built(
        stone, pier, (pier * (-1.0, 1.0))[::-1], *stones, left=(outer, -deep - 0.3, inner, -deep),
        right=(-inner, -deep - 0.3, -outer, -deep),
    )  # fmt: skip


CRACKED = [(flat_arch(3, 1.2, 0.35, 0.7), (0.05, -0.05)), (flat_arch(5, 1.0, 0.35, 0.65), (0.0, -0.12))]


@pytest.mark.parametrize(("model", "movement"), CRACKED)
def test_cracks_bear_nothing_in_the_mechanism_of_a_settled_state(model, movement):
    """A mechanism of little work moved so far that cracks closed and bore: 2.4 and 4.9 times the multiplier."""
    settled = pushdown(model, "right", movement, increment=0.03).final
    associative = limit_analysis(model, "+x", settled, "associative").alpha
    limit = limit_analysis(model, "+x", settled)
    assert limit.alpha <= associative + 1e-6

    places = limit.contacts.places(settled.positions)
    cracks = end_gaps(places) > 1e-5 * model.size
    assert cracks.any()
    assert abs(end_forces(limit.forces, places[:, H]))[cracks].max() < 1e-9 * model.weight
    entries = forces_on_blocks(places, limit.forces)
    total = model.dead_load + limit.alpha * model.lateral_load("+x")
    np.add.at(total, limit.contacts.a, entries[:, :3])
    np.add.at(total, limit.contacts.b, entries[:, 3:])
    assert abs(total[model.movable]).max() < 1e-8 * model.weight


@pytest.mark.parametrize("increment", [0.03, 0.01, 0.005])
def test_a_settled_arch_has_no_more_left_by_coarse_increments(increment):
    """It was told 0.15 by increments of 10 mm and more, and 0.0001 by 5 mm, after four jumps."""
    model, movement = CRACKED[0]
    path = pushdown(model, "right", movement, increment=increment)
    assert len(path.crossed) == 0
    assert abs(limit_analysis(model, "+x", path.final).alpha) < 1e-3


@pytest.mark.parametrize("seed", range(0, 90, 15))
def test_tie_on_settled(seed):
    """Of arches whose right support has spread, by either law; the tie is set after the movement."""
    model, sliding = random_masonry(seed), "associative" if seed % 2 else "coulomb"
    settled = pushdown(model, "right", (0.02, -0.01), increment=0.005, sliding=sliding).final
    movable = [block for block in model.blocks if block.support is None]
    first, last = movable[0].centroid, movable[-1].centroid
    tie = Tie("chain", tuple(first), tuple(last), 50.0)
    without = limit_analysis(model, state=settled, sliding=sliding).alpha
    with_tie = limit_analysis(model.tied([tie]), state=settled, sliding=sliding).alpha
    assert with_tie >= (1.0 - 1e-6) * without


STONES = (  # corners on a grid of 0.5 m × 0.35 m
    "20 22 12 11 01 00", "50 51 31 32 22 20", "11 12 02 01", "51 52 42 43 33 31", "12 13 03 02", "32 34 14 12",
    "52 53 43 42", "13 14 04 03", "53 54 34 33",
)  # fmt: skip


def test_the_least_multiplier_of_a_mechanism_that_no_load_holds_is_found():
    """α = −1e-11 was less than itself by a share of it, and the search went on without end."""
    stones = [[(0.5 * int(x), 0.35 * int(z)) for x, z in stone.split()] for stone in STONES]
    model = built(Material(20.0, 0.35), *stones, left=(-0.5, -0.3, 1.0, 0.0), right=(1.0, -0.3, 3.0, 0.0))
    settled = pushdown(model, "right", (0.0168, -0.0559), rotation=-0.009, increment=0.002).final
    assert limit_analysis(model, "+x", settled).alpha == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("motion", [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
def test_a_motion_on_which_the_horizontal_load_does_no_work_has_no_multiplier(motion):
    """A mechanism where blocks fall by themselves: a division by zero that stops no run, and is no finite number."""
    model = block_on_base()
    assert not np.isfinite(
        virtual_work_multiplier(model, np.tile(motion, (len(model.initial.positions), 1)), "+x")
    )


@pytest.mark.parametrize("number", [47, 58, 323])
def test_virtual_work_with_that_of_friction_gives_the_multiplier_of_what_slides(number):
    """Without it the check misses by a third and more, and a buttressed arch that slides was refused a capacity."""
    limit = limit_analysis(small_wall(number))
    taken = friction_work(limit.contacts, limit.state, limit.mechanism, limit.forces)
    found = [virtual_work_multiplier(limit.model, limit.mechanism, "+x", work) for work in (taken, 0.0)]
    assert found[0] == pytest.approx(limit.alpha, rel=1e-6)
    assert found[1] < 0.9 * limit.alpha
