"""The energy balance of a motion, and the frequency that damping refers to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from mechanics.assembly import Assembly
from mechanics.block import Array
from mechanics.scene import Motion, Scene
from mechanics.solvers.cholesky import factorise, substitute
from mechanics.solvers.compiled import repeat_matrix
from mechanics.solvers.kernels import STICKING

RIGID_SHEAR = 1e3  # normal stiffnesses: what stands for an infinite tangential one in the first frequency


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies (k,) in kNm.

    `kinetic`, `potential` (from the start) and `elastic` (contacts) are stored, computed from positions and velocities.
    `input` by the base motion and dissipated by `friction`, located `impact`s, `viscous` contact forces and the
    `integrator` are summed since the start, each from forces and displacements of its own kind. What `integrator`
    takes is what the scheme is known to: of implicit Euler ½ΔvᵀMΔv a step, impacts in it, and what springs lose where
    forces are not the mean ones; less the dilation of sliding, which comes back when the gap closes; of the midpoint
    rule with rigid contacts what their forces do while rows turn with the blocks, and sliding that stops in a step. So
    the balance is a check: its `residual` is what the solver's tolerance leaves open, and with elastic contacts the
    geometry linearised in a step.
    """

    kinetic: Array
    potential: Array
    elastic: Array
    input: Array
    friction: Array
    impact: Array
    viscous: Array
    integrator: Array

    @classmethod
    def of(cls, model: Assembly, motions: Sequence[Motion]) -> Energy:
        """The balance of a motion."""
        x, v = np.stack([m.x for m in motions]), np.stack([m.v for m in motions])
        return cls(
            0.5 * (model.mass * v**2).sum(axis=(1, 2)),
            -(model.dead_load * (x - x[0])).sum(axis=(1, 2)),
            *np.array(
                [(m.elastic, m.input, m.friction, m.impact, m.viscous, m.integrator) for m in motions]
            ).T,
        )

    @property
    def mechanical(self) -> Array:
        """Kinetic, potential and elastic energy (k,), kNm."""
        return self.kinetic + self.potential + self.elastic

    @property
    def dissipated(self) -> Array:
        """Dissipated in all (k,), kNm."""
        return self.friction + self.impact + self.viscous + self.integrator

    @property
    def residual(self) -> Array:
        """What the balance leaves open (k,), kNm: positive where energy is missing."""
        missing: Array = self.mechanical[0] + self.input - self.mechanical - self.dissipated
        return missing

    @property
    def turnover(self) -> float:
        """The largest energy (kNm) that was kinetic, dissipated or put in: what a residual is measured by."""
        return float(max(self.kinetic.max(), self.dissipated.max(), self.input.max()))

    @property
    def imbalance(self) -> float:
        """Largest residual over the turnover; 0 where nothing moved."""
        return float(abs(self.residual).max()) / self.turnover if self.turnover > 0.0 else 0.0


def first_frequency(scene: Scene) -> float:
    """The lowest circular frequency (rad/s) of the blocks as drawn, all contacts closed and sticking.

    Nothing where some blocks are loose.
    """
    newton, k = scene.newton, scene.contacts.stiffness
    _, normal, tangent = scene.geometry(scene.model.initial.positions)
    compliance = 1.0 / np.stack([k[:, 0], np.minimum(k[:, 1], RIGID_SHEAR * k[:, 0])], axis=1)
    state = np.full(len(k), STICKING)
    stored = np.empty_like(newton.stored)
    repeat_matrix(
        newton.row,
        normal,
        tangent,
        scene.contacts.friction,
        compliance,
        np.zeros(len(scene.mass)),
        state,
        stored,
        newton.pattern,
    )
    if not factorise(stored, newton.pattern):
        return 0.0
    root = np.sqrt(scene.mass[newton.order])

    def flexibility(x: Array) -> Array:
        y: Array = root * x.ravel()
        substitute(stored, newton.pattern, y)
        return root * y

    size = len(root)
    operator = LinearOperator((size, size), matvec=flexibility, dtype=float)
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # where few modes differ ARPACK goes on from random vectors: its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")
