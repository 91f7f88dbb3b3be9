"""What drawings of the structure are made of: blocks, earlier outlines, ties, arrows, numbers; in black and white."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from assessment.report.figures.style import MM, Sheet, key
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.faces import outlines
from assessment.results.configurations.ties import ties_of
from assessment.results.schema import Direction, Results, Settlement
from assessment.results.table import sense
from mechanics.pictures import FAINT, INK, TIE, Bounds, Shape, place
from mechanics.types import Array

ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.8}
PLATE_MM = 2.4  # length of the plate at an end of a tie
PLATE: dict[str, Any] = {"color": INK, "linewidth": 1.8, "solid_capstyle": "butt"}
LEADER: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.4, "color": "0.3", "shrinkA": 0.0, "shrinkB": 0.0}
# of the size of a font: width of a digit, of a bold one, height of a line
LETTER, BOLD, LINE = 0.65, 0.75, 1.2
# about a place that is taken: where a number may stand
RINGS_MM, TURNS = (3.0, 5.0, 7.0, 9.0, 12.0, 16.0), 12


def ghost_handle(label: str) -> Line2D:
    """Return the legend's line of an earlier outline."""
    return key(label, color=FAINT, linewidth=0.8, linestyle=(0, (4, 2)))


def movement_arrow(page: Sheet, axes: Axes, shape: Shape, results: Results, settlement: Settlement) -> None:
    """Draw the arrow of a support's movement, and a half circle of its rotation."""
    moved = [i for i, block in enumerate(results.geometry.blocks) if block.support == settlement.support]
    x, z = shape.centroids[moved].mean(axis=0)
    dx, dz = settlement.displacement_m
    if size := float(np.hypot(dx, dz)):
        reach = page.paper(9.0) / size
        axes.annotate("", (x + reach * dx, z + reach * dz), (x, z), arrowprops=ARROW | {"lw": 1.4})
    if turn := settlement.rotation_rad:  # a half circle over the support, anticlockwise from right to left
        half = math.copysign(page.paper(5.0), turn)
        bent = {"connectionstyle": f"arc3,rad={math.copysign(1.0, turn)}"}
        axes.annotate("", (x - half, z), (x + half, z), arrowprops=ARROW | {"lw": 1.4} | bent)


def push_arrow(page: Sheet, axes: Axes, bounds: Bounds, direction: Direction) -> None:
    """Draw the arrow of the lateral loads above a model."""
    sign = sense(direction)
    x, z = (bounds[0] + bounds[2]) / 2.0, bounds[3] + page.paper(4.0)
    half = page.paper(8.0) * sign
    axes.annotate("", (x + half, z), (x - half, z), arrowprops=ARROW | {"lw": 1.2})
    text, side = f"α ({direction_name(direction)})", "left" if sign > 0 else "right"
    axes.annotate(text, (x + half, z), (4.0 * sign, 0.0), textcoords="offset points", ha=side, va="center")


def draw_ties(page: Sheet, axes: Axes, ends: Iterable[Array]) -> None:
    """Draw ties by their ends (2, 2) m, each with its two plates."""
    for start, end in ends:
        axes.plot([start[0], end[0]], [start[1], end[1]], **TIE)
        along = (end - start) / max(float(np.hypot(*(end - start))), 1e-12)
        half = 0.5 * page.paper(PLATE_MM) * np.array([-along[1], along[0]])
        for point in (start, end):
            axes.plot(*np.array([point - half, point + half]).T, **PLATE)


def tie_handles(results: Results, words: Words, *states: str) -> list[Line2D]:
    """Return the legend of ties, nothing where none of the states has one."""
    there = any(ties_of(results, state) for state in states)
    return [key(words.plain("figure.tie"), **TIE)] if there else []


def moved_ends(results: Results, state: str, configuration: Any, times: float = 1.0) -> Iterator[Array]:
    """Yield the ends (2, 2) m of the ties of a state where blocks are displaced by `times` a configuration (b, 3)."""
    drawn, at = outlines(results), np.asarray(configuration, dtype=float)
    for tie in ties_of(results, state):
        ends = np.array([tie.start_m, tie.end_m])
        yield ends + times * (place(ends, np.array(tie.blocks), drawn.centroids, at) - ends)


class Labels:
    """Numbers written into a panel: inside its axes, and never on one another; lengths in m of the model."""

    def __init__(self, page: Sheet, axes: Axes) -> None:
        self.page, self.axes = page, axes
        self.taken: list[Array] = []  # x0, z0, x1, z1

    def write(self, text: str, places: Iterable[Array], **style: Any) -> bool:
        """Write a text at the first of the places (2,) that is free, else beside one of them with a leader to it.

        Return whether there was room for it.
        """
        half = self._half(text, style)
        wanted = [np.asarray(place, dtype=float) for place in places]
        spots: list[tuple[Array, Array | None]] = [(at, None) for at in wanted]
        turns = np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False)
        ways = self.page.paper(1.0) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        spots += [(target + ring * way, target) for target in wanted for ring in RINGS_MM for way in ways]
        for at, target in spots:
            if self._is_free(at, half):
                led: dict[str, Any] = {} if target is None else {"arrowprops": LEADER, "xytext": tuple(at)}
                self._take(at, half)
                self._text(text, at if target is None else target, **led, **style)
                return True
        return False

    def put(self, text: str, place: Array, **style: Any) -> None:
        """Write a text at a place (2,) that is its own, such as the inside of a block, whatever is there."""
        self._take(place, self._half(text, style))
        self._text(text, place, **style)

    def avoid(self, places: Array, points: float) -> None:
        """Keep texts off marks (n, 2) of a size in points."""
        for at in places:
            self._take(at, 0.5 * self.page.paper(points / 72.0 / MM))

    def _text(self, text: str, place: Array, **style: Any) -> None:
        x, z = place.tolist()
        self.axes.annotate(text, (x, z), ha="center", va="center", **style)

    def _half(self, text: str, style: Mapping[str, Any]) -> Array:
        """Return half the width and height (2,) of a text."""
        points = float(style.get("fontsize", 7.5))
        pad = 2.0 * float((style.get("bbox") or {}).get("pad", 0.0))
        letter = BOLD if style.get("fontweight") == "bold" else LETTER
        size = np.array([letter * points * len(text) + pad, LINE * points + pad])
        return np.asarray(0.5 * self.page.paper(1.0 / 72.0 / MM) * size)

    def _take(self, at: Array, half: Array | float) -> None:
        self.taken.append(np.concatenate([at - half, at + half]))

    def _is_free(self, at: Array, half: Array) -> bool:
        """Whether a box is inside the axes and on no other."""
        low, high = at - half, at + half
        (x0, x1), (z0, z1) = self.axes.get_xlim(), self.axes.get_ylim()
        inside = x0 <= low[0] and z0 <= low[1] and high[0] <= x1 and high[1] <= z1
        return inside and not any((low < box[2:]).all() and (box[:2] < high).all() for box in self.taken)
