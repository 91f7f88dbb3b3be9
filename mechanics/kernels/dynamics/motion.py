"""The state of a motion as the compiled loops keep it, and what follows from it."""

from __future__ import annotations

import numpy as np

from mechanics.kernels.bed_law import bed_forces, bed_work
from mechanics.kernels.crushing import leave
from mechanics.kernels.jit import compiled
from mechanics.kernels.joint import PHI, TIED, H, U
from mechanics.kernels.law import BED, SHEAR, STRENGTH
from mechanics.kernels.matrix import moved_by
from mechanics.types import Array

# where the energy of a motion is (energy, 8): stored in springs; taken by friction, impacts, dashpots and the
# stepping; put in; the largest kinetic energy so far, by which what steps take is measured; and that of friction which
# slides that turn back within steps leave uncertain
ELASTIC, FRICTION_WORK, IMPACT, VISCOUS, STEPPING, INPUT, LARGEST, TURNED = range(8)
ENERGIES = 8
# columns of the state of a joint (joints, j × 25): N₁, N₂, T and y₁, y₂, λ₊, λ₋ of the last program; of rigid ones
# the same of its central iterate, gaps over the length of the step (program); spring in shear, kN; gap of the blocks
# less that of the bed, m; by how much a tie is longer than as it was made, m; what a bed remembers of having been
# crushed (law)
N1, GAPS, MIDDLE, SPRING, SUNK, LONGER, REMAINS = 0, 3, 7, 14, 15, 16, 17
JOINT = 25
STANDARD_GRAVITY = 9.80665  # m/s²
GONE = 1e-9  # of the block size: an overlap that is none


@compiled
def relative(p: Array, a: int, b: int, moved: Array) -> tuple[float, float, float]:
    """Changes of u, φ and v of a joint at p (PLACE,) under displacements (b, 3), with the lever of its place.

    As matrix.motion, whose displacements are in the order of elimination; a view of these by rows took 13 % of a step.
    """
    return moved_by(p, moved[a, 0], moved[a, 1], moved[a, 2], moved[b, 0], moved[b, 1], moved[b, 2])


@compiled
def crushable(p: Array, law: Array) -> bool:
    """Whether a joint at a place p (PLACE,) is a bed that can be crushed; ties yield, see gaps."""
    return bool(law[STRENGTH] < np.inf and p[TIED] == 0.0)


@compiled
def work_on_bed(p: Array, u: float, law: Array, joint: Array) -> float:
    """The work (kNm) that presses the bed of a joint at a place p (PLACE,) to the gap u at its middle."""
    strength = law[STRENGTH] if crushable(p, law) else np.inf
    return bed_work(law, strength, joint[REMAINS:], p[H], u, p[PHI])


@compiled
def bed_under(
    p: Array, u: float, phi: float, law: Array, joint: Array
) -> tuple[float, float, float, float, float]:
    """N, P and −∂N/∂u, −∂N/∂φ, −∂P/∂φ of the bed of a joint at a place p (PLACE,) under the gap u + φs."""
    strength = law[STRENGTH] if crushable(p, law) else np.inf
    return bed_forces(law, strength, joint[REMAINS:], p[H], u, phi)


@compiled
def remember(places: Array, law: Array, joints: Array, size: float) -> None:
    """Let the beds of `joints` at places (j, PLACE) remember as what they are there of having been crushed."""
    for k in range(len(places)):
        if places[k, H] > GONE * size and crushable(places[k], law[k]):
            u = places[k, U] - joints[k, SUNK]
            leave(u, places[k, PHI], places[k, H], law[k, BED], law[k, STRENGTH], joints[k, REMAINS:])


@compiled
def strain_energy(places: Array, law: Array, joints: Array, size: float) -> float:
    """Energy (kNm) stored in the beds at places (j, PLACE), and in springs in shear with the forces of `joints`."""
    total = 0.0
    for k in range(len(places)):
        if places[k, H] > GONE * size:
            total += work_on_bed(places[k], places[k, U], law[k], joints[k])
        total += 0.5 * law[k, SHEAR] * joints[k, SPRING] ** 2
    return total


@compiled
def elastic_beds(law: Array) -> bool:
    """Whether joints of the `law` (j, LAW) are elastic; none are not."""
    return len(law) > 0 and law[0, BED] < np.inf
