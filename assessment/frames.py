"""The frames of a path: where the blocks are at some of its points, and what the joints carry there."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from mechanics import Assembly
    from mechanics.assembly import Behaviour, State
    from mechanics.pushdown import Pushdown
    from mechanics.pushover import Pushover
    from mechanics.types import Array

Numbers = dict[str, Any]
NUMBERS = 40_000  # kept of one path: what its frames may cost in results.json and in the page
FEWEST, MOST = 15, 60  # frames of a static path
FEWEST_IN_TIME, MOST_IN_TIME = 24, 150
DIGITS = 6  # of the model's size and weight: positions and forces are kept for pictures


def pushover_frames(model: Assembly, behaviour: Behaviour, path: Pushover) -> Numbers:
    """Frames of a capacity curve, its onset, peak and end among them; see `frames`."""
    # a rigid curve has no step at its onset: the forces there are those of the limit analysis
    lead: list[Array | None] = [] if len(path.steps) == len(path.states) else [None]
    forces = [*lead, *(step.forces for step in path.steps)]
    forces[path.formed] = path.forces
    return frames(model, behaviour, path.states, forces, (path.peak, path.formed))


def pushdown_frames(model: Assembly, behaviour: Behaviour, path: Pushdown, whole: float) -> Numbers:
    """Frames of a movement, the `whole` one (m) that was asked for among them; see `frames`."""
    asked = int(np.argmin(abs(path.movement - whole)))
    return frames(model, behaviour, path.states, [step.forces for step in path.steps], (asked,))


def frames(
    model: Assembly,
    behaviour: Behaviour,
    states: Sequence[State],
    forces: Sequence[Array | None],
    wanted: Iterable[int],
) -> Numbers:
    """Describe some points of a path, first, last and `wanted` ones among them.

    `index` (f,): which points of the path's curve; `configuration` (f, b, 3): displacements (m) and rotation (rad) of
    the blocks from the drawing; `force_kN` (f, j, 2) and `centre` (f, j): see joint_forces; None where not known.
    """
    kept = chosen(len(states), max(FEWEST, min(MOST, NUMBERS // _size(model))), wanted)
    at = [states[k].positions for k in kept]
    return {"index": kept, **_pictured(model, behaviour, at, [forces[k] for k in kept])}


def _size(model: Assembly) -> int:
    """Numbers of one frame."""
    return 3 * (len(model.blocks) + len(model.joints.a))


def _pictured(
    model: Assembly, behaviour: Behaviour, positions: Sequence[Array], forces: Sequence[Array | None]
) -> Numbers:
    carried = [
        None if c is None else joint_forces(model, behaviour, at, c)
        for at, c in zip(positions, forces, strict=True)
    ]
    return {
        "configuration": configurations(model, np.array(positions)),
        "force_kN": [None if c is None else _rounded(c[0], model.weight) for c in carried],
        "centre": [None if c is None else np.round(c[1], 4).tolist() for c in carried],
    }


def snapshots(
    model: Assembly,
    behaviour: Behaviour,
    time: Array,
    displacement: Array,
    positions: Array,
    forces: Sequence[Array],
    peak: int,
) -> Numbers:
    """Describe some times of a motion, evenly spaced, the peak among them: `time_s`, `displacement_m` (f,) as well.

    `configuration`, `force_kN` and `centre` as in `frames`; the forces are those of the step that led there.
    """
    kept = chosen(len(time), max(FEWEST_IN_TIME, min(MOST_IN_TIME, NUMBERS // _size(model))), (peak,))
    return {
        "time_s": np.round(time[kept], 6).tolist(),
        "displacement_m": displacement[kept].tolist(),
        # a motion with rigid joints knows no forces before its first step
        **_pictured(
            model,
            behaviour,
            [positions[k] for k in kept],
            [forces[k] if k > 0 or forces[k].any() else None for k in kept],
        ),
    }


def joint_forces(
    model: Assembly, behaviour: Behaviour, positions: Array, forces: Array
) -> tuple[Array, Array]:
    """Resultant (j, 2) kN of each joint's contact forces (c, 2) on its first block, and where it crosses the joint.

    The second array (j,) is the centre of compression as a share of the joint's length, from its first end; NaN where
    the joint carries nothing.
    """
    contacts, joints = model.contacts(behaviour), model.joints
    rows = model.kinematics(behaviour, positions)
    on_owner = forces[:, :1] * rows.normal[:, :2] + forces[:, 1:] * rows.tangent[:, :2]
    sign = np.where(contacts.a == joints.a[contacts.joint], 1.0, -1.0)
    count = len(joints.a)
    force: Array = np.stack(
        [np.bincount(contacts.joint, sign * on_owner[:, i], minlength=count) for i in (0, 1)], axis=1
    )
    place = model.initial.positions[contacts.a, :2] + contacts.p - joints.ends[contacts.joint, 0]
    share = (place * joints.tangent[contacts.joint]).sum(axis=1) / joints.length[contacts.joint]
    carried = np.bincount(contacts.joint, forces[:, 0], minlength=count)
    moment = np.bincount(contacts.joint, forces[:, 0] * share, minlength=count)
    centre = np.full(count, np.nan)
    bears = carried > 1e-9 * model.weight
    centre[bears] = np.clip(moment[bears] / carried[bears], 0.0, 1.0)
    return force, centre


def chosen(count: int, most: int, wanted: Iterable[int]) -> list[int]:
    """Return about `most` of `count` points, evenly spaced, with the first, the last and the wanted ones."""
    spaced = np.linspace(0, count - 1, min(count, most)).round().astype(int)
    return sorted({*spaced.tolist(), *(int(k) for k in wanted)})


def configurations(model: Assembly, positions: Array) -> list[list[list[float]]]:
    """Displacements and rotation (f, b, 3) of the blocks from the drawing, rounded as pictures need them."""
    extent = max(float(np.ptp(np.concatenate([block.polygon for block in model.blocks]), axis=0).max()), 1e-9)
    return _rounded(positions - model.initial.positions, extent)


def _rounded(values: Array, size: float) -> list[Any]:
    digits = DIGITS - math.floor(math.log10(size))
    return (np.round(values, digits) + 0.0).tolist()  # + 0.0: no −0.0
