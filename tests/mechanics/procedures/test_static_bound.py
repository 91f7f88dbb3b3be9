"""Coulomb's multiplier in settled states: never above the associative one, which is the largest of all by statics."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, State, limit_analysis, pushdown
from mechanics.kernels.joint import H
from mechanics.model.contacts import end_gaps, forces_on_blocks
from mechanics.program import end_forces
from tests.support.random_masonry import random_masonry, small_wall
from tests.support.structures import rectangle


def flat_arch(voussoirs: int, span: float, height: float, friction: float) -> Assembly:
    """Voussoirs between two piers whose inner faces lean outwards above the springing."""
    stone, deep, wide = Material(20.0, friction), 0.6, 0.5
    below, above = (share * span * np.linspace(-0.5, 0.5, voussoirs + 1) for share in (1.0, 1.24))
    pier = np.array([(below[0] - wide, -deep), (below[0], -deep), (below[0], 0.0), (above[0], height),
                     (below[0] - wide, height)])  # fmt: skip
    inner, outer = below[0] + 0.2, below[0] - wide - 0.2
    blocks = [
        Block(rectangle(outer, -deep - 0.3, inner, -deep), 1.0, stone, support="left"),
        Block(rectangle(-inner, -deep - 0.3, -outer, -deep), 1.0, stone, support="right"),
        Block(pier, 1.0, stone),
        Block((pier * (-1.0, 1.0))[::-1], 1.0, stone),
    ]
    for (a, b), (c, d) in zip(pairwise(below), pairwise(above), strict=True):
        blocks.append(Block([(a, 0.0), (b, 0.0), (d, height), (c, height)], 1.0, stone))
    return Assembly(blocks)


CRACKED = [(flat_arch(3, 1.2, 0.35, 0.7), (0.05, -0.05)), (flat_arch(5, 1.0, 0.35, 0.65), (0.0, -0.12))]


@pytest.mark.parametrize(("model", "movement"), CRACKED)
def test_cracks_bear_nothing_in_the_mechanism_of_a_settled_state(model, movement):
    """A mechanism of little work moved so far that cracks closed and bore: 2.4 and 4.9 times the multiplier."""
    settled = pushdown(model, "right", movement, increment=0.03).final
    associative = limit_analysis(model, "+x", settled, "associative").alpha
    limit = limit_analysis(model, "+x", settled)
    assert limit.alpha <= associative * (1.0 + 1e-6)

    places = limit.contacts.places(settled.positions)
    cracks = end_gaps(places) > 1e-5 * model.size
    assert cracks.any()
    assert abs(end_forces(limit.forces, places[:, H]))[cracks].max() < 1e-9 * model.weight
    entries = forces_on_blocks(places, limit.forces)
    total = model.dead_load + limit.alpha * model.lateral_load("+x")
    np.add.at(total, limit.contacts.a, entries[:, :3])
    np.add.at(total, limit.contacts.b, entries[:, 3:])
    assert abs(total[model.movable]).max() < 1e-8 * model.weight


def settled_states() -> Iterator[tuple[Assembly, State]]:
    """Random arches whose abutment has moved, random walls whose base leans, and flat arches."""
    for seed in (0, 18):
        arch = random_masonry(seed)
        yield arch, pushdown(arch, "right", (0.004, -0.006), increment=0.003).final
    for wall in map(small_wall, (4,)):
        yield wall, pushdown(wall, "base", rotation=0.02, increment=0.01).final
    arch = flat_arch(5, 1.2, 0.4, 0.7)
    yield arch, pushdown(arch, "right", (0.03, -0.03), increment=0.03).final


def test_coulombs_multiplier_is_not_above_the_associative_one():
    for model, state in settled_states():
        for direction in ("+x", "-x"):
            coulomb, associative = (
                limit_analysis(model, direction, state, law).alpha for law in ("coulomb", "associative")
            )
            assert coulomb <= associative * (1.0 + 1e-6)
