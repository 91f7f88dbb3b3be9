"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import U
from mechanics.kernels.law import FRICTION
from mechanics.messages import message
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Solution
from mechanics.solvers import solve
from mechanics.solvers.interior import Iterate
from mechanics.steps.equilibrium import ClosedProgram, check_self_weight, closed_program
from mechanics.steps.static_system import Sliding, check_sliding
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Limit:
    """Onset of collapse.

    `alpha`: multiplier of the lateral load; `mechanism` (b, 3): virtual displacements, scaled so that the largest
    centroid displacement is 1; `forces` (j, 3): N (kN), P (kNm) and T (kN) of the `contacts`, the drawn joints first.
    `residual` (Coulomb friction): by how much sliding joints are still lifted, over the mechanism's largest
    displacement; above LimitTolerances.slip_gap the slips have not settled. `sliding`: whether what slides lifts.
    """

    alpha: float
    mechanism: Array
    forces: Array
    contacts: Contacts
    certificate: Certificate
    residual: float = 0.0
    sliding: Sliding = "associative"


def limit_analysis(
    model: Assembly,
    direction: Direction = "+x",
    state: State | None = None,
    sliding: Sliding = "associative",
) -> Limit:
    """Return the largest α with equilibrium under f_D + α f_L over the joints closed in a state (paper, eq. 5).

    `state`: default as drawn. `sliding`: "associative", as in the paper, opens a joint that slides; "coulomb" does not:
    its multiplier is not unique, see limit_in. Raises UnstableError if the joints cannot carry gravity alone,
    NoEquilibriumError if the load meets no mechanism (an interlocked assembly), ConvergenceError if hinges that crush
    do not settle, ArgumentError for an argument out of its range.
    """
    Assembly.check(model)
    check_sliding(sliding)
    state = model.starting(state)
    return _limit(model, direction, check_self_weight(model, state), sliding)


def _without_lift(closed: ClosedProgram, lifting: Solution, iterate: Iterate) -> tuple[Solution, float]:
    """Return a flow that lifts no sliding joint, and the lift per step that is left: 0 with Coulomb's law.

    Begins with the flow and the iterate of the associative program, whose sliding joints lift in full. If the slips do
    not settle, the least multiplier of a flow that lifts by less than it moves; if there is none, that which lifts the
    least.
    """
    program = closed.program
    mu = program.law[:, FRICTION]
    slips = _slips(iterate)
    best, least = lifting, float((mu * slips).max(initial=0.0)) / program.step
    for _ in range(LIMIT.repeats):
        if least <= LIMIT.slip_gap:
            break
        places = program.places.copy()
        places[:, U] += mu * slips
        found, after = solve(replace(program, places=places), closed.layout)
        if after is None:
            break
        before, slips = slips, _slips(after)
        lift = float((mu * abs(slips - before)).max(initial=0.0)) / program.step
        lower = found.alpha < best.alpha and lift < LIMIT.lifted
        if lift <= LIMIT.slip_gap or lower or (least >= LIMIT.lifted and lift < least):
            best, least = found, lift
    return best, least


def _slips(iterate: Iterate) -> Array:
    """Return the slips (j,) m of an iterate, either way."""
    return np.asarray(abs(iterate.gaps[:, 2] - iterate.gaps[:, 3]))


def limit_in(model: Assembly, direction: Direction, state: State, sliding: Sliding = "associative") -> Limit:
    """Return the onset of collapse of a state that is known to stand under gravity.

    With Coulomb friction the program is repeated, and each repetition subtracts the lift of the last slips: once the
    slips settle, no joint is lifted. If they do not, see _without_lift: the lift that is left is returned. Raises
    NoEquilibriumError if the load meets no mechanism, ConvergenceError if hinges that crush do not settle.
    """
    return _limit(model, direction, closed_program(model, state), sliding)


def _limit(model: Assembly, direction: Direction, standing: ClosedProgram, sliding: Sliding) -> Limit:
    """Return the onset of collapse over the closed joints of a state. Raises as limit_in.

    A hinge that crushes its edge lies N/2s within it: the program is repeated until N is that of the solution.
    """
    closed = standing.pushed(model, model.lateral_load(direction))
    for _ in range(LIMIT.repeats):
        solution, iterate = solve(closed.program, closed.layout)
        residual = 0.0
        if sliding == "coulomb" and iterate is not None:
            solution, residual = _without_lift(closed, solution, iterate)
        again = closed.hinged(solution.forces[:, 0])
        if again is None:
            break
        closed = again
    else:
        raise ConvergenceError(message("the hinges that crush do not settle where their forces have them"))
    if abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
        raise NoEquilibriumError(
            message(
                "{direction}: no mechanism, the load only wedges the blocks (α > {bound:g})",
                direction=direction,
                bound=LARGEST_MULTIPLIER,
            )
        )
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable] = solution.displacement.reshape(-1, 3)
    forces = np.zeros((len(closed.contacts), 3))
    forces[closed.index] = solution.forces
    return Limit(
        solution.alpha,
        mechanism / abs(mechanism[:, :2]).max(),
        forces,
        closed.contacts,
        solution.certificate,
        residual,
        sliding,
    )
