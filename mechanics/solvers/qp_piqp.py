"""The program by PIQP, a sparse interior-point method: the second opinion, and the fallback.

A joint is here a row of contact points, its two ends where it is rigid, those of its segments where it has a bed: their
forces span the same cone, and friction is bounded on their sum. In the plane the cone of a point is spanned by two unit
rays along (1, μ) and (1, −μ): with the forces s ≥ 0 along them as unknowns the cone is a bound and the method's
matrices halve. An exact bed stands here as one of POINTS segments. Every call sets up a new solver object: PIQP's
update() accepts a wrong pattern without a word.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import piqp
from scipy import sparse

from mechanics.errors import ArgumentError
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import BED, DILATION, FRICTION, SEGMENTS, SHEAR, SLID, STEEPEST
from mechanics.model.contacts import rows
from mechanics.program import LARGEST_MULTIPLIER, Program
from mechanics.types import Array, Index

ITERATIONS = 60  # of a program
POINTS = 32  # segments in place of an exact bed

Answer = tuple[Array, float, Array]


def solve(program: Program, tolerance: float, most_iterations: int = ITERATIONS) -> Answer | None:
    """Return joint forces (j, 3), multiplier and displacements (m,) at which PIQP stops, whatever its status.

    None only if they are not finite: a result at "max iterations" is often good to ten digits, and a "solved" one may
    be wrong, so the certificate decides. `tolerance` is PIQP's, in the dimensionless program. Raises ArgumentError for
    a program with a number that is not finite.
    """
    form = StandardForm.of(program)
    if not all(np.isfinite(v).all() for v in (form.p.data, form.q, form.a.data, form.b)):
        raise ArgumentError("the program holds a number that is not finite")
    solver = sparse_solver(tolerance, tolerance, most_iterations)
    rays = form.rays
    lower, upper = np.full(len(form.q), -np.inf), np.full(len(form.q), np.inf)
    lower[:rays] = 0.0
    if program.lateral is not None:
        upper[rays] = LARGEST_MULTIPLIER
    solver.setup(form.p, form.q, form.a, form.b, None, None, None, lower, upper)
    solver.solve()
    z, y = np.array(solver.result.x), np.array(solver.result.y)
    if not (np.isfinite(z).all() and np.isfinite(y).all()):
        return None
    return form.recover(z, y)


def sparse_solver(tolerance: float, gap: float, most_iterations: int = ITERATIONS) -> piqp.SparseSolver:
    """Return a solver without a program; `tolerance` of residuals and duality `gap` in the dimensionless program."""
    solver = piqp.SparseSolver()
    settings = solver.settings
    settings.eps_abs = settings.eps_rel = tolerance
    settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = gap
    settings.reg_lower_limit = 1e-12  # at the default, 1e-10, one linear program in five stalls
    settings.max_iter = most_iterations
    return solver


@dataclass(frozen=True, eq=False)
class Points:
    """Contact points (c,): `joint` of each, its place `s` (m) from the middle of the overlap, `compliance`."""

    joint: Index
    s: Array
    compliance: Array

    @classmethod
    def of(cls, program: Program) -> Points:
        """Return the ends of rigid joints, and the ends of the segments of beds."""
        law, half = program.law, program.places[:, H]
        segments = np.where(
            np.isinf(law[:, BED]), 1, np.where(law[:, SEGMENTS] > 0, law[:, SEGMENTS], POINTS)
        )
        count = segments.astype(np.intp) + 1
        joint = np.repeat(np.arange(len(law)), count)
        number = np.arange(len(joint)) - np.repeat(np.cumsum(count) - count, count)
        share = number / segments[joint]
        inner = np.where((number == 0) | (number == segments[joint]), 0.5, 1.0)
        with np.errstate(divide="ignore"):
            compliance = segments[joint] / (2.0 * half[joint] * law[joint, BED] * inner)
        return cls(joint, half[joint] * (2.0 * share - 1.0), compliance)

    def rays(self, law: Array) -> tuple[Array, Array]:
        """Return normal and tangential components (c, 2) of the unit rays that span each point's cone, (1, ±μ).

        Where friction is infinite the points of a joint share its T: a ray (1, 0) each, and (0, ±1) by turns. By
        Coulomb's law T needs an N, however small, which no closed cone says: there it is a very large friction.
        """
        mu, turns = law[self.joint, FRICTION], np.where(np.arange(len(self.joint)) % 2, -1.0, 1.0)
        mu = np.where(law[self.joint, DILATION] < 1.0, np.minimum(mu, STEEPEST), mu)
        infinite, finite = np.isinf(mu), np.where(np.isinf(mu), 0.0, mu)
        n, t = 1.0 / np.hypot(1.0, finite), finite / np.hypot(1.0, finite)
        second = np.where(infinite, 0.0, n), np.where(infinite, turns, -t)
        return np.stack([n, second[0]], axis=1), np.stack([t, second[1]], axis=1)


@dataclass(frozen=True, eq=False)
class StandardForm:
    """½zᵀPz + qᵀz, Az = b over z = (forces along rays, α, i) without dimensions; `scale` (m,): of each row's arm."""

    program: Program
    points: Points
    p: sparse.csc_matrix
    q: Array
    a: sparse.csc_matrix
    b: Array
    scale: Array

    @property
    def rays(self) -> int:
        """Number of rays, two for each point."""
        return 2 * len(self.points.joint)

    @classmethod
    def of(cls, program: Program) -> StandardForm:
        """Return the standard form of a program."""
        points = Points.of(program)
        j, s, c, m = points.joint, points.s, len(points.joint), len(program.load)
        has_alpha, has_mass = program.lateral is not None, program.mass is not None
        size = 2 * c + has_alpha + m * has_mass
        scale = np.ones(m)
        scale[2::3] = program.size
        w, d, law, places = program.weight, program.step, program.law, program.places
        row = rows(places)[j]
        normal, tangent = row[:, 0] + s[:, None] * row[:, 1], row[:, 2]
        gap = np.stack([places[j, U] + s * places[j, PHI], (places[:, V] - law[:, SLID])[j]], axis=1)
        n, t = points.rays(law)
        rays = n[:, :, None] * normal[:, None, :] + t[:, :, None] * tangent[:, None, :]
        dof = program.dof[j]
        moving = np.broadcast_to((dof >= 0)[:, None, :], rays.shape)
        at = np.broadcast_to(dof[:, None, :], rays.shape)[moving]
        col = np.broadcast_to(np.arange(2 * c).reshape(-1, 2, 1), rays.shape)[moving]
        parts = [(-rays[moving] / scale[at], at, col)]
        q = np.zeros(size)
        q[: 2 * c] = (n * gap[:, :1] + t * gap[:, 1:]).ravel() / d
        every = np.arange(m)
        if program.lateral is not None:
            parts.append((-program.lateral / scale / w, every, np.full(m, 2 * c)))
            q[2 * c] = -program.work / (w * d)
        if has_mass:
            parts.append((np.ones(m), every, 2 * c + has_alpha + every))
        a = _matrix(parts, (m, size))
        # normal compliance of each point, tangential one of the sum of a joint
        of_point = sparse.csc_matrix((n.ravel(), (np.repeat(np.arange(c), 2), np.arange(2 * c))), (c, size))
        of_joint = sparse.csc_matrix((t.ravel(), (np.repeat(j, 2), np.arange(2 * c))), (len(law), size))
        p = (w / d) * (
            of_point.T @ sparse.diags(points.compliance) @ of_point
            + of_joint.T @ sparse.diags(law[:, SHEAR]) @ of_joint
        )
        if program.mass is not None:
            # i in units of w (moments of w·size), M̄⁻¹i in units of d
            inertia = 2 * c + has_alpha + every
            p = p + _matrix([(w / d * scale**2 / program.mass, inertia, inertia)], (size, size))
        upper = sparse.csc_matrix(sparse.triu(p))
        upper.eliminate_zeros()
        return cls(program, points, upper, q, a, program.load / scale / w, scale)

    def recover(self, z: Array, y: Array) -> Answer:
        """Return joint forces (j, 3), multiplier and displacements (m,), with units.

        z (n,): the solution of the dimensionless program; y (m,): the multipliers of its equations.
        """
        p, j = self.program, self.points.joint
        rays = p.weight * z[: self.rays].reshape(-1, 2)
        n, t = self.points.rays(p.law)
        bears, shears = (n * rays).sum(axis=1), (t * rays).sum(axis=1)
        parts = (bears, bears * self.points.s, shears)
        sums = [np.asarray(np.bincount(j, part, minlength=len(p.law)), dtype=float) for part in parts]
        forces = np.stack(sums, axis=1)
        alpha = float(z[self.rays]) if p.lateral is not None else 0.0
        return forces, alpha, -p.step * y / self.scale


def _matrix(parts: list[tuple[Array, Index, Index]], shape: tuple[int, int]) -> sparse.csc_matrix:
    data, row, col = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return sparse.csc_matrix((data, (row, col)), shape=shape)
