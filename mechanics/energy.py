"""The energy balance of a motion, and the frequency that damping refers to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig_banded

from mechanics.block import Array
from mechanics.integrators import CLOSED, Motion, Scene
from mechanics.solvers.kernels import OPEN, STICKING

RIGID_SHEAR = 1e3  # normal stiffnesses: what stands for an infinite tangential one in the first frequency


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies (k,) in kNm.

    `kinetic`, `potential` (from the start) and `elastic` (contacts) are stored; `input` by the base motion and
    dissipated by `friction`, located `impact`s and `viscous` contact forces are counted since the start. What is
    missing from the balance, the `integrator` has dissipated; implicit Euler's impacts are part of it.
    """

    kinetic: Array
    potential: Array
    elastic: Array
    input: Array
    friction: Array
    impact: Array
    viscous: Array

    @classmethod
    def of(cls, motions: Sequence[Motion], kinetic: Array, potential: Array, elastic: Array) -> Energy:
        """The balance of a motion with the given stored energies (k,)."""
        spent = np.array([(m.input, m.friction, m.impact, m.viscous) for m in motions])
        return cls(kinetic, potential, elastic, *spent.T)

    @property
    def mechanical(self) -> Array:
        """Kinetic, potential and elastic energy (k,), kNm."""
        return self.kinetic + self.potential + self.elastic

    @property
    def integrator(self) -> Array:
        """Dissipated by the time stepping (k,), kNm; negative where it adds energy."""
        missing: Array = self.mechanical[0] + self.input - self.mechanical
        spent: Array = self.friction + self.impact + self.viscous
        return missing - spent

    @property
    def dissipated(self) -> Array:
        """Dissipated in all (k,), kNm."""
        return self.friction + self.impact + self.viscous + self.integrator


def stored(scene: Scene, motions: Sequence[Motion]) -> tuple[Array, Array, Array]:
    """Kinetic, potential and elastic energy (k,) of a motion, kNm."""
    x, v = np.stack([m.x for m in motions]), np.stack([m.v for m in motions])
    kinetic = 0.5 * (scene.model.mass * v**2).sum(axis=(1, 2))
    potential = -(scene.model.dead_load * (x - x[0])).sum(axis=(1, 2))
    elastic = np.zeros(len(motions))
    if scene.behaviour == "elastic":
        k = scene.contacts.stiffness[:, 0]
        for i, m in enumerate(motions):
            gap = scene.geometry(m.x)[0][:, 0]
            elastic[i] = 0.5 * float(k @ np.minimum(gap, 0.0) ** 2) + 0.5 * float(
                scene.compliance[:, 1] @ m.forces[:, 1] ** 2
            )
    return kinetic, potential, elastic


def first_frequency(scene: Scene, x: Array) -> float:
    """The lowest circular frequency (rad/s) of the blocks on their closed contacts, sticking, in a configuration."""
    newton, k = scene.newton, scene.contacts.stiffness
    gap, normal, tangent = scene.geometry(x)
    compliance = 1.0 / np.stack([k[:, 0], np.minimum(k[:, 1], RIGID_SHEAR * k[:, 0])], axis=1)
    state = np.where(gap[:, 0] <= CLOSED * scene.model.size, STICKING, OPEN)
    band = np.zeros_like(newton.band)
    newton.kernels.repeat_matrix(
        newton.row,
        normal,
        tangent,
        scene.contacts.friction,
        compliance,
        np.zeros(len(scene.mass)),
        state,
        band,
    )
    root = np.sqrt(scene.mass[newton.order])
    for offset in range(band.shape[1]):
        size = len(root) - offset
        band[:size, offset] /= root[:size] * root[offset:]
    lowest = eig_banded(band.T, lower=True, eigvals_only=True, select="i", select_range=(0, 0))
    return float(np.sqrt(max(lowest[0], 0.0)))
