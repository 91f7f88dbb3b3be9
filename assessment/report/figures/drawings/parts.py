"""What drawings of the structure are made of: blocks, earlier outlines, ties, arrows, numbers; in black and white."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from assessment.report.figures.style import Panels, key
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.frames import ties_of
from assessment.results.configurations.joint_states import outlines
from assessment.results.schema import Direction, Results, Settlement
from assessment.results.table import sense
from mechanics.pictures import FAINT, INK, TIE, Bounds, Shape, place
from mechanics.types import Array

ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.8}
PLATE_MM = 2.4  # length of the plate at an end of a tie
PLATE: dict[str, Any] = {"color": INK, "linewidth": 1.8, "solid_capstyle": "butt"}


def ghost_handle(label: str) -> Line2D:
    """Return the legend's line of an earlier outline."""
    return key(label, color=FAINT, linewidth=0.8, linestyle=(0, (4, 2)))


def movement_arrow(page: Panels, axes: Axes, shape: Shape, results: Results, settlement: Settlement) -> None:
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


def push_arrow(page: Panels, axes: Axes, bounds: Bounds, direction: Direction) -> None:
    """Draw the arrow of the lateral loads above a model."""
    sign = sense(direction)
    x, z = (bounds[0] + bounds[2]) / 2.0, bounds[3] + page.paper(4.0)
    half = page.paper(8.0) * sign
    axes.annotate("", (x + half, z), (x - half, z), arrowprops=ARROW | {"lw": 1.2})
    text, side = f"α ({direction_name(direction)})", "left" if sign > 0 else "right"
    axes.annotate(text, (x + half, z), (4.0 * sign, 0.0), textcoords="offset points", ha=side, va="center")


def draw_ties(page: Panels, axes: Axes, ends: Iterable[Array]) -> None:
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


def write_number(
    axes: Axes, text: str, at: Array, away: tuple[float, float] = (0.0, 0.0), **style: Any
) -> None:
    """Write a number at a place (2,) m, or so many points away from it."""
    place: Any = {"textcoords": "offset points", "ha": "center", "va": "center", "annotation_clip": False}
    axes.annotate(text, (at[0], at[1]), away, **place, **style)
