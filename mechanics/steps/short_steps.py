"""A static step divided into short ones, for steps whose geometry does not settle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.solvers import GOOD, interior
from mechanics.solvers.interior import Iterate
from mechanics.steps.contact_values import iterate_over, over_all, spread, state_at_rest, taken
from mechanics.steps.static_step import (
    Equilibrium,
    StepProblem,
    balanced,
    check_motion,
    displaced,
    proximal,
    solve_program,
)
from mechanics.steps.tolerances import REST, STEP
from mechanics.types import GRAVITY, Array


def in_short_steps(problem: StepProblem, guess: Array, last: Equilibrium | None) -> Equilibrium:
    """Return the equilibrium of a step of rigid joints taken in short ones, up to the supports in `guess` (b, 3).

    Each short step is one program in the geometry in which it begins. A little inertia keeps loose blocks in place. A
    joint that sliding has lifted stays lifted while it slides: the further lift (dilation) vanishes, as with Coulomb
    friction. The forces of the result hold the blocks at their positions without inertia. Raises NoEquilibriumError if
    there are no such forces or blocks fall, ConvergenceError if a program is not solved.
    """
    system, model = problem.system, problem.system.model
    begun, fixed = problem.start.positions, ~model.movable
    count = int(np.ceil(problem.size / (REST.way * model.size)))
    mass = model.mass * GRAVITY / (STEP.short_time**2 * model.size)
    short = replace(problem, size=problem.size / count, work=problem.work / count, mass=mass)
    at, solves = begun, 0
    iterate: Iterate | None = None
    if last is not None and last.iterate is not None:
        iterate = iterate_over(last.iterate, last.contacts, system.contacts)
    for k in range(count):
        posed = at.copy()
        posed[fixed] = begun[fixed] + (k + 1.0) / count * (guess - begun)[fixed]
        program, index = short.pose(posed, None)
        near: Iterate | None = iterate and taken(iterate, index).warm(program)
        if iterate and system.dilation < 1.0:
            program = proximal(program, iterate.forces[index])
        found, more, _ = solve_program(program, system.layout.take(index), near, GOOD)
        solves += more
        at = displaced(model, posed, found.displacement)
        check_motion(short, at)
        iterate = over_all(found, index, len(system.contacts))
        forces = spread(interior.resultants(program, found), index, len(system.contacts))
        short = replace(short, start=state_at_rest(system, at, forces, short.start))
    return balanced(replace(short, mass=None), at, iterate, solves)
