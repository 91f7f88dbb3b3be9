"""The program without compliance and mass, a linear one, by HiGHS: the second opinion of rigid statics."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.optimize import linprog

from mechanics.block import Array
from mechanics.program import LARGEST_MULTIPLIER, Program
from mechanics.solvers.interior_point import recover, standard_form


def solve(
    program: Program, method: Literal["highs-ds", "highs-ipm"] = "highs-ds"
) -> tuple[Array, float, Array] | None:
    """Contact forces (c, 2), multiplier and displacements (m,), or None where HiGHS finds no optimum."""
    p, q, a, b, scale = standard_form(program)
    if p.nnz:
        raise ValueError("a program with compliance or mass is not linear")
    bounds = [(0.0, None)] * (2 * len(program.gap)) + [(None, LARGEST_MULTIPLIER)] * (
        program.lateral is not None
    )
    result = linprog(q, A_eq=a, b_eq=b, bounds=bounds, method=method)
    if result.status != 0:
        return None
    # HiGHS gives the change of the optimum with b; the multiplier of Az − b has the other sign
    return recover(program, np.asarray(result.x), -np.asarray(result.eqlin.marginals), scale)
