"""Coming to rest by a motion whose velocity is reset in every step: what no static step can find, or nothing.

A step of implicit Euler from rest, in a time h, is the static program with the mass M/h²: it always has a solution,
short
of equilibrium by the inertia alone. Where steps come to rest there is an equilibrium; where they run away, none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.assembly import State
from mechanics.errors import NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.model.contacts import end_gaps
from mechanics.program import bed_gaps, end_forces
from mechanics.solvers import ACCEPTED, interior, solve
from mechanics.solvers.interior import Iterate
from mechanics.steps.contact_values import iterate_over, over_all, taken
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.static_step import Equilibrium, StepProblem, displaced
from mechanics.steps.tolerances import REST, STEP, RestTolerances
from mechanics.types import GRAVITY, Array


def way(one: Array, other: Array, size: float) -> float:
    """The longest (m) of a block from positions (b, 3) to others; a turn counts at a block's `size`."""
    return float((abs(other - one) * (1.0, 1.0, size)).max())


def motion_to_rest(problem: StepProblem, begun: Array, tolerances: RestTolerances = REST) -> Equilibrium:
    """The equilibrium in which blocks come to rest that are let go at `begun` (b, 3).

    Under the problem's load, or pushed until its `work` is done and held there. Raises NoEquilibriumError where they
    run away, or do not rest.
    """
    system, model = problem.system, problem.system.model
    time = tolerances.time * float(np.sqrt(model.size / GRAVITY))
    at, iterate, left, since = begun, None, np.inf, problem.start
    size = max(problem.size, tolerances.still * model.size)
    for _ in range(tolerances.steps):
        # the work counts from the beginning, slips from the last step: what has slid does not come back
        done = (
            0.0
            if problem.lateral is None
            else float((problem.lateral * (at - problem.start.positions)).sum())
        )
        before, system = system, system.around(at, size)
        iterate = iterate and iterate_over(iterate, before.contacts, system.contacts)
        step = replace(
            problem,
            system=system,
            start=since,
            size=size,
            work=problem.work - done,
            mass=model.mass / time**2,
        )
        moved, iterate = _one(step, at, iterate)
        since = State(moved, np.zeros_like(moved))
        left, at = way(at, moved, model.size), moved
        far = way(begun, at, model.size)
        if far > tolerances.farthest * model.size:
            raise NoEquilibriumError(
                f"the structure falls: left to itself it moves by {far:.2g} m and does not rest"
            )
        if left <= tolerances.still * model.size:
            done = 0.0 if problem.lateral is None else float((problem.lateral * (at - begun)).sum())
            final = replace(
                problem,
                system=system,
                start=State(at, np.zeros_like(at)),
                size=size,
                work=problem.work - done,
            )
            return find_equilibrium(final, at)
    raise NoEquilibriumError(
        f"left to itself the structure does not come to rest: it goes on by {left:.2g} m a step"
    )


def _one(problem: StepProblem, at: Array, iterate: Iterate | None) -> tuple[Array, Iterate | None]:
    """Positions after one step, and its iterate."""
    system = problem.system
    program, index = problem.pose(at, None)
    layout = system.layout.take(index)
    starts = [interior.cold(program)]
    if iterate is not None:
        starts.insert(0, taken(iterate, index).warm(program, STEP.begin))
    for start in starts:
        found, outcome = interior.run(program, layout, start, 1e3 * ACCEPTED)
        if outcome.accepted:
            return displaced(system.model, at, found.displacement), over_all(
                found, index, len(system.contacts)
            )
    solution, iterate = solve(program, layout)
    return displaced(system.model, at, solution.displacement), iterate and over_all(
        iterate, index, len(system.contacts)
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
