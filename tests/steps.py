"""Programs that several tests solve."""

from __future__ import annotations

import numpy as np

from mechanics import Assembly, State
from mechanics.assembly import Behaviour
from mechanics.program import Program
from mechanics.types import GRAVITY


def euler_step(
    model: Assembly, behaviour: Behaviour, state: State, acceleration: float, step: float = 0.005
) -> Program:
    """The program of an implicit Euler step under a base acceleration in g (paper, eq. 3)."""
    contacts, movable = model.contacts(behaviour), model.movable
    rows = model.kinematics(behaviour, state.positions)
    load = model.dead_load - acceleration * GRAVITY * model.mass * (1.0, 0.0, 0.0)
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
