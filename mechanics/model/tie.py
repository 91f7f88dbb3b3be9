"""A tie rod between two blocks, and the contact that it is to the program.

A tie is a joint whose normal is its own line: its tension is N, its elongation the closing of the joint, its yielding
the crushing. It has no face: P and T are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import is_between, point_of, require, require_positive
from mechanics.kernels.joint import A1, A2, B1, B2, FACE, LENGTH, MEET, PX, PZ, QX, QZ
from mechanics.model.contacts import Contacts, shorter_face
from mechanics.types import Array, Index

ACROSS = 1e-7  # of the tension: a force across the tie, without which the cone of friction had no inside
RIGID = 10.0  # times the stiffest joint: a rigid tie in analyses with elastic joints


@dataclass(frozen=True, eq=False)
class Tie:
    """A straight tie between two points (x, z) m as drawn, each in or on a block: it pulls, and never pushes.

    `yield_force` (kN): it lengthens under that without bearing more; `stiffness` (kN/m) of the whole tie, None: rigid;
    `pretension` (kN): its tension at its `length` (m), None: that as drawn. Stiffness and pretension count in analyses
    with elastic joints; with rigid joints the tie is inextensible up to its yield force: a self-stress does not change
    what a rigid structure bears. Raises ArgumentError naming the argument.
    """

    name: str
    start: ArrayLike
    end: ArrayLike
    yield_force: float = float("inf")
    stiffness: float | None = None
    pretension: float = 0.0
    length: float | None = None

    def __post_init__(self) -> None:
        require(isinstance(self.name, str) and bool(self.name), "name", self.name, "the name of the tie")
        for key in ("start", "end"):
            object.__setattr__(self, key, point_of(key, getattr(self, key)))
        require_positive(self, "(]", yield_force="positive, in kN (inf: it does not yield)")
        require_positive(self, stiffness="positive, in kN/m, or None")
        fits = is_between(self.pretension, 0.0, self.yield_force, "[)")
        require(fits, "pretension", self.pretension, "from zero to less than yield_force, in kN")
        drawn = float(np.hypot(*(self.points[1] - self.points[0])))
        require(drawn > 0.0, "end", self.end, "another point than start")
        if self.length is None:
            object.__setattr__(self, "length", drawn)
        require_positive(self, length="positive, in m")

    @property
    def points(self) -> Array:
        """Both ends (2, 2) m as drawn."""
        return np.stack([self.start, self.end])

    @property
    def taut_length(self) -> float:
        """The length (m) at which it has its pretension: the one given, or that as drawn."""
        assert self.length is not None
        return self.length


def tie_contacts(
    ties: Sequence[Tie], ends: Array, blocks: Index, centroid: Array, drawn: Contacts
) -> Contacts:
    """Return the contacts of ties with `ends` (t, 2, 2) m in the `blocks` (t, 2), beside the `drawn` joints.

    Ends and the centroids (b, 2) m of all blocks count from one origin.

    Their length along the joint is 1 m: bed and strength are stiffness and yield force. A rigid one is as stiff as
    RIGID times the stiffest joint where joints are elastic.
    """
    count = len(ties)
    faces = np.zeros((count, FACE))
    faces[:, [PX, PZ]], faces[:, [QX, QZ]] = (
        ends[:, 0] - centroid[blocks[:, 0]],
        ends[:, 1] - centroid[blocks[:, 1]],
    )
    faces[:, [A1, B1]], faces[:, [A2, B2]], faces[:, MEET] = -0.5, 0.5, 1.0
    joint = drawn.bed * shorter_face(drawn.faces)
    stiffest = RIGID * float(joint.max()) if len(joint) and not np.isnan(joint).any() else 1.0
    faces[:, LENGTH] = [tie.taut_length for tie in ties]
    number = np.arange(count)
    return Contacts(
        a=blocks[:, 0],
        b=blocks[:, 1],
        faces=faces,
        friction=np.full(count, ACROSS),
        bed=np.array([tie.stiffness or stiffest for tie in ties]).reshape(count),
        shear=np.full(count, np.inf),
        strength=np.array([tie.yield_force for tie in ties]).reshape(count),
        segments=np.zeros(count, dtype=np.intp),
        edges=np.stack([-1 - number, -1 - number], axis=1),  # no edges of blocks: numbers of its own
        tolerance=drawn.tolerance,
    )
