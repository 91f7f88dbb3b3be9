"""One style for every figure, sheets drawn to scale on A4, and SVG files that are the same at every run."""

import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import ScalarFormatter
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar  # type: ignore[import-untyped]
from PIL import Image

from assessment.report.language import Words
from assessment.report.printing import FAMILY
from assessment.runtime.files import write_atomically
from mechanics.pictures import STYLE, nice

WIDTH_MM = 168.0  # column of an A4 page with 20 mm margins, a little air included
MM = 1.0 / 25.4  # inches
OVER_LINES = {"facecolor": "1.0", "edgecolor": "none", "pad": 0.6}  # behind a label that lies on lines
SHADES = 64  # of a PNG in colours
FONTS = f"'{FAMILY}', 'DejaVu Sans', Verdana, sans-serif"  # those of the PDF, then those of a screen
BAND_MM = 1.0  # of white around a figure
LINE_MM, FREE_MM, SCALE_MM = 3.8, 2.0, 5.0  # of a legend: a line, what is free around; height of the scale
PNG_DPI = 200  # sharp enough on paper at the column's width
LEGEND = 2  # columns
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)), (0, (3, 3)), (0, (8, 2)))
# of states: dark, so that grey prints
COLOURS = ("#000000", "#1b4f9c", "#a33c0a", "#2f6b2a", "#6b2c82", "#5a4a1f")
SYMBOL = re.compile(
    r"(?<![\w$\\])(α_[yu0]|d_[y0]|S_(?:De|[ea])|a_g|R_[xz]|(?:T|d\*)_SL[OVDC]|α₀|d₀|T₀)(?!\w)"
)
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
    bounds: tuple[float, float, float, float],
    count: int = 1,
    border_mm: float = 3.0,
    height_mm: float = 195.0,
    below_mm: float = 4.0,
    most_mm: float = 105.0,
) -> Panels:
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
