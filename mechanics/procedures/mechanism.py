"""Hinges, sliding joints and moving weight of a mechanism, and its multiplier by virtual work."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.kernels.joint import H
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts, end_points, relative_motion
from mechanics.types import Array, Index

NOTICEABLE = 0.02  # of the largest rotation, or displacement, of a block: a relative one that counts
CARRYING = 2e-3  # of the weight: a joint that carries less is no part of the load path


@dataclass(frozen=True, eq=False)
class Hinges:
    """Hinges, sliding joints and moving weight of a mechanism.

    `points` (h, 2) m: centres of pressure of the joints that carry and turn, in the state; hinges closer than a
    block count as one. `sliding`: joints that carry and slip; `moving_weight` kN.
    """

    points: Array
    sliding: Index
    moving_weight: float


def hinges(model: Assembly, contacts: Contacts, state: State, mechanism: Array, forces: Array) -> Hinges:
    """Return hinges and sliding joints of virtual displacements (b, 3) under joint forces N, P, T (j, 3).

    Relative motions below a fiftieth of the largest motion of a block do not count, nor do joints that carry next to
    nothing.
    """
    places = contacts.places(state.positions)
    moved = np.concatenate([mechanism[contacts.a], mechanism[contacts.b]], axis=1)
    slip = abs(relative_motion(places, moved)[:, 2])
    turn = abs(mechanism[contacts.a, 2] - mechanism[contacts.b, 2])
    carries = (forces[:, 0] > CARRYING * model.weight) & (places[:, H] > 0.0) & ~contacts.ties
    hinged = np.flatnonzero(carries & (turn > NOTICEABLE * float(abs(mechanism[:, 2]).max())))
    slides = np.flatnonzero(carries & (slip > NOTICEABLE * float(abs(mechanism[:, :2]).max())))
    moves = model.taking_part(mechanism)
    centre = pressure_centres(contacts.take(hinged), state.positions, forces[hinged])
    weight = -float(model.dead_load[moves, 1].sum())
    return Hinges(_merged(centre, turn[hinged], model.size), slides, weight)


def pressure_centres(contacts: Contacts, positions: Array, forces: Array) -> Array:
    """Return where forces N, P, T (j, 3) act in a configuration (j, 2), m; for a joint without force its middle."""
    low, high = end_points(contacts, positions).transpose(1, 0, 2)
    half = np.maximum(contacts.places(positions)[:, H], 1e-300)
    eccentricity = np.where(forces[:, 0] > 0.0, forces[:, 1] / np.maximum(forces[:, 0], 1e-300), 0.0)
    share = np.clip(eccentricity / half, -1.0, 1.0)[:, None]
    centre: Array = 0.5 * ((1.0 - share) * low + (1.0 + share) * high)
    return centre


def farthest_corner(model: Assembly, begun: Array, moved: Array, direction: Direction) -> tuple[Array, int]:
    """Return the drawn corner (2,), m, of a movable block that goes farthest along the push, and its block.

    `begun`, `moved` (b, 3): positions between which the blocks go. Of corners that go equally far, to NOTICEABLE,
    it is the highest, of those the foremost. A corner that another block has too is left out, for its block's centroid.
    """
    sense = 1.0 if direction == "+x" else -1.0
    turned = [np.stack([np.cos(at[:, 2]), -np.sin(at[:, 2])]).T for at in (begun, moved)]
    found = []
    for k in map(int, np.flatnonzero(model.movable)):
        block = model.blocks[k]
        points = np.vstack([block.polygon, block.centroid])
        way = moved[k, 0] - begun[k, 0] + (points - block.centroid) @ (turned[1][k] - turned[0][k])
        found.append(np.column_stack([sense * way, points, np.full(len(points), k)]))
    way, x, z, owner = np.vstack(found).T
    far = way / max(float(way.max()), 1e-300)
    order = np.lexsort((-sense * x, -z, -np.where(far > 1.0 - NOTICEABLE, 1.0, far)))
    of = (k for k in order if model.block_at((x[k], z[k])) == owner[k])
    best = next(of, order[0])
    point = np.array([x[best], z[best]])
    return point, model.block_at(point)


def _merged(points: Array, turn: Array, distance: float) -> Array:
    """Return the points (h, 2) m; of points closer than a distance (m) only the one that turns most is kept."""
    kept: list[Array] = []
    for k in np.argsort(-turn, kind="stable"):
        if all(np.hypot(*(points[k] - other)) > distance for other in kept):
            kept.append(points[k])
    return np.array(kept, dtype=float).reshape(-1, 2)


def friction_work(contacts: Contacts, state: State, mechanism: Array, forces: Array) -> float:
    """Return Σ T v (kNm) of virtual displacements (b, 3) under joint forces N, P, T (j, 3): joints that slide take it.

    By Coulomb's law; by the associative one N gives it back as they lift.
    """
    moved = np.concatenate([mechanism[contacts.a], mechanism[contacts.b]], axis=1)
    slip = relative_motion(contacts.places(state.positions), moved)[:, 2]
    return float(abs(forces[:, 2] * slip)[~contacts.ties].sum())


def virtual_work_multiplier(
    model: Assembly, mechanism: Array, direction: Direction, taken: float = 0.0
) -> float:
    """Return α = (W − f_Dᵀδ)/f_Lᵀδ of virtual displacements δ (b, 3); W (kNm): what friction and ties take.

    Infinite or NaN where the lateral load f_L does no work on δ.
    """
    moved = np.where(model.movable[:, None], mechanism, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        done = np.float64(taken) - (model.dead_load * moved).sum()
        return float(done / (model.lateral_load(direction) * moved).sum())
