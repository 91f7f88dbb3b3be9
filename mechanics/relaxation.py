"""Where a structure on elastic joints comes to rest when sliding has left it short of equilibrium.

In the program of a step what slides dilates (associated friction); in the geometry that the step leads to it does not.
There, joints that slid while they carried are less compressed than their forces ask for: by as much that geometry is no
equilibrium yet, and released it would fall until it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.equilibrium import rest
from mechanics.errors import NoEquilibriumError
from mechanics.integrators import implicit_euler
from mechanics.scene import Motion, Scene
from mechanics.static_step import JUMP, TURN, Step
from mechanics.types import GRAVITY, Array

LIFTED = 5e-5  # of the block size: what may be left of a lift, and what a step at rest moves
MOST_STEPS = 300


def lifted(model: Assembly, contacts: Behaviour, step: Step) -> float:
    """By how much (m) joints that carry lack the compression of their forces, at most; rigid ones: the gap there."""
    gap = model.kinematics(contacts, step.state.positions).gap
    missing = gap + step.program.compliance[:, 0] * step.forces[:, 0]
    return float(missing[step.state.carrying].max(initial=0.0))


def way(model: Assembly, one: Array, other: Array) -> float:
    """The longest (m) of a block from positions (b, 3) to others; a turn counts at a block's size."""
    return float((abs(other - one) * (1.0, 1.0, model.size)).max())


def come_to_rest(model: Assembly, step: Step) -> Step:
    """The rest under gravity near that of a step; itself where no joint of it is lifted.

    Sought by steps of implicit Euler that all begin at rest, which are short of an equilibrium of their own only by the
    inertia: none fails, as a static step may whose geometry goes to and fro. Raises NoEquilibriumError where they lead
    to no rest, or only to one so far that what comes down has fallen.
    """
    least, lift = LIFTED * model.size, lifted(model, "elastic", step)
    if lift <= least:
        return step
    farthest = min(JUMP * lift, TURN * model.size)
    scene, still = Scene(model, "elastic"), np.zeros_like(step.state.positions)
    duration = 0.5 * float(np.sqrt(model.size / GRAVITY))
    motion = Motion(step.state.positions, still, step.forces, step.forces[:, 1])
    for _ in range(MOST_STEPS):
        moved = implicit_euler(scene, motion, lambda _: model.dead_load, 0.0, duration)
        far = way(model, motion.x, moved.x)
        motion = replace(moved, v=still)
        whole = way(model, step.state.positions, motion.x)
        if whole > farthest:
            raise NoEquilibriumError(
                f"the structure falls: left to itself on elastic joints lifted by {lift:.2g} m "
                f"it moves by {whole:.2g} m"
            )
        if far <= least:
            springs = None if step.state.shear is None else motion.shear
            return rest(model, "elastic", State(motion.x, still, springs))
    raise NoEquilibriumError(
        f"left to itself on its elastic joints the structure comes to no rest: it goes on moving by {far:.2g} m"
    )
