"""Random assemblies and their programs, static and dynamic, for solvers to be compared on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechanics import Assembly, State
from mechanics.assembly import Behaviour
from mechanics.equilibrium import check_self_weight
from mechanics.errors import UnstableError
from mechanics.program import Program
from mechanics.static_step import programs
from tests.steps import euler_step
from tests.structures import arch_on_piers, block_on_base, running_bond, semicircular_arch


def assemblies(count: int, seed: int = 11) -> Iterator[tuple[int, Assembly]]:
    """Numbered blocks, walls, arches and arches on piers of random shape, friction and stiffness that stand."""
    rng = np.random.default_rng(seed)
    number = 0
    while number < count:
        model = _random(number % 4, rng)
        try:
            check_self_weight(model)
        except UnstableError:
            continue
        yield number, model
        number += 1


def _random(kind: int, rng: np.random.Generator) -> Assembly:
    mu, k = rng.uniform(0.3, 1.5), 10.0 ** rng.uniform(5.0, 8.0)
    a, b, segments = (int(n) for n in rng.integers(1, (5, 5, 4)))
    if kind == 0:
        return block_on_base(rng.uniform(0.1, 2.0), rng.uniform(0.1, 4.0), mu, k, segments)
    if kind == 1:
        return running_bond(a, b, rng.uniform(0.2, 0.6), rng.uniform(0.1, 0.3), mu, k)
    if kind == 2:
        return semicircular_arch(2 * a + 5, rng.uniform(0.11, 0.3), mu, k, segments)
    thickness = rng.uniform(0.1, 0.2)
    return arch_on_piers(0.6, thickness, 2 * a + 3, courses=b, friction=mu, stiffness=k, segments=segments)


def static(model: Assembly, behaviour: Behaviour) -> Program:
    """Equilibrium from the drawn state under a free multiplier whose loads do the work γ (eq. 5)."""
    size = 1e-3 * model.size
    lateral, gamma = model.lateral_load("+x"), 0.3 * size * model.weight
    start = model.initial
    return programs(model, behaviour, start, model.dead_load, size, lateral, gamma)(start.positions)


def shaken(model: Assembly, rng: np.random.Generator) -> State:
    """Blocks a little out of place, gaps open and closed, and moving."""
    unit = model.movable[:, None] * model.size * np.array([1.0, 1.0, 1.0 / model.size])
    move = rng.standard_normal((2, len(model.blocks), 3)) * unit
    return State(model.initial.positions + 1e-5 * move[0], 1e-2 * move[1])


def dynamic(model: Assembly, behaviour: Behaviour, rng: np.random.Generator, step: float = 0.005) -> Program:
    """One step of implicit Euler under a random base acceleration."""
    return euler_step(model, behaviour, shaken(model, rng), rng.uniform(-1.0, 1.0), step)
