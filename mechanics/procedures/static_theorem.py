"""Limit analysis once more, by the static theorem: a linear program of point forces, by HiGHS, without program.py.

    maximise α   subject to   Σ N n + Σ T t + f_D + α f_L = 0 and the same of moments, of each movable block
                              N ≥ 0 at each point,  |T| ≤ μ Σ N of each joint

Nothing of the matrices of other solvers is used: what is compared with it checks both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from mechanics.errors import ArgumentError
from mechanics.kernels.joint import BETA, NX, NZ
from mechanics.kernels.law import FRICTION, STRENGTH
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts, end_gaps, end_points
from mechanics.solvers import OPEN
from mechanics.steps.equilibrium import standing_program
from mechanics.types import Array, Index, Mask

METHOD = "highs-ipm"  # with crossover, to a vertex
LARGEST = 1e4  # a multiplier beyond which a load meets no mechanism


def static_theorem(model: Assembly, direction: Direction = "+x", state: State | None = None) -> float | None:
    """Return the largest α with equilibrium under f_D + α f_L over the joints closed in a state, by HiGHS.

    It is the α of limit_analysis with associative friction, from a linear program written apart: forces at the closed
    ends of joints, equilibrium of each block about its centroid. Contacts, which of their ends are closed, and loads
    are those of the model; a tie bears up to its yield force. None if HiGHS finds no optimum. Raises ArgumentError for
    joints that crush, whose bound is not linear; ConvergenceError where it is not known whether the state stands.
    """
    state = model.starting(state)
    closed = standing_program(model, state)
    contacts, law = closed.contacts.take(closed.index), closed.program.law
    if np.isfinite(law[~contacts.ties, STRENGTH]).any():
        raise ArgumentError("joints that crush make no linear program")
    bears = end_gaps(closed.program.places) < 0.5 * OPEN * closed.program.step
    points = _points(contacts, bears, law[:, FRICTION], state.positions)
    loads = model.dead_load, model.lateral_load(direction)
    return _largest_multiplier(points, state.positions[:, :2], model.movable, loads, model.size)


def _points(contacts: Contacts, bears: Mask, friction: Array, positions: Array) -> PointForces:
    """Return the forces that contacts of a friction (j,) can carry at their ends that bear (j, 2), at positions (b, 3).

    Sliding that lifts leaves a gap: the forces act at the corner that touches the other block's face, and T where the
    joint is the more closed.
    """
    places = contacts.places(positions)
    gaps, normal = end_gaps(places), places[:, [NX, NZ]]
    corner = ((0.5 - places[:, BETA])[:, None] * gaps)[:, :, None] * normal[:, None, :]
    at = end_points(contacts, positions) + corner
    return PointForces(
        a=contacts.a,
        b=contacts.b,
        normal=normal,
        friction=friction,
        joint=np.nonzero(bears)[0],
        pressure_at=at[bears],
        most=np.where(contacts.ties, 0.5 * contacts.strength, np.inf)[np.nonzero(bears)[0]],
        friction_at=at[np.arange(len(at)), np.argmin(gaps, axis=1)],
    )


@dataclass(frozen=True, eq=False)
class PointForces:
    """Where the joints (j,) between blocks `a` and `b` can press: points (c,), each of its `joint`.

    `normal` (j, 2), from b into a; `friction` (j,), tangent of the friction angle; `pressure_at` (c, 2) m: the points,
    which bear at `most` (c,) kN; `friction_at` (j, 2) m: where T acts.
    """

    a: Index
    b: Index
    normal: Array
    friction: Array
    joint: Index
    pressure_at: Array
    friction_at: Array
    most: Array

    def equilibrium(self, centroids: Array, movable: Mask, size: float) -> sparse.csc_matrix:
        """Return forces and moments (over `size`, m) on the movable blocks, per unit of each N and then of each T.

        `centroids` (b, 2) m, about which moments are taken; `movable` (b,).
        """
        tangent = np.stack([self.normal[:, 1], -self.normal[:, 0]], axis=1)
        unit, at = (
            np.concatenate([self.normal[self.joint], tangent]),
            np.concatenate([self.pressure_at, self.friction_at]),
        )
        number, columns = np.cumsum(movable) - 1, np.arange(len(at))
        entries, row, column = [], [], []
        for owner, sign in ((self.a, 1.0), (self.b, -1.0)):
            block = np.concatenate([owner[self.joint], owner])
            arm, on = at - centroids[block], movable[block]
            moment = (arm[:, 0] * unit[:, 1] - arm[:, 1] * unit[:, 0]) / size
            entries.append(sign * np.column_stack([unit, moment])[on].ravel())
            row.append((3 * number[block][on, None] + np.arange(3)).ravel())
            column.append(np.repeat(columns[on], 3))
        places = (np.concatenate(row), np.concatenate(column))
        return sparse.csc_matrix(
            (np.concatenate(entries), places), shape=(3 * int(movable.sum()), len(columns))
        )

    def friction_bounds(self) -> sparse.csc_matrix:
        """Return the rows of ±T − μ Σ N ≤ 0 over the unknowns N, T and α, of joints that slide."""
        points, joints = len(self.joint), len(self.a)
        slides = np.isfinite(self.friction)
        mu = np.where(slides, self.friction, 0.0)
        limit = sparse.csr_matrix((-mu[self.joint], (self.joint, np.arange(points))), shape=(joints, points))[
            slides
        ]
        one, alpha = sparse.identity(joints, format="csr")[slides], sparse.csr_matrix((int(slides.sum()), 1))
        return sparse.bmat([[limit, one, alpha], [limit, -one, alpha]], format="csc")


def _largest_multiplier(
    points: PointForces, centroids: Array, movable: Mask, loads: tuple[Array, Array], size: float
) -> float | None:
    """Return the largest α whose loads f_D + α f_L the points can balance; None if HiGHS finds no optimum.

    `centroids` (b, 2) m; `movable` (b,); `loads`: f_D and f_L (b, 3), kN and kNm about the centroids; `size` (m): of a
    block.
    """
    from scipy.optimize import linprog  # late: it takes its time

    weight = float(abs(loads[0][movable, 1]).sum())
    scale = np.array([1.0, 1.0, size]) * weight
    dead, lateral = ((each[movable] / scale).reshape(-1, 1) for each in loads)
    matrix = sparse.hstack([points.equilibrium(centroids, movable, size), lateral], format="csc")
    presses, shears = len(points.joint), len(points.a)
    result = linprog(
        np.r_[np.zeros(presses + shears), -1.0], A_ub=points.friction_bounds(),
        b_ub=np.zeros(2 * int(np.isfinite(points.friction).sum())), A_eq=matrix, b_eq=-dead.ravel(),
        bounds=[(0.0, most) for most in points.most / weight] + [(None, None)] * shears + [(None, LARGEST)],
        method=METHOD,
    )  # fmt: skip
    return float(result.x[-1]) if result.status == 0 else None
