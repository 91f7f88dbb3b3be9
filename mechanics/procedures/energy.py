"""The energy balance of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechanics.kernels.dynamics.motion import ELASTIC, FRICTION_WORK, IMPACT, INPUT, STEPPING, VISCOUS
from mechanics.model.assembly import Assembly
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies (k,) in kNm.

    `kinetic`, `potential` (from the start) and `elastic` (joints) are stored, computed from positions and velocities.
    `input` by the base motion and dissipated by `friction` (of slides, and of joints and ties that yield),
    `impact`s, `viscous` joint forces and the `integrator` are summed since the start, each from its own forces and
    displacements. The balance is therefore a check: its `residual` is the error that the solver's tolerance leaves.

    The `integrator` term holds the losses of the scheme itself. Implicit Euler loses ½ΔvᵀMΔv in each step, impacts
    included. Elastic beds lose energy where the force of a step is not its mean force, as in impacts shorter than a
    step. With rigid joints the term holds impacts of faces that meet no faster than a block falls within one step.
    The dilation of slides that change and the energy that beds return beyond what they stored are subtracted (up to
    2 % of the turnover was measured on stiff joints, up to 14 % with dashpots).
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
        """Return the balance of a motion: positions and velocities (k, b, 3), energies (k, ENERGIES) in kNm."""
        potential = -(model.dead_load * (x - x[0])).sum(axis=(1, 2))
        return cls(
            0.5 * (model.mass * v**2).sum(axis=(1, 2)),
            potential,
            energy[:, ELASTIC],
            energy[:, INPUT] + potential,  # INPUT is the work of all loads; the dead loads are in `potential`
            energy[:, FRICTION_WORK],
            energy[:, IMPACT],
            energy[:, VISCOUS],
            energy[:, STEPPING],
        )

    @property
    def mechanical(self) -> Array:
        """Sum of kinetic, potential and elastic energy (k,), kNm."""
        return self.kinetic + self.potential + self.elastic

    @property
    def dissipated(self) -> Array:
        """All the energy dissipated (k,), kNm."""
        return self.friction + self.impact + self.viscous + self.integrator

    @property
    def residual(self) -> Array:
        """Error of the balance (k,), kNm; positive where energy is missing."""
        missing: Array = self.mechanical[0] + self.input - self.mechanical - self.dissipated
        return missing

    @property
    def turnover(self) -> float:
        """The largest kinetic, dissipated or input energy, kNm: residuals are compared with it."""
        return float(max(self.kinetic.max(), self.dissipated.max(), self.input.max()))

    @property
    def imbalance(self) -> float:
        """Largest residual over the turnover; 0 if nothing moved."""
        return float(abs(self.residual).max()) / self.turnover if self.turnover > 0.0 else 0.0

    @property
    def integrator_share(self) -> float:
        """What the integrator took over the turnover; 0 if nothing moved.

        It bounds no error: undamped elastic beds that are shaken lose energy to it, and to nothing else. Whether it
        matters shows a shorter step.
        """
        return float(abs(self.integrator[-1])) / self.turnover if self.turnover > 0.0 else 0.0


def may_fall(parts: Sequence[Energy], spent: float) -> bool:
    """Return whether free motion after motions that follow each other may collapse: it gains no energy.

    With less than the share `spent` of the potential energy from which the structure has come back it does not.
    """
    begun = np.cumsum([0.0, *(float(part.potential[-1]) for part in parts[:-1])])
    stored = np.concatenate(
        [part.potential + part.elastic + high for part, high in zip(parts, begun, strict=True)]
    )
    lowest = float(stored[-len(parts[-1].potential) :].min())
    return float(stored[-1] + parts[-1].kinetic[-1]) - lowest >= spent * (float(stored.max()) - lowest)
