"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.assembly import Assembly, Direction, State
from mechanics.errors import NoEquilibriumError
from mechanics.model.contacts import Contacts
from mechanics.program import LARGEST_MULTIPLIER, Certificate
from mechanics.solvers import solve
from mechanics.steps.equilibrium import check_self_weight, closed_program
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class Limit:
    """Onset of collapse.

    `alpha`; `mechanism` (b, 3): virtual displacements, the largest centroid displacement being 1; `forces` (j, 3): N, P
    and T, kN and kNm, of the `contacts`, the drawn joints first; and the certificate.
    """

    alpha: float
    mechanism: Array
    forces: Array
    contacts: Contacts
    certificate: Certificate


def limit_analysis(model: Assembly, direction: Direction = "+x", state: State | None = None) -> Limit:
    """The largest α with equilibrium under f_D + α f_L over the joints closed in a state (default: as drawn).

    Friction is associative, as in the paper. Raises UnstableError where gravity alone cannot be carried and
    NoEquilibriumError where the load meets no mechanism (an interlocked assembly).
    """
    state = model.starting(state)
    check_self_weight(model, state)
    return limit_in(model, direction, state)


def limit_in(model: Assembly, direction: Direction, state: State) -> Limit:
    """Limit analysis in a state that is known to stand."""
    closed = closed_program(model, state, model.lateral_load(direction))
    solution, _ = solve(closed.program, closed.layout)
    if abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
        raise NoEquilibriumError(
            f"{direction}: no mechanism, the load only wedges the blocks (α > {LARGEST_MULTIPLIER:g})"
        )
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable] = solution.displacement.reshape(-1, 3)
    forces = np.zeros((len(closed.contacts), 3))
    forces[closed.index] = solution.forces
    return Limit(
        solution.alpha, mechanism / abs(mechanism[:, :2]).max(), forces, closed.contacts, solution.certificate
    )
