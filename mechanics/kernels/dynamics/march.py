"""Time steps one after another, halved where impacts take energy."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.dynamics.motion import LARGEST, SPRING, STANDARD_GRAVITY, elastic_beds
from mechanics.kernels.dynamics.program import FROM_GAPS, NEAR, RIGHT
from mechanics.kernels.dynamics.step import attempt
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
def march(
    a: Any, b: Any, faces: Array, basic: Array, row: Any, first: Any, mass: Array, dead: Array,
    base: Array, blocks: Array, joints: Array, energy: Array, h: float, theta: float, beta: float, restitution: float,
    sizes: Any, halving: Any, margin: float, radius: Array, halved: int, begun: Array, xs: Array, vs: Array, fs: Array,
    es: Array, counts: Any, stored_matrix: Array, pattern: Any,
) -> tuple[int, int, int]:  # fmt: skip
    """Steps of length h under base accelerations (k + 1, 3), m/s², linear in between, recorded in xs, vs, fs and es.

    `sizes`: weight, size of a block and what is accepted of a solution; `halving`: levels down to which a step is
    halved where it takes, or leaves unsure, more than a share of the largest kinetic energy so far, that share, levels
    where it is not solved, the share of its kinetic energy by which its velocities may be wrong, 0: as little as at
    rest, and whether the first share is of the kinetic energy of the moment; a part is as long as the one before unless
    that took little; `margin` (m): how far a corner may go from where it has `begun` (b, 3) before contacts are looked
    for anew, `radius` (b,) of blocks; `halved`: how often the last step before was; `counts` (7,): programs,
    iterations, halvings, cold starts, the worst residual of force, per weight, the largest energy (kNm) that errors of
    velocities may have, and steps in which joints lift by Coulomb's law (program.RIGHT). Returns the number of steps
    done; why the march ends, 0: all steps are done, 1: a corner has moved by the margin, 2: a program is not solved
    (the motion is as before it), 3: rigid joints rested before the last step and do after it (REST); how often it was
    halved.
    """
    weight, size, accepted = sizes
    levels, share, most, unsure, of_moment = halving
    n, c, steps = blocks.shape[1], len(a), len(base) - 1
    rigid = not elastic_beds(basic)
    load, resultants = np.empty((n, 3)), np.empty((c, 3))
    whole, deep = 1 << most, halved  # so many of the shortest steps are one; how often the next one is halved
    for k in range(steps):
        first_blocks, first_joints, first_energy = blocks.copy(), joints.copy(), energy.copy()
        gone, once, deep, halved_here = 0, True, max(deep - 1, 0), counts[2]
        rested = rigid and _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        while gone < whole:
            while gone % (whole >> deep) > 0:
                deep += 1
            step, at = h / (1 << deep), gone / whole + theta / (1 << deep)
            kinetic, fastest = _kinetic(mass, blocks[1]), 0.0
            for i in range(n):
                fastest = max(fastest, abs(blocks[1, i, 0]), abs(blocks[1, i, 1]))
                for e in range(3):
                    load[i, e] = dead[i, e] - mass[i, e] * ((1.0 - at) * base[k, e] + at * base[k + 1, e])
            energy[LARGEST] = max(energy[LARGEST], kinetic)
            kept_blocks, kept_joints, kept_energy = blocks.copy(), joints.copy(), energy.copy()
            # what is accepted of a program is a share of the way, and of a long step's of the block
            span = min(max(STANDARD_GRAVITY * step * step, fastest * step), size)
            found, taken, turned, held = False, np.inf, 0.0, 0.0
            exactly = accepted if kinetic > 0.0 or not rigid else SHARPLY * accepted
            counted = kinetic if of_moment else energy[LARGEST]
            small = share * (counted + 0.5 * weight * STANDARD_GRAVITY * step**2)
            for start in range(NEAR, FROM_GAPS + 1):
                counts[3] += start > NEAR
                found, done, taken, turned, held, force, errors, lift = attempt(
                    a, b, faces, basic, row, first, mass, load, blocks, joints, energy, step, theta, beta,
                    restitution, (weight, size, span, exactly, unsure * kinetic), resultants, stored_matrix, pattern,
                    start,
                )  # fmt: skip
                counts[0] += 1
                counts[1] += done
                if found:
                    counts[6] += lift > RIGHT
                    counts[4], counts[5] = max(counts[4], force), max(counts[5], errors)
                    break
            # blocks that meet no faster than one falls within a whole step may not have met at all
            meeting = MEETING * (counted + 0.5 * weight * STANDARD_GRAVITY * h**2)
            over = abs(taken) / small + held / meeting
            if rigid or of_moment:  # of many elastic joints slides turn with every tremor: told, not located
                over += turned / small
            if (deep < most and not found) or (deep < levels and over > 1.0 and once):
                # but the forces and gaps found: the parts begin near them
                blocks[:3], energy[:] = kept_blocks[:3], kept_energy
                joints[:, SPRING:] = kept_joints[:, SPRING:]
                counts[2] += 1
                deep += 1
                continue
            if not found:
                blocks[:], joints[:], energy[:] = first_blocks, first_joints, first_energy
                if not once:
                    return k, UNSOLVED, deep
                # once more, halved only where it is not solved
                gone, once, deep = 0, False, 0
                continue
            if over > 1.0 and rigid:
                blocks[2] = 0.0  # an impact is no acceleration
            for q in range(c):  # of elastic joints the greatest force of its parts, of rigid ones no impulse
                if gone == 0 or rigid or resultants[q, 0] >= fs[k + 1, q, 0]:
                    fs[k + 1, q] = resultants[q]
            gone += whole >> deep
            # longer again as far as that is expected to take no more than the share; at the latest in the next step
            while deep > 0 and over <= 0.5:
                deep, over = deep - 1, 2.0 * over
        still = _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        rests = rested and still and deep == 0 and halved_here == counts[2]
        xs[k + 1], vs[k + 1], es[k + 1] = blocks[0], blocks[1], energy
        far = 0.0
        for i in range(n):
            way = np.hypot(blocks[0, i, 0] - begun[i, 0], blocks[0, i, 1] - begun[i, 1])
            far = max(far, way + radius[i] * abs(blocks[0, i, 2] - begun[i, 2]))
        if far > margin:
            return k + 1, FAR, deep
        if rests:
            return k + 1, RESTS, deep
    return steps, 0, deep
