"""The frames of a path: where the blocks are at some of its points, and what the joints carry there."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

import mechanics
from assessment.results.joint_states import Met, outlines, shares
from assessment.results.schema import DrawnTie, Frames, Results, ShakenTie, Snapshots, TieTension, finite
from mechanics import Assembly, State
from mechanics.model import Contacts
from mechanics.pictures import field, place
from mechanics.types import Array, Index, Mask

YIELDS = 1.0 - 1e-6  # of the yield force: the tension of a tie that yields
NOTICED = 1e-6  # of the largest displacement, or of the model's size: less is none
NUMBERS = 40_000  # most numbers of the frames of one path, in results.json and in the page
FEWEST, MOST = 15, 60  # frames of a static path
FEWEST_IN_TIME, MOST_IN_TIME = 24, 150
Path: TypeAlias = "mechanics.Pushdown | mechanics.Pushover"
LEAST = 1e-6  # of the model's weight: least force of a pair that met and is described
DIGITS = 6  # of the model's size and weight: positions and forces are kept for pictures


def tensions(model: Assembly, forces: Array) -> Array:
    """Return the tension (t,) kN of each tie under the forces (j, 3) of contacts: joints, ties, pairs that met."""
    first = len(model.joints.a)
    return forces[first : first + len(model.ties), 0]


@dataclass(frozen=True, eq=False)
class Carried:
    """What joints carry: forces N, P, T (j, 3), kN and kNm, of contacts, the drawn joints first."""

    contacts: Contacts
    forces: Array


def carried_along(path: Path) -> list[Carried | None]:
    """Return what joints carry at each point of a path; None: not known, as a rigid curve begins without a step.

    Where a mechanism forms it is what limit analysis has there.
    """
    steps = [Carried(step.contacts, step.forces) for step in path.steps]
    found = [*[None] * (len(path.states) - len(steps)), *steps]
    if isinstance(path, mechanics.Pushover):
        found[path.formed] = Carried(path.contacts, path.forces)
    return found


def normal_forces(path: Path) -> Array:
    """Return N (k, j), kN, of the drawn joints at each point; if not known, of mechanism or first step."""
    first = (path if isinstance(path, mechanics.Pushover) else path.steps[0]).forces
    found = [first if each is None else each.forces for each in carried_along(path)]
    return np.array([forces[: len(path.model.contacts), 0] for forces in found])


def along_path(path: Path, peak: int, rigid: bool) -> list[TieTension] | None:
    """Return the tension of each tie along a path and at its `peak`, a point of it; None where there is no tie.

    With `rigid` joints it is known where it is determined, and not at rest. With elastic ones the greatest is no less
    than the pretension, under which the tie is set.
    """
    model, carried = path.model, carried_along(path)
    if not model.ties:
        return None
    unknown = np.full(len(model.ties), np.nan)
    pulled = np.array([unknown if each is None else tensions(model, each.forces) for each in carried])
    if rigid:  # known where it is determined, not at rest
        moved = list(np.diff([state.positions for state in path.states], axis=0))
        still = np.zeros_like(path.states[0].positions)
        moved = [*(moved[:1] or [still]), *moved]
        if isinstance(path, mechanics.Pushover):
            moved[path.formed] = path.mechanism
        pulled[~determined(model, moved)] = np.nan
    greatest = np.fmax.reduce(pulled, axis=0)
    if not rigid:
        greatest = np.maximum(greatest, [tie.pretension for tie in model.ties])
    begun, ended = (path.states[at].lengthened for at in (0, -1))
    longer = (0.0 if ended is None else ended) - (np.zeros(len(model.ties)) if begun is None else begun)
    found = []
    for tie, *three, yields, more in zip(
        model.ties, unknown if rigid else pulled[0], pulled[peak], greatest, yielding(model, greatest), longer,
        strict=True,
    ):  # fmt: skip
        start, top, most = (finite(float(force)) for force in three)
        found.append(TieTension(
            tie=tie.name, rest_kN=start, peak_kN=top, greatest_kN=most, yields=bool(yields), lengthening_m=float(more)
        ))  # fmt: skip
    return found


def determined(model: Assembly, moved: Sequence[Array]) -> Mask:
    """Return in which motions (k, b, 3) the tension of each tie (k, t) is determined with rigid joints.

    It is where the two blocks of a tie move against each other: the hinges of a mechanism leave no self-stress. Between
    blocks that rest, or move as one, a tie and the joints beside it bear any self-stress that they can.
    """
    found = np.zeros((len(moved), len(model.ties)), dtype=bool)
    start = np.reshape([model.from_origin(tie.points[0]) for tie in model.ties], (-1, 2))
    length, owner = np.array([tie.taut_length for tie in model.ties]), model.tie_blocks
    for point, motion in enumerate(moved):
        least = NOTICED * float(abs(motion[:, :2]).max())
        at = field(np.repeat(start, 2, axis=0), owner.ravel(), model.initial.positions[:, :2], motion)
        apart = abs(np.diff(at.reshape(-1, 2, 2), axis=1)).max(axis=(1, 2))
        # hinges leave no self-stress, blocks that move as one any
        found[point] = np.maximum(apart, abs(np.diff(motion[owner, 2], axis=1)[:, 0]) * length) > least
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
    if rigid:  # not determined; what has lengthened up to the `final` state has yielded
        none = [None] * len(model.ties)
        yields, greatest, when = longer > NOTICED * model.size, none, none
    else:
        pulled = np.array([tensions(model, each) for each in forces])
        most = pulled.max(axis=0)
        yields = yielding(model, most) | (longer > NOTICED * model.size)
        greatest, when = most.tolist(), time[pulled.argmax(axis=0)].tolist()
    rows = zip(model.ties, greatest, when, yields.tolist(), longer.tolist(), strict=True)
    return [
        ShakenTie(tie=tie.name, greatest_kN=most, time_s=at, yields=full, lengthening_m=more)
        for tie, most, at, full, more in rows
    ]


def yielding(model: Assembly, tension: Array) -> Mask:
    """Return which ties (t,) yield under a tension (t,) kN."""
    return tension >= YIELDS * np.array([tie.yield_force for tie in model.ties])


def lengthenings(model: Assembly, positions: Array, delta: Array) -> Array:
    """Return by how much each tie (t,) is longer under virtual displacements (b, 3) at positions (b, 3); 0: not."""
    at = replace(model.initial, positions=positions)
    ends = np.array(model.tie_ends(at)).reshape(-1, 2, 2)
    middles = model.shape.centroids + model.displaced(at)[:, :2]
    found = _lengthening(ends, model.tie_blocks, middles, delta)
    return np.where(found > NOTICED * float(abs(delta[:, :2]).max()), found, 0.0)


def _lengthening(ends: Array, owner: Index, middles: Array, delta: Array) -> Array:
    """Return how much longer ties (t,) become, by ends (t, 2, 2) and blocks (t, 2); centroids at `middles` (b, 2)."""
    moved = field(ends.reshape(-1, 2), owner.ravel(), middles, delta).reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    return np.asarray(((moved[:, 1] - moved[:, 0]) * along).sum(axis=1) / np.hypot(*along.T))


def ties_of(results: Results, state: str) -> list[DrawnTie]:
    """Return the ties of a state, in the order of its tensions: those that a strengthening sets come last."""
    there = [tie for tie in results.model.ties or () if state in tie.states]
    return sorted(there, key=lambda tie: state in tie.set_in)


def tie_ends(results: Results, state: str, configuration: ArrayLike, times: float = 1.0) -> Array:
    """Return the ends (t, 2, 2) m of a state's ties where blocks are displaced by `times` a configuration (b, 3)."""
    ties = ties_of(results, state)
    ends = np.array([(tie.start_m, tie.end_m) for tie in ties]).reshape(-1, 2)
    at = np.asarray(configuration, dtype=float)
    moved = place(ends, _owner(ties).ravel(), outlines(results).centroids, at)
    return np.asarray(ends + times * (moved - ends)).reshape(-1, 2, 2)


def lengthening(results: Results, state: str, configuration: ArrayLike, rate: ArrayLike) -> Array:
    """Return by how much (t,) the ties of a state lengthen under virtual displacements (b, 3) at a configuration."""
    middles, ends = outlines(results).moved(configuration).centroids, tie_ends(results, state, configuration)
    return _lengthening(ends, _owner(ties_of(results, state)), middles, np.asarray(rate, dtype=float))


def _owner(ties: Sequence[DrawnTie]) -> Index:
    """Return the blocks (t, 2) of the ends of ties."""
    return np.array([tie.blocks for tie in ties], dtype=np.intp).reshape(-1, 2)


def path_frames(path: Path, *wanted: int, met: Met | None = None) -> Frames:
    """Describe some points of a path (see `_pictured`): first, last and `wanted` ones, others evenly between them."""
    model, carried = path.model, carried_along(path)
    kept = chosen(len(path.states), max(FEWEST, min(MOST, NUMBERS // _size(model))), wanted)
    at = [path.states[k].positions for k in kept]
    return Frames(index=kept, **_pictured(model, at, [carried[k] for k in kept], met or Met(model)))


def _size(model: Assembly) -> int:
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
        centre.append([finite(value) for value in np.round(share, 6).tolist()])
    told = {"configuration": configurations(model, np.array(positions)), "force_kN": force, "centre": centre}
    told["met"] = list(met.joints)
    if model.ties:
        pulled = [None if c is None else tensions(model, c.forces) for c in carried]
        told["tie_kN"] = [None if each is None else _rounded(each, model.weight) for each in pulled]
    return told


def snapshots(
    model: Assembly, time: Array, displacement: Array, positions: Array, forces: Array, peak: int
) -> Snapshots:
    """Describe some times (k,) s of a motion (see `_pictured`), evenly spaced, the peak among them; of drawn joints.

    `displacement` (k,) m of the control point; positions (k, b, 3); `forces` (k, j, 3), kN, kNm, of the step before.
    """
    kept = chosen(len(time), max(FEWEST_IN_TIME, min(MOST_IN_TIME, NUMBERS // _size(model))), (peak,))
    carried = [Carried(model.contacts, forces[k]) if k > 0 or forces[k].any() else None for k in kept]
    # a motion knows no forces before its first step
    found = _pictured(model, [positions[k] for k in kept], carried, Met(model))
    at = np.round(time[kept], 6).tolist()
    return Snapshots(time_s=at, displacement_m=displacement[kept].tolist(), **found)


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
