"""The drawing that the table of cracks is read with: blocks numbered, and the joints that opened or slid."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.report.figures.drawings.deformed import INK, fill_roles, foot, legend, union
from assessment.report.figures.drawings.labels import LETTER, POINT_MM, Labels
from assessment.report.figures.style import Sheet, sheet
from assessment.report.tables.structure.cracks import PRINTED, cracks_of
from assessment.report.text.language import Words
from assessment.results.configurations.outlines import Array, Outlines, outlines
from assessment.results.schema import Results

SMALLEST_PT, LARGEST_PT = 3.5, 6.5  # of the number of a block, as large as the block has room for
HIGHEST_MM = 125.0  # of the drawing: larger than others, numbers are read in it
CAPITAL = 0.75  # of the size of a font: the height of a digit
CRACK: dict[str, Any] = {"color": INK, "linewidth": 2.0, "solid_capstyle": "butt"}
NUMBER: dict[str, Any] = {
    "fontsize": 6.5,
    "fontweight": "bold",
    "bbox": {"facecolor": "1.0", "edgecolor": "none", "pad": 0.5},
}


def draw_cracks(results: Results, words: Words, state: str) -> Figure:
    """Draw a settled state, not magnified: numbers in the blocks, and beside the joints that the report lists."""
    shape = outlines(results).moved(results.states[state].configuration)
    page = sheet(union([shape]), border_mm=8.0, foot_mm=foot([""]), most_mm=HIGHEST_MM)
    axes = page.panels[0]
    fill_roles(axes, shape, results)
    labels = Labels(page, axes)
    found = cracks_of(results, state)
    middle = np.asarray(shape.bounds).reshape(2, 2).mean(axis=0)
    ends = {crack.joint: _face(results, shape, crack.joint) for crack in found}
    for face in ends.values():
        axes.plot(*face.T, **CRACK)
    rings = shape.rings(range(len(shape.centroids)))
    for number, (ring, centroid) in enumerate(zip(rings, shape.centroids, strict=True)):
        size = room(page, ring, str(number))
        if size >= SMALLEST_PT:
            supports = results.geometry.blocks[number].support is not None  # drawn dark
            labels.put(str(number), centroid, fontsize=size, color="1.0" if supports else "0.25")
    for crack in found[:PRINTED]:
        labels.write(f"G{crack.joint}", _beside(page, ends[crack.joint], middle), **NUMBER)
    legend(page, [Line2D([], [], **CRACK, label=words.plain("figure.crack"))])
    return page.figure


def _face(results: Results, shape: Outlines, joint: int) -> Array:
    """Return the ends (2, 2) m of the second block's face of a joint, in the configuration drawn."""
    known = results.geometry.joints[joint]
    drawn = outlines(results)
    block = known.blocks[1]
    own, now = drawn.points[drawn.owner == block], shape.points[drawn.owner == block]
    arm, turned = own[1] - own[0], now[1] - now[0]
    turn = np.arctan2(turned[1], turned[0]) - np.arctan2(arm[1], arm[0])
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    face: Array = now[0] + (np.asarray(known.ends_m) - own[0]) @ spin.T
    return face


def _beside(page: Sheet, face: Array, middle: Array) -> list[Array]:
    """Return places for a number: beyond the end of the joint that is farther out, then beyond the other one."""
    along = (face[1] - face[0]) / max(float(np.hypot(*(face[1] - face[0]))), 1e-12)
    ends = sorted(((face[1], along), (face[0], -along)), key=lambda end: -float(np.hypot(*(end[0] - middle))))
    return [end + page.paper(distance) * out for distance in (3.0, 5.0) for end, out in ends]


def room(page: Sheet, ring: Array, text: str) -> float:
    """Return the size in points, LARGEST_PT at most, of a text that stays within a block (n, 2) m at any slope."""
    corners = np.asarray(shapely.minimum_rotated_rectangle(shapely.Polygon(ring)).exterior.coords)
    narrow = 1000.0 * min(np.hypot(*(corners[1] - corners[0])), np.hypot(*(corners[2] - corners[1])))
    diagonal = np.hypot(LETTER * len(text), CAPITAL) * POINT_MM  # mm of a text of one point
    return float(min(LARGEST_PT, narrow / page.scale / diagonal))
