"""Ties in drawings: a line between their ends, a plate at each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from assessment.report.figures.style import Sheet
from assessment.report.text.language import Words
from assessment.results.configurations.outlines import Array, Outlines, outlines, place
from assessment.results.configurations.tie_ends import ties_of
from assessment.results.schema import Results
from assessment.results.schema.model import Tie

PLATE_MM = 2.4  # length of the plate at an end
LINE: dict[str, Any] = {"color": "0.0", "linewidth": 1.1, "linestyle": (0, (7, 1.2, 1.5, 1.2))}
PLATE: dict[str, Any] = {"color": "0.0", "linewidth": 1.8, "solid_capstyle": "butt"}


def draw_ties(page: Sheet, axes: Axes, ends: Iterator[Array]) -> None:
    """Draw ties by their ends (2, 2) m, each with its two plates."""
    for start, end in ends:
        axes.plot([start[0], end[0]], [start[1], end[1]], **LINE)
        along = (end - start) / max(float(np.hypot(*(end - start))), 1e-12)
        half = 0.5 * page.paper(PLATE_MM) * np.array([-along[1], along[0]])
        for point in (start, end):
            axes.plot(*np.array([point - half, point + half]).T, **PLATE)


def tie_handles(results: Results, words: Words, *states: str) -> list[Line2D]:
    """Return the legend of ties, nothing where none of the states has one."""
    there = any(ties_of(results, state) for state in states)
    return [Line2D([], [], **LINE, label=words.plain("figure.tie"))] if there else []


def drawn_ends(results: Results, state: str) -> Iterator[Array]:
    """Yield the ends (2, 2) m of the ties of a state as drawn."""
    for tie in ties_of(results, state):
        yield np.array([tie.start_m, tie.end_m])


def moved_ends(results: Results, state: str, configuration: Any, times: float = 1.0) -> Iterator[Array]:
    """Yield the ends (2, 2) m of the ties of a state where blocks are displaced by `times` a configuration (b, 3)."""
    drawn = outlines(results)
    for tie in ties_of(results, state):
        yield _magnified(tie, drawn, np.asarray(configuration, dtype=float), times)


def _magnified(tie: Tie, drawn: Outlines, configuration: Array, times: float) -> Array:
    ends = np.array([tie.start_m, tie.end_m])
    moved: Array = ends + times * (place(ends, np.array(tie.blocks), drawn.centroids, configuration) - ends)
    return moved
