"""The program without beds and mass, a linear one, by HiGHS: the second opinion of rigid statics."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.optimize import linprog

from mechanics.errors import ArgumentError
from mechanics.program import LARGEST_MULTIPLIER, Program
from mechanics.solvers.qp_piqp import Answer, StandardForm


def solve(program: Program, method: Literal["highs-ds", "highs-ipm"] = "highs-ds") -> Answer | None:
    """Return joint forces (j, 3), multiplier and displacements (m,); None if HiGHS finds no optimum."""
    form = StandardForm.of(program)
    if form.p.nnz:
        raise ArgumentError("a program with beds or mass is not linear")
    bounds = [(0.0, None)] * form.rays + [(None, LARGEST_MULTIPLIER)] * (program.lateral is not None)
    result = linprog(form.q, A_eq=form.a, b_eq=form.b, bounds=bounds, method=method)
    if result.status != 0:
        return None
    # HiGHS gives the change of the optimum with b; the multiplier of Az − b has the other sign
    return form.recover(np.asarray(result.x), -np.asarray(result.eqlin.marginals))
