"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5).

By the associative law it is the largest multiplier of forces in equilibrium, and unique. By Coulomb's law, ψ = 0, a
flow is a mechanism and forces that fit it: where a gap opens the force is none, where a joint slides T = ∓μN. Flows
form a continuum of multipliers. The interior point finds one amid them, the *central* one. From it the least is sought:

    A ← the gaps and slips of the flow
    while α falls:
        f ← the forces of least α that balance the loads and fit A            a linear program
        A ← the gaps and slips of another mechanism that fits f               another one

Each pair is a flow, certified on its own. The descent is local. Where ψ = 0 has no flow of the given work (blocks
wedge, slips grow without bound), a slight dilation has one: its multiplier is returned with that dilation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.kernels.law import FRICTION
from mechanics.messages import message
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Program, Solution, certify, end_forces
from mechanics.solvers import GOOD, solve
from mechanics.solvers.interior import Iterate, with_dilation
from mechanics.steps.equilibrium import ClosedProgram, check_self_weight, closed_program
from mechanics.steps.static_system import Sliding, check_sliding
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Limit:
    """Onset of collapse.

    `alpha`: multiplier of the lateral load, by Coulomb's law the least found; `central`: that of the central flow;
    `mechanism` (b, 3): virtual displacements, scaled so that the largest centroid displacement is 1; `forces` (j, 3): N
    (kN), P (kNm) and T (kN) of the `contacts`, the drawn joints first; `dilation`: share of μ|slip| by which sliding
    lifts joints in the mechanism: 1 by the associative law, 0 by Coulomb's, LimitTolerances.slight where that has no
    flow.
    """

    alpha: float
    central: float
    mechanism: Array
    forces: Array
    contacts: Contacts
    certificate: Certificate
    dilation: float = 1.0
    sliding: Sliding = "associative"


def limit_analysis(
    model: Assembly,
    direction: Direction = "+x",
    state: State | None = None,
    sliding: Sliding = "associative",
) -> Limit:
    """Return the onset of collapse under f_D + α f_L over the joints closed in a state (paper, eq. 5).

    `state`: default as drawn. `sliding`: "associative", as in the paper, opens a joint that slides; "coulomb" does not.
    Raises UnstableError if the joints cannot carry gravity alone, NoEquilibriumError if the load meets no mechanism (an
    interlocked assembly), ConvergenceError if hinges that crush do not settle, ArgumentError for an argument out of its
    range.
    """
    Assembly.check(model)
    check_sliding(sliding)
    state = model.starting(state)
    return _limit(model, direction, check_self_weight(model, state), sliding)


def limit_in(model: Assembly, direction: Direction, state: State, sliding: Sliding = "associative") -> Limit:
    """Return the onset of collapse of a state that is known to stand under gravity; raises as limit_analysis."""
    return _limit(model, direction, closed_program(model, state), sliding)


def _limit(model: Assembly, direction: Direction, standing: ClosedProgram, sliding: Sliding) -> Limit:
    """Return the onset of collapse over the closed joints of a state. Raises as limit_in.

    A hinge that crushes its edge lies N/2s within it: the program is repeated until N is that of the solution.
    """
    closed = standing.pushed(model, model.lateral_load(direction))
    flow = _associative if sliding == "associative" else _coulomb
    for _ in range(LIMIT.repeats):
        found, central, dilation = flow(closed)
        again = closed.hinged(found.forces[:, 0])
        if again is None:
            break
        closed = again
    else:
        raise ConvergenceError(message("the hinges that crush do not settle where their forces have them"))
    if abs(found.alpha) > 0.99 * LARGEST_MULTIPLIER:
        raise NoEquilibriumError(
            message(
                "{direction}: no mechanism, the load only wedges the blocks (α > {bound:g})",
                direction=direction,
                bound=LARGEST_MULTIPLIER,
            )
        )
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable] = found.displacement.reshape(-1, 3)
    forces = np.zeros((len(closed.contacts), 3))
    forces[closed.index] = found.forces
    return Limit(
        found.alpha,
        central,
        mechanism / abs(mechanism[:, :2]).max(),
        forces,
        closed.contacts,
        found.certificate,
        dilation,
        sliding,
    )


def _associative(closed: ClosedProgram) -> tuple[Solution, float, float]:
    """Return the flow of the associative law, its multiplier and its dilation."""
    found, _ = solve(with_dilation(closed.program, 1.0), closed.layout)
    return found, found.alpha, 1.0


def _coulomb(closed: ClosedProgram) -> tuple[Solution, float, float]:
    """Return the flow of least multiplier that is found by Coulomb's law, the multiplier of the central one, and ψ."""
    program = with_dilation(closed.program, 0.0)
    try:
        central, iterate = solve(program, closed.layout)
    except ConvergenceError:
        wedged, _ = solve(with_dilation(closed.program, LIMIT.slight), closed.layout)
        return wedged, wedged.alpha, LIMIT.slight
    if iterate is None or len(program.places) > LIMIT.most_joints:
        return central, central.alpha, 0.0
    return _least(program, central, iterate), central.alpha, 0.0


def _least(program: Program, central: Solution, iterate: Iterate) -> Solution:
    """Return the flow of least multiplier that the descent from the central one finds."""
    from mechanics.solvers import lp_highs

    room = _room(program, central.forces)
    flowing = iterate.gaps / program.step > room / program.weight
    best, displacement = central, central.displacement
    for _ in range(LIMIT.repeats):
        if not (flowing[:, 2:].any(axis=1) & (room[:, :2].max(axis=1) > LIMIT.idle * program.weight)).any():
            break  # what only turns has one multiplier
        answer = lp_highs.least_multiplier(program, flowing)
        if answer is None:
            break
        forces, alpha = answer
        found = Solution(forces, alpha, displacement, certify(program, forces, alpha, displacement))
        if found.certificate.worst(program.step) > GOOD or alpha >= best.alpha * (1.0 - GOOD):
            break
        best, room = found, _room(program, forces)
        other = lp_highs.mechanism_of(program, room <= LIMIT.idle * program.weight)
        if other is None:
            break
        displacement, flowing = other[0], other[1] > LIMIT.idle * program.step
    return best


def _room(program: Program, forces: Array) -> Array:
    """Return N₁, N₂, μN + T and μN − T (j, 4), kN, of forces (j, 3)."""
    bound, t = program.law[:, FRICTION] * forces[:, 0], forces[:, 2]
    return np.column_stack([end_forces(forces, program.places[:, H]), bound + t, bound - t])
