"""The picture of a drawing that is no assembly: its outlines, and every fault with its number in the messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path as Curve

from assessment.report.figures.style import sheet
from assessment.report.text.language import Words
from mechanics.faults import Fault, FaultyDrawingError, Outline
from mechanics.pictures import INK, SUPPORT, Bounds
from mechanics.types import Array

RED = "#c00000"
MOST_NUMBERS = 400  # beyond it they would only cover each other
SURFACES = {"thin": "xxxx", "twice": "\\\\\\\\", "overlap": "", "floating": "////"}  # hatches
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
    page = sheet(_bounds(faulty.outlines), border_mm=14.0, below_mm=14.0, foot_mm=16.0)
    axes = page.panels[0]
    for support, grey in ((False, "0.95"), (True, SUPPORT)):
        blocks = [each for each in faulty.outlines if each.closed and each.support == support]
        if blocks:
            axes.add_artist(PathPatch(_curves(blocks), facecolor=grey, edgecolor=INK, linewidth=0.4))
    others = [each for each in faulty.outlines if not each.closed]
    if others:
        axes.add_artist(PathPatch(_curves(others), fill=False, edgecolor=INK, linewidth=0.4))
    for fault in faulty.faults:
        _mark(axes, fault)
    marked = [(n, fault) for n, fault in enumerate(faulty.faults, 1) if len(fault.points)]
    for turn, (number, fault) in enumerate(marked[:MOST_NUMBERS]):
        angle = 0.7 + 2.4 * turn  # neighbours' numbers lie on different sides
        off = 12.0 if fault.kind in SMALL else 0.0
        away = (off * np.cos(angle), off * np.sin(angle))
        axes.annotate(str(number), fault.points[0], away, textcoords="offset points", **NUMBER)
    page.legend(_handles(faulty.faults, words), words)
    return page.figure


def _bounds(outlines: Sequence[Outline]) -> Bounds:
    points = np.concatenate([outline.points for outline in outlines])
    low, high = points.min(axis=0), points.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _curves(outlines: Sequence[Outline]) -> Curve:
    """Return outlines as one path, which is one element of the SVG."""
    return _path([(outline.points, outline.closed) for outline in outlines])


def _path(rings: Sequence[tuple[Array, bool]]) -> Curve:
    curves = [Curve(np.vstack([r, r[:1]]) if closed else r, closed=closed) for r, closed in rings]
    return Curve.make_compound_path(*curves)


def _mark(axes: Axes, fault: Fault) -> None:
    lines = [line for line in fault.lines if len(line) > 1]
    if lines and fault.kind in SURFACES:
        axes.add_artist(PathPatch(_path([(line, True) for line in lines]), **_surface(fault.kind)))
    elif lines:
        thick = 2.4 if fault.kind == "gap" else 1.3
        path = _path([(line, False) for line in lines])
        axes.add_artist(PathPatch(path, fill=False, edgecolor=RED, linewidth=thick, capstyle="round"))
    if fault.kind == "outline":
        axes.plot(*fault.points.T, linestyle="none", marker="o", markersize=3.5, color=RED)


def _surface(kind: str) -> dict[str, Any]:
    face = {"facecolor": RED, "alpha": 0.45} if kind == "overlap" else {"facecolor": "none"}
    return {"edgecolor": RED, "linewidth": 1.0, "hatch": SURFACES[kind], **face}


def _handles(faults: Sequence[Fault], words: Words) -> list[Any]:
    counts = Counter(fault.kind for fault in faults)
    handles: list[Any] = []
    for kind, count in counts.items():
        label = words.plain(f"figure.fault_{kind}", count=count)
        if kind in SURFACES:
            handles.append(Patch(label=label, **_surface(kind)))
        else:
            handles.append(Line2D([], [], color=RED, linewidth=2.4 if kind == "gap" else 1.3, label=label))
    return handles
