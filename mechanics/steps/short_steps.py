"""A static step in short ones, where its geometry does not settle in one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.errors import NoEquilibriumError
from mechanics.program import Program
from mechanics.solvers import interior
from mechanics.solvers.interior import Iterate
from mechanics.steps.contact_values import over_all, spread, state_at_rest, taken
from mechanics.steps.static_step import (
    Equilibrium,
    StepProblem,
    balanced,
    check_motion,
    displaced,
    solve_program,
)
from mechanics.steps.tolerances import STEP
from mechanics.types import GRAVITY, Array


def inertia(program: Program, displacement: Array) -> float:
    """The largest force of inertia in displacements (m,) from rest, per weight; moments by the block size."""
    if program.mass is None:
        return 0.0
    force = (program.mass * displacement).reshape(-1, 3) / (1.0, 1.0, program.size)
    return float(abs(force).max(initial=0.0)) / program.weight


def in_short_steps(problem: StepProblem, guess: Array) -> Equilibrium:
    """The step in short ones, to where the supports are in `guess` (b, 3).

    Each is a single program in the geometry in which it begins, with a little inertia, which keeps loose blocks where
    they are. What sliding has lifted stays lifted while it goes on: the change of the lift, the dilation, vanishes, as
    with Coulomb friction. Under given loads blocks that gain speed fall; a push moves them as far as its work. The
    forces are those that hold the blocks where they arrive, without inertia. Raises NoEquilibriumError where there are
    none or blocks fall, ConvergenceError where a program is not solved.
    """
    system, model = problem.system, problem.system.model
    begun, fixed = problem.start.positions, ~model.movable
    count = max(STEP.fewest, int(np.ceil(problem.size / (STEP.short * model.size))))
    mass = model.mass * GRAVITY / (STEP.short_time**2 * model.size)
    short = replace(problem, size=problem.size / count, work=problem.work / count, mass=mass)
    at, iterate, solves = begun, None, 0
    for k in range(count):
        posed = at.copy()
        posed[fixed] = begun[fixed] + (k + 1.0) / count * (guess - begun)[fixed]
        program, index = short.pose(posed, None)
        near: Iterate | None = iterate and taken(iterate, index).warm(program, STEP.begin)
        found, more = solve_program(program, system.layout.take(index), near, STEP.rigid[-1], first=k == 0)
        solves += more
        at = displaced(model, posed, found.displacement)
        check_motion(short, at)
        if short.lateral is None and inertia(program, found.displacement) > STEP.inertia:
            raise NoEquilibriumError(f"the structure falls: in a step of {short.size:.3g} m it gains speed")
        iterate = over_all(found, index, len(system.contacts))
        forces = spread(interior.solution(program, found).forces, index, len(system.contacts))
        short = replace(short, start=state_at_rest(system, at, forces))
    return balanced(replace(short, mass=None), at, solves)
