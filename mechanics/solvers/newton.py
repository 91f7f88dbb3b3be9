"""The program with mass, by a semismooth Newton method on the displacements (design.md §3).

The contact forces are eliminated: what is left is the unconstrained minimisation of a convex, piecewise quadratic
function of Δx, with a banded Hessian once the blocks are ordered by reverse Cuthill–McKee. Rigid directions get the
compliance of a proximal term about the forces known so far, which a few rounds make exact.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.program import Certificate, Program, Solution
from mechanics.solvers import GOOD
from mechanics.solvers.kernels import fastest

PROXIMAL = 1e3  # stiffness of the proximal term, per scaled mass at the contact
BALANCE = 1e-10  # per weight: unbalanced force at which the iterations stop
MOST_ROUNDS = 12
MOST_ITERATIONS = 40
OVERSHOOT = 0.3  # of the first slope: a longer one past the minimum calls for a search along the line


@dataclass(eq=False)
class Newton:
    """The solver laid out once for the contacts of an assembly: order of the blocks, width of the band, work space.

    `dof` (c, 6) as in Program. `state` (c,) of the contacts and `forces` are where the next solve starts from;
    `iterations` and `factorisations` count.
    """

    dof: Index
    kernels: Any = field(default_factory=fastest)
    iterations: int = 0
    factorisations: int = 0

    def __post_init__(self) -> None:
        size = int(self.dof.max(initial=-1)) + 1
        pairs = self.dof[:, [0, 3]] // 3
        linked = pairs[(pairs >= 0).all(axis=1)]
        graph = sparse.coo_matrix(
            (np.ones(len(linked)), (linked[:, 0], linked[:, 1])), shape=(size // 3, size // 3)
        )
        order = reverse_cuthill_mckee(sparse.csr_matrix(graph + graph.T), symmetric_mode=True)
        rank = np.empty(len(order), dtype=np.intp)
        rank[order] = np.arange(len(order))
        self.order: Index = (3 * order[:, None] + np.arange(3)).ravel().astype(np.intp)
        self.back: Index = np.argsort(self.order)
        self.row: Index = np.where(pairs >= 0, 3 * rank[pairs], -1).astype(np.intp)
        apart = abs(self.row[:, 0] - self.row[:, 1])[(self.row >= 0).all(axis=1)]
        self.width = int(apart.max(initial=0)) + 3
        self.band: Array = np.zeros((size, self.width))
        self.gradient: Array = np.zeros(size)
        self.state: Index = np.zeros(len(self.dof), dtype=np.intp)
        self.known = False

    def solve(self, program: Program, guess: Array, forces: Array) -> Solution | None:
        """The solution near displacements `guess` (m,) and contact forces (c, 2); None where the method stalls.

        Needs `program.mass`. The certificate is recomputed from the definitions.
        """
        assert program.mass is not None and program.lateral is None
        mass, load = program.mass[self.order], program.load[self.order]
        x = guess[self.order]
        inverse = 1.0 / mass
        mobility = np.where(self.row >= 0, inverse[self.row], 0.0).sum(axis=1)
        extra = np.where(program.compliance > 0.0, 0.0, mobility[:, None] / PROXIMAL)
        compliance = program.compliance + extra
        centre = forces
        for count in range(MOST_ROUNDS):
            gap = program.gap - extra * centre
            parts = (
                self.row, program.normal, program.tangent, gap, program.friction, compliance, mass, load,
            )  # fmt: skip
            found = self._minimise(parts, program.weight, program.size, x, self.known and count == 0)
            if found is None:
                self.known = False
                return None
            x, centre = found
            unbalanced, cone, power, penetration = self.kernels.residuals(
                self.row, program.normal, program.tangent, program.gap, program.friction, program.compliance,
                mass, load, x, centre, program.size,
            )  # fmt: skip
            certificate = Certificate(
                unbalanced / program.weight,
                cone / program.weight,
                power / (program.weight * program.step),
                penetration,
                0.0,
            )
            if certificate.worst(program.step) <= GOOD:
                break
        self.known = True
        return Solution(centre, 0.0, x[self.back], certificate)

    def _minimise(
        self, parts: tuple[Any, ...], weight: float, size: float, x: Array, forced: bool
    ) -> tuple[Array, Array] | None:
        """Displacements and contact forces (c, 2) where Ψ is least; `forced`: begin from the last contact states."""
        forces = np.empty((len(self.row), 2))
        tolerance = BALANCE * weight
        if forced:
            self.kernels.evaluate(*parts, x, True, self.state, forces, self.gradient, self.band)
            x = x + self._direction()
        value, _ = self.kernels.evaluate(*parts, x, False, self.state, forces, self.gradient, self.band)
        for _ in range(MOST_ITERATIONS):
            self.iterations += 1
            largest = abs(self.gradient).reshape(-1, 3).max(axis=0, initial=0.0)
            if max(largest[0], largest[1], largest[2] / size) <= tolerance:
                return x, forces
            direction = self._direction()
            first = float(self.gradient @ direction)
            if not first < 0.0:
                return None
            trial = x + direction
            new, _ = self.kernels.evaluate(
                *parts, trial, False, self.state, forces, self.gradient, self.band
            )
            if float(self.gradient @ direction) > -OVERSHOOT * first:
                trial = x + self._least(parts, x, direction, first) * direction
                new, _ = self.kernels.evaluate(
                    *parts, trial, False, self.state, forces, self.gradient, self.band
                )
            x, value = trial, new
        return None

    def _direction(self) -> Array:
        """The Newton direction, from the gradient and Hessian last evaluated."""
        self.factorisations += 1
        factor, _ = lapack.dpbtrf(self.band.T, lower=1, overwrite_ab=1)
        direction, _ = lapack.dpbtrs(factor, -self.gradient, lower=1)
        return direction  # type: ignore[no-any-return]

    def _least(self, parts: tuple[Any, ...], x: Array, direction: Array, first: float) -> float:
        """Step in (0, 1) at which the slope along the direction, rising from `first` < 0, vanishes (Illinois)."""
        low, high = 0.0, 1.0
        at_low, at_high = first, self.kernels.slope(*parts, x + direction, direction)
        kept = 0
        step = 1.0
        for _ in range(20):
            step = (low * at_high - high * at_low) / (at_high - at_low)
            here = self.kernels.slope(*parts, x + step * direction, direction)
            if abs(here) <= 0.1 * abs(first):
                break
            if here > 0.0:
                high, at_high = step, here
                at_low *= 0.5 if kept > 0 else 1.0
                kept = 1
            else:
                low, at_low = step, here
                at_high *= 0.5 if kept < 0 else 1.0
                kept = -1
        return step
