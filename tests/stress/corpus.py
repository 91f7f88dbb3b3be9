"""Random assemblies that stand, for solvers and procedures to be tried on."""

from collections.abc import Iterator

import numpy as np

from mechanics import Assembly
from mechanics.errors import UnstableError
from mechanics.steps.equilibrium import check_self_weight
from tests.support.structures import arch_on_piers, block_on_base, running_bond, semicircular_arch


def assemblies(count: int, seed: int = 11, segments: int | None = None) -> Iterator[tuple[int, Assembly]]:
    """Numbered blocks, walls, arches and arches on piers of random shape, friction and stiffness that stand."""
    rng = np.random.default_rng(seed)
    number = 0
    while number < count:
        model = random_assembly(number % 4, rng, segments)
        try:
            check_self_weight(model)
        except UnstableError:
            continue
        yield number, model
        number += 1


def random_assembly(kind: int, rng: np.random.Generator, segments: int | None = None) -> Assembly:
    """One of four kinds; `segments` of beds of points, None: exact ones."""
    mu, k = rng.uniform(0.3, 1.5), 10.0 ** rng.uniform(5.0, 8.0)
    a, b = (int(n) for n in rng.integers(1, 5, 2))
    if kind == 0:
        return block_on_base(rng.uniform(0.1, 2.0), rng.uniform(0.1, 4.0), mu, k, segments)
    if kind == 1:
        wall = running_bond(a, b, rng.uniform(0.2, 0.6), rng.uniform(0.1, 0.3), mu, k)
        return Assembly(wall.blocks, segments)
    if kind == 2:
        return semicircular_arch(2 * a + 5, rng.uniform(0.11, 0.3), mu, k, segments)
    thickness = rng.uniform(0.1, 0.2)
    return arch_on_piers(0.6, thickness, 2 * a + 3, courses=b, friction=mu, stiffness=k, segments=segments)
