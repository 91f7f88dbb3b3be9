"""The program by the iteration of kernels.interior.iteration: from a cold start, or near an earlier solution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mechanics.kernels.interior.iteration import HOLDING, OrderedProgram, inertia, iterate
from mechanics.kernels.interior.joints import ProgramJoints, keep_within_strength
from mechanics.kernels.joint import CURVED, TIED, H
from mechanics.kernels.law import BED, DILATION, FRICTION, STEEP, STRENGTH
from mechanics.program import LARGEST_MULTIPLIER, Program, Solution, bed_gaps, certify
from mechanics.solvers.elimination import Elimination
from mechanics.types import Array

MOST_ITERATIONS, IDLE = 100, 10  # in all, and without progress
ROUGH = 1e-3  # residual of a solution by the associative law near which another one begins
WHOLE = 1e-2  # of one of joints that do not crush
APART = 0.3  # distance from the bounds, per weight and step, of a start near an earlier solution
COLD = 3.0  # per weight and step and root of the number of blocks: forces and gaps of a cold start


@dataclass(frozen=True, eq=False)
class Iterate:
    """Forces N₁, N₂, T (j, 3) kN, gaps y₁, y₂, slips λ₊, λ₋ (j, 4) m, all positive but T; multiplier; Δx (m,)."""

    forces: Array
    gaps: Array
    alpha: float
    displacement: Array

    def warm(self, program: Program, distance: float = APART) -> Iterate:
        """Return the iterate with a least distance from the bounds, per weight and step, for a next solution.

        A force that is raised closes the bed of its end, and its gap y takes that up: y + ∂W*/∂N stays as it was.
        """
        p = program
        least = 0.5 * distance * p.weight
        forces = np.zeros_like(self.forces)
        forces[:, :2] = np.maximum(self.forces[:, :2], least)
        keep_within_strength(p.places, p.law, forces)
        mu = np.minimum(p.law[:, FRICTION], STEEP)
        bound = (1.0 - distance) * mu * forces[:, :2].sum(axis=1)
        forces[:, 2] = np.clip(self.forces[:, 2], -bound, bound)
        gaps, soft = self.gaps.copy(), p.law[:, BED] < np.inf
        if soft.any():
            half = p.places[soft, H]
            for ends, sign in ((self.forces, 1.0), (forces, -1.0)):
                gaps[soft, :2] += sign * bed_gaps(ends[soft, :2], half, p.law[soft])
        slip = 1.0 / np.maximum(mu, 1.0)
        gaps = np.maximum(gaps, distance * p.step * np.stack([mu**0, mu**0, slip, slip], axis=1))
        return Iterate(forces, gaps, self.alpha, np.zeros(len(p.load)))


@dataclass(frozen=True, slots=True)
class IterationEnd:
    """End of an iteration: whether its result is `accepted`, or equilibrium was found `unstable`; its `iterations`.

    Residuals: `force` per weight, `product` per weight and step, `gap` per step.
    """

    accepted: bool
    unstable: bool
    iterations: int
    force: float
    gap: float
    product: float


def cold(program: Program) -> Iterate:
    """Return the iterate of a cold start: all joints carry equal forces and have equal gaps."""
    far = COLD * np.sqrt(len(program.load) / 3)
    mu = np.clip(program.law[:, FRICTION], 1.0, STEEP)
    forces = np.zeros((len(program.places), 3))
    forces[:, :2] = 0.5 * far * program.weight
    keep_within_strength(program.places, program.law, forces)
    gaps = far * program.step * np.stack([mu**0, mu**0, 1.0 / mu, 1.0 / mu], axis=1)
    return Iterate(forces, gaps, 0.0, np.zeros(len(program.load)))


def cold_starts(program: Program, layout: Elimination) -> Iterator[Iterate]:
    """Yield starts of a program of which nothing is known: near one whose rigid joints do not crush, and cold.

    What crushes makes the program non-convex, and far from its solution it does not converge.
    """
    strength, bed = program.law[:, STRENGTH], program.law[:, BED]
    crush = np.isinf(bed) & (strength < np.inf) & (program.places[:, TIED] == 0.0)
    if crush.any():
        law = program.law.copy()
        law[crush, STRENGTH] = np.inf
        whole = replace(program, law=law)
        found, outcome = run(whole, layout, cold(whole), WHOLE)
        if outcome.accepted:
            yield found.warm(program)
    yield cold(program)


def starts(program: Program, layout: Elimination) -> Iterator[Iterate]:
    """Yield starts far from any solution, the likeliest first.

    Without the lift of the associative law the program is no minimum, and a start may lead nowhere: then comes one near
    a rough solution of the associative program.
    """
    yield from cold_starts(program, layout)
    if (program.law[:, DILATION] < 1.0).any():
        lifting = with_dilation(program, 1.0)
        yield run(lifting, layout, cold(lifting), ROUGH)[0].warm(program)


def with_dilation(program: Program, psi: float) -> Program:
    """Return the program whose joints that slide lift by a share ψ of μ|slip|."""
    law = program.law.copy()
    law[:, DILATION] = psi
    return replace(program, law=law)


def run(
    program: Program, layout: Elimination, start: Iterate, accepted: float
) -> tuple[Iterate, IterationEnd]:
    """Iterate from a start until the residuals, per weight and step, are within `accepted`; `start` is not changed."""
    x, forces, gaps = start.displacement[layout.order], start.forces.copy(), start.gaps.copy()
    count, alpha, force, gap, product = iterate(
        ordered(program, layout), x, start.alpha, forces, gaps, accepted, accepted, (MOST_ITERATIONS, IDLE)
    )
    good = max(force, product) <= accepted and abs(alpha) < LARGEST_MULTIPLIER
    outcome = IterationEnd(good, count < 0 and program.curved is not None, abs(count), force, gap, product)
    return Iterate(forces, gaps, alpha, x[layout.back]), outcome


def ordered(p: Program, layout: Elimination) -> OrderedProgram:
    """Return a program as the compiled loops take it: what it has not is empty."""
    order, none = layout.order, np.zeros(0)
    curved = np.zeros((0, CURVED)) if p.curved is None else p.curved
    lateral, mass = (none if given is None else given[order] for given in (p.lateral, p.mass))
    joints = ProgramJoints(layout.row, p.places, p.law, curved, np.arange(len(layout.row)))
    return OrderedProgram(
        joints, p.load[order], lateral, p.work, mass, p.weight, p.size, p.step, layout.work_space, layout.pattern
    )  # fmt: skip


def resultants(program: Program, iterate: Iterate) -> Array:
    """Return N, P and T (j, 3), kN and kNm, of an iterate."""
    n1, n2, t = iterate.forces.T
    return np.stack([n1 + n2, program.places[:, H] * (n2 - n1), t], axis=1)


def solution(program: Program, iterate: Iterate) -> Solution:
    """Return the certified solution of an iterate."""
    forces, alpha, moved = resultants(program, iterate), iterate.alpha, iterate.displacement
    return Solution(forces, alpha, moved, certify(program, forces, alpha, moved))


def frozen(program: Program) -> Program:
    """Return the program without the change of forces with the geometry."""
    return replace(program, curved=None)


def stable(program: Program, layout: Elimination, solution: Iterate) -> bool:
    """Whether the equilibrium of a `solution` is stable: K + M̄ − G is positive where the lateral load does no work.

    K: tangent stiffness of the joints, G: what their forces change with the geometry (`curved`, which must be given).
    M̄: mass over the square of the time of a step from rest. Under dead load no pivot may be negative. If the multiplier
    is free, one may be, beyond the peak of the curve: then f_Lᵀ(K − G)⁻¹f_L < 0, and with the work of the lateral load
    held no direction is left that is unstable. By Coulomb's law one of two matrices must be so: the symmetric one of
    joints that slide under the friction that they have, or the true tangent, whose friction follows N.
    """
    assert program.curved is not None
    held = np.full(len(program.load), HOLDING * program.weight / program.step)
    held[2::3] *= program.size**2
    if program.mass is not None:
        held += program.mass[layout.order]
    skewed = (False, True) if (program.law[:, DILATION] < 1.0).any() else (False,)
    each = (inertia(ordered(program, layout), solution.forces, solution.gaps, held, two) for two in skewed)
    return any(negative == 0 or (negative == 1 and work < 0.0) for negative, work in each)
