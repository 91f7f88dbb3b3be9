"""Linear programs by HiGHS and PIQP: the program without beds and mass, and mechanisms that fit the forces of a flow.

Mechanisms are displacements that open or slide no joint but where these forces leave it free. Of a joint (y₁, y₂, λ₊,
λ₋): the gaps of its ends and its slip forth and back. Without dilation

    gap₁ + b₁ᵀΔx = y₁,   gap₂ + b₂ᵀΔx = y₂,   slip + b₃ᵀΔx = λ₊ − λ₋,   y, λ ≥ 0,   zero where they are not free
    f_LᵀΔx = γ
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import piqp
from scipy import sparse
from scipy.optimize import OptimizeResult, linprog

from mechanics.errors import ArgumentError
from mechanics.kernels.joint import H, V
from mechanics.kernels.law import FRICTION, SLID
from mechanics.model.contacts import end_gaps, rows
from mechanics.program import LARGEST_MULTIPLIER, Program
from mechanics.solvers.qp_piqp import Answer, StandardForm, sparse_solver
from mechanics.types import Array, Mask

# what HiGHS may leave of a row, the least that it takes, and PIQP of a linear program
ACCURACY = 1e-10
MOVED = 10.0 * ACCURACY  # of the step: a gap or slip of a mechanism that is less has not moved
EXACTLY = {"primal_feasibility_tolerance": ACCURACY, "dual_feasibility_tolerance": ACCURACY}
STIFF = 1e10  # of what is not free, against displacements: rounding of the last step need not be undone


def solve(program: Program, method: Literal["highs-ds", "highs-ipm"] = "highs-ds") -> Answer | None:
    """Return joint forces (j, 3), multiplier and displacements (m,); None if HiGHS finds no optimum.

    Raises ArgumentError for a program with beds or mass, which is not linear.
    """
    form = StandardForm.of(program)
    if form.p.nnz:
        raise ArgumentError("a program with beds or mass is not linear")
    bounds = [(0.0, None)] * form.rays + [(None, LARGEST_MULTIPLIER)] * (program.lateral is not None)
    result = _linprog(form.q, form.a, form.b, bounds, method)
    if result is None:
        return None
    # HiGHS gives the change of the optimum with b; the multiplier of Az − b has the other sign
    return form.recover(np.asarray(result.x), -np.asarray(result.eqlin.marginals))


def least_residual(program: Program, closed: Mask) -> float:
    """Return the unbalanced force, per weight, of forces at closed ends (j, 2) that balance the loads.

    It is infinite if HiGHS finds no such forces. The simplex method needs no interior: it decides also where the forces
    are unique or at their bounds, as without friction or in an arch of the least thickness.
    """
    form = StandardForm.of(program)
    bounds: list[Any] = [(0.0, None if bears else 0.0) for bears in np.repeat(closed.ravel(), 2)]
    bounds += [(None, LARGEST_MULTIPLIER)] * (program.lateral is not None)
    result = _linprog(np.zeros(len(bounds)), form.a, form.b, bounds)
    if result is None:
        return np.inf
    forces = np.asarray(result.x)
    forces[: form.rays] = forces[: form.rays].clip(0.0)
    return float(abs(form.a @ forces - form.b).max())


def least_multiplier(form: StandardForm, flowing: Mask) -> tuple[Array, float] | None:
    """Return forces (j, 3) and the least multiplier α ≥ 0 with which they balance the loads and fit a mechanism.

    `flowing` (j, 4): what the mechanism opens or slides, y₁, y₂, λ₊ and λ₋: there N₁, N₂, μN + T or μN − T is zero.
    None if there are no such forces.
    """
    first, second, forth, back = flowing.T
    idle = np.stack([first | forth, first | back, second | forth, second | back], axis=1)  # rays of +T and −T
    idle |= ((forth | back) & np.isinf(form.program.law[:, FRICTION]))[:, None]  # what presses does not slide
    bears = np.append(~idle.ravel(), True)
    a, q, z = form.a[:, bears], np.append(np.zeros(bears.sum() - 1), 1.0), np.zeros(len(bears))
    bounds = np.stack([np.zeros(len(q)), np.append(np.full(len(q) - 1, np.inf), LARGEST_MULTIPLIER)])
    solver = sparse_solver(ACCURACY, ACCURACY)
    solver.setup(sparse.csc_matrix((len(q), len(q))), q, a, form.b, None, None, None, *bounds)
    status, z[bears] = solver.solve(), solver.result.x
    if status not in (piqp.PIQP_SOLVED, piqp.PIQP_PRIMAL_INFEASIBLE):  # the forces have no interior
        # where no forces fit, the simplex method may take minutes to say so
        found = _linprog(q, a, form.b, bounds.T, "highs-ipm")
        status = piqp.PIQP_SOLVED if found else piqp.PIQP_PRIMAL_INFEASIBLE
        z[bears] = found.x if found else 0.0
    return form.recover(z, np.zeros(len(form.b)))[:2] if status == piqp.PIQP_SOLVED else None


def mechanism_of(program: Program, free: Mask, weights: Array) -> tuple[Array, Mask] | None:
    """Return displacements (m,) of the program's work, and which gaps and slips (j, 4) of theirs are not zero: few.

    `free` (j, 4): gaps and slips that forces leave free. Their sum by these `weights` (j, 4) is least. None if there
    are no such displacements.
    """
    change, begun = _gaps_and_slips(program)
    m, count = len(program.load), len(program.places)
    assert program.lateral is not None
    split = sparse.kron(
        sparse.identity(count), [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]
    )
    work = sparse.csr_matrix(
        np.concatenate([program.lateral, np.zeros(4 * count)]) * (program.step / program.work)
    )
    found = _linprog(
        np.concatenate([np.zeros(m), weights.ravel()]),
        sparse.vstack([sparse.hstack([change, -split]), work]),
        np.concatenate([-begun, [program.step]]),
        [(None, None)] * m + [(0.0, None if may else 0.0) for may in free.ravel()],
    )
    if found is None:
        return None
    return np.asarray(found.x[:m]), np.asarray(found.x[m:] > MOVED * program.step).reshape(-1, 4)


def nearest_mechanism(program: Program, free: Mask, began: Mask, little: float) -> tuple[Array, Array] | None:
    """Return the least displacements (m,) of the program's work, and their gaps and slips (j, 4).

    `free` (j, 4) as in mechanism_of; `began` (j, 4): those of the flow so far: others begin where they must. Rotations
    count times the block size. None if there are no such displacements: of what is not free more than a `little` (m)
    is left.
    """
    change, begun = _gaps_and_slips(program)
    m, size = len(program.load), program.step
    assert program.lateral is not None
    scale = np.ones(m)
    scale[2::3] = 1.0 / program.size
    rows_of = change @ sparse.diags(scale)
    # a slip forth counts as a gap, one back as a gap below zero
    rises = np.stack([free[:, 0], free[:, 1], free[:, 2]], axis=1).ravel()
    falls = np.stack([np.zeros(len(free), bool)] * 2 + [free[:, 3]], axis=1).ravel()
    new = np.stack([~began[:, 0], ~began[:, 1], ~began[:, 2:].any(axis=1)], axis=1).ravel()
    held, at_least, at_most = ~(rises | falls), rises & ~falls, falls & ~rises
    most, kept = abs(program.lateral).max(), int(held.sum())
    load = sparse.csr_matrix(program.lateral * scale / most)
    g = sparse.vstack([rows_of[at_least], -rows_of[at_most]])
    solver = sparse_solver(1e-12, ACCURACY)  # its status is not asked: the certificate of the step decides
    solver.setup(
        sparse.diags(np.concatenate([np.ones(m), np.full(kept, STIFF)]), format="csc"),
        np.concatenate([rows_of.T @ (1.0 * (new & at_least) - 1.0 * (new & at_most)), np.zeros(kept)]),
        sparse.bmat([[rows_of[held], -sparse.identity(kept)], [load, None]], format="csc"),
        np.concatenate([-begun[held], [program.work / most]]) / size,
        sparse.hstack([g, sparse.csr_matrix((g.shape[0], kept))], format="csc"),
        np.concatenate([-begun[at_least], begun[at_most]]) / size, np.full(g.shape[0], np.inf), None, None,
    )  # fmt: skip
    solver.solve()
    x = size * np.array(solver.result.x)[:m]
    left = begun + rows_of @ x
    if not abs(left[held]).max(initial=0.0) <= little:  # nor numbers that are none
        return None
    y = left.reshape(-1, 3)
    gaps = np.column_stack([y[:, :2], y[:, 2], -y[:, 2]]).clip(0.0)
    return x * scale, np.where(free, gaps, 0.0)


def _linprog(
    q: Array, a: sparse.sparray, b: Array, bounds: Any, method: str = "highs-ds"
) -> OptimizeResult | None:
    """Return the optimum of min qᵀz, Az = b within bounds; None if HiGHS finds none."""
    found = linprog(q, A_eq=a, b_eq=b, bounds=bounds, method=method, options=EXACTLY)
    return found if found.status == 0 else None


def _gaps_and_slips(program: Program) -> tuple[sparse.csr_matrix, Array]:
    """Return the rows (3j, m) of the gaps of both ends and the slip of each joint, and what they are (3j,)."""
    row, half, places = rows(program.places), program.places[:, H], program.places
    tilt = half[:, None] * row[:, 1]
    entries = np.stack([row[:, 0] - tilt, row[:, 0] + tilt, row[:, 2]], axis=1)
    moving = np.broadcast_to((program.dof >= 0)[:, None, :], entries.shape)
    column = np.broadcast_to(program.dof[:, None, :], entries.shape)[moving]
    line = np.broadcast_to(np.arange(3 * len(row)).reshape(-1, 3, 1), entries.shape)[moving]
    change = sparse.csr_matrix((entries[moving], (line, column)), (3 * len(row), len(program.load)))
    begun = np.column_stack([end_gaps(places), places[:, V] - program.law[:, SLID]])
    return change, begun.ravel()
