"""The drawing that the table of measurements is read with: the best movement, and where it was measured."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch

from assessment.report.figures.drawings.deformed import (
    GHOST,
    INK,
    fill_roles,
    foot,
    ghost_handle,
    legend,
    union,
)
from assessment.report.figures.drawings.labels import Labels
from assessment.report.figures.style import nice, sheet
from assessment.report.text.language import Words
from assessment.results.configurations.outlines import outlines, place
from assessment.results.identified import best_of
from assessment.results.schema import Results
from assessment.results.schema.part import known

SHOWN = 0.06  # of the size of the model: the largest displacement, magnified
MARK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4.0,
    "markerfacecolor": "1.0",
    "markeredgecolor": INK,
    "markeredgewidth": 1.0,
}
NUMBER: dict[str, Any] = {
    "fontsize": 7.0,
    "fontweight": "bold",
    "bbox": {"facecolor": "1.0", "edgecolor": "none", "pad": 0.6},
}


def draw_identification(results: Results, words: Words) -> Figure:
    """Draw the best movement, magnified until it shows, the measurements marked by their numbers."""
    found = known(results.identification)
    drawn, moved = outlines(results), np.asarray(known(known(best_of(found)).configuration), dtype=float)
    travel = float(np.abs(drawn.moved(moved).points - drawn.points).max())
    times = nice(max(1.0, SHOWN * drawn.size / travel)) if travel > 0.0 else 1.0
    shape = drawn.moved(moved, times)
    points = np.array([site.point_m for site in found.sites], dtype=float)
    owner = np.array([site.block for site in found.sites], dtype=np.intp)
    marked = points + times * (place(points, owner, drawn.centroids, moved) - points)
    page = sheet(union([drawn, shape]), border_mm=8.0, foot_mm=foot([""]))
    axes = page.panels[0]
    axes.set_title(words.plain("figure.settled", times=f"{times:g}"))
    axes.add_artist(PathPatch(drawn.path(range(len(drawn.centroids))), **GHOST))
    fill_roles(axes, shape, results)
    axes.plot(*marked.T, **MARK)
    labels = Labels(page, axes)
    labels.avoid(marked, MARK["markersize"] + MARK["markeredgewidth"])
    for number, point in enumerate(marked, 1):
        beside = [point + page.paper(3.0) * np.array(way) for way in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        labels.write(str(number), beside, **NUMBER)
    handles = [
        ghost_handle(words.plain("figure.original_outline")),
        Line2D([], [], **MARK, label=words.plain("figure.measurement")),
    ]
    legend(page, handles)
    return page.figure
