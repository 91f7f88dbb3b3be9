"""The equilibrium of a static step in its own displaced geometry: programs are solved as the geometry is updated."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.messages import message
from mechanics.model.contacts import end_gaps
from mechanics.program import Solution, certify
from mechanics.solvers import GOOD, interior
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_step import (
    Equilibrium,
    StepProblem,
    check_motion,
    displaced,
    equilibrium,
    proximal,
    slips,
    solve_program,
    sticking,
)
from mechanics.steps.static_system import iterate_over, moved_over, over_all, sliding_joints, spread, taken
from mechanics.steps.tolerances import STEP
from mechanics.types import Array, Index, Mask


@dataclass(frozen=True, eq=False)
class Round:
    """What one program of the sequence passes on to the next.

    `at` (b, 3): positions; `forces` (j, 3): N, P and T; `iterate` of all joints, and the `distance` from the bounds at
    which the next program begins; `touching`: the program's joints; `solves`: programs so far; `reference` (j, 3):
    forces near which rigid joints keep them, `stage`: programs of a step; `stuck` (j,): joints that stick, see
    static_step.sticking, None where none is known to.
    """

    at: Array
    forces: Array | None
    iterate: Iterate | None
    distance: float = interior.APART
    touching: Index | None = None
    alpha: float = 0.0
    solves: int = 0
    reference: Array | None = None
    stage: int = 0
    stuck: Mask | None = None


def find_equilibrium(problem: StepProblem, guess: Array, last: Equilibrium | None = None) -> Equilibrium:
    """Return the equilibrium near a `guess` (b, 3) of the positions; the supports take the positions of the guess.

    A sequence of programs is solved, each from where the last one ended; the first ones roughly, in the geometry of the
    one before. The others contain the change of the last forces with that (Newton's method for geometry and forces
    together), with rigid joints where geometry and forces do not settle without it. By Coulomb's law joints yield a
    little to changes of their forces (proximal), and rigid ones that have not slid in the last step stick as long as
    they can (sticking). `last`: the previous equilibrium of the path. Raises NoEquilibriumError if none lies near, if
    it is unstable, or if geometry and forces do not agree in the end, ConvergenceError if that cannot be decided.
    """
    system, model = problem.system, problem.system.model
    *rough, final = STEP.residuals(system.behaviour)
    residuals = (*(each for each in rough if each <= system.lightest), final)
    stages = residuals + (residuals[-1],) * STEP.rounds
    now, best, relaxation, stable = _begin(problem, guess, last), None, Relaxation(), True
    for stage, residual in enumerate(stages):
        before, now = now, _solve_round(problem, now, residual)
        if stage < len(residuals) - 1:
            continue
        if (others := _other_contacts(problem, now)) is not None:
            now = replace(now, touching=others)
            continue
        found = certified(problem, now)
        if found.certificate.worst(problem.size) <= STEP.certificate(system.behaviour):
            found = _once_more(problem, now, found)
            if not found.stable:  # an iteration can end at an unstable one
                raise NoEquilibriumError(
                    message("loss of stability: the equilibrium of the structure is an unstable one")
                )
            return found
        # programs with the geometry held approach an equilibrium only where the stiffness is positive
        if not (stable or found.stable):
            raise NoEquilibriumError(
                message("loss of stability: the structure gives way under forces that it should bear")
            )
        best = min(best or found, found, key=lambda each: each.certificate.equilibrium)
        stable = found.stable
        way = (now.at - before.at)[model.movable] * (1.0, 1.0, model.size)
        relaxation = relaxation.after(way)
        now = replace(now, at=before.at + relaxation.factor * (now.at - before.at))
    if system.rigid and best is not None and best.certificate.worst(problem.size) <= STEP.slow:
        return best
    assert now.iterate is not None
    farthest = np.argmax(abs(now.iterate.displacement.reshape(-1, 3)[:, :2]).max(axis=1))
    block = int(np.flatnonzero(model.movable)[farthest])
    raise NoEquilibriumError(
        message("the geometry of the step does not settle, at block {block} first", block=block)
    )


def _begin(problem: StepProblem, guess: Array, last: Equilibrium | None) -> Round:
    """Return the start of the sequence: at a guess (b, 3), near the last equilibrium of the path."""
    system = problem.system
    if last is None:
        return Round(guess, None, None)
    forces = moved_over(last.forces, last.contacts, system.contacts) if system.rigid else None
    iterate = last.iterate and iterate_over(last.iterate, last.contacts, system.contacts)
    if iterate is None or system.dilation >= 1.0:
        return Round(guess, forces, iterate)
    stuck = ~sliding_joints(iterate, problem.size) if system.rigid else None
    return Round(guess, forces, iterate, reference=iterate.forces, stuck=stuck)


def _solve_round(problem: StepProblem, last: Round, residual: float) -> Round:
    """Solve the program in the geometry of the last round to a residual (per weight and step)."""
    system = problem.system
    program, index = problem.pose(last.at, last.forces, last.touching)
    near, posed, stuck = None, program, last.stuck
    rough = residual > STEP.residuals(system.behaviour)[-1]
    # where joints slide Newton's method also finds what does not last: two seats that share the slip of a beam
    held = rough or (system.rigid and last.stage < STEP.held)
    if last.iterate is not None:
        before = taken(last.iterate, index)
        near = before.warm(program, last.distance)
        if last.reference is not None:
            posed = proximal(posed, last.reference[index])
        if stuck is not None:
            posed = sticking(posed, stuck[index])

    def moved(found: Iterate) -> Array:
        at = displaced(system.model, last.at, found.displacement)
        check_motion(problem, at)
        return at

    found, at, solves, reached = solve_program(posed, system.layout.take(index), near, residual, held, moved)
    if stuck is not None and not rough and slips(program, stuck[index], found):
        stuck = None
    reference = last.reference
    if system.dilation < 1.0 and last.stage < STEP.memory:
        reference = spread(found.forces, index, len(system.contacts))
    everywhere = over_all(found, index, len(system.contacts))
    distance = STEP.go_on * residual
    if program.curved is not None and not reached:
        distance = min(STEP.wider * last.distance, interior.APART)
    return Round(
        at, system.resultants(at, everywhere.forces), everywhere, distance, index, found.alpha, last.solves + solves,
        reference, last.stage + 1, stuck,
    )  # fmt: skip


def _once_more(problem: StepProblem, now: Round, found: Equilibrium) -> Equilibrium:
    """Return the better of an equilibrium and what one more program makes of it: that squares what is left."""
    if found.certificate.worst(problem.size) > GOOD:
        with suppress(NoEquilibriumError, ConvergenceError):
            now = _solve_round(problem, now, STEP.residuals(problem.system.behaviour)[-1])
            if _other_contacts(problem, now) is None:
                again = certified(problem, now)
                return min(found, again, key=lambda each: each.certificate.worst(problem.size))
    return found


def _other_contacts(problem: StepProblem, now: Round) -> Index | None:
    """Return the indices of the joints that touch at the positions of a round; None if the program has just these.

    Joints that carry beyond the edge of their faces are removed, joints whose faces penetrate are added.
    """
    assert now.forces is not None and now.touching is not None
    system = problem.system
    places = system.places(now.at, problem.start)
    apart = places[:, H] <= system.no_overlap
    wrong = apart & (now.forces[:, 0] > system.least_force)
    inside = ~apart & (end_gaps(places).min(axis=1) < -STEP.inside * system.model.size)
    inside[now.touching] = False
    if not wrong.any() and not inside.any():
        return None
    touching = np.zeros(len(places), dtype=bool)
    touching[now.touching] = True
    return np.flatnonzero((touching & ~wrong) | inside)


def certified(problem: StepProblem, now: Round) -> Equilibrium:
    """Return forces and positions of a round, with the certificate of the forces in the geometry of the positions."""
    assert now.forces is not None and now.iterate is not None
    system = problem.system
    program, index = problem.pose(now.at, now.forces, now.touching)
    if now.reference is not None:
        program = proximal(program, now.reference[index])
    forces, rest = now.forces[index], np.zeros(len(program.load))
    iterate = taken(now.iterate, index)
    found = Solution(forces, now.alpha, rest, certify(program, forces, now.alpha, rest))
    stable = system.rigid or interior.stable(program, system.layout.take(index), iterate)
    return equilibrium(problem, now.at, index, found, iterate, now.solves, stable)


@dataclass(frozen=True, eq=False)
class Relaxation:
    """Aitken's relaxation of a fixed-point iteration: the `factor` of its last `residual`, of any shape."""

    factor: float = 1.0
    residual: Array | None = None

    def after(self, residual: Array) -> Relaxation:
        """Return the relaxation after the next residual, its factor between 0.1 and 1."""
        if self.residual is None:
            return Relaxation(self.factor, residual)
        change = residual - self.residual
        secant = -self.factor * (self.residual * change).sum() / max((change * change).sum(), 1e-300)
        return Relaxation(float(np.clip(secant, 0.1, 1.0)), residual)
