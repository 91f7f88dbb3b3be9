"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechanics.errors import NoEquilibriumError
from mechanics.kernels.joint import U
from mechanics.kernels.law import FRICTION
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.program import LARGEST_MULTIPLIER, Certificate
from mechanics.solvers import solve
from mechanics.steps.equilibrium import check_self_weight, closed_program
from mechanics.steps.static_system import Sliding
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Limit:
    """Onset of collapse.

    `alpha`; `mechanism` (b, 3): virtual displacements, the largest centroid displacement being 1; `forces` (j, 3): N, P
    and T, kN and kNm, of the `contacts`, the drawn joints first; and the certificate. `residual`: with Coulomb
    friction, what the lift of slips changed by in the last repetition, as a share of the mechanism's largest
    displacement; beyond LEVEL the repetitions alternate between mechanisms.
    """

    alpha: float
    mechanism: Array
    forces: Array
    contacts: Contacts
    certificate: Certificate
    residual: float = 0.0


def limit_analysis(
    model: Assembly,
    direction: Direction = "+x",
    state: State | None = None,
    sliding: Sliding = "associative",
) -> Limit:
    """The largest α with equilibrium under f_D + α f_L over the joints closed in a state (default: as drawn).

    `sliding`: "associative", as in the paper: what slides is lifted; "coulomb": it is not. The multiplier is then not
    unique: see limit_in, which gives the least that it comes upon. Raises UnstableError where gravity alone cannot be
    carried and NoEquilibriumError where the load meets no mechanism (an interlocked assembly).
    """
    state = model.starting(state)
    check_self_weight(model, state)
    return limit_in(model, direction, state, sliding)


def limit_in(model: Assembly, direction: Direction, state: State, sliding: Sliding = "associative") -> Limit:
    """Limit analysis in a state that is known to stand.

    With Coulomb friction the program is repeated, the lift of its last slips taken back each time: where these settle,
    nothing is lifted. They may alternate between mechanisms; the least multiplier of the sequence is the one returned.
    """
    closed = closed_program(model, state, model.lateral_load(direction))
    program = closed.program
    solution, iterate = solve(program, closed.layout)
    slips = np.zeros(len(program.law))
    residual = 0.0
    for _ in range(LIMIT.repeats if sliding == "coulomb" else 0):
        if iterate is None:
            break
        before, slips = slips, abs(iterate.gaps[:, 2] - iterate.gaps[:, 3])
        residual = float((program.law[:, FRICTION] * abs(slips - before)).max(initial=0.0)) / program.step
        if residual <= LIMIT.slip_gap:
            break
        places = program.places.copy()
        places[:, U] += program.law[:, FRICTION] * slips
        found, iterate = solve(replace(program, places=places), closed.layout)
        if found.alpha < solution.alpha:
            solution = found
    if abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
        raise NoEquilibriumError(
            f"{direction}: no mechanism, the load only wedges the blocks (α > {LARGEST_MULTIPLIER:g})"
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
    )
