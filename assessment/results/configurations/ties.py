"""Ties of an assembly: their tension along a path and while the base moves, how they lengthen in a mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from assessment.results.schema.dynamic import ShakenTie
from assessment.results.schema.static import TieTension

if TYPE_CHECKING:
    from mechanics import Assembly
    from mechanics.types import Array, Mask

YIELDS = 1.0 - 1e-6  # of the yield force: the tension of a tie that yields
NOTICED = 1e-6  # of the largest displacement: a tie that lengthens by less does not


def tensions(model: Assembly, forces: Array) -> Array:
    """Return the tension (t,) kN of each tie under the forces (j, 3) of contacts: joints, ties, pairs that met."""
    first = len(model.joints.a)
    found: Array = forces[first : first + len(model.ties), 0]
    return found


def along_path(
    model: Assembly, carried: Sequence[Array | None], peak: int, rest: Array | None
) -> list[TieTension] | None:
    """Return the tension of each tie along a path, None where there is no tie.

    `carried`: forces (j, 3) at each point, None: not known; `peak`: which point; `rest`: forces where the path starts.
    """
    if not model.ties:
        return None
    known = [tensions(model, forces) for forces in carried if forces is not None]
    greatest = np.max(known, axis=0) if known else None
    at_peak = carried[peak]
    return [
        TieTension(
            tie=tie.name,
            rest_kN=None if rest is None else float(tensions(model, rest)[k]),
            peak_kN=None if at_peak is None else float(tensions(model, at_peak)[k]),
            greatest_kN=None if greatest is None else float(greatest[k]),
            yields=greatest is not None and bool(yielding(model, greatest)[k]),
        )
        for k, tie in enumerate(model.ties)
    ]


def while_shaken(model: Assembly, time: Array, forces: Array) -> list[ShakenTie] | None:
    """Return the greatest tension of each tie in a motion, None where there is no tie.

    `time` (k,) s; `forces` (k, j, 3) kN and kNm of the drawn contacts, ties among them.
    """
    if not model.ties:
        return None
    pulled = np.array([tensions(model, each) for each in forces])
    at, greatest = pulled.argmax(axis=0), pulled.max(axis=0)
    yields = yielding(model, greatest)
    return [
        ShakenTie(
            tie=tie.name, greatest_kN=float(greatest[k]), time_s=float(time[at[k]]), yields=bool(yields[k])
        )
        for k, tie in enumerate(model.ties)
    ]


def yielding(model: Assembly, tension: Array) -> Mask:
    """Return which ties (t,) yield under a tension (t,) kN."""
    found: Mask = tension >= YIELDS * np.array([tie.yield_force for tie in model.ties])
    return found


def lengthenings(model: Assembly, positions: Array, delta: Array) -> Array:
    """Return by how much each tie (t,) is longer under virtual displacements (b, 3) at positions (b, 3); 0: not."""
    found = np.zeros(len(model.ties))
    least = NOTICED * float(abs(delta[:, :2]).max())
    for k, (tie, blocks) in enumerate(zip(model.ties, model.tie_blocks.tolist(), strict=True)):
        ends, moved = np.zeros((2, 2)), np.zeros((2, 2))
        for end, (point, block) in enumerate(zip(tie.points, blocks, strict=True)):
            ends[end] = point + model.point_displacement(point, block, positions)
            arm = ends[end] - positions[block, :2]
            moved[end] = delta[block, :2] + delta[block, 2] * np.array([-arm[1], arm[0]])
        along = ends[1] - ends[0]
        more = float((moved[1] - moved[0]) @ along / np.hypot(*along))
        found[k] = more if more > least else 0.0
    return found
