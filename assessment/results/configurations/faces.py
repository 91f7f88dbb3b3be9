"""Outlines of the blocks and faces of the joints: where they are as drawn and in a configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from assessment.results.numbers import finite
from assessment.results.schema import Face, Results
from mechanics import Assembly
from mechanics.model import Contacts, FaceLines, H, face_lines, kinematic_contacts
from mechanics.pictures import Shape
from mechanics.types import Array, Index, Mask


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
        friction = finite(
            min(model.blocks[block].material.friction for block in (a, b))
        )  # JSON has no infinity
        limits: dict[str, Any] = {"friction": friction, "depth_m": thin}
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
    """Joints of the results, ready for their kinematics.

    `contacts`: their faces and friction; `centroids` (b, 2) m as drawn; `depth` (m) and `strength` (kN/m²) (j,),
    infinite where there is no limit. `drawn`: how many of them are joints of the drawing; the others met as blocks
    moved, and their slips have no start to count from.
    """

    contacts: Contacts
    centroids: Array
    depth: Array
    strength: Array
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
        lines,
        np.array([joint.blocks for joint in joints], dtype=np.intp).reshape(-1, 2),
        centroids,
        _limits([joint.friction for joint in joints]),
        geometry.joint_tolerance_m,
        len(geometry.joints),
    )
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
    told = (
        (block.vertices_m, block.centroid_m, block.support is not None) for block in results.geometry.blocks
    )
    return Shape.of(*zip(*told, strict=True))
