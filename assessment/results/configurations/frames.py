"""The frames of a path: where the blocks are at some of its points, and what the joints carry there."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.results.configurations.faces import Met, shares
from assessment.results.configurations.ties import tensions
from assessment.results.numbers import plain
from assessment.results.schema import Frames, Snapshots

if TYPE_CHECKING:
    from mechanics import Assembly
    from mechanics.model import Contacts, State
    from mechanics.procedures import Pushdown, Pushover
    from mechanics.types import Array

NUMBERS = 40_000  # most numbers of the frames of one path, in results.json and in the page
FEWEST, MOST = 15, 60  # frames of a static path
FEWEST_IN_TIME, MOST_IN_TIME = 24, 150
LEAST = 1e-6  # of the model's weight: least force of a pair that met and is described
DIGITS = 6  # of the model's size and weight: positions and forces are kept for pictures


@dataclass(frozen=True, eq=False)
class Carried:
    """What joints carry: forces N, P, T (j, 3), kN and kNm, of contacts, the drawn joints first."""

    contacts: Contacts
    forces: Array


def pushover_frames(model: Assembly, path: Pushover, met: Met) -> Frames:
    """Frames of a capacity curve, its onset, peak and end among them; see `frames`."""
    # a rigid curve has no step at its onset: the forces there are those of the limit analysis
    lead: list[Carried | None] = [] if len(path.steps) == len(path.states) else [None]
    carried = [*lead, *(Carried(step.contacts, step.forces) for step in path.steps)]
    carried[path.formed] = Carried(path.contacts, path.forces)
    return frames(model, path.states, carried, (path.peak, path.formed), met)


def pushdown_frames(model: Assembly, path: Pushdown, whole: float) -> Frames:
    """Frames of a movement, that of the `whole` movement (m) among them; see `frames`."""
    asked = int(np.argmin(abs(path.movement - whole)))
    carried = [Carried(step.contacts, step.forces) for step in path.steps]
    return frames(model, path.states, carried, (asked,), Met(model))


def frames(
    model: Assembly,
    states: Sequence[State],
    carried: Sequence[Carried | None],
    wanted: Iterable[int],
    met: Met,
) -> Frames:
    """Describe some points of a path (see `_pictured`): first, last and `wanted` ones, others evenly between them."""
    kept = chosen(len(states), max(FEWEST, min(MOST, NUMBERS // _size(model))), wanted)
    at = [states[k].positions for k in kept]
    found = _pictured(model, at, [carried[k] for k in kept], met)
    return Frames(index=kept, **found)


def _size(model: Assembly) -> int:
    """Numbers of one frame."""
    return 3 * (len(model.blocks) + len(model.joints.a))


def _pictured(
    model: Assembly, positions: Sequence[Array], carried: Sequence[Carried | None], met: Met
) -> dict[str, Any]:
    """Return what frames and snapshots have in common, by their keys: some points of a path (f,).

    `configuration` (f, b, 3): displacements and rotations of the blocks, m and rad; `force_kN` (f, j, 2): N and T of
    each joint, `centre` (f, j): where N presses, as a share of the overlap; None where not known. Joints are the drawn
    ones and then those in `met`, which did not touch as drawn. `tie_kN` (f, t): tension of each tie of the state.
    """
    least = LEAST * model.weight
    numbers = [None if c is None else met.numbers(c.contacts, c.forces[:, 0] > least) for c in carried]
    count = met.drawn + len(met.joints)
    force: list[Any] = []
    centre: list[Any] = []
    for at, c, number in zip(positions, carried, numbers, strict=True):
        if c is None or number is None:
            force.append(None)
            centre.append(None)
            continue
        known = number >= 0
        resultant, share = np.zeros((count, 2)), np.full(count, np.nan)
        resultant[number[known]] = c.forces[known][:, [0, 2]]
        share[number[known]] = shares(c.contacts.places(at), c.forces)[known]
        share[resultant[:, 0] <= 1e-9 * model.weight] = np.nan
        force.append(_rounded(resultant, model.weight))
        centre.append(plain(np.round(share, 6).tolist()))
    told = {"configuration": configurations(model, np.array(positions)), "force_kN": force, "centre": centre}
    told["met"] = list(met.joints)
    if model.ties:
        told["tie_kN"] = [
            None if c is None else _rounded(tensions(model, c.forces), model.weight) for c in carried
        ]
    return told


def snapshots(
    model: Assembly, time: Array, displacement: Array, positions: Array, forces: Array, peak: int
) -> Snapshots:
    """Describe some times of a motion (see `_pictured`), evenly spaced, the peak among them, of the drawn joints.

    `time` (k,) s; `displacement` (k,) m of the control point; `positions` (k, b, 3); `forces` (k, j, 3), kN and kNm:
    those of the step that led there.
    """
    kept = chosen(len(time), max(FEWEST_IN_TIME, min(MOST_IN_TIME, NUMBERS // _size(model))), (peak,))
    carried = [Carried(model.contacts, forces[k]) if k > 0 or forces[k].any() else None for k in kept]
    # a motion knows no forces before its first step
    found = _pictured(model, [positions[k] for k in kept], carried, Met(model))
    return Snapshots(
        time_s=np.round(time[kept], 6).tolist(), displacement_m=displacement[kept].tolist(), **found
    )


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
