"""Ties: which are in a state and where their ends are, their tension along a path, how they lengthen in a mechanism."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from assessment.results.configurations.faces import outlines
from assessment.results.numbers import finite
from assessment.results.schema import Results, ShakenTie, Tie, TieTension
from mechanics import Assembly, State
from mechanics.pictures import field, place
from mechanics.types import Array, Mask

YIELDS = 1.0 - 1e-6  # of the yield force: the tension of a tie that yields
NOTICED = 1e-6  # of the largest displacement, or of the model's size: less is none


def tensions(model: Assembly, forces: Array) -> Array:
    """Return the tension (t,) kN of each tie under the forces (j, 3) of contacts: joints, ties, pairs that met."""
    first = len(model.joints.a)
    found: Array = forces[first : first + len(model.ties), 0]
    return found


def along_path(
    model: Assembly, carried: Sequence[Array | None], peak: int, rest: Array | None, known: Mask | None = None
) -> list[TieTension] | None:
    """Return the tension of each tie along a path, None where there is no tie.

    `carried`: forces (j, 3) at each point, None: not known; `peak`: which point; `rest`: forces where the path starts;
    `known` (k, t): at which points the tension of a tie is determined, default at all.
    """
    if not model.ties:
        return None
    pulled = np.full((len(carried), len(model.ties)), np.nan)
    for point, forces in enumerate(carried):
        if forces is not None:
            pulled[point] = tensions(model, forces)
    if known is not None:
        pulled[~known] = np.nan
    greatest = np.fmax.reduce(pulled, axis=0)
    at_rest = np.full(len(model.ties), np.nan) if rest is None else tensions(model, rest)
    found = []
    for tie, *three, yields in zip(
        model.ties, at_rest, pulled[peak], greatest, yielding(model, greatest), strict=True
    ):
        start, top, most = (finite(float(force)) for force in three)
        found.append(
            TieTension(tie=tie.name, rest_kN=start, peak_kN=top, greatest_kN=most, yields=bool(yields))
        )
    return found


def determined(model: Assembly, moved: Sequence[Array]) -> Mask:
    """Return in which motions (k, b, 3) the tension of each tie (k, t) is determined with rigid joints.

    It is where the two blocks of a tie move against each other: the hinges of a mechanism leave no self-stress. Between
    blocks that rest, or move as one, a tie and the joints beside it bear any self-stress that they can.
    """
    found = np.zeros((len(moved), len(model.ties)), dtype=bool)
    for point, motion in enumerate(moved):
        least = NOTICED * float(abs(motion[:, :2]).max())
        for k, (tie, (a, b)) in enumerate(zip(model.ties, model.tie_blocks.tolist(), strict=True)):
            arm = model.from_origin(tie.points[0]) - model.initial.positions[[a, b], :2]
            at = [
                motion[block, :2] + motion[block, 2] * np.array([-z, x])
                for block, (x, z) in zip((a, b), arm, strict=True)
            ]
            turn = abs(motion[a, 2] - motion[b, 2]) * tie.taut_length
            found[point, k] = max(float(abs(at[0] - at[1]).max()), float(turn)) > least
    return found


def while_shaken(
    model: Assembly, time: Array, forces: Array, final: State, rigid: bool
) -> list[ShakenTie] | None:
    """Return the greatest tension of each tie in a motion, None where there is no tie.

    `time` (k,) s; `forces` (k, j, 3) kN and kNm of the drawn contacts, ties among them; `final`: the state at the end.
    With `rigid` joints the tension is not determined, and a tie that has lengthened has yielded.
    """
    if not model.ties:
        return None
    longer = np.zeros(len(model.ties)) if final.lengthened is None else final.lengthened
    if rigid:
        none = {"greatest_kN": None, "time_s": None}
        lengthened = zip(model.ties, longer > NOTICED * model.size, strict=True)
        return [ShakenTie(tie=tie.name, yields=bool(more), **none) for tie, more in lengthened]
    pulled = np.array([tensions(model, each) for each in forces])
    at, greatest = pulled.argmax(axis=0), pulled.max(axis=0)
    yields = yielding(model, greatest) | (longer > NOTICED * model.size)
    rows = zip(model.ties, greatest.tolist(), time[at].tolist(), yields.tolist(), strict=True)
    return [
        ShakenTie(tie=tie.name, greatest_kN=most, time_s=when, yields=full) for tie, most, when, full in rows
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
            ends[end] = model.from_origin(point) + model.point_displacement(point, block, positions)
            arm = ends[end] - positions[block, :2]
            moved[end] = delta[block, :2] + delta[block, 2] * np.array([-arm[1], arm[0]])
        along = ends[1] - ends[0]
        more = float((moved[1] - moved[0]) @ along / np.hypot(*along))
        found[k] = more if more > least else 0.0
    return found


def ties_of(results: Results, state: str) -> list[Tie]:
    """Return the ties of a state, in the order of its tensions: those that a strengthening sets come last."""
    there = [tie for tie in results.model.ties or () if state in tie.states]
    return sorted(there, key=lambda tie: state in tie.set_in)


def tie_ends(results: Results, tie: Tie, configuration: ArrayLike) -> Array:
    """Return both ends (2, 2) m of a tie where the blocks are displaced by a configuration (b, 3)."""
    at = np.asarray(configuration, dtype=float)
    return place(np.array([tie.start_m, tie.end_m]), np.array(tie.blocks), outlines(results).centroids, at)


def lengthening(results: Results, tie: Tie, configuration: ArrayLike, rate: ArrayLike) -> float:
    """Return the virtual lengthening of a tie under virtual displacements (b, 3) at a configuration (b, 3)."""
    drawn = outlines(results)
    shape = drawn.moved(configuration)
    ends, owner = tie_ends(results, tie, configuration), np.array(tie.blocks)
    moved = field(ends, owner, shape.centroids, np.asarray(rate, dtype=float))
    along = ends[1] - ends[0]
    return float((moved[1] - moved[0]) @ along / np.hypot(*along))
