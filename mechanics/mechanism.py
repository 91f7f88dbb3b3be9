"""What a mechanism is made of: hinges, sliding joints, moving weight; and its multiplier by virtual work."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mechanics.assembly import Assembly, Behaviour, Direction, State
from mechanics.equilibrium import local
from mechanics.types import Array, Index

NOTICEABLE = 0.02  # of the largest relative motion in the mechanism
OVERRUN = 0.1  # of a block: a slide past an edge that is worth a warning
CARRYING = 2e-3  # of the weight: a joint that carries less is no part of the load path


@dataclass(frozen=True, eq=False)
class Hinges:
    """What moves in a mechanism.

    `points` (h, 2) m: where joints that carry turn about a contact, in the state; hinges closer than a block are one.
    `sliding`: joints that carry and slip; `moving_weight` kN.
    """

    points: Array
    sliding: Index
    moving_weight: float


def hinges(model: Assembly, state: State, mechanism: Array, forces: Array) -> Hinges:
    """Find the hinges and sliding joints of virtual displacements (b, 3) under rigid contact forces (c, 2) kN.

    A joint hinges where its blocks turn against each other about the contact points that carry its force, and slides
    where those slip. Motions below a fiftieth of the largest, and of joints off the load path, do not count.
    """
    contacts, rows = model.rigid_contacts, model.kinematics("rigid", state.positions)
    slip = abs(local(rows.tangent, contacts.a, contacts.b, mechanism))
    carried = np.bincount(contacts.joint, forces[:, 0], minlength=len(model.joints.a))
    turn = abs(mechanism[model.joints.a, 2] - mechanism[model.joints.b, 2])
    largest = float(abs(mechanism[:, 2]).max())
    carries = carried > CARRYING * model.weight
    share = forces[:, 0] / np.maximum(carried, 1e-300)[contacts.joint]
    point = _points(model, state)
    moment = share[:, None] * point
    sums = [np.bincount(contacts.joint, moment[:, k], minlength=len(carried)) for k in (0, 1)]
    centre: Array = np.stack(sums, axis=1)
    hinged = np.flatnonzero(carries & (turn > NOTICEABLE * largest))
    fastest = float(abs(mechanism[:, :2]).max())
    slides = carries[contacts.joint] & (share > 0.05) & (slip > NOTICEABLE * fastest)
    moves = (abs(mechanism[:, :2]).max(axis=1) > 1e-6 * fastest) & model.movable
    weight = -float(model.dead_load[moves, 1].sum())
    return Hinges(
        _merged(centre[hinged], turn[hinged], model.size), np.unique(contacts.joint[slides]), weight
    )


def _points(model: Assembly, state: State) -> Array:
    """Contact points (c, 2), m, in a state."""
    contacts = model.rigid_contacts
    cos, sin = np.cos(state.positions[contacts.a, 2]), np.sin(state.positions[contacts.a, 2])
    x, z = contacts.p.T
    points: Array = state.positions[contacts.a, :2] + np.stack([cos * x - sin * z, sin * x + cos * z], axis=1)
    return points


def _merged(points: Array, turn: Array, distance: float) -> Array:
    """Of points closer than a distance, the one that turns most."""
    kept: list[Array] = []
    for k in np.argsort(-turn, kind="stable"):
        if all(np.hypot(*(points[k] - other)) > distance for other in kept):
            kept.append(points[k])
    return np.array(kept, dtype=float).reshape(-1, 2)


def virtual_work_multiplier(model: Assembly, mechanism: Array, direction: Direction) -> float:
    """α = −f_Dᵀδ / f_Lᵀδ of virtual displacements δ (b, 3): contact forces do no work on an associated mechanism."""
    moved = np.where(model.movable[:, None], mechanism, 0.0)
    return -float((model.dead_load * moved).sum() / (model.lateral_load(direction) * moved).sum())


def overruns(model: Assembly, behaviour: Behaviour, path: Iterable[tuple[Array, Array]]) -> tuple[str, ...]:
    """What the contacts of a path cannot show: blocks that have slid past an edge and are carried all the same.

    `path`: positions (b, 3) and contact forces (c, 2) kN of its points. The contacts keep the surfaces they have as
    drawn, without end (the paper's scheme). The worst overrun is named where a contact that carries more than a
    thousandth of the weight is past its edge by a tenth of a block.
    """
    contacts = model.contacts(behaviour)
    worst, text = OVERRUN * model.size, ""
    for positions, forces in path:
        slide = model.kinematics(behaviour, positions).slide
        off = np.maximum(contacts.room[:, 0] - slide, slide - contacts.room[:, 1])
        off[forces[:, 0] <= 1e-3 * model.weight] = 0.0
        k = int(np.argmax(off))
        if off[k] > worst:
            worst = float(off[k])
            text = (
                f"block {contacts.a[k]} slides up to {worst:.3g} m past the edge of block {contacts.b[k]} and is still "
                f"carried there with {forces[k, 0]:.3g} kN: surfaces have no end here; judge whether it would fall"
            )
    return (text,) if text else ()
