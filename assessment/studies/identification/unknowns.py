"""The unknowns of a hypothesis, all as lengths, and the directions in which a search for them begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from mechanics.messages import Message, linked, message
from mechanics.procedures import SupportMovement
from mechanics.types import Array, Mask

COMPONENTS = ("x", "z", "rotation")
WORDS: dict[str, str] = {"x": "x", "z": "z", "rotation": message("rotation")}
TOGETHER = 3  # unknowns that a direction of the search moves at once; where there are more, pairs


@dataclass(frozen=True)
class Unknowns:
    """The unknown components (support, component) of a hypothesis; `lever` (m): the arc of a rotation of 1 rad.

    Their values u (n,) are lengths, m: of a rotation the arc at the lever. `downward_only`: z is not positive.
    """

    components: tuple[tuple[str, str], ...]
    lever: float
    downward_only: bool

    def __len__(self) -> int:
        return len(self.components)

    @property
    def title(self) -> Message:
        """The hypothesis in words: "right: x, z, rotation"."""
        return linked(
            [
                message(
                    "{name}: {components}",
                    name=support,
                    components=[WORDS[name] for other, name in self.components if other == support],
                )
                for support in self.supports
            ]
        )

    @property
    def supports(self) -> tuple[str, ...]:
        """The supports that move."""
        return tuple(dict.fromkeys(support for support, _ in self.components))

    @property
    def size(self) -> Array:
        """Length (n,) of a unit of each unknown: 1 for m, the lever for rad."""
        return np.array([self.lever if name == "rotation" else 1.0 for _, name in self.components])

    @property
    def falling(self) -> Mask:
        """Which unknowns (n,) may not be positive."""
        return np.array([self.downward_only and name == "z" for _, name in self.components])

    def bounded(self, u: Array) -> Array:
        """Return the values within the bounds."""
        return np.where(self.falling, np.minimum(u, 0.0), u)

    def movements(self, u: Array) -> tuple[SupportMovement, ...]:
        """Return the movement of each support at values u (n,), m; of none, 0 has no sign."""
        value = {each: float(v) + 0.0 for each, v in zip(self.components, u / self.size, strict=True)}
        return tuple(
            SupportMovement(
                support,
                (value.get((support, "x"), 0.0), value.get((support, "z"), 0.0)),
                value.get((support, "rotation"), 0.0),
            )
            for support in self.supports
        )

    def directions(self) -> list[Array]:
        """Return unit vectors (n,): every sign of one unknown alone and of several together, within the bounds."""
        most = TOGETHER if len(self) <= TOGETHER else 2
        found = []
        for signs in product((0.0, 1.0, -1.0), repeat=len(self)):
            u = np.array(signs)
            if 0 < np.count_nonzero(u) <= most and (self.bounded(u) == u).all():
                found.append(u / np.linalg.norm(u))
        return found


def unknowns_of(hypothesis: Mapping[str, Sequence[str]], lever: float, downward_only: bool) -> Unknowns:
    """Return the unknowns of a hypothesis of the project file: its supports, each with its components."""
    components = tuple(
        (support, name) for support in hypothesis for name in COMPONENTS if name in hypothesis[support]
    )
    return Unknowns(components, lever, downward_only)
