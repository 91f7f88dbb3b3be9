"""THE mathematical program: every analysis is this one, with parts present or absent (paper, eqs 3–5).

    minimise   ½ iᵀM̄⁻¹i + W*(N, P) + T²/2k_t + cᵀg₀ − αγ       c = (N, P, T) of each joint, i = M̄Δx
    subject to i − Bᵀc − αf_L = f̄                              equilibrium of each movable block
               |P| ≤ hN − N²/(2σ),   |T| ≤ μN                   at each joint

The paper's contact points at the ends of a joint give the same cone |P| ≤ hN, with friction on the resultant. The
displacements Δx are the multipliers of equilibrium. As a minimum it holds where sliding lifts the joint by μ|slip|
(ψ = 1, the associative law of the paper). With Coulomb's law, ψ = 0, the same conditions without that lift are those of
no minimum: a mixed complementarity problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import BED, CRUSHED, DILATION, FRICTION, SHEAR, SLID, STRENGTH, ends_under
from mechanics.model.contacts import forces_on_blocks, relative_motion
from mechanics.types import Array, Index

LARGEST_MULTIPLIER, BOUNDED = 1e4, 0.99e4  # no mechanism has one beyond; no solution one between


@dataclass(frozen=True, eq=False)
class Program:
    """One program over j joints and m degrees of freedom.

    `dof` (j, 6): degrees of freedom of blocks a and b, −1 for a support; `places` (j, PLACE) and `law` (j, LAW): see
    kernels; `load` (m,) kN: f̄; `lateral` (m,) kN: f_L, None where there is no multiplier; `work` γ in kNm;
    `mass` (m,): M̄, None in statics; `curved` (j, CURVED): what given forces change with the geometry (joint.curvature),
    None where that is left out. `weight` (kN) and `step` (m) are the sizes of a force and a displacement, `size` (m)
    that of a block: residuals are relative to them.
    """

    dof: Index
    places: Array
    law: Array
    load: Array
    lateral: Array | None
    work: float
    mass: Array | None
    weight: float
    size: float
    step: float
    curved: Array | None = None

    def resultant(self, forces: Array) -> Array:
        """Bᵀc (m,): forces and moments that joint forces (j, 3) exert on the blocks."""
        entries = forces_on_blocks(self.places, forces)
        moving = self.dof >= 0
        total = np.bincount(self.dof[moving], entries[moving], minlength=len(self.load))
        return np.asarray(total, dtype=float)

    def deformation(self, displacement: Array) -> Array:
        """Gap u, turn φ and slip v − v₀ (j, 3) after displacements (m,)."""
        local = np.where(self.dof >= 0, displacement[self.dof], 0.0)
        found: Array = self.places[:, [U, PHI, V]] + relative_motion(self.places, local)
        found[:, 2] -= self.law[:, SLID]
        return found


@dataclass(frozen=True, slots=True)
class Certificate:
    """How well a solution meets the definitions of its program, recomputed from them.

    `equilibrium`: largest unbalanced force (moments by the block size) per weight; `cone`: largest violation of the
    bounds of P and T per weight; `complementarity`: forces times the gaps and slips that they should not have, per
    weight of the structure and step; `penetration` m: deepest interpenetration that no bed explains; `work`:
    |f_LᵀΔx − γ| per weight and step.
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
class Solution:
    """Joint forces N, P, T (j, 3), kN and kNm, multiplier, displacements (m,); and their certificate."""

    forces: Array
    alpha: float
    displacement: Array
    certificate: Certificate


def end_forces(forces: Array, half: Array) -> Array:
    """N₁ and N₂ (j, 2) at the ends of overlaps 2h of N and P (j, 3)."""
    couple = np.divide(forces[:, 1], half, out=np.zeros(len(forces)), where=half > 0.0)
    return 0.5 * np.stack([forces[:, 0] - couple, forces[:, 0] + couple], axis=1)


def bed_gaps(ends: Array, half: Array, law: Array) -> Array:
    """Gaps (j, 2), m, of the ends of elastic beds under end forces (j, 2), kN."""
    gaps = np.empty_like(ends)
    ends_under(np.maximum(ends, 1e-12 * abs(ends).max(initial=1e-300)), half, law, gaps)
    return gaps


def certify(program: Program, forces: Array, alpha: float, displacement: Array) -> Certificate:
    """Return the residuals of a solution, from their definitions (see Certificate).

    `forces` (j, 3): N, P and T, kN and kNm; `alpha`; `displacement` (m,), m and rad.
    """
    p, law, half = program, program.law, program.places[:, H]
    residual = p.resultant(forces) + p.load
    if p.lateral is not None:
        residual = residual + alpha * p.lateral
    if p.mass is not None:
        residual = residual - p.mass * displacement
    residual[2::3] /= p.size
    u, phi, v = p.deformation(displacement).T
    n, _, t = forces.T
    ends = end_forces(forces, half)
    crush = n**2 / (4.0 * half * law[:, STRENGTH])
    margin = ends - crush[:, None]
    slip = v + law[:, SHEAR] * t
    # the cone in homogeneous form, |T| cos φ ≤ N sin φ over the larger of both: N ≥ 0 alone where nothing slides
    mu = law[:, FRICTION]
    infinite = np.isinf(mu)
    cos = 1.0 / np.maximum(mu, 1.0)
    sin = np.where(infinite, 1.0, np.minimum(mu, 1.0))
    room = sin * n - cos * abs(t)
    lifted = u - law[:, DILATION] * np.where(infinite, 0.0, mu) * abs(slip)
    gaps = np.stack([lifted - half * phi, lifted + half * phi], axis=1)
    elastic = law[:, BED] < np.inf
    if elastic.any():
        gaps[elastic] -= bed_gaps(ends[elastic], half[elastic], law[elastic])
    # crushing closes both ends, w = y − 2κN(y₁ + y₂): of the gaps y one is nothing unless all of the joint is crushed
    apart, share = gaps[:, 0] - gaps[:, 1], n / (2.0 * half * law[:, STRENGTH])
    both = 0.5 * (gaps.sum(axis=1) - (1.0 - 2.0 * share) * abs(apart))
    both = np.where(share < CRUSHED, both, -both)
    gaps = both[:, None] + np.maximum(np.stack([apart, -apart], axis=1), 0.0)
    work = 0.0
    if p.lateral is not None:
        work = (float(p.lateral @ displacement) - p.work) / (p.weight * p.step)
        # a load that only wedges the blocks holds α at its bound and does less than the given work
        work = max(work, 0.0) if alpha > BOUNDED else abs(work)
    idle = abs(np.maximum(margin, 0.0) * gaps).sum() + abs(sin * n * abs(slip) + cos * t * slip).sum()
    # an open joint bears no T either, but by the associative law, whose cone is closed
    coulomb = infinite & (law[:, DILATION] < 1.0)
    idle += float((abs(t) * np.maximum(gaps.min(axis=1), 0.0))[coulomb].sum())
    return Certificate(
        equilibrium=float(abs(residual).max(initial=0.0) / p.weight),
        cone=float(max((-room).max(initial=0.0), (-margin).max(initial=0.0)) / p.weight),
        complementarity=float(idle / (p.weight * p.step * len(p.load) / 3)),
        penetration=float((-gaps).max(initial=0.0)),
        work=work,
    )
