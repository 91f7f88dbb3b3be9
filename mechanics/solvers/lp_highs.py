"""The program without beds and mass, a linear one, by HiGHS: the second opinion of rigid statics."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.optimize import linprog

from mechanics.errors import ArgumentError
from mechanics.program import LARGEST_MULTIPLIER, Program
from mechanics.solvers.qp_piqp import Answer, StandardForm
from mechanics.types import Array, Mask

# what HiGHS may leave of a row: the least that it takes
EXACTLY = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


def solve(program: Program, method: Literal["highs-ds", "highs-ipm"] = "highs-ds") -> Answer | None:
    """Return joint forces (j, 3), multiplier and displacements (m,); None if HiGHS finds no optimum.

    Raises ArgumentError for a program with beds or mass, which is not linear.
    """
    form = StandardForm.of(program)
    if form.p.nnz:
        raise ArgumentError("a program with beds or mass is not linear")
    bounds = [(0.0, None)] * form.rays + [(None, LARGEST_MULTIPLIER)] * (program.lateral is not None)
    result = linprog(form.q, A_eq=form.a, b_eq=form.b, bounds=bounds, method=method, options=EXACTLY)
    if result.status != 0:
        return None
    # HiGHS gives the change of the optimum with b; the multiplier of Az − b has the other sign
    return form.recover(np.asarray(result.x), -np.asarray(result.eqlin.marginals))


def least_residual(program: Program, closed: Mask) -> float:
    """Return the unbalanced force, per weight, of forces at closed ends (j, 2) that balance the loads.

    It is infinite if HiGHS finds no such forces. The simplex method needs no interior: it decides also where the forces
    are unique or at their bounds, as without friction or in an arch of the least thickness.
    """
    form = StandardForm.of(program)
    bounds: list[tuple[float | None, float | None]] = [
        (0.0, None if bears else 0.0) for bears in np.repeat(closed.ravel(), 2)
    ]
    bounds += [(None, LARGEST_MULTIPLIER)] * (program.lateral is not None)
    result = linprog(
        np.zeros(len(bounds)), A_eq=form.a, b_eq=form.b, bounds=bounds, method="highs-ds",
        options=EXACTLY,
    )  # fmt: skip
    if result.status != 0:
        return np.inf
    forces = np.asarray(result.x)
    forces[: form.rays] = forces[: form.rays].clip(0.0)
    return float(abs(form.a @ forces - form.b).max())


def least_multiplier(program: Program, flowing: Mask) -> tuple[Array, float] | None:
    """Return forces (j, 3) and the least multiplier α ≥ 0 with which they balance the loads and fit a mechanism.

    `flowing` (j, 4): what the mechanism opens or slides, y₁, y₂, λ₊ and λ₋: there N₁, N₂, μN + T or μN − T is zero.
    None if there are no such forces.
    """
    form = StandardForm.of(program)
    first, second, forth, back = flowing.T
    idle = np.stack([first | forth, first | back, second | forth, second | back], axis=1)  # rays of +T and −T
    q = np.zeros(len(form.q))
    q[form.rays] = 1.0
    bounds = [(0.0, 0.0 if none else None) for none in idle.ravel()] + [(0.0, LARGEST_MULTIPLIER)]
    # where no forces fit, the simplex method may take minutes to say so
    found = linprog(q, A_eq=form.a, b_eq=form.b, bounds=bounds, method="highs-ipm", options=EXACTLY)
    if found.status != 0:
        return None
    forces, alpha, _ = form.recover(np.asarray(found.x), np.zeros(len(form.b)))
    return forces, alpha
