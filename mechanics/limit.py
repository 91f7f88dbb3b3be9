"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechanics.assembly import Assembly, Direction, State
from mechanics.block import Array
from mechanics.equilibrium import check_self_weight, closed_program
from mechanics.errors import NoEquilibriumError
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Solution
from mechanics.solvers import solve, suits_central_path
from mechanics.static_step import GEOMETRY_TOLERANCE, Step, assemble, elimination_of


@dataclass(frozen=True, eq=False)
class Limit:
    """Onset of collapse.

    `alpha`; `mechanism` (b, 3): virtual displacements, the largest centroid displacement being 1; `forces` (c, 2) kN at
    the rigid contact points; and the certificate.
    """

    alpha: float
    mechanism: Array
    forces: Array
    certificate: Certificate


def limit_analysis(model: Assembly, direction: Direction = "+x", state: State | None = None) -> Limit:
    """The largest α with equilibrium under f_D + α f_L over the contacts closed in a state (default: as drawn).

    Friction is associative, as in the paper. Raises UnstableError where gravity alone cannot be carried and
    NoEquilibriumError where the load meets no mechanism (an interlocked assembly).
    """
    state = model.starting(state)
    check_self_weight(model, state)
    return _limit(model, direction, state)


def limit_of(model: Assembly, direction: Direction, step: Step) -> Step:
    """A step with the multiplier and forces of limit analysis in the configuration to which it leads (paper, §3).

    Its own are those on the way there: less, where it lets down what an earlier one lifted by dilatant sliding, since
    they are admissible in the configuration too. Where mechanisms alternate the configuration is the one in which the
    step's forces act. `program` and `at` are those of the configuration; `neighbour` is left. Raises NoEquilibriumError
    where the load only wedges the blocks there.
    """
    apart = abs(step.state.positions - step.at) * (1.0, 1.0, model.size)
    # where mechanisms alternate, equilibrium is certain only where the forces of the step act
    settled = float(apart.max()) <= GEOMETRY_TOLERANCE * step.program.step
    at, lateral = step.state.positions if settled else step.at, model.lateral_load(direction)
    found = _limit(model, direction, replace(step.state, positions=at), step)
    program = assemble(model, "rigid", step.state, at, model.dead_load, step.program.step, lateral)
    quality = step.certificate.joined(found.certificate)
    solution = Solution(found.forces, found.alpha, np.zeros_like(program.load), quality)
    return replace(step, at=at, program=program, solution=solution, solves=step.solves + 1)


def _limit(model: Assembly, direction: Direction, state: State, last: Step | None = None) -> Limit:
    """Limit analysis in a state, sought near the step that led to it where it is solved on central_path."""
    onset, closed = closed_program(model, state, model.lateral_load(direction))
    near = None
    if last is not None and suits_central_path(len(closed)):
        near = last.neighbour.take(closed, onset.step / last.program.step)
    solution = solve(onset, near, elimination_of(model, "rigid").take(closed))
    if solution.alpha > 0.99 * LARGEST_MULTIPLIER:
        raise NoEquilibriumError(
            f"{direction}: no mechanism, the load only wedges the blocks (α > {LARGEST_MULTIPLIER:g})"
        )
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable] = solution.displacement.reshape(-1, 3)
    forces = np.zeros((len(model.rigid_contacts), 2))
    forces[closed] = solution.forces
    return Limit(solution.alpha, mechanism / abs(mechanism[:, :2]).max(), forces, solution.certificate)
