"""Coming to rest by a motion whose velocity is reset to zero in every step, where a static step finds no equilibrium.

A step of implicit Euler from rest over a time h is the static program with the mass M/h². It always has a solution,
which differs from equilibrium by the inertia alone. If the steps come to rest there is an equilibrium; if the blocks
run away there is none, and the structure collapses.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from itertools import chain

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError
from mechanics.kernels.joint import H
from mechanics.messages import message
from mechanics.model.contacts import end_gaps
from mechanics.program import Program, bed_gaps, end_forces
from mechanics.solvers import interior
from mechanics.solvers.interior import Iterate
from mechanics.steps.geometry_iteration import Round, certified, find_equilibrium
from mechanics.steps.static_step import Equilibrium, StepProblem, displaced, proximal
from mechanics.steps.static_system import (
    StaticSystem,
    iterate_over,
    moved_over,
    over_all,
    state_at_rest,
    taken,
)
from mechanics.steps.tolerances import REST, STEP, RestTolerances
from mechanics.types import GRAVITY, Array

UNSTABLE = message("the structure balances on an unstable equilibrium: its joints are too soft to hold it")


def way(one: Array, other: Array, size: float) -> float:
    """Return the longest way (m) of a block between two positions (b, 3); 1 rad counts as `size` (m)."""
    return float((abs(other - one) * (1.0, 1.0, size)).max())


def motion_to_rest(problem: StepProblem, begun: Array, tolerances: RestTolerances = REST) -> Equilibrium:
    """Return the equilibrium in which blocks released at `begun` (b, 3) come to rest.

    They move under the problem's load; if it has a lateral load, that pushes until its `work` is done and then holds
    them. The time step follows the motion: blocks that fall move by `way` or a `stride` in a step, blocks that creep
    take longer steps, and shorter ones where a step has no stable solution nearby, or none by Coulomb's law. Raises
    RunawayError if a block moves farther than `farthest`, or if the motion does not slow down within `steps`, or if it
    stops at an unstable equilibrium; ConvergenceError if it still slows down then, or has without a certified
    equilibrium.
    """
    model, solves = problem.system.model, 0
    still, least = STEP.slow * model.size, tolerances.way * model.size
    now, at, time = replace(problem, size=least), begun, tolerances.first
    last: Round | None = None
    force, half_way, slowing, failed, grows = np.inf, np.inf, False, 0, 0
    for step in range(tolerances.steps):
        before, now = now, replace(now, system=now.system.around(at, now.size))
        mass = model.mass / (time**2 * model.size / GRAVITY)
        if last:
            last = _over(last, before.system, now.system)
        shorter = time > tolerances.first
        # with the geometry that changes, what the last imbalance does not lead to is another solution
        led = max(force * time**2, STEP.slow * model.size)
        near = tolerances.faster * led if shorter else tolerances.jump * now.size
        found = _step_from_rest(replace(now, mass=mass), at, last, near, shorter)
        if found is None:
            time, failed = max(0.5 * time, tolerances.first), failed + 1
            grows = step + failed + 1  # after as many steps as have failed
            continue
        last, moved, solves = found, found.at, solves + found.solves
        left, far = way(at, moved, model.size), way(begun, moved, model.size)
        if far > tolerances.farthest * model.size:
            falls = message(
                "the structure falls: left to itself it moves by {moved:.2g} m and does not rest", moved=far
            )
            raise RunawayError(falls)
        force = left / time**2  # unbalanced force per mass
        if half_way == np.inf and step >= tolerances.steps // 2 > 0:
            half_way = force
        size = max(least, tolerances.stride * far)
        time *= min(tolerances.growth if step >= grows else 1.0, np.sqrt(size / max(left, 1e-300)))
        # slips count from the last step: a joint that has slid does not slide back
        assert last.forces is not None
        start = state_at_rest(now.system, moved, last.forces, now.start)
        done = 0.0 if problem.lateral is None else float((problem.lateral * (moved - begun)).sum())
        now, at = replace(now, start=start, work=problem.work - done, size=size), moved
        if force > still:
            continue
        held = certified(replace(now, size=least), last)
        with suppress(NoEquilibriumError, ConvergenceError):
            # next to an unstable equilibrium a motion is slow too, and another may lie on its other side
            rested = find_equilibrium(replace(now, size=problem.size), moved, held)
            return replace(rested, solves=rested.solves + solves)
        # forces and geometry may alternate about the rest; what is unstable only passes an equilibrium
        if slowing and held.stable and held.certificate.worst(least) <= STEP.slow:
            return replace(held, solves=solves)
        if left <= STEP.rounding * model.size and not held.stable:
            raise RunawayError(UNSTABLE)
        if slowing and force <= np.finfo(float).eps * model.size:
            break  # inertia is below the last digit of the weight: further steps are the same static program
        slowing = True
        still = 0.5 * force  # slow, but no equilibrium yet: at rest only if it slows down further
    kind = RunawayError if force > tolerances.steady * half_way else ConvergenceError
    goes_on = message(
        "left to itself the structure does not come to rest: it goes on by {moved:.2g} m a step", moved=left
    )
    raise kind(goes_on)


def _over(last: Round, before: StaticSystem, now: StaticSystem) -> Round:
    """Return the round with the forces and the iterate of the contacts of another system."""
    assert last.forces is not None and last.iterate is not None
    forces = moved_over(last.forces, before.contacts, now.contacts)
    iterate = iterate_over(last.iterate, before.contacts, now.contacts)
    return replace(last, forces=forces, iterate=iterate)


def _step_from_rest(
    problem: StepProblem, at: Array, last: Round | None, near: float, shorter: bool
) -> Round | None:
    """Return the round of one step from rest at positions (b, 3), sought near the last one.

    The program contains the change of the last forces with the geometry. Without it blocks follow a slow motion at a
    fraction of its speed and would seem to come to rest. Where it has no stable solution nearby the step is too long:
    None if it can be `shorter`; else its geometry is held. `near` (m): how far one with it may lead.
    """
    system, size = problem.system, problem.system.model.size
    program, index = problem.pose(at, None if last is None or system.rigid else last.forces)
    layout, frozen, curved = system.layout.take(index), interior.frozen(program), program.curved is not None
    warm = last and last.iterate and taken(last.iterate, index)
    if warm and system.dilation < 1.0:
        program = proximal(program, warm.forces)
        frozen = interior.frozen(program)
    full, held, solves = None, None, 0  # solutions with the geometry that changes, and with the geometry held

    def solved(tried: Program, begin: Iterate) -> Iterate | None:
        found, outcome = interior.run(tried, layout, begin, REST.rigid if system.rigid else REST.elastic)
        return found if outcome.accepted else None

    def nearby(begin: Iterate) -> Iterate | None:
        found = solved(program, begin)
        if found is None or not interior.stable(program, layout, found):
            return None
        return found if way(at, displaced(system.model, at, found.displacement), size) <= near else None

    if warm and curved:
        full, solves = nearby(warm.warm(program)), 1
    if full is None:
        programs = [frozen]
        if not shorter and system.dilation < 1.0:
            # a step by Coulomb's law may have no solution, one that lifts always has
            programs.append(interior.with_dilation(frozen, 1.0))
        first = [(frozen, warm.warm(frozen))] if warm else []
        cold = ((tried, start) for tried in programs for start in interior.cold_starts(tried, layout))
        for tried, start in chain(first, cold):
            held, solves = solved(tried, start), solves + 1
            if held:
                break
        if held and curved:
            begin = replace(held.warm(program, STEP.go_on), displacement=held.displacement)
            full, solves = nearby(begin), solves + 1
        if shorter and (held is None or (curved and full is None)):
            return None
    found = full or held
    if found is None:
        raise ConvergenceError(message("a step of the path was not solved to the required accuracy"))
    moved = displaced(system.model, at, found.displacement)
    everywhere = over_all(found, index, len(system.contacts))
    forces = system.resultants(moved, everywhere.forces)
    return Round(moved, forces, everywhere, touching=index, alpha=found.alpha, solves=solves)


def lifted(equilibrium: Equilibrium) -> float:
    """Return the largest difference (m) between gap and compression of joints that carry; rigid joints: their gap."""
    carries = equilibrium.forces[:, 0] > equilibrium.system.least_force
    places, forces = equilibrium.places[carries], equilibrium.forces[carries]
    missing = end_gaps(places)
    if not equilibrium.system.rigid:
        half = abs(places[:, H])
        missing = missing - bed_gaps(end_forces(forces, half), half, equilibrium.system.law[carries])
    return float(missing.min(axis=1).max(initial=0.0))


def come_down(step: Equilibrium, size: float) -> Equilibrium:
    """Return the equilibrium under gravity into which blocks that sliding has lifted come down; `step` if none is.

    `size` (m): least displacement that is expected. Raises as motion_to_rest.
    """
    model, lift = step.system.model, lifted(step)
    if lift <= REST.lifted * model.size:
        return step
    problem = StepProblem(step.system, step.state, model.dead_load, max(lift, size))
    return motion_to_rest(problem, step.state.positions)
