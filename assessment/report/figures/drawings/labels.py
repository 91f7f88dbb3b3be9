"""Numbers written into a drawing: inside its axes, and never on one another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from assessment.report.figures.style import Sheet
from assessment.results.configurations.outlines import Array

POINT_MM = 25.4 / 72.0
LETTER, LINE = 0.65, 1.2  # of the size of a font: the width of a digit and the height of a line
BOLD = 0.75  # likewise the width of a bold letter or digit
RINGS_MM = (
    3.0,
    5.0,
    7.0,
    9.0,
    12.0,
    16.0,
)  # about a place that is taken, where a number with a leader may stand
TURNS = 12
LEADER: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.4, "color": "0.3", "shrinkA": 0.0, "shrinkB": 0.0}


class Labels:
    """The boxes that are taken on one panel; lengths in m of the model."""

    def __init__(self, page: Sheet, axes: Axes) -> None:
        self.page, self.axes = page, axes
        self.taken: list[Array] = []  # x0, z0, x1, z1

    def write(self, text: str, places: Iterable[Array], **style: Any) -> bool:
        """Write a text at the first of the places (2,) that is free, else beside one of them with a leader to it.

        Return whether there was room for it.
        """
        half = 0.5 * self._size(text, float(style.get("fontsize", 7.5)), style)
        wanted = [np.asarray(place, dtype=float) for place in places]
        for at in wanted:
            if self._take(at, half):
                self.axes.annotate(text, tuple(at), ha="center", va="center", **style)
                return True
        for target, at in ((place, at) for place in wanted for at in self._around(place)):
            if self._take(at, half):
                self.axes.annotate(
                    text, tuple(target), tuple(at), ha="center", va="center", arrowprops=LEADER, **style
                )
                return True
        return False

    def avoid(self, places: Array, points: float) -> None:
        """Keep texts off marks (n, 2) of a size in points."""
        half = 0.5 * self.page.paper(points * POINT_MM)
        self.taken += [np.concatenate([place - half, place + half]) for place in places]

    def put(self, text: str, place: Array, **style: Any) -> None:
        """Write a text at a place (2,) that is its own, such as the inside of a block, whatever is there."""
        half = 0.5 * self._size(text, float(style.get("fontsize", 7.5)), style)
        self.taken.append(np.concatenate([place - half, place + half]))
        self.axes.annotate(text, (float(place[0]), float(place[1])), ha="center", va="center", **style)

    def _size(self, text: str, points: float, style: Mapping[str, Any]) -> Array:
        pad = 2.0 * float((style.get("bbox") or {}).get("pad", 0.0))
        letter = BOLD if style.get("fontweight") == "bold" else LETTER
        width = (letter * points * len(text) + pad) * POINT_MM
        return np.array([self.page.paper(width), self.page.paper((LINE * points + pad) * POINT_MM)])

    def _around(self, place: Array) -> Iterator[Array]:
        for radius in RINGS_MM:
            for turn in np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False):
                yield place + self.page.paper(radius) * np.array([np.cos(turn), np.sin(turn)])

    def _take(self, at: Array, half: Array) -> bool:
        box = np.concatenate([at - half, at + half])
        (x0, x1), (z0, z1) = self.axes.get_xlim(), self.axes.get_ylim()
        inside = x0 <= box[0] and z0 <= box[1] and box[2] <= x1 and box[3] <= z1
        if not inside or any(_meet(box, other) for other in self.taken):
            return False
        self.taken.append(box)
        return True


def _meet(box: Sequence[float] | Array, other: Sequence[float] | Array) -> bool:
    return bool(box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3])
