"""The inertia of the tangent stiffness K − G of a solution: whether its equilibrium is stable."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.interior.bounds import begin
from mechanics.kernels.interior.elimination import KNOWN, LANES
from mechanics.kernels.interior.joint_loops import ProgramJoints, assemble, dot, evaluate
from mechanics.kernels.jit import compiled
from mechanics.kernels.linalg.factors import lu, substitute
from mechanics.kernels.linalg.pattern import unpacked
from mechanics.types import Array


@compiled
def inertia(
    row: Any, places: Array, law: Array, curved: Array, lateral: Array, x: Array, f: Array, y: Array,
    step: float, least: float, held: Array, stored: Array, packed: Any, which: Any,
) -> tuple[int, float]:  # fmt: skip
    """Return the number of negative pivots of K − G at a solution, −1 where one vanishes, and f_Lᵀ(K − G)⁻¹f_L.

    Joints that slide by Coulomb's law do so under the friction that they have.

    Arrays as in `iterate`; `step` (m) of the program; `least` (m/kN): compliance that bounds the stiffness; `held`
    (m,): stiffness added to the diagonal.
    """
    pattern = unpacked(packed)
    law = law.copy()
    begin(places, law, f, step)
    joints = ProgramJoints(row, places, law, curved, which)
    known = np.empty(((len(row) + LANES - 1) // LANES, KNOWN))
    residual = np.zeros(len(x))
    evaluate(joints, x, f, y, least, known, residual)
    lower, upper = stored[: len(stored) // 2], stored[len(stored) // 2 :]
    assemble(joints, known, held, lower, upper, False, pattern)
    upper[:] = lower
    negative = lu(lower, upper, pattern)
    if negative < 0 or len(lateral) == 0:
        return negative, 0.0
    lateral_solution = lateral.copy()
    substitute(lower, upper, pattern, lateral_solution)
    return negative, dot(lateral, lateral_solution)
