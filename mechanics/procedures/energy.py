"""The energy balance of a motion."""

from __future__ import annotations

from dataclasses import dataclass

from mechanics.kernels.motion_step import ELASTIC, IMPACT, INPUT, RUBBED, STEPPING, VISCOUS
from mechanics.model.assembly import Assembly
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies (k,) in kNm.

    `kinetic`, `potential` (from the start) and `elastic` (joints) are stored, computed from positions and velocities.
    `input` by the base motion and dissipated by `friction`, `impact`s, `viscous` joint forces and the `integrator` are
    summed since the start, each from forces and displacements of its own kind. What the `integrator` takes is known
    from the scheme: of implicit Euler ½ΔvᵀMΔv a step, impacts in it, and what springs lose where forces are not the
    mean ones, less the dilation of sliding, which comes back when the gap closes. So the balance is a check: its
    `residual` is what the solver's tolerance leaves open, and with elastic joints the geometry linearised in a step.
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
    def of(cls, model: Assembly, x: Array, v: Array, energy: Array) -> Energy:
        """The balance of a motion: positions and velocities (k, b, 3), energies (k, ENERGIES)."""
        potential = -(model.dead_load * (x - x[0])).sum(axis=(1, 2))
        return cls(
            0.5 * (model.mass * v**2).sum(axis=(1, 2)),
            potential,
            energy[:, ELASTIC],
            energy[:, INPUT] + potential,  # of all loads, less the dead ones
            energy[:, RUBBED],
            energy[:, IMPACT],
            energy[:, VISCOUS],
            energy[:, STEPPING],
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

    @property
    def integrator_share(self) -> float:
        """What the integrator itself took, of all that was dissipated; 0 where nothing was."""
        taken = float(self.dissipated[-1])
        return float(abs(self.integrator[-1])) / taken if taken > 0.0 else 0.0
