"""Certificates, warnings, configurations and local losses (C8.7.1.2) of paths, of settlements as of lateral loads."""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from assessment.results.schema.model import QualityRow
from assessment.results.schema.static import LocalLoss
from mechanics import Assembly, State, UnstableError
from mechanics.messages import Message, headed, message
from mechanics.model import H
from mechanics.procedures import PATH, Pushdown, Pushover
from mechanics.program import Certificate
from mechanics.steps import check_self_weight, unpressed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from mechanics.types import Array

AT_LIMIT = 1e-5  # of the friction limit: a joint whose T is closer to it slides
PARTING = 0.02  # of the overlap at the start: most that a joint has left where its loss fells the structure
BEARS = 1e-3  # of the weight of the model: least force of a joint that carries
SLIDING_CARRIES = 1e-3  # of the weight of the model: the slide of a joint that carries less has no effect


def quality_row(state: str, stage: str, path: Pushdown | Pushover | None) -> QualityRow:
    """Return the worst certificate of the programs of a path; None: there is no path."""
    certificates, steps = (path.certificates, path.steps) if path is not None else ((), ())
    worst = reduce(Certificate.joined, certificates, Certificate(0.0, 0.0, 0.0, 0.0, 0.0))
    return QualityRow(
        state=state,
        stage=stage,
        solves=sum(step.solves for step in steps) + len(certificates) - len(steps),
        worst_equilibrium_residual=worst.equilibrium,
        worst_penetration_m=max([worst.penetration, *(step.penetration for step in steps)]),
        worst_complementarity=worst.complementarity,
        worst_cone_violation=worst.cone,
        lifting=(path.lifting or None) if path is not None else None,
    )


def lifts(title: str, path: Pushdown | Pushover) -> list[Message]:
    """Return a warning if points of a path were solved with a dilation."""
    if not path.lifting:
        return []
    text = message(
        "Coulomb's law was not solved at {count} of {points} points: what slides lifts there; try a smaller increment",
        count=path.lifting,
        points=len(path.states),
    )
    return [headed(title, text)]


def stand(model: Assembly) -> Message | None:
    """Return why the structure cannot stand under its own weight; None if it can."""
    try:
        check_self_weight(model)
    except UnstableError as error:
        return error.message
    return None


def pressed_in(model: Assembly) -> list[Message]:
    """Return a warning that names the blocks that friction alone holds in a structure that stands, if there are any."""
    held = unpressed(model).tolist()
    if not held:
        return []
    return [
        message(
            "stands only if pressed in: nothing presses the faces that hold these blocks: {blocks}; rigid joints "
            "may hold them by friction, elastic ones let them fall",
            blocks=", ".join(map(str, held[:10])) + (" …" if len(held) > 10 else ""),
        )
    ]


def turns_on_rounding(model: Assembly, path: Pushdown | Pushover) -> bool:
    """Whether a path amplifies the last digits of its input: a joint that carries slides, or a part jumps."""
    if len(path.crossed):
        return True
    least = SLIDING_CARRIES * model.weight
    for step in path.steps:
        carries = (step.forces[:, 0] > least) & ~step.contacts.ties
        N, T = step.forces[carries, 0], step.forces[carries, 2]
        if (abs(T) >= (1.0 - AT_LIMIT) * step.contacts.friction[carries] * N).any():
            return True
    return False


def crossings(title: str, crossed: NDArray[np.float64], increment: float) -> list[Message]:
    """Return a warning for each stretch (n, 2) m in which a part moves by itself; adjoining stretches are joined.

    A stretch shorter than 1/32 of the increment (m) is below the accuracy of the path and left out.
    """
    stretches: list[list[float]] = []
    for left, held in np.sort(crossed, axis=1):
        if held - left < 0.99 * PATH.shortest(increment):
            continue
        if stretches and left <= stretches[-1][1]:
            stretches[-1][1] = max(held, stretches[-1][1])
        else:
            stretches.append([left, held])
    return [
        headed(
            title,
            message(
                "between d = {start:.4g} and {end:.4g} m a part moves by itself, until others hold it again",
                start=left,
                end=held,
            ),
        )
        for left, held in stretches
    ]


def configuration(model: Assembly, state: State) -> list[list[float]]:
    """Return displacements (m) and rotations (rad) (b, 3) of the blocks from the drawing."""
    moved: NDArray[np.float64] = state.positions - model.initial.positions
    rows: list[list[float]] = moved.tolist()
    return rows


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
