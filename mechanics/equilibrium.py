"""States of equilibrium: whether a structure stands, where it comes to rest, what its supports carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.block import Array
from mechanics.errors import UnstableError
from mechanics.joints import Index
from mechanics.program import Program
from mechanics.solvers import BALANCED, imbalance
from mechanics.static_step import Step, assemble, elimination_of, find_step

CLOSED = 1e-3  # of the block size: a gap that is none (dilatant sliding leaves some in a settled state)


def local(rows: Array, a: Index, b: Index, displacement: Array) -> Array:
    """Change (c,) of gaps or slides that block displacements (b, 3) cause."""
    change: Array = (rows[:, :3] * displacement[a]).sum(axis=1) + (rows[:, 3:] * displacement[b]).sum(axis=1)
    return change


def closed_program(model: Assembly, state: State, lateral: Array | None = None) -> tuple[Program, Index]:
    """The rigid program over the contacts closed in a state, and their indices; γ moves the blocks by about a step."""
    size = 1e-3 * model.size
    program = assemble(
        model, "rigid", state, state.positions, model.dead_load, size, lateral, size * model.weight
    )
    closed = np.flatnonzero((program.gap[:, 0] <= CLOSED * model.size) | model.carrying(state))
    taken = program.take(closed)
    return replace(taken, gap=np.zeros_like(taken.gap)), closed


def check_self_weight(model: Assembly, state: State | None = None) -> None:
    """Raise UnstableError where gravity alone cannot be carried in a state (default: as drawn)."""
    program, closed = closed_program(model, state or model.initial)
    acceleration = imbalance(program, elimination_of(model, "rigid").take(closed))
    if acceleration > BALANCED:
        raise UnstableError(
            "the structure cannot stand under its own weight: some block would start to move with "
            f"{acceleration:.2g} g; check supports, friction and joints (open ones carry nothing)"
        )


def rest(
    model: Assembly, behaviour: Behaviour, state: State, size: float | None = None, last: Step | None = None
) -> Step:
    """The equilibrium under gravity into which a state settles: gaps closed, elastic joints compressed."""
    size = rest_size(model, behaviour) if size is None else size
    return find_step(model, behaviour, state, state.positions, model.dead_load, size, last=last)


def rest_size(model: Assembly, behaviour: Behaviour) -> float:
    """A displacement (m) on the scale of the joints' compression under gravity; rigid: 1/1000 of a block."""
    if behaviour == "rigid":
        return 1e-3 * model.size
    contacts = model.contacts(behaviour)
    ends = np.unique(contacts.joint, return_index=True)[1]  # of a joint: points at which one segment ends
    return float(np.median(model.weight / contacts.stiffness[ends, 0])) / 4.0


def reaction(model: Assembly, behaviour: Behaviour, step: Step, support: Index) -> Array:
    """Force (x, z) in kN and moment about the origin in kNm (3,) that a support exerts on the structure."""
    contacts = model.contacts(behaviour)
    entries = step.forces[:, :1] * step.program.normal + step.forces[:, 1:] * step.program.tangent
    total = np.zeros(3)
    for part, owner in ((entries[:, :3], contacts.a), (entries[:, 3:], contacts.b)):
        on = np.isin(owner, support)
        force, arm = part[on], step.at[owner[on]]
        total -= (
            *force[:, :2].sum(axis=0),
            (force[:, 2] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum(),
        )
    return total
