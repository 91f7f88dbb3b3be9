"""Coming to rest by a motion whose velocity is reset in every step: it finds what no static step finds.

A step of implicit Euler from rest, in a time h, is the static program with the mass M/h²: it always has a solution,
short of equilibrium by the inertia alone. Where the steps come to rest there is an equilibrium; where they run away
there is none, and the structure collapses.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, RunawayError, UnsettledError
from mechanics.kernels.joint import H
from mechanics.model.assembly import State
from mechanics.model.contacts import end_gaps
from mechanics.program import bed_gaps, end_forces
from mechanics.solvers import ACCEPTED, USABLE, interior, solve
from mechanics.solvers.interior import Iterate
from mechanics.steps.contact_values import iterate_over, over_all, spread, taken
from mechanics.steps.geometry_iteration import Round, certified, find_equilibrium
from mechanics.steps.static_step import Equilibrium, StepProblem, displaced
from mechanics.steps.tolerances import REST, STEP, RestTolerances
from mechanics.types import GRAVITY, Array

STEADY = 0.9  # of the force that was left half way: of a motion that does not slow down


def way(one: Array, other: Array, size: float) -> float:
    """The longest (m) of a block from positions (b, 3) to others; a turn counts at a block's `size`."""
    return float((abs(other - one) * (1.0, 1.0, size)).max())


def motion_to_rest(problem: StepProblem, begun: Array, tolerances: RestTolerances = REST) -> Equilibrium:
    """The equilibrium in which blocks come to rest that are released at `begun` (b, 3).

    Under the problem's load, or pushed until its `work` is done and held there. The time of a step follows the motion:
    what falls moves a `way` a step, what creeps takes longer ones. Raises RunawayError where the blocks go far, or have
    not slowed down after all `steps` of the tolerances; ConvergenceError where they still do.
    """
    model, solves = problem.system.model, 0
    still = tolerances.still * model.size
    now, at, time = replace(problem, size=tolerances.way * model.size), begun, tolerances.first
    iterate: Iterate | None = None
    half_way = np.inf
    for step in range(tolerances.steps):
        before, now = now, replace(now, system=now.system.around(at, now.size))
        iterate = iterate and iterate_over(iterate, before.system.contacts, now.system.contacts)
        mass = model.mass / (time**2 * model.size / GRAVITY)
        last = _step_from_rest(replace(now, mass=mass), at, iterate)
        moved, iterate, solves = last.at, last.iterate, solves + last.solves
        left, far = way(at, moved, model.size), way(begun, moved, model.size)
        # slips count from the last step: what has slid does not come back
        start, work = State(moved, np.zeros_like(moved)), problem.work - _work_done(problem, begun, moved)
        now, at = replace(now, start=start, work=work), moved
        if far > tolerances.farthest * model.size:
            raise RunawayError(
                f"the structure falls: left to itself it moves by {far:.2g} m and does not rest"
            )
        force = left / time**2  # that is left, per mass
        if 0 < step == tolerances.steps // 2:
            half_way = force
        longer = min(2.0, np.sqrt(tolerances.way * model.size / max(left, 1e-300)))
        time = min(time * longer, tolerances.longest)
        if force > still:
            continue
        try:
            found = find_equilibrium(replace(now, size=problem.size), moved)
        except UnsettledError:  # forces and geometry alternate about the rest that the motion comes to
            found = certified(now, last)
            if found.certificate.worst(problem.size) <= USABLE:
                return replace(found, solves=solves)
        except (NoEquilibriumError, ConvergenceError):
            pass
        else:
            return replace(found, solves=found.solves + solves)
        still = 0.5 * force  # slow, but not at rest: it gains speed, or slows down further
    kind = RunawayError if force > STEADY * half_way else ConvergenceError
    raise kind(f"left to itself the structure does not come to rest: it goes on by {left:.2g} m a step")


def _work_done(problem: StepProblem, begun: Array, at: Array) -> float:
    """The work (kNm) of the lateral load on the way from `begun` to `at` (b, 3); 0 where there is none."""
    return 0.0 if problem.lateral is None else float((problem.lateral * (at - begun)).sum())


def _step_from_rest(problem: StepProblem, at: Array, iterate: Iterate | None) -> Round:
    """One step from positions (b, 3), and the programs solved."""
    system = problem.system
    program, index = problem.pose(at, None)
    layout, solves = system.layout.take(index), 0
    starts = [interior.cold(program)]
    if iterate is not None:
        starts.insert(0, taken(iterate, index).warm(program, STEP.begin))
    for start in starts:
        found, outcome = interior.run(program, layout, start, 1e3 * ACCEPTED)
        solves += 1
        if outcome.accepted:
            solution = interior.solution(program, found)
            last: Iterate | None = found
            break
    else:
        solution, last = solve(program, layout)
        solves += 1
    count = len(system.contacts)
    return Round(
        displaced(system.model, at, solution.displacement),
        spread(solution.forces, index, count),
        last and over_all(last, index, count),
        STEP.begin,
        touching=index,
        alpha=solution.alpha,
        solves=solves,
    )


def lifted(equilibrium: Equilibrium, weight: float) -> float:
    """By how much (m) joints that carry lack the compression of their forces, at most; rigid ones: their gap."""
    carries = equilibrium.forces[:, 0] > 1e-6 * weight
    places, forces = equilibrium.places[carries], equilibrium.forces[carries]
    missing = end_gaps(places)
    if not equilibrium.system.rigid:
        half = abs(places[:, H])
        missing = missing - bed_gaps(end_forces(forces, half), half, equilibrium.system.law[carries])
    return float(missing.min(axis=1).max(initial=0.0))
