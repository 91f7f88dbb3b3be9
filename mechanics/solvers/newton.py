"""The program with mass, by Newton's method on matrices in a band or in fronts (design.md §3).

The contact forces are eliminated; what is left has three rows a block, which elimination puts in an order of
few numbers. Two methods share it. The first repeats the contact states (open, sticking,
sliding) of the last step and corrects them a few times, a semismooth Newton method with an exact line search: one
factorisation where they are right. The second is a primal-dual interior point method in the rays of the friction cone
(as interior_point), which needs no such luck: some eight factorisations where a tenth of the contacts change state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.program import Program, Solution
from mechanics.solvers.cholesky import factorise, substitute
from mechanics.solvers.compiled import repeat_forces, repeat_matrix
from mechanics.solvers.compiled_iterations import PROXIMAL, interior, semismooth
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.kernels import OPEN, SLIDING_ON, STICKING, certificate, worst
from mechanics.solvers.warm_start import WarmStart

ACCEPTED = 1e-6  # certificate; worse ones are left to the interior point method of PIQP
FEW, MANY = 40, 0.015  # contacts, and share of them: where more change state, it takes over at once
FINISHING = 8  # contacts: the same after it, where its solution is to be made exact
LONGEST_PAUSE = 7  # solves left to it at once, the other having failed again and again


@dataclass(eq=False)
class Newton:
    """The solver laid out once for the contacts of an assembly: order of the blocks, pattern and work space.

    `dof` (c, 6) as in Program; `centres` (m/3, 2): of the movable blocks, m. `state` (c,): contact states of the last
    solution; `factorisations`, `repeated` (steps solved by repeating states) and `solved` count. `start` is that of
    the next interior point solve.
    """

    dof: Index
    centres: Array
    factorisations: int = 0
    repeated: int = 0
    solved: int = 0

    def __post_init__(self) -> None:
        self.start = WarmStart()
        layout = Elimination.of(self.dof, self.centres)
        self.order, self.back, self.row = layout.order, layout.back, layout.row
        self.runs, self.pattern, self.stored = layout.runs, layout.pattern, layout.matrix()
        self.packed = layout.packed
        self.state: Index | None = None
        self.pause, self.next_try = 0, 0

    def solve(self, program: Program, guess: Array, forces: Array) -> Solution | None:
        """The certified solution near displacements `guess` (m,) and contact forces (c, 2); None where none is found.

        Needs `program.mass`, no multiplier.
        """
        assert program.mass is not None and program.lateral is None
        self.solved += 1
        mass, load, near = program.mass[self.order], program.load[self.order], guess[self.order]
        paused = self.solved < self.next_try
        tried = self.state is not None and not paused
        if self.state is not None and tried:
            found = self._semismooth(
                program, mass, load, near, forces, self.state, max(FEW, int(MANY * len(forces)))
            )
            if found is not None:
                self.repeated += 1
                self.pause = 0
                return found
            self.pause = min(2 * self.pause + 1, LONGEST_PAUSE)
            self.next_try = self.solved + 1 + self.pause
        inner = self._interior(program, mass, load, near)
        if inner is None or inner.certificate.worst(program.step) > ACCEPTED:
            self.start.forget()  # it was none for this program
            inner = self._interior(program, mass, load, near)
        if inner is None or self.state is None or paused or (tried and program.compliance[:, 0].any()):
            return inner
        # the states are known now: with them, forces that vanish are exactly zero (elastic joints whose states were
        # not found before are not found so either)
        near = inner.displacement[self.order]
        exact = self._semismooth(program, mass, load, near, inner.forces, self.state, FINISHING)
        return inner if exact is None else exact

    def _semismooth(
        self, program: Program, mass: Array, load: Array, x: Array, forces: Array, state: Index, many: int
    ) -> Solution | None:
        """From known contact states, none where a step changes more than `many` of them."""
        x, forces, state = x.copy(), forces.copy(), state.copy()
        count, residuals = semismooth(
            *self._posed(program, mass, load), x, forces, state, *self._work_space(program), many
        )
        self.factorisations += count
        if worst(residuals, program.weight, program.step) > ACCEPTED:
            return None
        self.state = state
        return Solution(forces, 0.0, x[self.back], certificate(residuals, program))

    def _interior(self, program: Program, mass: Array, load: Array, x: Array) -> Solution | None:
        c = len(program.gap)
        s, z = self.start.begin(c, program.weight, program.step)
        x, forces, state = x.copy(), np.empty((c, 2)), np.empty(c, np.intp)
        count, residuals = interior(
            *self._posed(program, mass, load), x, forces, s, z, state, self.runs, *self._work_space(program)
        )
        self.factorisations += count
        if not np.isfinite(worst(residuals, program.weight, program.step)):
            return None
        self.start.keep(s, z, program.weight, program.step)  # a poor one, too: it is better than none
        self.state = state
        return Solution(forces, 0.0, x[self.back], certificate(residuals, program))

    def _posed(self, program: Program, mass: Array, load: Array) -> tuple[Any, ...]:
        p = program
        return self.row, p.normal, p.tangent, p.gap, p.friction, p.compliance, mass, load

    def _work_space(self, program: Program) -> tuple[Any, ...]:
        scale = program.weight, program.size, program.step, ACCEPTED
        return self.stored, self.packed, scale

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
        repeat_matrix(*rows, frictionless, compliance, scaled, state, self.stored, self.pattern)
        self.factorisations += 1
        definite = factorise(self.stored, self.pattern)
        assert definite
        forces, total, still = np.empty((len(gap), 2)), np.empty_like(mass), np.zeros_like(mass)
        repeat_forces(*rows, gap, frictionless, compliance, still, state, forces, total)
        substitute(self.stored, self.pattern, total)
        moved: Array = total[self.back]
        return moved
