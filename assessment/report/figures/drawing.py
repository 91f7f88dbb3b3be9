"""The drawing of the model, to scale, in black and white; of a drawing that is no assembly its outlines and faults.

Other drawings of the structure are made of the same parts: earlier outlines, ties, arrows, numbers.
"""

import math
from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.path import Path

from assessment.report.figures.style import Panels, key, sheet
from assessment.report.language import Words, direction_name
from assessment.results.frames import ties_of
from assessment.results.joint_states import outlines
from assessment.results.schema import Direction, Results, Settlement
from assessment.results.table import sense
from mechanics.errors import FaultyDrawingError
from mechanics.pictures import FAINT, INK, SUPPORT, TIE, Bounds, Shape, fill
from mechanics.types import Array

LAYER_GREYS = ("1.0", "0.88", "0.76", "0.94", "0.82", "0.70")
SHAFT = [(-0.05, 1.0), (0.05, 1.0), (0.05, -0.2), (0.3, -0.2), (0.0, -1.0), (-0.3, -0.2), (-0.05, -0.2)]
DOWN = Path([*SHAFT, SHAFT[0]], closed=True)  # an arrow, as a mark
MOST_NAMED, LONGEST_NAME = 24, 50  # layers, and letters of one, in the legend
ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.8}
PLATE_MM = 2.4  # length of the plate at an end of a tie
PLATE: dict[str, Any] = {"color": INK, "linewidth": 1.8, "solid_capstyle": "butt"}
DIMENSION = {"arrowstyle": "|-|,widthA=0.15,widthB=0.15", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.5}
WHITE: dict[str, Any] = {"facecolor": "1.0", "edgecolor": "none", "pad": 0.6}
ON_WHITE: dict[str, Any] = {"textcoords": "offset points", "bbox": WHITE}


def draw_model(results: Results, words: Words) -> Figure:
    """Draw blocks by layer, supports, vertical loads, control points and overall dimensions."""
    shape, blocks = outlines(results), results.geometry.blocks
    by_layer: dict[str, list[int]] = {}
    for number, block in enumerate(blocks):
        by_layer.setdefault(block.layer, []).append(number)
    named = {}  # in the legend, cut to the room that it has
    for layer, own in sorted(by_layer.items()):
        support = blocks[own[0]].support
        text = words.plain("figure.support_layer", layer=layer, support=support) if support else layer
        named[layer] = text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 1]}…"
    page = sheet(shape.bounds, border_mm=14.0, below_mm=9.0)
    axes = page.panels[0]
    handles: list[Any] = []
    for index, (layer, label) in enumerate(named.items()):
        grey = SUPPORT if blocks[by_layer[layer][0]].support else LAYER_GREYS[index % len(LAYER_GREYS)]
        fill(axes, shape, by_layer[layer], grey)
        if index < MOST_NAMED:
            handles.append(Patch(facecolor=grey, edgecolor=INK, linewidth=0.5, label=label))
    if len(named) > MOST_NAMED:
        more = words.plain("figure.more_layers", count=len(named) - MOST_NAMED)
        handles.append(key(more, linestyle="none"))
    if loaded := [block for block in blocks if block.vertical_load_kN]:
        for block in loaded:
            x, z = block.centroid_m
            axes.annotate("", (x, z), (x, z + page.paper(7.0)), arrowprops=ARROW | {"color": INK})
        sizes = " / ".join(map(words.number, sorted({block.vertical_load_kN for block in loaded})))
        label = words.plain("figure.loads", count=len(loaded), loads=sizes)
        handles.append(key(label, linestyle="none", marker=DOWN, markersize=9.0, color=INK))
    mark: dict[str, Any] = {"linestyle": "none", "marker": "D", "markersize": 4.0, "color": INK}
    for control in results.geometry.controls:
        x, z = control.point_m
        axes.plot(x, z, **mark)
        # names lie outside, away from one another
        away, side = (-4.0, "right") if x < sum(axes.get_xlim()) / 2.0 else (4.0, "left")
        axes.annotate(control.name, (x, z), (away, 4.0), ha=side, fontweight="bold", **ON_WHITE)
    handles += [key(words.plain("figure.control"), **mark)] if results.geometry.controls else []
    for tie in results.model.ties or ():  # whatever states it is in
        ends = np.array([tie.start_m, tie.end_m])
        draw_ties(page, axes, [ends])
        axes.annotate(tie.name, ends.mean(axis=0), (0.0, 3.0), ha="center", va="bottom", **ON_WHITE)
    handles += [key(words.plain("figure.tie"), **TIE)] if results.model.ties else []
    # the width below and the height beside the model
    x0, z0, x1, z1 = shape.bounds
    low, left = z0 - page.paper(7.0), x0 - page.paper(7.0)
    for start, end, turn in (((x0, low), (x1, low), 0), ((left, z0), (left, z1), 90)):
        axes.annotate("", end, start, arrowprops=DIMENSION)
        length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        text = f"{words.comma(f'{length:.3f}'.rstrip('0').rstrip('.'))} m"
        axes.annotate(
            text, np.mean([start, end], axis=0), rotation=turn, ha="center", va="center", bbox=WHITE
        )
    page.legend(handles, words)
    return page.figure


RED = "#c00000"
MOST_NUMBERS = 400  # beyond it they would only cover each other
SURFACES = ("thin", "twice", "overlap", "floating")
LOOKS: dict[str, dict[str, Any]] = {  # of faults: surfaces hatched, lines as thick as they are wide
    "thin": {"hatch": "xxxx"}, "twice": {"hatch": "\\\\\\\\"}, "floating": {"hatch": "////"},
    "overlap": {"facecolor": RED, "alpha": 0.45}, "gap": {"linewidth": 2.4},
}  # fmt: skip
SMALL = {"outline", "overlap", "thin"}  # a number would cover what it marks
NUMBER: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "color": RED,
    "fontweight": "bold",
    "fontsize": 6.5,
    "bbox": {"boxstyle": "circle,pad=0.25", "facecolor": "1.0", "edgecolor": RED, "linewidth": 0.6},
    "arrowprops": {"arrowstyle": "-", "color": RED, "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 0.0},
}


def draw_faults(faulty: FaultyDrawingError, words: Words) -> Figure:
    """Draw the outlines that could be read, to scale, and mark every fault that has a place; ValueError without any."""
    points = np.concatenate([outline.points for outline in faulty.outlines])
    (x0, z0), (x1, z1) = np.quantile(points, (0.0, 1.0), axis=0).tolist()
    page = sheet((x0, z0, x1, z1), border_mm=14.0, below_mm=14.0)
    axes = page.panels[0]
    for each in faulty.outlines:
        grey = "none" if not each.closed else SUPPORT if each.support else "0.95"
        axes.add_patch(Polygon(each.points, closed=each.closed, facecolor=grey, edgecolor=INK, linewidth=0.4))
    handles: list[Any] = []
    for kind, count in Counter(fault.kind for fault in faulty.faults).items():
        own = [each for each in faulty.faults if each.kind == kind]
        surface = kind in SURFACES
        style: dict[str, Any] = {"facecolor": "none", "edgecolor": RED, "linewidth": 1.0 if surface else 1.3}
        style |= LOOKS.get(kind, {})
        lines = [line for fault in own for line in fault.lines if len(line) > 1]
        axes.add_collection(PolyCollection(lines, closed=surface, **style), autolim=False)
        if kind == "outline":
            points = np.concatenate([fault.points for fault in own])
            axes.plot(*points.T, linestyle="none", marker="o", markersize=3.5, color=RED)
        label = words.plain(f"figure.fault_{kind}", count=count)
        line = key(label, color=RED, linewidth=style["linewidth"])
        handles.append(Patch(label=label, **style) if surface else line)
    marked = [(n, fault) for n, fault in enumerate(faulty.faults, 1) if len(fault.points)]
    for turn, (number, fault) in enumerate(marked[:MOST_NUMBERS]):
        angle = 0.7 + 2.4 * turn  # neighbours' numbers lie on different sides
        off = 12.0 if fault.kind in SMALL else 0.0
        away = (off * np.cos(angle), off * np.sin(angle))
        axes.annotate(str(number), fault.points[0], away, textcoords="offset points", **NUMBER)
    page.legend(handles, words)
    return page.figure


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


def write_number(
    axes: Axes, text: str, at: Array, away: tuple[float, float] = (0.0, 0.0), **style: Any
) -> None:
    """Write a number at a place (2,) m, or so many points away from it."""
    place: Any = {"textcoords": "offset points", "ha": "center", "va": "center", "annotation_clip": False}
    axes.annotate(text, (at[0], at[1]), away, **place, **style)
