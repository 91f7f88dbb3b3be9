"""Limit analysis once more, by the static theorem and another solver: a check of limit_analysis."""

from __future__ import annotations

import numpy as np

from mechanics.errors import ArgumentError
from mechanics.kernels.joint import BETA, NX, NZ
from mechanics.kernels.law import FRICTION, STRENGTH
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts, end_gaps, end_points
from mechanics.solvers import OPEN
from mechanics.solvers.lp_point_forces import PointForces, largest_multiplier
from mechanics.steps.equilibrium import closed_program
from mechanics.types import Array, Mask


def static_theorem(model: Assembly, direction: Direction = "+x", state: State | None = None) -> float | None:
    """Return the largest α with equilibrium under f_D + α f_L over the joints closed in a state, by HiGHS.

    It is the α of limit_analysis with associative friction, from a linear program written apart: forces at the closed
    ends of joints, equilibrium of each block about its centroid. Contacts, which of their ends are closed, and loads
    are those of the model; a tie bears up to its yield force. None if HiGHS finds no optimum. Raises ArgumentError for
    joints that crush: their bound on N and P is not linear.
    """
    state = model.starting(state)
    closed = closed_program(model, state)
    contacts, law = closed.contacts.take(closed.index), closed.program.law
    if np.isfinite(law[~contacts.ties, STRENGTH]).any():
        raise ArgumentError("joints that crush make no linear program")
    bears = end_gaps(closed.program.places) < 0.5 * OPEN * closed.program.step
    points = _points(contacts, bears, law[:, FRICTION], state.positions)
    loads = model.dead_load, model.lateral_load(direction)
    return largest_multiplier(points, state.positions[:, :2], model.movable, loads, model.size)


def _points(contacts: Contacts, bears: Mask, friction: Array, positions: Array) -> PointForces:
    """Return the forces that contacts of a friction (j,) can carry at their ends that bear (j, 2), at positions (b, 3).

    Sliding that lifts leaves a gap: the forces act at the corner that touches the other block's face, and T where the
    joint is the more closed.
    """
    places = contacts.places(positions)
    gaps, normal = end_gaps(places), places[:, [NX, NZ]]
    corner = ((0.5 - places[:, BETA])[:, None] * gaps)[:, :, None] * normal[:, None, :]
    at = end_points(contacts, positions) + corner
    return PointForces(
        a=contacts.a,
        b=contacts.b,
        normal=normal,
        friction=friction,
        joint=np.nonzero(bears)[0],
        pressure_at=at[bears],
        most=np.where(contacts.ties, 0.5 * contacts.strength, np.inf)[np.nonzero(bears)[0]],
        friction_at=at[np.arange(len(at)), np.argmin(gaps, axis=1)],
    )
