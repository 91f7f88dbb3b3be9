"""Infinite friction: what presses does not slide, what is open bears nothing; no coefficient stands for it."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import (
    Assembly,
    Block,
    Material,
    State,
    UnstableError,
    limit_analysis,
    pushdown,
    pushover,
    time_history,
)
from mechanics.procedures import static_theorem
from mechanics.types import GRAVITY
from tests.support.random_masonry import random_masonry
from tests.support.structures import arch_on_piers, column, on_base, rectangle

STONE = Material(20.0, np.inf, 1e6)


def with_friction(model: Assembly, friction: float) -> Assembly:
    stones = [replace(block.material, friction=friction) for block in model.blocks]
    return replace(model, blocks=[replace(b, material=s) for b, s in zip(model.blocks, stones, strict=True)])


@pytest.mark.parametrize("law", ["coulomb", "associative"])
def test_a_plumb_stack_turns_about_its_foot(law):
    stack = with_friction(column(0.5, 1.0, 4), np.inf)
    assert limit_analysis(stack, sliding=law).alpha == pytest.approx(0.5 / 1.0, rel=1e-9)


def test_what_only_turns_does_so_at_any_friction():
    """Onset, ultimate displacement and forces of an arch on piers, whose joints do not slide at μ = 5 either."""
    free, rough = (pushover(with_friction(arch_on_piers(), mu), increment=0.004) for mu in (np.inf, 5.0))
    assert free.multiplier[0] == pytest.approx(rough.multiplier[0], rel=1e-9)
    assert free.displacement[-1] == pytest.approx(rough.displacement[-1], rel=1e-9)
    assert free.lifting == 0


@pytest.mark.parametrize(("seed", "by_a_thousand"), [(5, 3.37376), (13, 3.35497), (16, 2.63692)])
def test_the_associative_multiplier_is_that_of_forces_without_a_bound(seed, by_a_thousand):
    """N ≥ 0 with any T, by an independent linear program; μ = 1000 is up to 3e-4 lower."""
    model = with_friction(random_masonry(seed), np.inf)
    exact = static_theorem(model)
    assert exact > by_a_thousand * (1.0 + 1e-5)
    assert limit_analysis(model, sliding="associative").alpha == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("seed", [7, 13, 16])
def test_by_coulombs_law_what_opens_may_slip(seed):
    """Bricks lift and move sideways at once: less than the associative law, whose open joints hold them."""
    model = with_friction(random_masonry(seed), np.inf)
    found = limit_analysis(model)
    assert found.dilation == 0.0 and found.alpha < 0.999 * static_theorem(model)
    idle = found.forces[:, 0] < 1e-9 * model.weight
    assert idle.any() and abs(found.forces[idle, 2]).max() < 1e-6 * model.weight


def test_a_block_that_only_touches_a_wall_falls():
    wall = Block(rectangle(0.0, 0.0, 1.0, 3.0), 1.0, STONE, support="wall")
    with pytest.raises(UnstableError):
        limit_analysis(Assembly([wall, Block(rectangle(-0.5, 1.0, 0.0, 1.5), 1.0, STONE)]))


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_support_that_leaves_a_beam_does_not_drag_it(contacts):
    """The middle one of three goes down and aside: its joint opens, and has no shear left."""
    beam = Block(rectangle(-2.0, 0.0, 2.0, 0.4), 1.0, STONE)
    seats = [
        Block(rectangle(x - 0.2, -0.3, x + 0.2, 0.0), 1.0, STONE, support=name)
        for x, name in ((-1.5, "left"), (0.0, "middle"), (1.5, "right"))
    ]
    path = pushdown(Assembly([beam, *seats]), "middle", (0.02, -0.01), increment=0.005, contacts=contacts)
    assert path.final.positions[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert path.reaction[-1] == pytest.approx([0.0, 0.0], abs=1e-6 * beam.weight)


@pytest.mark.parametrize(
    ("contacts", "integrator"), [("rigid", "moreau-jean"), ("elastic", "implicit-euler")]
)
def test_a_block_in_the_air_moves_on_and_stops_where_it_lands(contacts, integrator):
    """Thrown at 0.1 m/s, 5 mm above its bed: it is there after √(2h/g) = 32 ms, and slides no farther."""
    model = on_base(STONE, (-2.0, -0.3, 2.0), (-1.0, 0.0, 1.0, 0.2))
    up, speed = np.array([[0.0, 0.0, 0.0], [0.0, 0.005, 0.0]]), np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    above = State(model.initial.positions + up, speed)
    path = time_history(model, np.zeros(121), 0.001, contacts, above, integrator=integrator).positions[:, 1]
    lands = np.sqrt(2.0 * 0.005 / GRAVITY)
    assert path[30, 0] == pytest.approx(0.1 * 0.030, rel=1e-6)
    assert path[-1, 0] == pytest.approx(0.1 * lands, abs=0.1 * 0.002)
    assert path[-1, 0] == pytest.approx(path[60, 0], abs=2e-5)
