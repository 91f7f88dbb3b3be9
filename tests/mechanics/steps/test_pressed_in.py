"""Blocks that friction alone holds, of faces that nothing presses."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import (
    Assembly,
    Block,
    CollapseError,
    Material,
    UnstableError,
    limit_analysis,
    pushdown,
    pushover,
)
from mechanics.steps import unpressed
from tests.support.random_masonry import random_masonry
from tests.support.structures import arch_on_piers, rectangle, running_bond

STONE = Material(20.0, 0.84, 1e6)


def between_walls(*blocks: Block) -> Assembly:
    walls = [
        Block(rectangle(-1.0, -1.0, 0.0, 2.0), 1.0, STONE, support="left"),
        Block(rectangle(1.8, -1.0, 2.8, 2.0), 1.0, STONE, support="right"),
    ]
    return Assembly([*blocks, *walls])


BEAM = Block(rectangle(0.0, 0.0, 1.8, 0.8), 1.0, STONE)
BED = Block(rectangle(0.0, -1.0, 1.8, -0.03), 1.0, STONE, support="bed")


def test_a_beam_between_walls_hangs_by_self_stress_alone():
    """By limit analysis it stands; elastic joints have no force on faces that nothing presses, however stiff."""
    model = between_walls(BEAM)
    assert unpressed(model).tolist() == [0]
    assert unpressed(between_walls(BEAM, BED)).tolist() == [0], "30 mm above its bed"
    for stiffness in (1e5, 1e7):
        stiff = Material(20.0, 0.84, stiffness)
        soft = Assembly([Block(b.vertices, 1.0, stiff, support=b.support) for b in model.blocks])
        with pytest.raises(UnstableError, match="by friction of faces that nothing presses"):
            pushover(soft, (0.9, 0.6), "+x", "elastic", 0.005)


def test_siblings_of_a_beam_between_walls():
    """A row with upright joints, keystones that nothing wedges; a beam whose thrust is lost as a wall goes away."""
    row = [Block(rectangle(0.6 * k, 0.0, 0.6 * (k + 1), 0.8), 1.0, STONE) for k in range(3)]
    assert unpressed(between_walls(*row)).tolist() == [0, 1, 2]
    with pytest.raises(CollapseError):
        pushdown(between_walls(BEAM), "right", (0.01, 0.0), increment=0.001)


def test_what_weight_presses_together_is_not_named():
    model = random_masonry(3)
    limit_analysis(model)
    assert not len(unpressed(model))


def test_walls_and_arches_stand_pressed_by_their_weight():
    for model in (running_bond(), arch_on_piers(voussoirs=7, courses=3)):
        assert not len(unpressed(model))
    wall, loose = running_bond(3, 3), np.array([0.02, 0.0])
    held = Block(wall.blocks[-1].vertices + loose, 0.1, STONE)
    assert not len(unpressed(Assembly([*wall.blocks[:-1], held])))


@pytest.mark.parametrize("count", [10, 100])
def test_no_block_of_a_tall_stack_is_named(count: int):
    """The beds of the probe yielded by 10⁻⁴ of a block a block above: 68 of 100 sank as if they fell."""
    blocks = [Block(rectangle(-2.0, -0.5, 3.0, 0.0), 1.0, STONE, support="base")]
    blocks += [Block(rectangle(0.0, 0.3 * k, 0.6, 0.3 * (k + 1)), 1.0, STONE) for k in range(count)]
    assert not len(unpressed(Assembly(blocks)))
