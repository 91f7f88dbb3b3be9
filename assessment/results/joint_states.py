"""What the joints of a state carry, and how: resultants, where they cross, contact, pressure, opening and slip."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from assessment.results.schema import Behaviour, Direction, Face, Frames, Results, StateResults, finite
from mechanics import Assembly
from mechanics.model import (
    NX,
    NZ,
    Contacts,
    FaceLines,
    H,
    V,
    end_gaps,
    end_points,
    face_lines,
    kinematic_contacts,
)
from mechanics.pictures import Shape, through_blocks
from mechanics.types import Array, Index, Mask

IDLE = 1e-6  # of the model's weight: a joint that carries less carries nothing
EDGE = 0.02  # of the joint's length: a resultant so near its end makes a hinge
FRICTION = 0.99  # of μN: a joint about to slide
# the resultant within the middle third (the whole joint presses), outside it, at an edge, on the cone of friction; idle
CONDITIONS = ("whole", "partial", "edge", "sliding", "idle")


def described(model: Assembly, contacts: Contacts) -> list[Face]:
    """Describe pairs of faces (m, as drawn): of either block start and end along the common direction, and a middle.

    The `middle_m` of each face are the points from which slips count; of drawn joints they are one.
    """
    depth = np.array([block.depth for block in model.blocks])
    lines = face_lines(contacts, model.as_drawn(model.initial.positions[:, :2]))
    found = []
    for a, b, ends, middle, strength in zip(
        contacts.a, contacts.b, lines.ends, lines.middle, contacts.strength, strict=True
    ):
        thin = float(min(depth[a], depth[b]))
        friction = min(model.blocks[each].material.friction for each in (a, b))
        limits: dict[str, Any] = {"friction": finite(friction), "depth_m": thin}  # JSON has no infinity
        limits["compressive_strength_kN_m2"] = finite(float(strength) / thin)
        lines_m = {"middle_m": middle.tolist(), "faces_m": ends.tolist()}
        found.append(Face(blocks=[int(a), int(b)], **lines_m, **limits))
    return found


class Met:
    """Pairs of faces that met on a path although they did not touch as drawn, in the order in which they did."""

    def __init__(self, model: Assembly) -> None:
        self.model, self.drawn = model, len(model.joints.a)
        self.later = len(model.contacts)  # ties come between
        self.place: dict[tuple[int, ...], int] = {}
        self.joints: list[Face] = []

    def numbers(self, contacts: Contacts, wanted: Mask) -> Index:
        """Return the number (j,) of each of the contacts among drawn joints and met pairs; −1 of others, and of ties.

        `wanted` (j,): which pairs count as met.
        """
        found = np.full(len(contacts), -1, dtype=np.intp)
        found[: self.drawn] = np.arange(self.drawn)
        for k in np.flatnonzero(wanted[self.later :]) + self.later:
            pair = tuple(contacts.edges[k].tolist())
            if pair not in self.place:
                self.place[pair] = self.drawn + len(self.joints)
                self.joints += described(self.model, contacts.take(np.array([k])))
            found[k] = self.place[pair]
        return found


@dataclass(frozen=True, eq=False)
class Faces:
    """Joints of the results, ready for their kinematics."""

    contacts: Contacts  # their faces and friction
    centroids: Array  # (b, 2) m as drawn
    depth: Array  # (j,) m
    strength: Array  # (j,) kN/m², infinite where there is no limit
    # how many are joints of the drawing; the others met as blocks moved, and their slips have no start to count from
    drawn: int

    def positions(self, configuration: Array) -> Array:
        """Positions (b, 3) of blocks displaced by a configuration (b, 3)."""
        return np.column_stack([self.centroids, np.zeros(len(self.centroids))]) + configuration


def faces_of(results: Results, met: Sequence[Face] = ()) -> Faces:
    """Return the joints of the results, then those of a path's `met`."""
    geometry = results.geometry
    joints: list[Face] = [*geometry.joints, *met]
    centroids = np.array([block.centroid_m for block in geometry.blocks], dtype=float)
    lines = FaceLines(
        ends=np.array([joint.faces_m for joint in joints], dtype=float).reshape(-1, 2, 2, 2),
        middle=np.array([joint.middle_m for joint in joints], dtype=float).reshape(-1, 2, 2),
    )
    contacts = kinematic_contacts(
        lines, np.array([joint.blocks for joint in joints], dtype=np.intp).reshape(-1, 2), centroids,
        _limits([joint.friction for joint in joints]), geometry.joint_tolerance_m, len(geometry.joints),
    )  # fmt: skip
    depth = np.array([joint.depth_m for joint in joints], dtype=float)
    strength = _limits([joint.compressive_strength_kN_m2 for joint in joints])
    return Faces(contacts, centroids, depth, strength, len(geometry.joints))


def _limits(given: Sequence[float | None]) -> Array:
    """Return values (j,), infinite where there is no limit."""
    return np.array([np.inf if value is None else value for value in given], dtype=float)


def shares(places: Array, forces: Array) -> Array:
    """Return where N presses (j,), as a share of the overlap from its first end; NaN where nothing does."""
    half, normal = places[:, H], forces[:, 0]
    presses = (normal > 0.0) & (half > 0.0)
    found = np.full(len(forces), np.nan)
    found[presses] = np.clip(0.5 + 0.5 * forces[presses, 1] / (normal[presses] * half[presses]), 0.0, 1.0)
    return found


def outlines(results: Results) -> Shape:
    """Return the outlines of the blocks in the drawing position."""
    told = ((each.vertices_m, each.centroid_m, each.support is not None) for each in results.geometry.blocks)
    return Shape.of(*zip(*told, strict=True))


@dataclass(frozen=True)
class Situation:
    """A state in equilibrium whose joint forces are known: at rest (`direction` None), or as a mechanism begins."""

    state: str
    direction: Direction | None
    contacts: Behaviour  # the behaviour
    alpha: float  # the multiplier
    configuration: Array  # (b, 3)
    force: Array  # (j, 2) kN: N and T, of drawn joints and those `met`
    centre: Array  # (j,), as a share of the overlap
    met: Sequence[Face]
    tension: Array = field(default_factory=lambda: np.zeros(0))  # (t,) kN of the ties


@dataclass(frozen=True)
class JointStates:
    """The joints in a situation, the drawn ones and then those that met."""

    blocks: Index  # (j, 2)
    ends: Array  # (j, 2, 2) m of where the faces overlap now, midway between them
    point: Array  # (j, 2) where the resultant crosses
    force: Array  # (j, 2) kN, x and z, on the first block
    normal: Array  # (j,) kN, compression positive
    shear: Array  # (j,) kN
    eccentricity: Array  # (j,) m from the middle of the overlap
    # (j,) m, the length that presses, and kN/m² at its edge: a linear bed without tension that crushes at its strength
    contact: Array
    pressure: Array  # infinite in a hinge at the very edge
    uncrushed: Array  # (j,): the same without strength
    opening: Array  # (j, 2) m at the two ends, NaN where faces have slid off each other
    slip: Array  # (j,) m, NaN for those that met
    condition: list[str]  # (j,) of CONDITIONS


def situations(results: Results) -> Iterator[Situation]:
    """Yield the rest of every state and the onset of every mechanism, where the forces were kept."""
    for name, state in results.states.items():
        yield from _rest(name, state)
        for direction, pushover in state.pushover.items():
            if rigid := pushover.rigid:
                point = rigid.mechanism.point
                alpha = rigid.curve.multiplier[point]
                yield from _at(name, direction, "rigid", alpha, rigid.frames, point)


def loaded(results: Results) -> Iterator[Situation]:
    """Yield the situations and, with elastic joints, the peak of every pushover."""
    yield from situations(results)
    for name, state in results.states.items():
        for direction, pushover in state.pushover.items():
            if elastic := pushover.elastic:
                yield from _at(name, direction, "elastic", elastic.alpha_u, elastic.frames, elastic.peak)


def _rest(name: str, state: StateResults) -> Iterator[Situation]:
    """Yield the rest under gravity: with elastic joints if it can be, where forces are determined."""
    for pushover in state.pushover.values():
        if pushover.elastic:
            yield from _at(name, None, "elastic", 0.0, pushover.elastic.frames, 0)
            return
    for contacts, path in sorted(state.pushdown.items()):  # elastic before rigid
        asked = int(np.argmin(abs(np.asarray(path.movement_m) - path.applied_movement_m)))
        yield from _at(name, None, contacts, 0.0, path.frames, asked)
        return


def _at(
    name: str, direction: Direction | None, contacts: Behaviour, alpha: float, frames: Frames, point: int
) -> Iterator[Situation]:
    kept = frames.index.index(point)
    if frames.force_kN[kept] is not None:
        at = np.array(frames.configuration[kept], dtype=float)
        force, centre = (np.array(each[kept], dtype=float) for each in (frames.force_kN, frames.centre))
        tension = np.array((frames.tie_kN[kept] if frames.tie_kN else None) or [], dtype=float)
        yield Situation(name, direction, contacts, alpha, at, force, centre, frames.met, tension)


def joint_states(results: Results, situation: Situation) -> JointStates:
    """Derive what the joints do from the forces and the configuration of a situation."""
    return states_of(faces_of(results, situation.met), results.model.weight_kN, situation)


def states_of(faces: Faces, weight: float, situation: Situation) -> JointStates:
    """Derive the same from the faces of the situation's joints and the weight (kN) of the model."""
    contacts, positions = faces.contacts, faces.positions(situation.configuration)
    places = contacts.places(positions)
    ends = end_points(contacts, positions)
    n = places[:, [NX, NZ]]
    t = np.stack([n[:, 1], -n[:, 0]], axis=1)
    N, T = situation.force.T
    share = np.where(np.isfinite(situation.centre), situation.centre, 0.5)
    overlap = 2.0 * places[:, H]
    idle = ~(IDLE * weight < N) | (overlap <= 0.0)
    carried = np.where(idle, 0.0, N)
    near = np.minimum(share, 1.0 - share) * overlap
    contact, pressure = pressed(carried / faces.depth, near, overlap, faces.strength)
    uncrushed = pressed(carried / faces.depth, near, overlap, np.full(len(contacts), np.inf))[1]
    conditions = {
        "idle": idle, "sliding": abs(T) > contacts.friction * np.maximum(FRICTION * N, 1e-99),
        "edge": abs(share - 0.5) > 0.5 - EDGE, "partial": abs(share - 0.5) > 1.0 / 6.0,
    }  # fmt: skip
    condition = np.select(list(conditions.values()), list(conditions), "whole").tolist()
    point = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    force, eccentricity = N[:, None] * n + T[:, None] * t, np.where(idle, np.nan, (share - 0.5) * overlap)
    opening = np.where((overlap > 0.0)[:, None], end_gaps(places), np.nan)
    slip = np.where(np.arange(len(contacts)) < faces.drawn, places[:, V], np.nan)
    carries = (N, T, eccentricity, contact, pressure, uncrushed)
    blocks = np.stack([contacts.a, contacts.b], axis=1)
    return JointStates(blocks, ends, point, force, *carries, opening, slip, condition)


def pressed(normal: Array, near: Array, length: Array, strength: Array) -> tuple[Array, Array]:
    """Return the length (j,), m, that presses, and the pressure (j,), kN/m², at its edge, of a bed without tension.

    `normal` (kN/m) acts `near` (m) the end of a joint of `length` (m); beyond `strength` (kN/m²) it crushes, the full
    strength over some length and then linearly less. A joint that carries nothing has no pressure.
    """
    carries = normal > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        partial = 3.0 * near < length
        whole = normal / length * (1.0 + 6.0 * (0.5 - near / length))
        linear = np.where(partial, 2.0 * normal / (3.0 * near), whole)
        block = normal / strength  # the length that would press with the full strength
        crushed = block + np.sqrt(np.maximum(6.0 * (near * block - 0.5 * block**2), 0.0))
    reach = np.minimum(np.where(linear > strength, crushed, 3.0 * near), length)
    return np.where(carries, reach, 0.0), np.where(carries, np.minimum(linear, strength), 0.0)


def thrust_lines(states: JointStates) -> list[Array]:
    """Return a line (2, 2) m through each block that exactly two joints load."""
    return through_blocks(states.blocks, states.point, [each != "idle" for each in states.condition])
