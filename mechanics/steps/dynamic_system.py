"""The system of a motion, which does not change while blocks move, and the motion itself, step by step.

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mechanics.errors import ConvergenceError
from mechanics.kernels.bed_law import bed_forces
from mechanics.kernels.dynamics.march import FAR, RESTS, UNSOLVED, march
from mechanics.kernels.dynamics.motion import (
    ELASTIC,
    ENERGIES,
    JOINT,
    LARGEST,
    LONGER,
    RATE,
    SPEED,
    SPRING,
    SUNK,
    remember,
    strain_energy,
)
from mechanics.kernels.dynamics.program import KEPT
from mechanics.kernels.joint import H, U
from mechanics.kernels.law import BED, LEFT, SHEAR
from mechanics.kernels.linalg.factors import cholesky, substitute
from mechanics.kernels.matrix import diagonal, stiffen
from mechanics.messages import message
from mechanics.model.assembly import Assembly, MotionMemory, State
from mechanics.model.contacts import Contacts, end_gaps
from mechanics.program import end_forces
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.threads import one_thread
from mechanics.steps.contact_values import moved_over, spring_forces
from mechanics.steps.static_system import StaticSystem, static_system
from mechanics.types import Array, Index

LONG = 10  # computed steps at rest after which it is tried how far rest goes
AHEAD = 0.05  # of the block size: how far a corner may move before contacts are looked for again


@dataclass(eq=False)
class Rest:
    """The accelerations (m/s²) under which rigid joints rest where they are, from `low` to `high`, and their forces.

    From v₀ = 0 the one solution of a step is v₁ = 0 where, and only where, forces within their bounds that press closed
    joints alone balance the loads. Loads are affine in the acceleration and bounds are convex, so what rests under two
    accelerations rests under all between, with the forces (j, 3) between. `computed`: steps that have
    found it so far; `tried`: accelerations that were tried ahead.
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
        found: Array = self.forces_low + share[:, None, None] * (self.forces_high - self.forces_low)
        return found


@dataclass(eq=False)
class Motion:
    """Blocks in motion, changed step by step.

    `blocks` (3, b, 3): positions, velocities and mean accelerations of the last step, 0 after an impact; `joints`
    (j, JOINT) and `energy` (ENERGIES,) kNm: see kernels.dynamics.motion; `halved`: how often the last step was; `rest`:
    None while it moves.
    """

    blocks: Array
    joints: Array
    energy: Array
    halved: int = 0
    rest: Rest | None = None

    @property
    def shear(self) -> Array:
        """Tangential forces (j,) kN of the joints' springs."""
        return self.joints[:, SPRING]

    @property
    def longer(self) -> Array:
        """By how much ties are longer (j,) m than as they were made; 0 of joints."""
        return self.joints[:, LONGER]


@dataclass(frozen=True, eq=False)
class Recorded:
    """Positions and velocities (k + 1, b, 3), N, P and T (k + 1, j, 3) and energies (k + 1, ENERGIES) of k steps.

    Row 0 is where the steps begin; its forces are not known.
    """

    x: Array
    v: Array
    forces: Array
    energy: Array

    def until(self, last: int) -> Recorded:
        """Return the first steps, up to the `last`."""
        return Recorded(*(values[: last + 1] for values in (self.x, self.v, self.forces, self.energy)))

    def since(self, first: int) -> Recorded:
        """Return the steps from the `first` on, which is their row 0."""
        return Recorded(*(values[first:] for values in (self.x, self.v, self.forces, self.energy)))


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

    @property
    def limits(self) -> tuple[int, float, int, float, bool]:
        """Levels, share, unsolved levels, unsure share and of_moment, in the order of kernels.dynamics.march."""
        return self.levels, self.share, max(self.levels, self.unsolved), self.unsure, self.of_moment


@dataclass(frozen=True, eq=False)
class DynamicSystem:
    """The system of a motion.

    `theta`: share of a step at which the equations of motion hold; `damping` (s): viscous contact force over the
    stiffness and the rate of the gap; `restitution`: of normal velocities at impacts; `halving`: of steps; `accepted`:
    residual of a program, per weight and span, that is accepted. `counts` (7,): programs, iterations, halvings, cold
    starts, the worst residual of force, per weight, the largest energy (kNm) that errors of velocities may have, and
    steps at rest that were not computed; `skips`: whether there are any.
    """

    system: StaticSystem
    theta: float
    damping: float
    restitution: float
    halving: Halving
    accepted: float
    counts: Array = field(default_factory=lambda: np.zeros(7))
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

    @cached_property
    def central(self) -> Array:
        """What the program of a step keeps for the next one, see kernels.dynamics.program."""
        return np.zeros(2 + KEPT * len(self.contacts) + 3 * int(self.model.movable.sum()))

    @property
    def _central_joints(self) -> Array:
        """Forces, gaps and slips (j, KEPT) of that."""
        count = len(self.contacts)
        return self.central[2 : 2 + KEPT * count].reshape(count, KEPT)

    @property
    def _central_moves(self) -> Array:
        """Displacements (b, 3) of that, 0 of supports."""
        found, first = np.zeros((len(self.first), 3)), self.first
        moves = self.central[2 + KEPT * len(self.contacts) :]
        for e in range(3):
            found[first >= 0, e] = moves[first[first >= 0] + e]
        return found

    def _central(self, step: float, joints: Array, moves: Array) -> Array:
        """Return `central` of forces, gaps and slips (j, KEPT) and displacements (b, 3) of a step, s; 0: of none."""
        count, movable = len(self.contacts), self.first >= 0
        ordered = np.zeros(len(self.central) - 2 - KEPT * count)
        for e in range(3):
            ordered[self.first[movable] + e] = moves[movable, e]
        return np.concatenate([[float(step > 0.0), step], joints.ravel(), ordered])

    @property
    def margin(self) -> float:
        """How far (m) a corner may move before contacts are looked for again."""
        return AHEAD * self.model.size if self.model.collisions else np.inf

    def around(self, motion: Motion) -> DynamicSystem:
        """Return the system with the contacts near a motion, whose arrays become those of these contacts."""
        system, before = self.system.around(motion.blocks[0], self.margin), self.contacts
        if system is self.system:
            return self
        found = replace(self, system=system)
        motion.rest = None
        if np.array_equal(before.edges, system.contacts.edges):
            found.__dict__["layout"] = self.layout
        found.central[:] = found._central(
            float(self.central[1]),
            moved_over(self._central_joints, before, system.contacts),
            self._central_moves,
        )
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
        blocks = np.stack([start.positions, start.velocities, np.zeros_like(start.positions)])
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

    def remembered(self, motion: Motion) -> MotionMemory:
        """Return what a motion goes on from."""
        joints = np.column_stack([self.contacts.edges, motion.joints, self._central_joints])
        return MotionMemory(
            self.system.rigid, motion.blocks[2].copy(), joints, float(motion.energy[LARGEST]), motion.halved,
            float(self.central[1]), self._central_moves,
        )  # fmt: skip

    def _recall(self, memory: MotionMemory, places: Array, motion: Motion) -> None:
        """Go on from what a motion remembers; contacts at places (j, PLACE) that it does not know are new."""
        motion.blocks[2], motion.energy[LARGEST], motion.halved = (
            memory.accelerations, memory.largest, memory.halved,
        )  # fmt: skip
        if not self.system.rigid:
            motion.joints[:, SUNK] = _deep(places)
        known = {(int(e), int(f)): row for e, f, *row in memory.joints}
        begun = np.zeros((len(self.contacts), KEPT))
        for k, (e, f) in enumerate(self.contacts.edges.tolist()):
            if (e, f) in known:
                motion.joints[k], begun[k] = known[e, f][:JOINT], known[e, f][JOINT:]
        self.central[:] = self._central(memory.step, begun, memory.moves)

    @one_thread()
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
                self.counts[6] += still
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
            motion.blocks[1:], motion.joints[:, SPEED : RATE + 1], motion.halved = 0.0, 0.0, 0
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
        """Compute steps into `found`; how many, and why they end, see kernels.dynamics.march."""
        model, c = self.model, self.contacts
        gone, reason, motion.halved = march(
            c.a, c.b, c.faces, self.system.law, self.layout.row, self.first, model.mass, model.dead_load,
            base, motion.blocks, motion.joints, motion.energy, step, self.theta, self.damping, self.restitution,
            (self.system.weight, model.size, self.accepted), self.halving.limits, self.margin, model.radius,
            motion.halved, begun, found.x, found.v, found.forces, found.energy, self.counts, self.layout.work_space,
            self.layout.packed, self.central,
        )  # fmt: skip
        return gone, reason

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
    deep: Array = end_gaps(places).min(axis=1).clip(max=0.0)
    return deep


def contact_period(model: Assembly) -> float:
    """Return √(m/k), s, of the stiffest joint as drawn, m the reduced mass: a contact lasts π times it."""
    contacts, mass = model.contacts, np.where(model.movable, model.mass[:, 0], np.inf)
    contacts = contacts.take(np.flatnonzero(~contacts.ties))
    stiffness = contacts.bed * 2.0 * contacts.places(model.initial.positions)[:, H]
    with np.errstate(divide="ignore"):
        lightness = 1.0 / mass[contacts.a] + 1.0 / mass[contacts.b]
    return float(1.0 / np.sqrt((stiffness * lightness).max(initial=1e-300)))


RIGID_SHEAR = 1e3  # tangential over normal stiffness that replaces an infinite one in the first frequency


def first_frequency(model: Assembly) -> float:
    """Return the lowest circular frequency (rad/s) of the blocks as drawn: all joints closed and sticking, ties taut.

    It is 0 if some blocks are loose.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    system = static_system(model, "elastic")
    layout = Elimination.of(system.dof, model.initial.positions[model.movable, :2])
    places = system.contacts.places(model.initial.positions)
    ties, normal = system.contacts.ties, system.law[:, BED] * 2.0 * places[:, H]
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    mass, stored = model.mass[model.movable].ravel()[layout.order], layout.triangle()
    diagonal(np.zeros(len(mass)), stored, layout.pattern)
    for k, (i, j) in enumerate(layout.row):
        _, _, _, _, turns = bed_forces(
            system.law[k], np.inf, system.law[k, LEFT:], places[k, H], -1.0, 0.0
        )  # all of it pressed, none crushed
        turns, slides = (0.0, 0.0) if ties[k] else (turns, shear[k])
        law = np.array([normal[k], 0.0, 0.0, turns, 0.0, slides, 0.0, 0.0])
        stiffen(k, places[k], i, j, law, stored, layout.pattern)
    if _some_are_loose(model) or not cholesky(stored, layout.pattern):
        return 0.0
    root = np.sqrt(mass)

    def flexibility(x: Array) -> Array:
        y: Array = root * x.ravel()
        substitute(stored, stored, layout.pattern, y)
        return root * y

    operator = LinearOperator((len(mass), len(mass)), matvec=flexibility, dtype=float)
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # with few distinct modes ARPACK restarts from random vectors, and its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")


def _some_are_loose(model: Assembly) -> bool:
    """Whether some block is connected to no support by joints (a frequency of rounding alone might hide it)."""
    joints, count = model.joints, len(model.blocks)
    links = sparse.coo_matrix((np.ones(len(joints.a)), (joints.a, joints.b)), shape=(count, count))
    _, part = connected_components(links, directed=False)
    return not np.isin(part, part[~model.movable]).all()
