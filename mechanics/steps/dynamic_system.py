"""What does not change while blocks move, and the motion itself, step by step.

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.errors import ConvergenceError
from mechanics.kernels.interior_iteration import BED, SHEAR
from mechanics.kernels.joint import H, V
from mechanics.kernels.motion_step import ENERGIES, march, strain_energy
from mechanics.model.contacts import Contacts
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.threads import one_thread
from mechanics.steps.static_step import StaticSystem, static_system
from mechanics.types import Array, Index

ACCEPTED = 1e-7  # what a program may miss, per weight and span
COLD = 10.0  # forces and gaps before the first step, per weight and span


@dataclass(eq=False)
class Motion:
    """Blocks in motion, changed step by step.

    `x`, `v` (b, 3): positions and velocities; `past` (b, 3): mean acceleration of the last step, 0 after an impact;
    `forces` (j, 3): N₁, N₂, T and `gaps` (j, 4): y₁, y₂, λ₊, λ₋ of the last program; `shear` (j,) kN of springs; `energy`
    (ENERGIES,) kNm: see kernels.motion_step.
    """

    x: Array
    v: Array
    past: Array
    forces: Array
    gaps: Array
    shear: Array
    energy: Array


@dataclass(frozen=True, eq=False)
class Recorded:
    """What steps were recorded: positions and velocities (k + 1, b, 3), forces (k + 1, j, 3), energies; and the `reason`.

    That no more were done: 0 all are, 1 a block has gone as far as is watched.
    """

    x: Array
    v: Array
    forces: Array
    energy: Array
    reason: int


@dataclass(frozen=True, slots=True)
class Halving:
    """How often a step is halved where impacts, or the stepping, take more than a `share` of the kinetic energy."""

    levels: int
    share: float


@dataclass(frozen=True, eq=False)
class DynamicSystem:
    """The system of a motion.

    `theta`: the share of a step at which balance holds; `damping` (s): viscous contact force per elastic one and rate of
    gap; `halving` of steps; `lifted` (j,) m: gaps that count as none. `counts` (6,): programs, iterations, halvings, cold
    starts, and the worst residuals of force and product.
    """

    system: StaticSystem
    contacts: Contacts
    theta: float
    damping: float
    halving: Halving
    lifted: Array
    counts: Array = field(default_factory=lambda: np.zeros(6))

    @property
    def model(self) -> Assembly:
        """The assembly."""
        return self.system.model

    @cached_property
    def layout(self) -> Elimination:
        """In which order the matrices are eliminated."""
        dof, model = self.model.dof, self.model
        rows = np.concatenate([dof[self.contacts.a], dof[self.contacts.b]], axis=1)
        return Elimination.of(rows, model.initial.positions[model.movable, :2])

    @cached_property
    def first(self) -> Index:
        """First row (b,) of each block in that order, −1 of a support."""
        first = np.full(len(self.model.blocks), -1, dtype=np.intp)
        first[self.model.movable] = 3 * np.argsort(self.layout.order[::3] // 3)
        return first

    @cached_property
    def smallest(self) -> float:
        """Size of the smallest block, m."""
        return float(np.sqrt(min(b.area for b in self.model.blocks)))

    def begun(self, start: State, forces: Array | None) -> Motion:
        """The motion that begins in a state, with forces (j, 3) N, P and T where they are known."""
        count = len(self.contacts)
        ends = np.zeros((count, 3))
        if forces is not None:
            half = np.maximum(self.contacts.places(start.positions)[:, H], 1e-300)
            couple = forces[:, 1] / half
            ends = np.stack([0.5 * (forces[:, 0] - couple), 0.5 * (forces[:, 0] + couple), forces[:, 2]], axis=1)
        shear = np.zeros(count)
        if not self.system.rigid:
            if forces is not None:
                shear = forces[:, 2].copy()
            elif start.shear is not None:
                shear[: len(start.shear)] = start.shear
        energy = np.zeros(ENERGIES)
        if not self.system.rigid:
            places = self.contacts.places(start.positions)
            energy[0] = strain_energy(places, self.system.law, shear, self.model.size)
        return Motion(
            start.positions.copy(), start.velocities.copy(), np.zeros_like(start.positions), ends,
            np.zeros((count, 4)), shear, energy,
        )  # fmt: skip

    @one_thread()
    def march(self, motion: Motion, base: Array, step: float, watch: float, begun: Array) -> Recorded:
        """The steps of a motion under base accelerations (k + 1, 3), m/s², one `step` (s) apart; the motion goes on.

        Ends after the step in which a block is farther than `watch` (m, or rad) from where it `begun` (b, 3). Raises
        ConvergenceError where a step is not solved, however short.
        """
        model, c = self.model, self.contacts
        steps, count = len(base) - 1, len(c)
        xs, vs = (np.empty((steps + 1, len(model.blocks), 3)) for _ in range(2))
        fs, es = np.empty((steps + 1, count, 3)), np.empty((steps + 1, ENERGIES))
        xs[0], vs[0], fs[0], es[0] = motion.x, motion.v, motion.forces, motion.energy
        done, reason = march(
            c.a, c.b, c.faces, self.system.law, c.tolerance, self.layout.row, self.first, model.mass, model.dead_load,
            base, motion.x, motion.v, motion.past, motion.forces, motion.gaps, motion.shear, motion.energy, step,
            self.theta, self.damping, self.lifted, (self.system.weight, model.size, ACCEPTED),
            (self.halving.levels, self.halving.share), watch, begun, xs, vs, fs, es, self.counts,
            self.layout.work_space, self.layout.packed,
        )  # fmt: skip
        if reason == 2:
            raise ConvergenceError(f"a step of the motion was not solved, {done} steps on")
        return Recorded(xs[: done + 1], vs[: done + 1], fs[: done + 1], es[: done + 1], reason)


def dynamic_system(
    model: Assembly, behaviour: Behaviour, theta: float, halving: Halving, damping: float = 0.0
) -> DynamicSystem:
    """The system of the motions of an assembly."""
    system = static_system(model, behaviour)
    return DynamicSystem(system, system.contacts, theta, damping, halving, np.zeros(len(system.contacts)))


RIGID_SHEAR = 1e3  # normal stiffnesses: what stands for an infinite tangential one in the first frequency


def first_frequency(model: Assembly) -> float:
    """The lowest circular frequency (rad/s) of the blocks as drawn, all joints closed and sticking.

    Nothing where some blocks are loose.
    """
    from scipy import sparse
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    from mechanics.model.contacts import rows

    system = static_system(model, "elastic")
    places = system.contacts.places(model.initial.positions)
    length = 2.0 * places[:, H]
    normal = system.law[:, BED] * length
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    stiffness = np.stack([normal, normal * length**2 / 12.0, shear], axis=1)
    b = rows(places)
    blocks = np.einsum("jrc,jr,jrd->jcd", b, stiffness, b)
    dof = system.dof
    i, j = np.broadcast_to(dof[:, :, None], blocks.shape), np.broadcast_to(dof[:, None, :], blocks.shape)
    moving = (i >= 0) & (j >= 0)
    mass = model.mass[model.movable].ravel()
    matrix = sparse.csc_matrix((blocks[moving], (i[moving], j[moving])), shape=(len(mass), len(mass)))
    diagonal = matrix.diagonal()
    if not (diagonal > 0.0).all():
        return 0.0
    factors = splu(matrix)
    pivots = factors.U.diagonal()
    if abs(pivots).min() < 1e-12 * abs(diagonal).max() or (pivots <= 0.0).any():
        return 0.0
    root = np.sqrt(mass)
    operator = LinearOperator(
        (len(mass), len(mass)), matvec=lambda x: root * factors.solve(root * x.ravel()), dtype=float
    )
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # where few modes differ ARPACK goes on from random vectors: its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")


def slips(contacts: Contacts, positions: Array) -> Array:
    """Slips (j,) of the joints in a configuration."""
    found: Array = contacts.places(positions)[:, V]
    return found
