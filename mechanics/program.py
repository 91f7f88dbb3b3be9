"""THE mathematical program: every analysis is this one, with parts present or absent (paper, eqs 3–5; design.md §1).

    minimise   ½ iᵀM̄⁻¹i + ½ cᵀCc + g₀ᵀc − αγ
    subject to i − A₀c − αf_L = f̄            equilibrium of each movable block
               |t_k| ≤ μ n_k                  at each contact point

The displacements Δx are the multipliers of equilibrium; w = Cc + g₀ + A₀ᵀΔx, the gap and slip left after the step,
lies in the dual cone w_n ≥ μ|w_t| and does no work on the forces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanics.block import Array
from mechanics.joints import Index

LARGEST_MULTIPLIER = 1e4  # beyond it a load is said to meet no mechanism


@dataclass(frozen=True, eq=False)
class Program:
    """One program over c contact points and m degrees of freedom; arrays as named in the module's docstring.

    `dof` (c, 6): row of equilibrium of each entry of `normal` and `tangent` (c, 6), the rows of A₀ᵀ; −1: a support.
    `gap` (c, 2) m: g₀, normal and tangential; `friction` (c,); `compliance` (c, 2) m/kN: C;
    `load` (m,) kN: f̄; `lateral` (m,) kN: f_L, None where there is no multiplier; `work` γ in kNm;
    `mass` (m,): M̄, None in statics. `weight` (kN) and `step` (m) are the sizes of a force and a displacement,
    `size` (m) that of a block: they make the program dimensionless and its residuals relative.
    """

    dof: Index
    normal: Array
    tangent: Array
    gap: Array
    friction: Array
    compliance: Array
    load: Array
    lateral: Array | None
    work: float
    mass: Array | None
    weight: float
    size: float
    step: float

    def take(self, index: NDArray[np.intp]) -> Program:
        """The program over a choice of contact points."""
        per_contact = ("dof", "normal", "tangent", "gap", "friction", "compliance")
        return replace(self, **{name: getattr(self, name)[index] for name in per_contact})

    def resultant(self, forces: Array) -> Array:
        """A₀c (m,): forces and moments that contact forces (c, 2) exert on the blocks."""
        entries = forces[:, :1] * self.normal + forces[:, 1:] * self.tangent
        moving = self.dof >= 0
        total = np.bincount(self.dof[moving], entries[moving], minlength=len(self.load))
        return np.asarray(total, dtype=float)

    def relative(self, displacement: Array) -> Array:
        """A₀ᵀΔx (c, 2): opening and slip that block displacements (m,) cause at the contact points."""
        local = np.where(self.dof >= 0, displacement[self.dof], 0.0)
        return np.stack([(self.normal * local).sum(axis=1), (self.tangent * local).sum(axis=1)], axis=1)

    def opening(self, forces: Array, displacement: Array) -> Array:
        """W = Cc + g₀ + A₀ᵀΔx (c, 2): gap and slip left after the step."""
        left: Array = self.compliance * forces + self.gap + self.relative(displacement)
        return left


@dataclass(frozen=True, slots=True)
class Certificate:
    """How well a solution meets the definitions of its program, recomputed from them.

    `equilibrium`: largest unbalanced force (moments by the block size) per weight; `cone`: largest violation of
    |t| ≤ μn per weight; `complementarity`: |cᵀw| per weight and step; `penetration` m: largest violation of
    w_n ≥ μ|w_t|; `work`: |f_LᵀΔx − γ| per weight and step.
    """

    equilibrium: float
    cone: float
    complementarity: float
    penetration: float
    work: float

    def worst(self, step: float) -> float:
        """The largest residual; complementarity and penetration (per step, m) are allowed a hundredfold."""
        return max(
            self.equilibrium,
            self.cone,
            self.work,
            self.complementarity / 100.0,
            self.penetration / step / 100.0,
        )

    def joined(self, other: Certificate) -> Certificate:
        """The worse of two, residual by residual."""
        return Certificate(
            max(self.equilibrium, other.equilibrium),
            max(self.cone, other.cone),
            max(self.complementarity, other.complementarity),
            max(self.penetration, other.penetration),
            max(self.work, other.work),
        )


@dataclass(frozen=True, eq=False)
class Neighbour:
    """The solution of a like program, near which another is sought: forces (c, 2) kN, w (c, 2) m and multiplier."""

    forces: Array
    opening: Array
    alpha: float

    def take(self, index: NDArray[np.intp], stretch: float) -> Neighbour:
        """The same at a choice of the contact points, for a step that is longer by the factor `stretch`."""
        return Neighbour(self.forces[index], stretch * self.opening[index], self.alpha)


@dataclass(frozen=True, eq=False)
class Solution:
    """Contact forces (c, 2) kN, multiplier, displacements (m,), inertia forces are M̄Δx; and its certificate."""

    forces: Array
    alpha: float
    displacement: Array
    certificate: Certificate

    def neighbour(self, program: Program) -> Neighbour:
        """What this solution of a program tells one that is sought near it."""
        return Neighbour(self.forces, program.opening(self.forces, self.displacement), self.alpha)


def certify(program: Program, forces: Array, alpha: float, displacement: Array) -> Certificate:
    """Recompute from the definitions how far a solution is from one (see Certificate)."""
    residual = program.resultant(forces) + program.load
    if program.lateral is not None:
        residual = residual + alpha * program.lateral
    if program.mass is not None:
        residual = residual - program.mass * displacement
    residual[2::3] /= program.size
    w = program.opening(forces, displacement)
    n, t = forces.T
    work = 0.0
    if program.lateral is not None:
        work = (float(program.lateral @ displacement) - program.work) / (program.weight * program.step)
        # a load that only wedges the blocks holds α at its bound and does less work than is asked of it
        work = max(work, 0.0) if alpha > 0.99 * LARGEST_MULTIPLIER else abs(work)
    return Certificate(
        equilibrium=float(abs(residual).max(initial=0.0) / program.weight),
        cone=float(
            max((abs(t) - program.friction * n).max(initial=0.0), (-n).max(initial=0.0)) / program.weight
        ),
        complementarity=float(abs((forces * w).sum(axis=1)).sum() / (program.weight * program.step)),
        penetration=float((program.friction * abs(w[:, 1]) - w[:, 0]).max(initial=0.0)),
        work=work,
    )
