"""What figures are made of: one style, sheets drawn to scale on A4, SVG files that are the same at every run.

The drawing of the model, to scale, in black and white; of a drawing that is no assembly its outlines and faults. Other
drawings of the structure have the same parts: earlier outlines, ties, arrows, numbers.
"""

import io
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.path import Path as Mark
from matplotlib.text import Text
from matplotlib.ticker import ScalarFormatter
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar  # type: ignore[import-untyped]
from PIL import Image

from assessment.report.language import Words, direction_name
from assessment.report.printing import FAMILY
from assessment.results.frames import ties_of
from assessment.results.joint_states import outlines
from assessment.results.schema import Direction, Results, Settlement
from assessment.results.table import sense
from assessment.runtime.files import write_atomically
from mechanics.errors import FaultyDrawingError
from mechanics.pictures import FAINT, INK, STYLE, SUPPORT, TIE, Bounds, Shape, fill, nice
from mechanics.types import Array

WIDTH_MM = 168.0  # column of an A4 page with 20 mm margins, a little air included
MM = 1.0 / 25.4  # inches
# behind a label that lies on lines
OVER_LINES: dict[str, Any] = {"facecolor": "1.0", "edgecolor": "none", "pad": 0.6}
SHADES = 64  # of a PNG in colours
FONTS = f"'{FAMILY}', 'DejaVu Sans', Verdana, sans-serif"  # those of the PDF, then those of a screen
BAND_MM = 1.0  # of white around a figure
LINE_MM, FREE_MM, SCALE_MM = 3.8, 2.0, 5.0  # of a legend: a line, what is free around; height of the scale
PNG_DPI = 200  # sharp enough on paper at the column's width
LEGEND = 2  # columns
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)), (0, (3, 3)), (0, (8, 2)))
# of states: dark, so that grey prints
COLOURS = ("#000000", "#1b4f9c", "#a33c0a", "#2f6b2a", "#6b2c82", "#5a4a1f")
SYMBOL = re.compile(r"(?<![\w$\\])(α_[yu0]|d_[y0]|S_(?:De|[ea])|a_g|R_[xz]|(?:T|d\*)_SL[OVDC]|[αdT]₀)(?!\w)")
SCALES = tuple(step * 10.0**power for power in range(5) for step in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.5))


def state_style(number: int) -> dict[str, Any]:
    """Return the line of the state of that number (from 0): its colour, and dashes for who prints in grey."""
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": DASHES[number % len(DASHES)]}


def key(label: str, **style: Any) -> Line2D:
    """Return the line of a legend, black unless it has a colour."""
    return Line2D([], [], label=label, **({"color": "0.0"} | style))


def typeset(figure: Figure) -> Figure:
    """Set the symbols in the words of a figure as symbols: a_g with its subscript; a name's own dollars stay."""

    def symbol(found: re.Match[str]) -> str:
        letter, _, index = found[1].replace("₀", "_0").partition("_")
        star = "^*" if "*" in found[1] else ""
        return f"${letter.rstrip('*')}_{{\\mathrm{{{index.rstrip('*')}}}}}{star}$"

    for text in figure.findobj(Text):
        words = text.get_text()
        if not text.get_parse_math() and SYMBOL.search(words):
            text.set_text(SYMBOL.sub(symbol, words.replace("$", r"\$")))
            text.set_parse_math(True)
    return figure


def save_svg(draw: Callable[[], Figure], path: Path) -> None:
    """Draw in the common style and write an SVG whose bytes depend on nothing but the drawing."""
    svg = _drawn(draw, format="svg", metadata={"Date": None}).getvalue().decode()
    write_atomically(path, svg.replace("'DejaVu Sans'", FONTS).encode())


def save_png(draw: Callable[[], Figure], path: Path) -> None:
    """Draw in the common style and write a PNG in few colours, whose bytes depend on nothing but the drawing."""
    picture = Image.open(_drawn(draw, format="png", dpi=PNG_DPI)).convert("RGB")
    buffer = io.BytesIO()
    picture.quantize(SHADES, dither=Image.Dither.NONE).save(buffer, format="png", dpi=(PNG_DPI, PNG_DPI))
    write_atomically(path, buffer.getvalue())


def _drawn(draw: Callable[[], Figure], **kind: Any) -> io.BytesIO:
    """Return a figure as matplotlib writes it, cut to what is drawn."""
    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]
        typeset(draw()).savefig(buffer, bbox_inches="tight", pad_inches=BAND_MM * MM, **kind)
    return buffer


@dataclass(frozen=True)
class Panels:
    """Panels of equal bounds, drawn at 1:scale on paper."""

    figure: Figure
    panels: list[Axes]
    scale: float

    def paper(self, millimetres: float) -> float:
        """Return the length in metres of the model that covers so many millimetres of paper."""
        return millimetres * self.scale / 1000.0

    def legend(self, handles: Sequence[Any], words: Words) -> None:
        """Put a scale of lengths below the panels, at the left, and a legend below it."""
        labels = [str(handle.get_label()) for handle in handles]
        labels = [f" {text}" if text.startswith("_") else text for text in labels]  # "_": left out
        height = self.figure.get_size_inches()[1] / MM
        self.figure.legend(
            handles, labels, loc="upper center", bbox_to_anchor=(0.5, -SCALE_MM / height), borderaxespad=0.2,
            ncols=min(len(labels), LEGEND), handlelength=1.8, columnspacing=1.6,
        )  # fmt: skip
        length = nice(self.paper(25.0))
        text = words.plain(
            "figure.scale", length=f"{words.comma(f'{length:g}')} m", scale=words.comma(f"{self.scale:g}")
        )
        self.figure.add_artist(AnchoredSizeBar(
            self.panels[0].transData, length, text, "upper left", borderpad=0.2, sep=2.0, frameon=False,
            size_vertical=self.paper(0.6), fontproperties=FontProperties(size=6.5), bbox_to_anchor=(0.0, 0.0),
            bbox_transform=self.figure.transFigure,
        ))  # fmt: skip


def sheet(
    bounds: Bounds, count: int = 1, border_mm: float = 3.0, height_mm: float = 195.0, below_mm: float = 4.0,
    most_mm: float = 105.0,
) -> Panels:  # fmt: skip
    """Lay out `count` panels, two in a row, three if three, or below one another, at the largest usual scale.

    bounds (x0, z0, x1, z1) in m; every panel has a free border, `below_mm` high at its foot; `most_mm`: height of
    a panel that stands alone.
    """
    x0, z0, x1, z1 = bounds
    width, height = max(x1 - x0, 1e-6), max(z1 - z0, 1e-6)
    head_mm, most = 9.0, most_mm if count == 1 else 85.0  # of several, so that two figures stand on a page

    def denominator(columns: int) -> float:
        across = WIDTH_MM / columns - 2.0 * border_mm
        up = min(most, height_mm / math.ceil(count / columns) - head_mm) - border_mm - below_mm
        needed = max(width / across, height / max(up, 1.0)) * 1000.0
        return next((scale for scale in SCALES if scale >= needed - 1e-9), needed)

    least = 2.0 * denominator(1)  # beside one another unless below one another they are twice as large
    columns = next((each for each in {1: (), 3: (3,)}.get(count, (2,)) if denominator(each) < least), 1)
    scale, rows = denominator(columns), math.ceil(count / columns)
    cell = (WIDTH_MM / columns, height * 1000.0 / scale + border_mm + below_mm)
    total = (WIDTH_MM, (cell[1] + head_mm) * rows)
    figure = Figure(figsize=(total[0] * MM, total[1] * MM))
    middle, half = (x0 + x1) / 2.0, cell[0] * scale / 2000.0
    above, below = border_mm * scale / 1000.0, below_mm * scale / 1000.0
    panels = []
    for index in range(count):
        row, column = divmod(index, columns)
        bottom = total[1] - (row + 1) * (cell[1] + head_mm)
        place = np.array([column * cell[0], bottom, *cell]) / np.tile(total, 2)
        axes = figure.add_axes(tuple(place.tolist()))
        axes.set(xlim=(middle - half, middle + half), ylim=(z0 - below, z1 + above))
        axes.set_axis_off()
        panels.append(axes)
    return Panels(figure, panels, scale)


def chart(
    words: Words, count: int = 1, columns: int = 2, height_mm: float = 66.0
) -> tuple[Figure, list[Axes]]:
    """Return a figure of so many axes, each so high with its words, side by side in the column's width."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = Figure(figsize=(WIDTH_MM * MM, rows * height_mm * MM), layout="constrained")
    panels: list[Axes] = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axes in panels:
        comma_ticks(axes, words)
    for axes in panels[count:]:
        axes.set_axis_off()
    return figure, panels[:count]


def legend(figure: Figure, columns: int = LEGEND, handles: Sequence[Artist] = (), **style: Any) -> None:
    """Put a legend below the axes of a chart, which becomes higher by it: each label once, then `handles`."""
    named = dict[str, Any]()
    for axes in figure.axes:
        named = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True)) | named
    shown = [*named.values(), *handles]
    columns = min(columns, len(shown))
    figure.set_figheight(figure.get_figheight() + (FREE_MM + LINE_MM * math.ceil(len(shown) / columns)) * MM)
    figure.legend(handles=shown, loc="outside lower center", ncols=columns, **style)


class CommaFormatter(ScalarFormatter):
    """Tick labels with the decimal mark of the language."""

    def __init__(self, words: Words) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)
        self._words = words

    def __call__(self, value: float, pos: int | None = None) -> str:
        """Return the label of one value."""
        return self._words.comma(super().__call__(value, pos))


def comma_ticks(axes: Axes, words: Words) -> None:
    """Write the tick labels with the decimal mark of the language; the grid stands for tick marks."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(CommaFormatter(words))
    axes.locator_params(nbins=6)
    axes.tick_params(bottom=False, left=False)


LAYER_GREYS = ("1.0", "0.88", "0.76", "0.94", "0.82", "0.70")
SHAFT = [(-0.05, 1.0), (0.05, 1.0), (0.05, -0.2), (0.3, -0.2), (0.0, -1.0), (-0.3, -0.2), (-0.05, -0.2)]
DOWN = Mark([*SHAFT, SHAFT[0]], closed=True)  # an arrow, as a mark
MOST_NAMED, LONGEST_NAME = 24, 50  # layers, and letters of one, in the legend
ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.8}
PLATE_MM = 2.4  # length of the plate at an end of a tie
PLATE: dict[str, Any] = {"color": INK, "linewidth": 1.8, "solid_capstyle": "butt"}
DIMENSION = {"arrowstyle": "|-|,widthA=0.15,widthB=0.15", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.5}
ON_WHITE: dict[str, Any] = {"textcoords": "offset points", "bbox": OVER_LINES}


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
        middle = np.mean([start, end], axis=0)
        axes.annotate(text, middle, rotation=turn, ha="center", va="center", bbox=OVER_LINES)
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
