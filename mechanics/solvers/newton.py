"""The program with mass, by Newton's method on banded matrices (design.md §3).

The contact forces are eliminated; what is left has three rows a block and, the blocks ordered by reverse
Cuthill–McKee or by a sweep, a narrow band. Two methods share it. The first repeats the contact states (open, sticking,
sliding) of the last step and corrects them a few times, a semismooth Newton method with an exact line search: one
factorisation where they are right. The second is a primal-dual interior point method in the rays of the friction cone
(as interior_point), which needs no such luck: some eight factorisations where a tenth of the contacts change state.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import lapack

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.program import Certificate, Program, Solution
from mechanics.solvers.band import Band
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING, fastest

ACCEPTED = 1e-6  # certificate; worse ones are left to the interior point method of PIQP
PROXIMAL = 1e6  # stiffness that stands for a rigid contact, per scaled mass: one or two rounds make it exact
CORRECTIONS = 7  # of the contact states, before the interior point method takes over
FEW, MANY = 40, 0.04  # contacts, and share of them: where more change state, it takes over at once
FINISHING = 8  # contacts: the same after it, where its solution is to be made exact
LONGEST_PAUSE = 7  # solves left to it at once, the other having failed again and again
MOST_ITERATIONS = 40
TO_THE_BOUND = 0.995  # share of the way to the cone that a step of the interior point method goes
START = 0.01  # least distance from the cone at which it starts, per weight and step


@dataclass(eq=False)
class Newton:
    """The solver laid out once for the contacts of an assembly: order of the blocks, width of the band, work space.

    `dof` (c, 6) as in Program; `centres` (m/3, 2): of the movable blocks, m. `state` (c,): contact states of the last
    solution; `factorisations`, `repeated` (steps solved by repeating states) and `solved` count.
    """

    dof: Index
    centres: Array
    kernels: Any = field(default_factory=fastest)
    factorisations: int = 0
    repeated: int = 0
    solved: int = 0

    def __post_init__(self) -> None:
        layout = Band.of(self.dof, self.centres)
        self.order, self.back, self.row = layout.order, layout.back, layout.row
        self.band: Array = np.zeros((len(layout.order), layout.width))
        self.state: Index | None = None
        self.pause, self.next_try = 0, 0
        self.along: Array | None = None
        self.apart: Array | None = None

    def solve(self, program: Program, guess: Array, forces: Array) -> Solution | None:
        """The certified solution near displacements `guess` (m,) and contact forces (c, 2); None where none is found.

        Needs `program.mass`, no multiplier.
        """
        assert program.mass is not None and program.lateral is None
        self.solved += 1
        mass, load, near = program.mass[self.order], program.load[self.order], guess[self.order]
        paused = self.solved < self.next_try
        if self.state is not None and not paused:
            found = self._semismooth(
                program, mass, load, near, forces, self.state, max(FEW, int(MANY * len(forces)))
            )
            if found is not None:
                self.repeated += 1
                self.pause = 0
                return found
            self.pause = min(2 * self.pause + 1, LONGEST_PAUSE)
            self.next_try = self.solved + 1 + self.pause
        inner = self._interior(program, mass, load, near, forces)
        if inner is None or inner.certificate.worst(program.step) > ACCEPTED:
            # the last solution was no start for this one
            self.along = self.apart = None
            inner = self._interior(program, mass, load, near, forces)
        if inner is None or self.state is None or paused:
            return inner
        # the states are known now: with them, forces that vanish are exactly zero
        near = inner.displacement[self.order]
        exact = self._semismooth(program, mass, load, near, inner.forces, self.state, FINISHING)
        return inner if exact is None else exact

    def _semismooth(
        self, program: Program, mass: Array, load: Array, x: Array, forces: Array, state: Index, many: int
    ) -> Solution | None:
        """From known contact states, none where a step changes more than `many` of them."""
        kernels, friction = self.kernels, program.friction
        rows = (self.row, program.normal, program.tangent)
        mobility = np.where(self.row >= 0, 1.0 / mass[self.row], 0.0).sum(axis=1)
        extra = np.where(program.compliance > 0.0, 0.0, mobility[:, None] / PROXIMAL)
        compliance = program.compliance + extra
        gap = program.gap - extra * forces
        found, total, guessed = np.empty_like(forces), np.empty_like(load), state.copy()
        kernels.contact_law(*rows, gap, friction, compliance, x, guessed, found, total)
        # where joints are elastic the last states tell more than a guess of the slip; rigid ones need the forces
        state = np.where(program.compliance[:, 0] > 0.0, state, guessed)
        kernels.repeat_forces(*rows, gap, friction, compliance, x, state, found, total)
        changes, factor = 1, None
        accepted: Solution | None = None
        for correction in range(CORRECTIONS):
            if changes:
                kernels.repeat_matrix(*rows, friction, compliance, mass, state, self.band)
                factor = self._factor()
                if factor is None:
                    return None
            dx = lapack.dpbtrs(factor, load + total - mass * x, lower=1)[0]
            if changes and correction:
                dx *= kernels.line_search(*rows, gap, friction, compliance, mass, load, x, dx)
            x = x + dx
            changes = kernels.contact_law(*rows, gap, friction, compliance, x, state, found, total)
            certificate = self._certify(program, mass, load, x, found)
            if certificate.worst(program.step) <= ACCEPTED:
                self.state = state.copy()
                if accepted is not None or changes:
                    return Solution(found, 0.0, x[self.back], certificate)
                accepted = Solution(found.copy(), 0.0, x[self.back], certificate)
            if changes > many:
                return None
            if not changes:
                # right but for the compliance that stands for none: with its centre in the forces found, exact
                gap = program.gap - extra * found
                changes = kernels.contact_law(*rows, gap, friction, compliance, x, state, found, total)
                if accepted is not None and changes:
                    break
        return accepted

    def _interior(
        self, program: Program, mass: Array, load: Array, x: Array, forces: Array
    ) -> Solution | None:
        kernels, c = self.kernels, len(forces)
        rows = (self.row, program.normal, program.tangent)
        n = 1.0 / np.hypot(1.0, program.friction)
        ray = np.stack([n, program.friction * n], axis=1)
        law = (ray, program.compliance)
        s = self.along if self.along is not None else np.zeros((c, 2))
        z = self.apart if self.apart is not None else np.zeros((c, 2))
        s = np.clip(s, START * program.weight, None)
        z = np.clip(z, START * program.step, None)
        u, du, ds, dz, found = (np.empty((c, 2)) for _ in range(5))
        inverse, rhs, product = np.empty((c, 3)), np.empty_like(load), s * z
        kernels.opening(*rows, program.gap, x, u)
        best: Solution | None = None
        for _ in range(MOST_ITERATIONS):
            kernels.interior_matrix(*rows, *law, mass, s, z, inverse, self.band)
            factor = self._factor()
            if factor is None:
                break
            point = (u, s, z, product, inverse)
            for corrects in (False, True):
                kernels.interior_rhs(*rows, *law, mass, load, x, *point, rhs)
                dx = lapack.dpbtrs(factor, rhs, lower=1)[0]
                reach = kernels.interior_step(*rows, *law, *point, dx, du, ds, dz)
                if not corrects:
                    kernels.interior_centre(s, z, ds, dz, *reach, product)
            share = min(1.0, TO_THE_BOUND * min(reach))
            x = x + share * dx
            kernels.interior_advance(share, ray, u, s, z, du, ds, dz, product, found)
            certificate = self._certify(program, mass, load, x, found)
            if best is None or certificate.worst(program.step) < best.certificate.worst(program.step):
                best = Solution(found.copy(), 0.0, x[self.back], certificate)
            if certificate.worst(program.step) <= ACCEPTED:
                break
        self.along, self.apart = s, z
        active = s * program.step > z * program.weight
        self.state = np.where(
            active.all(axis=1),
            STICKING,
            np.where(active[:, 0], SLIDING_ON, np.where(active[:, 1], SLIDING_BACK, OPEN)),
        ).astype(np.intp)
        return best

    def close(self, mass: Array, normal: Array, tangent: Array, gap: Array, held: Index) -> Array:
        """The smallest displacements (m,), in the norm of the mass (m,), that close gaps and slides (c, 2).

        `held` (c,): 0 for contacts that do not count, 1 where the gap does, 2 where the slide does too.
        """
        state = np.array([OPEN, SLIDING_ON, STICKING])[held]
        scaled = mass[self.order]
        mobility = np.where(self.row >= 0, 1.0 / scaled[self.row], 0.0).sum(axis=1)
        compliance = np.repeat(mobility[:, None] / PROXIMAL, 2, axis=1)
        frictionless = np.zeros(len(gap))
        rows = (self.row, normal, tangent)
        self.kernels.repeat_matrix(*rows, frictionless, compliance, scaled, state, self.band)
        factor = self._factor()
        assert factor is not None
        forces, total, still = np.empty((len(gap), 2)), np.empty_like(mass), np.zeros_like(mass)
        self.kernels.repeat_forces(*rows, gap, frictionless, compliance, still, state, forces, total)
        moved: Array = lapack.dpbtrs(factor, total, lower=1)[0][self.back]
        return moved

    def _factor(self) -> Array | None:
        self.factorisations += 1
        factor, failed = lapack.dpbtrf(self.band.T, lower=1, overwrite_ab=1)
        return None if failed else factor

    def _certify(self, program: Program, mass: Array, load: Array, x: Array, forces: Array) -> Certificate:
        unbalanced, cone, power, penetration = self.kernels.residuals(
            self.row, program.normal, program.tangent, program.gap, program.friction, program.compliance,
            mass, load, x, forces, program.size,
        )  # fmt: skip
        return Certificate(
            unbalanced / program.weight,
            cone / program.weight,
            power / (program.weight * program.step),
            penetration,
            0.0,
        )
