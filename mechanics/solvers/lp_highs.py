"""The program without beds and mass, a linear one, by HiGHS: the second opinion of rigid statics."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from mechanics.errors import ArgumentError
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import SLID
from mechanics.model.contacts import rows
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


def mechanism_of(program: Program, free: Mask, weights: Array) -> tuple[Array, Array] | None:
    """Return displacements (m,) of the given work, and their gaps and slips (j, 4), of which few are not zero.

    `free` (j, 4): gaps and slips, as in least_multiplier, that forces leave free; no joint is lifted by its slip. Their
    sum by these `weights` (j, 4) is least. None if there are no such displacements.
    """
    p, j = program, np.arange(len(program.places))
    assert p.lateral is not None
    row, half, m, count = rows(p.places), p.places[:, H], len(p.load), len(j)
    ends = [row[:, 0] - half[:, None] * row[:, 1], row[:, 0] + half[:, None] * row[:, 1], row[:, 2]]
    tilt = half * p.places[:, PHI]
    begun = np.stack([p.places[:, U] - tilt, p.places[:, U] + tilt, p.places[:, V] - p.law[:, SLID]], axis=1)
    moving = p.dof >= 0
    blocks, rhs = [], []
    for e, entries in enumerate(ends):
        b = sparse.csr_matrix((entries[moving], (np.nonzero(moving)[0], p.dof[moving])), (count, m))
        y = [
            sparse.csr_matrix((np.ones(count), (j, 4 * j + r)), (count, 4 * count))
            for r in ((e,), (2, 3))[e > 1]
        ]
        blocks.append(sparse.hstack([b, -y[0] if e < 2 else y[1] - y[0]]))
        rhs.append(-begun[:, e])
    work = sparse.csr_matrix(np.concatenate([p.lateral, np.zeros(4 * count)]) * (p.step / p.work))
    equations = sparse.vstack([*blocks, work])
    bounds = [(None, None)] * m + [(0.0, None if may else 0.0) for may in free.ravel()]
    cost = np.concatenate([np.zeros(m), weights.ravel()])
    found = linprog(
        cost,
        A_eq=equations,
        b_eq=np.concatenate([*rhs, [p.step]]),
        bounds=bounds,
        method="highs-ds",
        options=EXACTLY,
    )
    if found.status != 0:
        return None
    return np.asarray(found.x[:m]), np.asarray(found.x[m:]).reshape(-1, 4)
