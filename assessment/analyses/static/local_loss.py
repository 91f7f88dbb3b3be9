"""Local losses along a path: a block that slides past the edge of what bears it, a beam that unseats (C8.7.1.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mechanics.model import H

if TYPE_CHECKING:
    from mechanics import Assembly, State
    from mechanics.types import Array

BEARS = 1e-3  # of the weight of the model: what a joint carries at least to bear something


def local_loss(
    model: Assembly, states: Sequence[State], displacement: Array, forces: Array
) -> dict[str, Any] | None:
    """Return the first loss along a path: a drawn joint that bears and whose faces come to overlap no more.

    `displacement` (k,) m of the points `states`; `forces` (j, 3), kN, kNm, of the drawn joints, and others, at the
    start. The displacement is interpolated between the two points about it; `overlap_m`: of the joint at the start.
    None where there is no loss.
    """
    drawn = model.contacts
    overlap = np.array([2.0 * drawn.places(state.positions)[:, H] for state in states])
    bears = (forces[: len(drawn), 0] > BEARS * model.weight) & (overlap[0] > 0.0)
    gone = (overlap <= 0.0) & bears
    if not gone.any():
        return None
    at = int(np.argmax(gone.any(axis=1)))
    before, after = overlap[at - 1], overlap[at]
    share = np.where(gone[at], before / np.where(gone[at], before - after, 1.0), np.inf)
    joint = int(np.argmin(share))
    d_1, d_2 = displacement[at - 1], displacement[at]
    return {
        "displacement_m": float(d_1 + share[joint] * (d_2 - d_1)),
        "joint": joint,
        "blocks": [int(drawn.a[joint]), int(drawn.b[joint])],
        "overlap_m": float(overlap[0, joint]),
    }


def loss_told(loss: Mapping[str, Any]) -> str:
    """Return what is lost, and where."""
    a, b = loss["blocks"]
    return f"the faces of blocks {a} and {b} slide off each other at d = {loss['displacement_m']:.4g} m"
