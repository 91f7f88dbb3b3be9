"""The program by PIQP, a sparse interior-point method.

In the plane the friction cone is spanned by two unit rays along (1, μ) and (1, −μ): with the forces s ≥ 0 along them
as unknowns the cone is a
bound and the method's matrices halve. Every call sets up a new solver object: PIQP's update() accepts a wrong pattern
without a word.
"""

from __future__ import annotations

import numpy as np
import piqp
from scipy import sparse

from mechanics.block import Array
from mechanics.program import LARGEST_MULTIPLIER, Program


def solve(program: Program, tolerance: float, most_iterations: int = 60) -> tuple[Array, float, Array] | None:
    """Contact forces (c, 2), multiplier and displacements (m,) where PIQP stops, whatever it says of them.

    None only where they are not finite: an answer at "max iterations" is often good to ten digits and one that is
    "solved" may be wrong, so that the certificate decides. `tolerance` is PIQP's, in the dimensionless program.
    """
    p, q, a, b, scale = standard_form(program)
    c = len(program.gap)
    if not all(np.isfinite(v).all() for v in (p.data, q, a.data, b)):
        raise ValueError("the program holds a number that is not finite")
    solver = piqp.SparseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = tolerance
    solver.settings.eps_duality_gap_abs = solver.settings.eps_duality_gap_rel = tolerance
    solver.settings.reg_lower_limit = 1e-12  # at the default, 1e-10, one linear program in five stalls
    solver.settings.max_iter = most_iterations
    lower, upper = np.full(len(q), -np.inf), np.full(len(q), np.inf)
    lower[: 2 * c] = 0.0
    if program.lateral is not None:
        upper[2 * c] = LARGEST_MULTIPLIER
    solver.setup(p, q, a, b, None, None, None, lower, upper)
    solver.solve()
    z, y = np.array(solver.result.x), np.array(solver.result.y)
    if not (np.isfinite(z).all() and np.isfinite(y).all()):
        return None
    return recover(program, z, y, scale)


def recover(program: Program, z: Array, y: Array, scale: Array) -> tuple[Array, float, Array]:
    """Forces, multiplier and displacements with their units from the standard form's solution and multipliers."""
    c = len(program.gap)
    rays = program.weight * z[: 2 * c].reshape(-1, 2)
    normal, tangential = _ray(program)
    forces = np.stack([normal * rays.sum(axis=1), tangential * (rays[:, 0] - rays[:, 1])], axis=1)
    alpha = float(z[2 * c]) if program.lateral is not None else 0.0
    return forces, alpha, -program.step * y / scale


def standard_form(
    program: Program,
) -> tuple[sparse.csc_matrix, Array, sparse.csc_matrix, Array, Array]:
    """½zᵀPz + qᵀz, Az = b over z = (rays s (2c), α, i) without dimensions; last, the size of each row's arm (m,)."""
    c, m = len(program.gap), len(program.load)
    has_alpha, has_mass = program.lateral is not None, program.mass is not None
    size = 2 * c + has_alpha + m * has_mass
    scale = np.ones(m)
    scale[2::3] = program.size
    w, d = program.weight, program.step

    n, t = _ray(program)
    rays = np.stack(
        [n[:, None] * program.normal + sign * t[:, None] * program.tangent for sign in (1, -1)], axis=1
    )
    moving = np.broadcast_to((program.dof >= 0)[:, None, :], rays.shape)
    rows = np.broadcast_to(program.dof[:, None, :], rays.shape)[moving]
    cols = np.broadcast_to(np.arange(2 * c).reshape(-1, 2, 1), rays.shape)[moving]
    parts = [(-rays[moving] / scale[rows], rows, cols)]
    q = np.zeros(size)
    q[: 2 * c] = (
        np.stack([n * program.gap[:, 0] + sign * t * program.gap[:, 1] for sign in (1, -1)], 1).ravel() / d
    )
    every = np.arange(m)
    if program.lateral is not None:
        parts.append((-program.lateral / scale / w, every, np.full(m, 2 * c)))
        q[2 * c] = -program.work / (w * d)
    if has_mass:
        parts.append((np.ones(m), every, 2 * c + has_alpha + every))
    data, row, col = (np.concatenate([part[k] for part in parts]) for k in range(3))
    a = sparse.csc_matrix((data, (row, col)), shape=(m, size))

    cn, ct = (program.compliance * (w / d)).T
    same, cross = n**2 * cn + t**2 * ct, n**2 * cn - t**2 * ct
    first = 2 * np.arange(c)
    p_parts = [(same, first, first), (cross, first, first + 1), (same, first + 1, first + 1)]
    if program.mass is not None:
        at = 2 * c + has_alpha + every
        # i in units of w (moments of w·size), M̄⁻¹i in units of d
        p_parts.append((w / d * scale**2 / program.mass, at, at))
    data, row, col = (np.concatenate([part[k] for part in p_parts]) for k in range(3))
    used = data != 0.0
    p = sparse.csc_matrix((data[used], (row[used], col[used])), shape=(size, size))
    return p, q, a, program.load / scale / w, scale


def _ray(program: Program) -> tuple[Array, Array]:
    """Normal and tangential component (c,) of the unit ray (1, μ)."""
    size = np.hypot(1.0, program.friction)
    return 1.0 / size, program.friction / size
