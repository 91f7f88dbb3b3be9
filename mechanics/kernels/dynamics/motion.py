"""The state of a motion as the compiled loops keep it, and what follows from it."""

from __future__ import annotations

import numpy as np

from mechanics.kernels.bed import stored
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import PHI, H, U
from mechanics.kernels.law import BED, SHEAR
from mechanics.kernels.matrix import moved_by
from mechanics.types import Array

compiled = compiler("contract", "reassoc")

# where the energy of a motion is (energy, 7): stored in springs; taken by friction, impacts, dashpots and the
# stepping; put in; and the largest kinetic energy so far, by which what steps take is measured
ELASTIC, FRICTION_WORK, IMPACT, VISCOUS, STEPPING, INPUT, LARGEST = range(7)
ENERGIES = 7
# columns of the state of a joint (joints, j × 12): N₁, N₂, T and y₁, y₂, λ₊, λ₋ of the last program; force of the
# spring in shear, kN; speed of the slide, m/s, and its acceleration; gap of the blocks less that of the bed, m; by how
# much a tie is longer than as it was made, m
N1, GAPS, SPRING, SPEED, RATE, SUNK, LONGER = 0, 3, 7, 8, 9, 10, 11
JOINT = 12
STANDARD_GRAVITY = 9.80665  # m/s²
GONE = 1e-9  # of the block size: an overlap that is none


@compiled
def relative(p: Array, a: int, b: int, moved: Array) -> tuple[float, float, float]:
    """Changes of u, φ and v of a joint at p (PLACE,) under displacements (b, 3), with the lever of its place.

    As matrix.motion, whose displacements are in the order of elimination; a view of these by rows took 13 % of a step.
    """
    return moved_by(p, moved[a, 0], moved[a, 1], moved[a, 2], moved[b, 0], moved[b, 1], moved[b, 2])


@compiled
def strain_energy(places: Array, law: Array, shear: Array, size: float) -> float:
    """Energy (kNm) of the beds at places (j, PLACE) and of springs in shear with forces (j,)."""
    total = 0.0
    for k in range(len(places)):
        if places[k, H] > GONE * size:
            total += stored(places[k, U], places[k, PHI], places[k, H], law[k, BED])
        total += 0.5 * law[k, SHEAR] * shear[k] ** 2
    return total


@compiled
def elastic_beds(law: Array) -> bool:
    """Whether joints of the `law` (j, LAW) are elastic; none are not."""
    return len(law) > 0 and law[0, BED] < np.inf
