"""What does not change while blocks move, and the motion itself, step by step.

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mechanics.errors import ConvergenceError
from mechanics.kernels.cholesky import factorise, substitute
from mechanics.kernels.joint import H
from mechanics.kernels.law import BED, SHEAR
from mechanics.kernels.matrix import diagonal, stiffen
from mechanics.kernels.motion_step import ELASTIC, ENERGIES, march, strain_energy
from mechanics.model.assembly import Assembly, State
from mechanics.model.contacts import Contacts
from mechanics.program import end_forces
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.threads import one_thread
from mechanics.steps.contact_values import moved_over, spring_forces
from mechanics.steps.static_system import StaticSystem, static_system
from mechanics.types import Array, Index

ACCEPTED = 1e-7  # what a program may miss, per weight and span
AHEAD = 0.05  # of the block size: how far a corner goes before contacts are looked for anew


@dataclass(eq=False)
class Motion:
    """Blocks in motion, changed step by step.

    `x`, `v` (b, 3): positions and velocities; `past` (b, 3): mean acceleration of the last step, 0 after an impact;
    `forces` (j, 3): N₁, N₂, T and `gaps` (j, 4): y₁, y₂, λ₊, λ₋ of the last program; `shear` (j,) kN of springs;
    `slides` (j, 2): speed (m/s) and acceleration of joints that slide;
    `energy` (ENERGIES,) kNm: see kernels.motion_step.
    """

    x: Array
    v: Array
    past: Array
    forces: Array
    gaps: Array
    shear: Array
    slides: Array
    energy: Array


@dataclass(frozen=True, eq=False)
class Recorded:
    """Positions and velocities (k + 1, b, 3), N, P and T (k + 1, j, 3) and energies (k + 1, ENERGIES) of k steps.

    Of the first ones, from which the steps begin, the forces are unknown.
    """

    x: Array
    v: Array
    forces: Array
    energy: Array

    def until(self, last: int) -> Recorded:
        """The first steps, up to the `last`."""
        return Recorded(*(values[: last + 1] for values in (self.x, self.v, self.forces, self.energy)))


@dataclass(frozen=True, slots=True)
class Halving:
    """How often a step is halved where impacts, or the stepping, take more than a `share` of the kinetic energy."""

    levels: int
    share: float


@dataclass(frozen=True, eq=False)
class DynamicSystem:
    """The system of a motion.

    `theta`: the share of a step at which balance holds; `damping` (s): viscous contact force per elastic one and rate
    of gap; `restitution` of normal velocities; `halving` of steps; `lifted` (j,) m: gaps that count as none. `counts`
    (6,): programs, iterations, halvings, cold starts, and the worst residuals of force and product.
    """

    system: StaticSystem
    theta: float
    damping: float
    restitution: float
    halving: Halving
    lifted: Array
    counts: Array = field(default_factory=lambda: np.zeros(6))

    @property
    def model(self) -> Assembly:
        """The assembly."""
        return self.system.model

    @property
    def contacts(self) -> Contacts:
        """Where blocks touch, or may within the way that is looked ahead."""
        return self.system.contacts

    @cached_property
    def layout(self) -> Elimination:
        """In which order the matrices are eliminated."""
        model = self.model
        return Elimination.of(self.system.dof, model.initial.positions[model.movable, :2])

    @property
    def margin(self) -> float:
        """How far (m) a corner may go before contacts are looked for anew."""
        return AHEAD * self.model.size if self.model.collisions else np.inf

    def around(self, motion: Motion) -> DynamicSystem:
        """The system with the contacts about a motion, whose arrays become those of these contacts."""
        system, before = self.system.around(motion.x, self.margin), self.contacts
        if system is self.system:
            return self
        lifted = moved_over(self.lifted[:, None], before, system.contacts)[:, 0]
        found = replace(self, system=system, lifted=lifted)
        if np.array_equal(before.edges, system.contacts.edges):
            found.__dict__["layout"] = self.layout
        motion.forces, motion.gaps, springs = (
            moved_over(v, before, system.contacts)
            for v in (motion.forces, motion.gaps, np.column_stack([motion.shear, motion.slides]))
        )
        motion.shear, motion.slides = springs[:, 0].copy(), springs[:, 1:].copy()
        return found

    @cached_property
    def first(self) -> Index:
        """First row (b,) of each block in that order, −1 of a support."""
        first = np.full(len(self.model.blocks), -1, dtype=np.intp)
        first[self.model.movable] = 3 * np.argsort(self.layout.order[::3] // 3)
        return first

    def begun(self, start: State, forces: Array | None) -> Motion:
        """The motion that begins in a state, with forces (j, 3) N, P and T where they are known."""
        count, elastic = len(self.contacts), not self.system.rigid
        places = self.contacts.places(start.positions)
        ends = np.zeros((count, 3))
        if forces is not None:
            ends[:, :2], ends[:, 2] = end_forces(forces, places[:, H]), forces[:, 2]
        shear, energy = np.zeros(count), np.zeros(ENERGIES)
        if elastic:
            shear = spring_forces(self.contacts, start)
            energy[ELASTIC] = strain_energy(places, self.system.law, shear, self.model.size)
        return Motion(
            start.positions.copy(), start.velocities.copy(), np.zeros_like(start.positions), ends,
            np.zeros((count, 4)), shear, np.zeros((count, 2)), energy,
        )  # fmt: skip

    @one_thread()
    def march(self, motion: Motion, base: Array, step: float) -> Recorded:
        """The steps of a motion under base accelerations (k + 1, 3), m/s², one `step` (s) apart; the motion goes on.

        Ends early after the step in which a corner has gone farther than the margin. Raises ConvergenceError where a
        step is not solved, however short.
        """
        model, c = self.model, self.contacts
        steps, count = len(base) - 1, len(c)
        xs, vs = (np.empty((steps + 1, len(model.blocks), 3)) for _ in range(2))
        fs, es = np.zeros((steps + 1, count, 3)), np.empty((steps + 1, ENERGIES))
        xs[0], vs[0], es[0] = motion.x, motion.v, motion.energy
        done, reason = march(
            c.a, c.b, c.faces, self.system.law, c.tolerance, self.layout.row, self.first, model.mass, model.dead_load,
            base, motion.x, motion.v, motion.past, motion.forces, motion.gaps, motion.shear, motion.slides,
            motion.energy, step,
            self.theta, self.damping, self.restitution, self.lifted, (self.system.weight, model.size, ACCEPTED),
            (self.halving.levels, self.halving.share), self.margin, model.radius, motion.x.copy(), xs, vs, fs, es,
            self.counts,
            self.layout.work_space, self.layout.packed,
        )  # fmt: skip
        if reason == 2:
            raise ConvergenceError(f"a step of the motion was not solved, {done} steps on")
        return Recorded(xs[: done + 1], vs[: done + 1], fs[: done + 1], es[: done + 1])


RIGID_SHEAR = 1e3  # normal stiffnesses: what stands for an infinite tangential one in the first frequency


def first_frequency(model: Assembly) -> float:
    """The lowest circular frequency (rad/s) of the blocks as drawn, all joints closed and sticking.

    Nothing where some blocks are loose.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    system = static_system(model, "elastic")
    layout = Elimination.of(system.dof, model.initial.positions[model.movable, :2])
    places = system.contacts.places(model.initial.positions)
    length = 2.0 * places[:, H]
    normal = system.law[:, BED] * length
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    mass, stored = model.mass[model.movable].ravel()[layout.order], layout.matrix()
    diagonal(np.zeros(len(mass)), stored, layout.pattern)
    for k, (i, j) in enumerate(layout.row):
        law = np.array([normal[k], 0.0, 0.0, normal[k] * length[k] ** 2 / 12.0, 0.0, shear[k]])
        stiffen(k, places[k], i, j, law, stored, layout.pattern)
    if _some_are_loose(model) or not factorise(stored, layout.pattern):
        return 0.0
    root = np.sqrt(mass)

    def flexibility(x: Array) -> Array:
        y: Array = root * x.ravel()
        substitute(stored, layout.pattern, y)
        return root * y

    operator = LinearOperator((len(mass), len(mass)), matvec=flexibility, dtype=float)
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # where few modes differ ARPACK goes on from random vectors: its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")


def _some_are_loose(model: Assembly) -> bool:
    """Whether no joints lead from some block to a support: rounding might hold it."""
    joints, count = model.joints, len(model.blocks)
    links = sparse.coo_matrix((np.ones(len(joints.a)), (joints.a, joints.b)), shape=(count, count))
    _, part = connected_components(links, directed=False)
    return not np.isin(part, part[~model.movable]).all()
