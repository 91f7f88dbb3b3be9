"""Error over processor time, both logarithmic: a panel for each case, a line for each quantity or way to integrate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, StrMethodFormatter

from assessment.benchmark.table import Precision
from assessment.report.figures.style import DASHES, MM, WIDTH_MM

COLUMNS, HEIGHT_MM, LEGEND_MM = 3, 58.0, 12.0
MARKS = ("o", "s", "^", "D", "v", "p", "h", "<")
LEGIBLE = 12  # points of a panel, whose values are written; where there are more, those of each line's ends
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
    names = dict.fromkeys(getattr(row, series) for row in rows)
    looks = dict(zip(names, zip(cycle(DASHES), cycle(MARKS), cycle(BESIDE), strict=False), strict=False))
    height = math.ceil(len(cases) / COLUMNS) * HEIGHT_MM + LEGEND_MM
    figure = Figure(figsize=(WIDTH_MM * MM, height * MM), layout="constrained")
    panels = figure.subplots(math.ceil(len(cases) / COLUMNS), COLUMNS, squeeze=False).ravel()
    for axes, case in zip(panels, cases, strict=False):
        _panel(axes, case, [row for row in rows if row.case == case], series, looks)
    for axes in panels[len(cases) :]:
        axes.set_axis_off()
    lines = [
        Line2D(
            [],
            [],
            color="0.0",
            linestyle=dashes,
            linewidth=0.8,
            marker=mark,
            markersize=3.5,
            fillstyle="none",
        )
        for dashes, mark, _ in looks.values()
    ]
    figure.legend(lines, list(looks), loc="outside lower center", ncols=COLUMNS, fontsize=6)
    return figure


def _panel(
    axes: Axes, case: str, rows: Sequence[Precision], series: str, looks: Mapping[str, tuple[Any, str, Any]]
) -> None:
    errors = [row.error for row in rows if row.error > EXACT]
    least = max(EXACT, 0.1 * min(errors, default=EXACT))  # where an error that is none has its mark
    lines = {name: line for name in looks if (line := [row for row in rows if getattr(row, series) == name])}
    for name, line in lines.items():
        dashes, mark, beside = looks[name]
        points = [(row.seconds, max(row.error, least)) for row in line]
        axes.plot(*zip(*points, strict=True), color="0.0", linestyle=dashes, linewidth=0.8)
        for number, (row, point) in enumerate(zip(line, points, strict=True)):
            fill = "full" if row.default else "none"
            axes.plot(*point, mark, markersize=3.5, color="0.0", fillstyle=fill)
            if len(rows) <= LEGIBLE or number in (0, len(line) - 1):
                axes.annotate(_value(row), point, beside, textcoords="offset points", fontsize=5)
    where, _, what = case.partition(", ")
    axes.set(xscale="log", yscale="log", title=f"{where}\n{what}")
    axes.set(
        xlim=_decades([row.seconds for row in rows]), ylim=_decades([max(row.error, least) for row in rows])
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))  # powers as formulas are not typeset in figures
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("processor time, s")
    axes.set_ylabel("relative error")


def _value(row: Precision) -> str:
    return f"{1e3 * row.value:.3g} ms" if row.parameter.startswith("time step") else shown(row.value)


def shown(value: float) -> str:
    """The value of a parameter; infinitely many segments are the exact bed."""
    return "exact" if math.isinf(value) else f"{value:g}"


def _decades(values: Sequence[float]) -> tuple[float, float]:
    """The powers of ten about some values."""
    return 10.0 ** math.floor(math.log10(0.8 * min(values))), 10.0 ** math.ceil(
        math.log10(1.25 * max(values))
    )
