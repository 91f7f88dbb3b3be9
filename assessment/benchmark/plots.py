"""Error over processor time, both logarithmic: a panel for each case, a line for each quantity or way to integrate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, StrMethodFormatter

from assessment.benchmark.table import Precision
from assessment.report.figures.style import DASHES, MM, WIDTH_MM

COLUMNS, HEIGHT_MM = 3, 58.0
BESIDE = (
    (3, 2),
    (3, -6),
    (-3, 4),
)  # where a line has its values, points: those of two lines that meet are legible
EXACT = 1e-12  # an error that is none, for a logarithmic axis


def work_precision(rows: Sequence[Precision], series: str) -> Figure:
    """The rows of one parameter; what the program takes by itself is a filled mark, the others are open.

    Rows that failed have no place in it.
    """
    rows = [row for row in rows if row.failed is None]
    cases = list(dict.fromkeys(row.case for row in rows))
    height = math.ceil(len(cases) / COLUMNS) * HEIGHT_MM
    figure = Figure(figsize=(WIDTH_MM * MM, height * MM), layout="constrained")
    panels = figure.subplots(math.ceil(len(cases) / COLUMNS), COLUMNS, squeeze=False).ravel()
    for axes, case in zip(panels, cases, strict=False):
        _panel(axes, case, [row for row in rows if row.case == case], series)
    for axes in panels[len(cases) :]:
        axes.set_axis_off()
    return figure


def _panel(axes: Axes, case: str, rows: Sequence[Precision], series: str) -> None:
    names = dict.fromkeys(getattr(row, series) for row in rows)
    for dashes, beside, name in zip(cycle(DASHES), cycle(BESIDE), names, strict=False):
        line = [row for row in rows if getattr(row, series) == name]
        seconds, errors = [row.seconds for row in line], [max(row.error, EXACT) for row in line]
        axes.plot(seconds, errors, color="0.0", linestyle=dashes, linewidth=0.8, label=name)
        for row, x, y in zip(line, seconds, errors, strict=True):
            axes.plot(x, y, "o", markersize=3.5, color="0.0", fillstyle="full" if row.default else "none")
            axes.annotate(shown(row.value), (x, y), beside, textcoords="offset points", fontsize=5)
    where, _, what = case.partition(", ")
    axes.set(xscale="log", yscale="log", title=f"{where}\n{what}")
    axes.set(
        xlim=_decades([row.seconds for row in rows]), ylim=_decades([max(row.error, EXACT) for row in rows])
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))  # powers as formulas are not typeset in figures
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("processor time, s")
    axes.set_ylabel("relative error")
    axes.legend(fontsize=5.5)


def shown(value: float) -> str:
    """The value of a parameter; infinitely many segments are the exact bed."""
    return "exact" if math.isinf(value) else f"{value:g}"


def _decades(values: Sequence[float]) -> tuple[float, float]:
    """The powers of ten about some values."""
    return 10.0 ** math.floor(math.log10(0.8 * min(values))), 10.0 ** math.ceil(
        math.log10(1.25 * max(values))
    )
