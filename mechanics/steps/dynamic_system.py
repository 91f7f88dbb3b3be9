"""The system of a motion, which does not change while blocks move, and the motion itself, step by step.

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mechanics.errors import ConvergenceError
from mechanics.kernels.dynamics.motion import (
    ELASTIC,
    ENERGIES,
    JOINT,
    LARGEST,
    LONGER,
    SPRING,
    SUNK,
    Moving,
    Scheme,
    Structure,
    remember,
    strain_energy,
)
from mechanics.kernels.dynamics.step import FAR, RESTS, UNSOLVED, march
from mechanics.kernels.joint import H, U
from mechanics.messages import message
from mechanics.model.assembly import Assembly, MotionMemory, State
from mechanics.model.contacts import Contacts, end_gaps
from mechanics.program import end_forces
from mechanics.solvers.elimination import Elimination
from mechanics.steps.static_system import StaticSystem, moved_over, places_among, spring_forces
from mechanics.steps.tolerances import STEP
from mechanics.types import Array, Index

LONG = 10  # computed steps at rest after which it is tried how far rest goes


@dataclass(eq=False)
class Rest:
    """The accelerations (m/s²) under which rigid joints rest where they are, from `low` to `high`, and their forces.

    From v₀ = 0 the one solution of a step is v₁ = 0 where, and only where, forces within their bounds that press closed
    joints alone balance the loads. Loads are affine in the acceleration and bounds are convex, so what rests under two
    accelerations rests under all between, with the forces (j, 3) between. `computed`: steps that have found it so far;
    `tried`: accelerations that were tried ahead.
    """

    low: float
    high: float
    forces_low: Array
    forces_high: Array
    computed: int = 1
    tried: list[float] = field(default_factory=list)

    def grow(self, at: float, forces: Array) -> None:
        """Take an acceleration up under which a step has found rest."""
        self.computed += 1
        if at < self.low:
            self.low, self.forces_low = at, forces
        if at > self.high:
            self.high, self.forces_high = at, forces

    def steps(self, a: Array) -> int:
        """Return during how many steps from the first on base accelerations a (k + 1,) stay inside, at both ends."""
        outside = np.flatnonzero((a < self.low) | (a > self.high))
        return max(int(outside[0]) - 1, 0) if outside.size else len(a) - 1

    def forces(self, a: Array) -> Array:
        """Return forces (k, j, 3) at accelerations a (k,)."""
        share = (a - self.low) / max(self.high - self.low, 1e-300)
        return self.forces_low + share[:, None, None] * (self.forces_high - self.forces_low)


@dataclass(eq=False)
class Motion:
    """Blocks in motion, changed step by step.

    `blocks` (4, b, 3): positions, velocities, mean accelerations of the last step, 0 after an impact, and velocities at
    which the program of the next one begins; `joints` (j, JOINT) and `energy` (ENERGIES,) kNm: see
    kernels.dynamics.motion; `halved`: how often the last step was; `rest`: None while it moves.
    """

    blocks: Array
    joints: Array
    energy: Array
    halved: int = 0
    rest: Rest | None = None


class Recorded(NamedTuple):
    """Positions and velocities (k + 1, b, 3), N, P and T (k + 1, j, 3) and energies (k + 1, ENERGIES) of k steps.

    Row 0 is where the steps begin; its forces are not known.
    """

    x: Array
    v: Array
    forces: Array
    energy: Array

    def until(self, last: int) -> Recorded:
        """Return the first steps, up to the `last`."""
        return Recorded(*(values[: last + 1] for values in self))

    def since(self, first: int) -> Recorded:
        """Return the steps from the `first` on, which is their row 0."""
        return Recorded(*(values[first:] for values in self))


@dataclass(frozen=True, slots=True)
class Halving:
    """How often a step is halved, and how exactly its program is solved.

    At most `levels` times while impacts take more than a `share` of the largest kinetic energy so far; at most
    `unsolved` times while its program is not solved. `unsure`: share of the kinetic energy that errors of velocities
    may have; 0: no more than at rest. `of_moment`: the share is of the kinetic energy of the moment.
    """

    levels: int
    share: float
    unsolved: int = 6
    unsure: float = 0.0
    of_moment: bool = False


@dataclass(frozen=True, eq=False)
class DynamicSystem:
    """The system of a motion.

    `theta`: share of a step at which the equations of motion hold; `damping` (s): viscous contact force over the
    stiffness and the rate of the gap; `restitution`: of normal velocities at impacts; `halving`: of steps; `accepted`:
    residual of a program, per weight and span, that is accepted. `counts` (8,): programs, iterations, halvings, cold
    starts, the worst residual of force, per weight, the largest energy (kNm) that errors of velocities may have, steps
    in which what slides lifts, and steps at rest that were not computed; `skips`: whether
    there are any.
    """

    system: StaticSystem
    theta: float
    damping: float
    restitution: float
    halving: Halving
    accepted: float
    counts: Array = field(default_factory=lambda: np.zeros(8))
    skips: bool = True

    @property
    def model(self) -> Assembly:
        """The assembly."""
        return self.system.model

    @property
    def contacts(self) -> Contacts:
        """The contacts of blocks that touch, or may touch within the margin."""
        return self.system.contacts

    @cached_property
    def layout(self) -> Elimination:
        """The order of elimination of the matrices."""
        model = self.model
        return Elimination.of(self.system.dof, model.initial.positions[model.movable, :2])

    @property
    def margin(self) -> float:
        """How far (m) a corner may move before contacts are looked for again."""
        return STEP.look_ahead * self.model.size if self.model.collisions else np.inf

    def around(self, motion: Motion) -> DynamicSystem:
        """Return the system with the contacts near a motion, whose arrays become those of these contacts."""
        system, before = self.system.around(motion.blocks[0], self.margin), self.contacts
        if system is self.system:
            return self
        found = replace(self, system=system)
        motion.rest = None
        if np.array_equal(before.edges, system.contacts.edges):
            found.__dict__["layout"] = self.layout
        kept = moved_over(np.ones((len(before), 1)), before, system.contacts)[:, 0] > 0.0
        motion.joints = moved_over(motion.joints, before, system.contacts)
        if not self.system.rigid:
            motion.joints[~kept, SUNK] = _deep(system.contacts.places(motion.blocks[0]))[~kept]
        return found

    @cached_property
    def first(self) -> Index:
        """First row (b,) of each block in that order, −1 for a support."""
        first = np.full(len(self.model.blocks), -1, dtype=np.intp)
        first[self.model.movable] = 3 * np.argsort(self.layout.order[::3] // 3)
        return first

    def begun(self, start: State, forces: Array | None, lifted: Array) -> Motion:
        """Return the motion that begins in a state, with joint forces (j, 3) N, P and T where they are known.

        `lifted` (j,) m: gaps at the beginning that count as closed. A motion before goes on as if it had not ended.
        """
        places, rigid = self.system.places(start.positions, start), self.system.rigid
        still = np.zeros_like(start.positions)
        blocks = np.stack([start.positions, start.velocities, still, still])
        motion = Motion(blocks, np.zeros((len(self.contacts), JOINT)), np.zeros(ENERGIES))
        joints = motion.joints
        joints[:, SUNK] = lifted
        if self.model.ties:
            joints[self.system.ties, LONGER] = -self.system.stretched
            if start.lengthened is not None:
                joints[self.system.ties, LONGER] += start.lengthened
        if forces is not None:
            joints[:, :2], joints[:, 2] = end_forces(forces, places[:, H]), forces[:, 2]
        if not rigid:
            joints[:, SPRING] = spring_forces(self.contacts, start)
        if start.motion is not None and start.motion.rigid == rigid:
            self._recall(start.motion, places, motion)
        elif not rigid:
            remember(places, self.system.law, joints, self.model.size)
        if not rigid:
            felt = places.copy()
            felt[:, U] -= joints[:, SUNK]
            motion.energy[ELASTIC] = strain_energy(felt, self.system.law, joints, self.model.size)
        return motion

    def remembered(self, motion: Motion, begun: Array) -> MotionMemory:
        """Return what a motion goes on from that has `begun` at positions (b, 3)."""
        joints = np.column_stack([self.contacts.edges, motion.joints])
        return MotionMemory(
            self.system.rigid,
            motion.blocks[2:].copy(),
            joints,
            float(motion.energy[LARGEST]),
            motion.halved,
            begun,
        )

    def _recall(self, memory: MotionMemory, places: Array, motion: Motion) -> None:
        """Go on from what a motion remembers; contacts at places (j, PLACE) that it does not know are new."""
        motion.blocks[2:] = memory.blocks
        motion.energy[LARGEST] = memory.largest
        motion.halved = memory.halved
        if not self.system.rigid:
            motion.joints[:, SUNK] = _deep(places)
        known = places_among(self.contacts.edges, memory.joints[:, :2])
        motion.joints[known >= 0] = memory.joints[known[known >= 0], 2:]

    def march(
        self, motion: Motion, base: Array, step: float, ahead: tuple[float, float] | None = None
    ) -> Recorded:
        """Advance a motion in place under base accelerations (k + 1, 3), m/s², one `step` (s) apart; return its steps.

        Rigid joints that rest are not computed while the acceleration is one under which they have rested; `ahead`:
        least and largest horizontal one still to come, None: of these. The motion stops early after the step in which
        a corner has moved farther than the margin. Raises ConvergenceError if even the shortest step is not solved.
        """
        steps = len(base) - 1
        found, begun = self._recorded(motion, steps), motion.blocks[0].copy()
        skips, done, reason = self.skips and not base[:, 1].any(), 0, 0
        ahead = ahead or (float(base[:, 0].min()), float(base[:, 0].max()))
        while done < steps and reason != FAR:
            rest = motion.rest
            if rest is not None and (still := rest.steps(base[done:, 0])):
                row = slice(done + 1, done + still + 1)
                found.x[row], found.v[row], found.energy[row] = motion.blocks[0], 0.0, motion.energy
                found.forces[row] = rest.forces(base[row, 0])
                self.counts[7] += still
                done += still
                continue
            until = steps if rest is None else done + 1
            gone, reason = self._compute(motion, base[done : until + 1], step, begun, found.since(done))
            done += gone
            if reason == UNSOLVED:
                raise ConvergenceError(
                    message("a step of the motion was not solved, {count} steps on", count=int(done))
                )
            if reason != RESTS or not skips:
                motion.rest = None
                continue
            at = float((1.0 - self.theta) * base[done - 1, 0] + self.theta * base[done, 0])
            forces = found.forces[done].copy()
            if rest is None:
                rest = motion.rest = Rest(at, at, forces, forces)
            else:
                rest.grow(at, forces)
                motion.blocks[0] = found.x[done] = found.x[done - 1]
            motion.blocks[1:3], motion.halved = 0.0, 0
            found.v[done] = 0.0
            if rest.computed >= LONG:
                self._look_ahead(motion, rest, ahead, step)
        return found.until(done)

    def _recorded(self, motion: Motion, steps: int) -> Recorded:
        """Return room for so many steps, the first row that of the motion."""
        count, blocks = len(self.contacts), len(self.model.blocks)
        found = Recorded(
            np.empty((steps + 1, blocks, 3)),
            np.empty((steps + 1, blocks, 3)),
            np.zeros((steps + 1, count, 3)),
            np.empty((steps + 1, ENERGIES)),
        )
        found.x[0], found.v[0], found.energy[0] = motion.blocks[0], motion.blocks[1], motion.energy
        return found

    def _compute(
        self, motion: Motion, base: Array, step: float, begun: Array, found: Recorded
    ) -> tuple[int, int]:
        """Compute steps into `found`; how many, and why they end, see kernels.dynamics.step."""
        halving = self.halving
        scheme = Scheme(
            step, self.theta, self.damping, self.restitution, self.accepted, halving.levels, halving.share,
            max(halving.levels, halving.unsolved), halving.unsure, halving.of_moment, self.margin,
        )  # fmt: skip
        moving = Moving(motion.blocks, motion.joints, motion.energy)
        gone, reason, motion.halved = march(
            self.structure, scheme, moving, base, motion.halved, begun, found, self.counts
        )
        return gone, reason

    @cached_property
    def structure(self) -> Structure:
        """Blocks and joints as the compiled loops take them."""
        model, c, layout = self.model, self.contacts, self.layout
        return Structure(
            c.a, c.b, c.faces, self.system.law, layout.row, self.first, model.mass, model.dead_load, model.radius,
            self.system.weight, model.size, layout.work_space, layout.pattern,
        )  # fmt: skip

    def _look_ahead(self, motion: Motion, rest: Rest, ahead: tuple[float, float], step: float) -> None:
        """Try whether blocks that have rested for long also rest under the extremes of what is to come."""
        for extreme in ahead:
            if rest.low <= extreme <= rest.high or extreme in rest.tried:
                continue
            rest.tried.append(extreme)
            trial = Motion(motion.blocks.copy(), motion.joints.copy(), motion.energy.copy())
            found, base = self._recorded(trial, 1), np.array([[extreme, 0.0, 0.0]] * 2)
            if self._compute(trial, base, step, trial.blocks[0].copy(), found)[1] == RESTS:
                rest.grow(extreme, found.forces[1])


def _deep(places: Array) -> Array:
    """Return how deep (j,) m, negative, faces penetrate: a contact found for the first time carries nothing there."""
    return end_gaps(places).min(axis=1).clip(max=0.0)
