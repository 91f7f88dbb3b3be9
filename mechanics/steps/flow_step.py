"""A step along a flow: rigid joints by Coulomb's law, whose programs have many solutions where joints slide.

A flow is a mechanism and forces that fit it (see procedures.limit_analysis). It goes on as long as its gaps and slips
and its forces can:

    free ← gaps and slips that the last forces leave free
    until the geometry is exact:
        Δx ← the least displacement of the given work that closes what is not free    a quadratic program
    f  ← the forces of least α that balance the loads there and fit the mechanism     a linear program

Where either has no solution the flow ends, and another begins. It is needed where the next program leads to another
flow whose multiplier is not lower.
"""

from __future__ import annotations

import numpy as np

from mechanics.errors import ConvergenceError
from mechanics.kernels.joint import H
from mechanics.kernels.law import FRICTION, STRENGTH
from mechanics.messages import message
from mechanics.program import Program, Solution, certify, end_forces
from mechanics.solvers import interior
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_step import Equilibrium, StepProblem, check_motion, displaced, equilibrium
from mechanics.steps.static_system import iterate_over, sliding_joints, taken
from mechanics.steps.tolerances import LIMIT, STEP
from mechanics.types import Array, Mask


def margins(program: Program, forces: Array) -> Array:
    """Return N₁, N₂, μN + T and μN − T (j, 4), kN, of forces N, P and T (j, 3).

    Where friction is infinite the last two are N: no slip under it.
    """
    mu = program.law[:, FRICTION]
    bound, t = np.where(np.isinf(mu), 1.0, mu) * forces[:, 0], np.where(np.isinf(mu), 0.0, forces[:, 2])
    return np.column_stack([end_forces(forces, program.places[:, H]), bound + t, bound - t])


def flows_at(program: Program, forces: Array, gaps: Array) -> Mask:
    """Return which gaps and slips (j, 4), y₁, y₂, λ₊ and λ₋, of a flow are not zero: its forces (j, 3) vanish there."""
    return gaps / program.step > margins(program, forces) / program.weight


def flows(problem: StepProblem, last: Equilibrium) -> bool:
    """Whether a push may go on along the flow of its last step: rigid joints that slide and do not crush or yield."""
    system = problem.system
    if problem.lateral is None or not (system.rigid and system.dilation == 0.0):
        return False
    return bool(np.isinf(system.law[:, STRENGTH]).all()) and slides(last, problem.size)


def slides(found: Equilibrium, size: float) -> bool:
    """Whether joints slide in the program of an equilibrium by more than a share of its step's `size` (m)."""
    return found.iterate is not None and bool(sliding_joints(found.iterate, size).any())


def begins(found: Equilibrium, last: Equilibrium, size: float) -> bool:
    """Whether joints slide in an equilibrium that do not in the `last` one: its flow is another one."""
    assert found.iterate is not None and last.iterate is not None
    before = iterate_over(last.iterate, last.contacts, found.contacts)
    return bool((sliding_joints(found.iterate, size) & ~sliding_joints(before, size)).any())


def along_flow(problem: StepProblem, guess: Array, last: Equilibrium) -> Equilibrium:
    """Return the equilibrium near a `guess` (b, 3), m and rad, to which the flow of the `last` one leads.

    Its work is that of the `problem`, kNm. Source: the program of eq. 5 without dilation; docs/theory.md, Static paths.
    Raises NoEquilibriumError where blocks fall, ConvergenceError where the flow ends.
    """
    from mechanics.solvers import lp_highs, qp_piqp  # late: with them comes scipy.optimize

    system, model = problem.system, problem.system.model
    assert last.iterate is not None
    known = iterate_over(last.iterate, last.contacts, system.contacts)
    at, ended = guess, ConvergenceError(message("the flow of the last step ends"))
    for _ in range(STEP.rounds):
        program, index = problem.pose(at, None)
        before = taken(known, index)
        forces = interior.resultants(program, before)
        free = margins(program, forces) <= LIMIT.idle * program.weight
        began = before.gaps > STEP.touching * program.step
        free |= flows_at(program, forces, before.gaps)
        found = lp_highs.nearest_mechanism(program, free, began, STEP.touching * program.step)
        if found is None:
            raise ended
        displacement, gaps = found
        at = displaced(model, at, displacement)
        check_motion(problem, at)
        if abs(displacement).max() <= STEP.rounding * model.size:
            break
    else:
        raise ended
    program, _ = problem.pose(at, None, index)
    answer = lp_highs.least_multiplier(qp_piqp.StandardForm.of(program), gaps > STEP.touching * program.step)
    if answer is None:
        raise ended
    forces, alpha = answer
    rest = np.zeros(len(program.load))
    flow = Solution(forces, alpha, rest, certify(program, forces, alpha, rest))
    if flow.certificate.worst(problem.size) > STEP.certificate(system.behaviour):
        raise ended
    ends = np.column_stack([end_forces(forces, program.places[:, H]), forces[:, 2]])
    return equilibrium(problem, at, index, flow, Iterate(ends, gaps, alpha, rest), 1)
