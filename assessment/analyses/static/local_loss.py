"""Local losses along a path: a block slides off the block that supports it, a beam unseats (C8.7.1.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from assessment.results.schema.static import LocalLoss
from mechanics.messages import Message, message
from mechanics.model import H

if TYPE_CHECKING:
    from mechanics import Assembly, State
    from mechanics.types import Array

PARTING = 0.02  # of the overlap at the start: most that a joint has left where its loss fells the structure
BEARS = 1e-3  # of the weight of the model: least force of a joint that carries


def local_loss(
    model: Assembly, states: Sequence[State], displacement: Array, forces: Array, falls: bool
) -> LocalLoss | None:
    """Return the first loss along a path: a drawn joint that carries, and whose faces overlap no longer.

    `displacement` (k,) m of the points `states`; `forces` (j, 3), kN, kNm, of the drawn joints, and others, by which
    they carry: those at α0, or at the start of a movement; `falls`: no equilibrium lies beyond the last point. The
    displacement of the loss is interpolated between two points, or is that of the last point if the structure falls as
    the faces part; `overlap_m`: of the joint at the start. None if there is no loss.
    """
    drawn = model.contacts
    overlap = np.array([2.0 * drawn.places(state.positions)[:, H] for state in states])
    bears = (forces[: len(drawn), 0] > BEARS * model.weight) & (overlap[0] > 0.0)
    gone = (overlap <= 0.0) & bears
    if not gone.any():
        left = np.where(bears, overlap[-1] / np.where(bears, overlap[0], 1.0), np.inf)
        joint = int(np.argmin(left))
        return _loss(model, joint, displacement[-1], overlap) if falls and left[joint] < PARTING else None
    at = int(np.argmax(gone.any(axis=1)))
    before, after = overlap[at - 1], overlap[at]
    share = np.where(gone[at], before / np.where(gone[at], before - after, 1.0), np.inf)
    joint = int(np.argmin(share))
    d_1, d_2 = displacement[at - 1], displacement[at]
    return _loss(model, joint, d_1 + share[joint] * (d_2 - d_1), overlap)


def _loss(model: Assembly, joint: int, displacement: float, overlap: Array) -> LocalLoss:
    drawn = model.contacts
    return LocalLoss(
        displacement_m=float(displacement),
        joint=joint,
        blocks=[int(drawn.a[joint]), int(drawn.b[joint])],
        overlap_m=float(overlap[0, joint]),
    )


def loss_sentence(loss: LocalLoss) -> Message:
    """Return the text of a local loss for messages."""
    first, second = loss.blocks
    return message(
        "the faces of blocks {first} and {second} slide off each other at d = {displacement:.4g} m",
        first=first,
        second=second,
        displacement=loss.displacement_m,
    )
