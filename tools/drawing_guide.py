"""Draws docs/pictures/drawing.svg, the picture of the drawing guide: python -m tools.drawing_guide.

The joints of the picture are those that the program finds.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from mechanics import Block, Material
from mechanics.model.block import find_joints
from tools.pictures import write_picture

STONE = Material(unit_weight=18.0, friction=0.6)
JOINT, FAULT = "#c02020", "#1050b0"


def rectangle(x: float, z: float, width: float, height: float) -> np.ndarray:
    """Corners (4, 2)."""
    return np.array([[x, z], [x + width, z], [x + width, z + height], [x, z + height]])


def wall() -> dict[str, list[np.ndarray]]:
    """Outlines by layer: a wall in running bond with a lintel, on two supports."""
    courses = [rectangle(x, 0.0, 1.0, 0.5) for x in (0.0, 2.0)]
    courses += [rectangle(0.0, 0.5, 0.6, 0.5), rectangle(2.4, 0.5, 0.6, 0.5)]
    courses += [rectangle(0.6, 0.5, 0.4, 0.5), rectangle(2.0, 0.5, 0.4, 0.5)]
    courses += [np.array([[0.5, 1.0], [2.5, 1.0], [2.3, 1.45], [0.7, 1.45]])]
    courses += [np.array([[0.0, 1.0], [0.5, 1.0], [0.7, 1.45], [0.0, 1.45]])]
    courses += [np.array([[2.5, 1.0], [3.0, 1.0], [3.0, 1.45], [2.3, 1.45]])]
    return {
        "WALL": courses,
        "BASE_LEFT": [rectangle(-0.2, -0.35, 1.4, 0.35)],
        "BASE_RIGHT": [rectangle(1.8, -0.35, 1.4, 0.35)],
    }


def outline(
    axes: Axes, corners: np.ndarray, face: str = "#eeeeee", closed: bool = True, **style: object
) -> None:
    """Draw a polyline with its vertices."""
    axes.add_patch(Polygon(corners, closed=closed, facecolor=face, edgecolor="black", lw=1.0, **style))
    axes.plot(*corners.T, "s", color="black", ms=2.5)


def note(axes: Axes, text: str, at: tuple[float, float], away: tuple[float, float]) -> None:
    """Write a text with an arrow to a place."""
    arrow = {"arrowstyle": "->", "lw": 0.8, "shrinkB": 2.0}
    axes.annotate(text, at, away, fontsize=8, ha="center", va="center", arrowprops=arrow)


def right(axes: Axes) -> None:
    """Draw a wall as it should be, with the joints found."""
    layers = wall()
    blocks = []
    for layer, outlines in layers.items():
        support = layer if layer.startswith("BASE") else None
        for corners in outlines:
            outline(axes, corners, "#b8b8b8" if support else "#eeeeee")
            blocks.append(Block(corners, 1.0, STONE, support=support))
    for ends in find_joints(blocks, 1e-3).ends:
        axes.plot(*ends.T, color=JOINT, lw=2.5, solid_capstyle="butt", zorder=3)
    note(
        axes,
        "layer WALL: one closed polyline per block,\nvertices only at its own corners",
        (1.5, 1.3),
        (1.5, 2.15),
    )
    note(axes, "joint (red): edges that\ncoincide, found by the program", (0.6, 0.7), (-1.0, 1.25))
    note(axes, 'layer BASE_LEFT:\nsupport = "left"', (-0.15, -0.2), (-0.85, 0.1))
    note(axes, 'layer BASE_RIGHT:\nsupport = "right"', (3.15, -0.2), (3.85, 0.1))
    note(axes, "no vertex needed here", (2.4, 0.5), (3.9, 0.8))
    note(axes, "control point\npoint_m = [3.0, 1.45]", (3.0, 1.45), (3.85, 1.7))
    axes.plot(3.0, 1.45, "o", color=FAULT, ms=5)
    axes.annotate("", (1.5, -0.15), (1.5, -0.6), arrowprops={"arrowstyle": "->", "lw": 1.0})
    axes.annotate("", (1.95, -0.6), (1.5, -0.6), arrowprops={"arrowstyle": "->", "lw": 1.0})
    axes.text(1.56, -0.2, "z", fontsize=8)
    axes.text(1.98, -0.64, "x", fontsize=8)
    axes.set(xlim=(-1.8, 4.7), ylim=(-0.75, 2.4))


def wrong(axes: Axes) -> None:
    """Draw the usual faults and what is said of them."""
    upper = [
        (rectangle(0.0, 0.58, 1.0, 0.5), "a gap: no joint\n(they face each other)"),
        (rectangle(1.8, 0.42, 1.0, 0.5), "an overlap\n(error: overlap by … m²)"),
        (
            np.vstack([rectangle(3.6, 0.5, 1.0, 0.5)[[3, 0, 1, 2]], [[3.75, 1.0]]]),
            "not closed\n(error: is open)",
        ),
        (rectangle(5.4, 0.5, 1.0, 0.5)[[0, 1, 3, 2]], "crosses itself\n(error)"),
    ]
    for number, (corners, text) in enumerate(upper):
        x = 1.8 * number
        outline(axes, rectangle(x, 0.0, 1.0, 0.5))
        closed = "open" not in text
        outline(axes, corners, "#eeeeee" if closed else "none", closed, alpha=0.8)
        axes.text(x + 0.5, -0.15, text, fontsize=8, ha="center", va="top", color=FAULT)
    axes.set(xlim=(-0.3, 6.9), ylim=(-0.65, 1.2))


def draw(figure: Figure) -> None:
    """Draw outlines as they should be, with the joints found, above those that are wrong."""
    top, bottom = figure.subplots(2, 1, height_ratios=(2.1, 1.0))
    right(top)
    wrong(bottom)
    for axes in (top, bottom):
        axes.set_aspect("equal")
        axes.set_axis_off()


if __name__ == "__main__":
    write_picture("drawing.svg", (7.6, 5.6), draw, font_size=10.0)
