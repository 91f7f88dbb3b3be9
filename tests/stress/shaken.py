"""Fifty random structures, rigid and elastic, shaken so that many rock and slide.

Steps are solved, energy is kept, blocks stay apart.
"""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import shapely

from mechanics import Assembly, time_history
from mechanics.model.assembly import Behaviour
from mechanics.types import Array
from tests.stress.corpus import assemblies
from tests.stress.harness import Case, sound
from tests.support.structures import outlines

COUNT, TOGETHER = 50, 10
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")
STEP, DURATION = 0.005, 1.0  # s
BALANCE = 1e-4  # of the energy turned over
INSIDE = 0.02  # of the smallest block's size: how far blocks may lie in each other


def waves(number: int) -> Array:
    """Base acceleration (k,) in g: three sines of 1 to 5 Hz, 0.3 to 0.9 g at most."""
    rng = np.random.default_rng(1000 + number)
    times = STEP * np.arange(round(DURATION / STEP) + 1)
    waves = np.sin(
        2.0 * np.pi * rng.uniform(1.0, 5.0, 3)[:, None] * times + rng.uniform(0.0, 6.0, 3)[:, None]
    )
    total: Array = waves.sum(axis=0) * np.minimum(times / 0.2, 1.0)
    return rng.uniform(0.3, 0.9) * total / abs(total).max()


def deepest(model: Assembly, x: Array) -> float:
    """How far (m) two blocks lie in each other at most, at positions (b, 3): overlap over its length."""
    shapes = outlines(model, x)
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    common = shapely.intersection(
        np.array(shapes)[first[first < second]], np.array(shapes)[second[first < second]]
    )
    length = shapely.length(common)
    return float(
        np.divide(2.0 * shapely.area(common), length, out=np.zeros(len(length)), where=length > 0.0).max(
            initial=0.0
        )
    )


def shaken(number: int, model: Assembly, contacts: Behaviour) -> None:
    """One structure, up to its collapse."""
    motion = time_history(model, waves(number), STEP, contacts)
    sound(motion)
    energy = motion.energy
    # of a structure that rests there is nothing to balance
    moves = energy.turnover > 1e-12 * model.weight * model.size
    assert not moves or energy.imbalance <= BALANCE, f"energy balance {energy.imbalance:.1e}"
    into = max(deepest(model, x) for x in motion.positions[:: max(len(motion.time) // 5, 1)])
    assert into <= INSIDE * model.block_size.min(), f"blocks lie {into:.2e} m in each other"


@cache
def structures() -> tuple[tuple[int, Assembly], ...]:
    """All of them; made when they are asked for, not where tests are collected."""
    return tuple(assemblies(COUNT, seed=19))


def all_shaken(first: int, contacts: Behaviour) -> None:
    """Several structures from the first on, one after the other; which of them failed is told."""
    for number, model in structures()[first : first + TOGETHER]:
        try:
            shaken(number, model, contacts)
        except Exception as error:
            which = f"structure {number}, {len(model.blocks)} blocks, {contacts}"
            raise AssertionError(f"{which}: {type(error).__name__}: {error}") from error


def cases() -> Iterator[Case]:
    for first in range(0, COUNT, TOGETHER):
        for contacts in CONTACTS:
            name = f"structures {first} to {first + TOGETHER - 1}, {contacts}"
            yield Case("shaken", name, partial(all_shaken, first, contacts))
