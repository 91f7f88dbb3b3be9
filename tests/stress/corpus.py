"""Random assemblies and their programs, static and dynamic, for solvers to be compared on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechanics import Assembly, State
from mechanics.assembly import Behaviour
from mechanics.block import GRAVITY
from mechanics.equilibrium import check_self_weight
from mechanics.errors import UnstableError
from mechanics.program import Program
from mechanics.static_step import programs
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
    """One step of implicit Euler under a random base acceleration (eq. 3)."""
    state, movable, contacts = shaken(model, rng), model.movable, model.contacts(behaviour)
    rows = model.kinematics(behaviour, state.positions)
    load = model.dead_load - rng.uniform(-1.0, 1.0) * GRAVITY * model.mass * (1.0, 0.0, 0.0)
    mass = model.mass[movable].ravel() / step**2
    return Program(
        dof=np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1),
        normal=rows.normal,
        tangent=rows.tangent,
        gap=np.stack([rows.gap, np.zeros(len(contacts))], axis=1),
        friction=contacts.friction,
        compliance=np.zeros((len(contacts), 2)) if behaviour == "rigid" else 1.0 / contacts.stiffness,
        load=load[movable].ravel() + mass * step * state.velocities[movable].ravel(),
        lateral=None,
        work=0.0,
        mass=mass,
        weight=model.weight / movable.sum(),
        size=model.size,
        step=max(GRAVITY * step**2, step * abs(state.velocities[:, :2]).max()),
    )
