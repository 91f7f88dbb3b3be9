"""Time steps one after another, halved where impacts take energy."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.dynamics.motion import (  # isort: skip
    LARGEST, SPRING, STANDARD_GRAVITY, Moving, Scheme, Structure, elastic_beds,
)  # fmt: skip
from mechanics.kernels.dynamics.program import FROM_GAPS, NEAR, RIGHT
from mechanics.kernels.dynamics.step import Tried, attempt
from mechanics.kernels.jit import compiled
from mechanics.types import Array

FAR, UNSOLVED, RESTS = 1, 2, 3  # why a march ends before all steps are done
MEETING = 0.1  # of the largest kinetic energy so far: elastic contacts that hold more are resolved

# kinetic energy, over W g h² of a mean block: less is rest. From rest programs are solved to so much more, of what is
# accepted, that the error of velocities is less
REST, SHARPLY = 1e-10, 1e-2


@compiled
def _kinetic(mass: Array, v: Array) -> float:
    """Kinetic energy (kNm) of blocks with velocities v (b, 3)."""
    found = 0.0
    for i in range(len(v)):
        for e in range(3):
            found += 0.5 * mass[i, e] * v[i, e] ** 2
    return found


@compiled
def _tried(
    structure: Structure, scheme: Scheme, moving: Moving, step: float, load: Array, kinetic: float, resultants: Array,
    counts: Array,
) -> Tried:  # fmt: skip
    """A part of a step, tried from one start of its program after the other.

    What is accepted of a program is a share of the way, and of a long step's of the block.
    """
    fastest, rigid = 0.0, not elastic_beds(structure.basic)
    for i in range(len(load)):
        fastest = max(fastest, abs(moving.blocks[1, i, 0]), abs(moving.blocks[1, i, 1]))
    span = min(max(STANDARD_GRAVITY * step * step, fastest * step), structure.size)
    exactly = scheme.accepted if kinetic > 0.0 or not rigid else SHARPLY * scheme.accepted
    wanted = (span, exactly, scheme.unsure * kinetic)
    for start in range(NEAR, FROM_GAPS + 1):
        counts[3] += start > NEAR
        tried = attempt(structure, scheme, moving, step, load, wanted, resultants, start)
        counts[0] += 1
        counts[1] += tried.iterations
        if tried.solved:
            counts[6] += tried.lift > RIGHT
            counts[4], counts[5] = max(counts[4], tried.force), max(counts[5], tried.errors)
            break
    return tried


@compiled
def march(
    structure: Structure, scheme: Scheme, moving: Moving, base: Array, halved: int, begun: Array, found: Any,
    counts: Array,
) -> tuple[int, int, int]:  # fmt: skip
    """Steps under base accelerations (k + 1, 3), m/s², linear in between, into `found` (dynamic_system.Recorded).

    A part of a step is as long as the one before unless that took little; `halved`: how often the last step before was;
    `begun` (b, 3): positions from where contacts were looked for; `counts` (7,): programs, iterations, halvings, cold
    starts, the worst residual of force, per weight, the largest energy (kNm) that errors of velocities may have, and
    steps in which joints lift by Coulomb's law (program.RIGHT). Returns the number of steps done; why the march ends,
    0: all steps are done, FAR: a corner has moved by the margin, UNSOLVED: a program is not solved (the motion is as
    before it), RESTS: rigid joints rested before the last step and do after it (REST); how often it was halved.
    """
    mass, weight, h, theta = structure.mass, structure.weight, scheme.h, scheme.theta
    blocks, joints, energy = moving
    n, c, steps, rigid = len(mass), len(joints), len(base) - 1, not elastic_beds(structure.basic)
    load, resultants = np.empty((n, 3)), np.empty((c, 3))
    # so many of the shortest steps are one; how often the next one is halved
    whole, deep = 1 << scheme.most, halved
    for k in range(steps):
        first_blocks, first_joints, first_energy = blocks.copy(), joints.copy(), energy.copy()
        gone, once, deep, halved_here = 0, True, max(deep - 1, 0), counts[2]
        rested = rigid and _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        while gone < whole:
            while gone % (whole >> deep) > 0:
                deep += 1
            step, at, kinetic = h / (1 << deep), gone / whole + theta / (1 << deep), _kinetic(mass, blocks[1])
            load[:] = structure.dead - mass * ((1.0 - at) * base[k] + at * base[k + 1])
            energy[LARGEST] = max(energy[LARGEST], kinetic)
            kept_blocks, kept_joints, kept_energy = blocks.copy(), joints.copy(), energy.copy()
            counted = kinetic if scheme.of_moment else energy[LARGEST]
            tried = _tried(structure, scheme, moving, step, load, kinetic, resultants, counts)
            # blocks that meet no faster than one falls within a whole step may not have met at all
            small = scheme.share * (counted + 0.5 * weight * STANDARD_GRAVITY * step**2)
            meeting = MEETING * (counted + 0.5 * weight * STANDARD_GRAVITY * h**2)
            over = abs(tried.taken) / small + tried.held / meeting
            # of many elastic joints slides turn with every tremor: told, not located
            over += tried.turned / small if rigid or scheme.of_moment else 0.0
            if (deep < scheme.most and not tried.solved) or (deep < scheme.levels and over > 1.0 and once):
                # but the forces and gaps found: the parts begin near them
                blocks[:3], energy[:] = kept_blocks[:3], kept_energy
                joints[:, SPRING:] = kept_joints[:, SPRING:]
                counts[2] += 1
                deep += 1
                continue
            if not tried.solved:
                blocks[:], joints[:], energy[:] = first_blocks, first_joints, first_energy
                if not once:
                    return k, UNSOLVED, deep
                # once more, halved only where it is not solved
                gone, once, deep = 0, False, 0
                continue
            if over > 1.0 and rigid:
                blocks[2] = 0.0  # an impact is no acceleration
            for q in range(c):  # of elastic joints the greatest force of its parts, of rigid ones no impulse
                if gone == 0 or rigid or resultants[q, 0] >= found.forces[k + 1, q, 0]:
                    found.forces[k + 1, q] = resultants[q]
            gone += whole >> deep
            # longer again as far as that is expected to take no more than the share; at the latest in the next step
            while deep > 0 and over <= 0.5:
                deep, over = deep - 1, 2.0 * over
        still = _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        found.x[k + 1], found.v[k + 1], found.energy[k + 1] = blocks[0], blocks[1], energy
        far = 0.0
        for i in range(n):
            way = np.hypot(blocks[0, i, 0] - begun[i, 0], blocks[0, i, 1] - begun[i, 1])
            far = max(far, way + structure.radius[i] * abs(blocks[0, i, 2] - begun[i, 2]))
        if far > scheme.margin:
            return k + 1, FAR, deep
        if rested and still and deep == 0 and halved_here == counts[2]:
            return k + 1, RESTS, deep
    return steps, 0, deep
