"""One style for every drawing and curve, and what drawings are made of: blocks, earlier outlines, hinges, ties."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import PathPatch

from mechanics.pictures.shape import Shape
from mechanics.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Bounds = tuple[float, float, float, float]
STYLE = {
    "font.family": "DejaVu Sans",  # shipped with matplotlib
    "font.size": 7.5,
    "svg.fonttype": "none",  # words stay words: searchable, and faster to set in the PDF
    "svg.hashsalt": "assesto",
    "mathtext.fontset": "dejavusans",
    "text.parse_math": False,  # the dollar of a name is a dollar; what is a formula says so
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 8.0,
    "patch.facecolor": "0.0",  # drawings are black, white and grey, heads of arrows too
    "axes.titley": 1.0,  # no labels above axes that a title would have to clear: measuring them all takes time
    "axes.grid": True,
    "grid.linewidth": 0.3,
    "grid.color": "0.8",
    "legend.frameon": False,
    "legend.fontsize": 7.0,
    "lines.linewidth": 1.0,
}
INK, FAINT, SUPPORT, MOVING, MASONRY = "0.0", "0.55", "0.55", "0.82", "0.92"
GHOST = {"fill": False, "edgecolor": FAINT, "linewidth": 0.5, "linestyle": (0, (4, 2))}
TIE: dict[str, Any] = {"color": INK, "linewidth": 1.1, "linestyle": (0, (7, 1.2, 1.5, 1.2))}
THRUST: dict[str, Any] = {"color": INK, "linewidth": 1.8}
SLIDING: dict[str, Any] = {"color": INK, "linewidth": 2.4, "solid_capstyle": "butt"}
HINGE: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 5.0,
    "markerfacecolor": "1.0",
    "markeredgecolor": INK,
    "markeredgewidth": 1.2,
}
MARKS: dict[str, dict[str, Any]] = {  # of the points of a curve, by their names in the legend
    name: {"marker": marker, "markersize": size, "markerfacecolor": "1.0", "linestyle": "none"}
    for name, marker, size in (("α_0", "o", 4.5), ("d_0", "^", 5.0), ("d_y, α_y", "s", 4.0))
}
SHOWN = 0.06  # of the size of the model: the largest displacement of a settlement, magnified
SWEPT = 0.08  # likewise, of the virtual displacements of a mechanism


def fill(axes: Axes, shape: Shape, chosen: Any, grey: str) -> None:
    """Fill some blocks with a grey."""
    if len(chosen):
        axes.add_artist(PathPatch(shape.path(chosen), facecolor=grey, edgecolor=INK, linewidth=0.45))


def fill_roles(axes: Axes, shape: Shape) -> None:
    """Fill supports dark and all other blocks light."""
    fill(axes, shape, np.flatnonzero(~shape.supports), MASONRY)
    fill(axes, shape, np.flatnonzero(shape.supports), SUPPORT)


def ghost(axes: Axes, shape: Shape) -> None:
    """Draw the outlines of an earlier configuration, dashed."""
    axes.add_artist(PathPatch(shape.path(shape.every), **GHOST))


def union(shapes: Sequence[Shape]) -> Bounds:
    """Return the bounds of all shapes, m."""
    boxes = np.array([shape.bounds for shape in shapes])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def nice(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-9))


def magnification(shape: Shape, configuration: Any) -> float:
    """Return a round factor that makes the largest displacement of a configuration (b, 3) `SHOWN` of the size."""
    travel = float(np.abs(shape.moved(configuration).points - shape.points).max())
    return nice(max(1.0, SHOWN * shape.size / travel)) if travel > 0.0 else 1.0


def swept_by(shape: Shape, velocity: Array) -> float:
    """Return by how much virtual displacements (b, 3) are multiplied so that the largest is `SWEPT` of the size."""
    rate = shape.swept(velocity, 1.0).points - shape.points
    return SWEPT * shape.size / max(float(np.linalg.norm(rate, axis=1).max()), 1e-12)
