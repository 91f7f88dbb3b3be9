"""What was measured: rows of fields, as CSV, as a Markdown table, and as plots of error over processor time."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from itertools import cycle
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, StrMethodFormatter

from assessment.report.figures.style import DASHES, MM, WIDTH_MM

Row = dict[str, Any]
"""Fields by name, `case` first; None or NaN: not measured; `failed`: why."""

PANELS, HEIGHT_MM, LEGEND_MM = 3, 58.0, 12.0
MARKS = "os^Dvph<"
EXACT = 1e-12  # an error that is none, for a logarithmic axis
IN_PER_CENT = ("error", "saves")


def known(value: object) -> bool:
    """Whether a cell has a value."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def fields(rows: Sequence[Row]) -> list[str]:
    """Names of the fields that any row has a value of, in their order."""
    return list(dict.fromkeys(name for row in rows for name, value in row.items() if known(value)))


def as_csv(rows: Sequence[Row]) -> bytes:
    """All fields that are known of any row; one that is not is empty."""
    text, names = io.StringIO(), fields(rows)
    lines = [[row[name] if known(row.get(name)) else "" for name in names] for row in rows]
    csv.writer(text, lineterminator="\n").writerows([names, *lines])
    return text.getvalue().encode()


def table(rows: Sequence[Row], index: Sequence[str] = (), across: str = "", cells: Sequence[str] = ()) -> str:
    """A Markdown table: a line for each row or value of `index`, a column for each value of `across`."""
    if not across:
        names = [name for name in fields(rows) if name in index or (not index and name != "parameter")]
        return _markdown(names, [[written(name, row.get(name)) for name in names] for row in rows])
    headings = list(dict.fromkeys(written(across, row[across], row) for row in rows))
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        told = [written(name, row.get(name)) for name in cells if known(row.get(name))]
        text = "; ".join(told) if row.get("failed") is None else "fails"
        line = lines.setdefault(tuple(str(row.get(name, "")) for name in index), {})
        line[written(across, row[across], row)] = f"**{text}**" if row.get("default") else text
    return _markdown(
        [*index, *headings], [[*at, *(line.get(each, "") for each in headings)] for at, line in lines.items()]
    )


def _markdown(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in (headings, ["---"] * len(headings), *lines))


def written(name: str, value: Any, row: Row | None = None) -> str:
    """The text of a field; infinitely many segments are the exact bed."""
    if not known(value):
        return ""
    if name == "value" and row:
        times = row["parameter"] == "increment"
        text = "exact" if math.isinf(value) else f"{'× ' if times else ''}{value:g}"
        return f"{1e3 * value:.3g} ms" if row["parameter"].startswith("time step") else text
    if name in IN_PER_CENT:
        return percent(value)
    if name == "alpha" or name.endswith(("_end_m", "_g")):
        return f"{value:.5f}"
    if name in ("least", "median", "most"):
        return f"{value:.3g}"
    return number(value) if isinstance(value, float) else str(value)


def number(value: float) -> str:
    """Two significant digits."""
    if value != 0.0 and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return f"{value:.0e}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}" if value else "0"


def percent(share: float) -> str:
    """A share in per cent, two significant digits."""
    return "< 1e-5 %" if 0.0 < abs(share) < 1e-7 else f"{number(100.0 * share)} %"


def work_precision(rows: Sequence[Row], series: str) -> Figure:
    """Error over processor time: a panel for each case, a line for each value of `series`; filled: defaults."""
    rows = [row for row in rows if row.get("failed") is None and known(row.get("error"))]
    cases, names = (list(dict.fromkeys(row[name] for row in rows)) for name in ("case", series))
    looks = dict(zip(names, zip(cycle(DASHES), cycle(MARKS), strict=False), strict=False))
    height = math.ceil(len(cases) / PANELS)
    figure = Figure(figsize=(WIDTH_MM * MM, (height * HEIGHT_MM + LEGEND_MM) * MM), layout="constrained")
    panels = figure.subplots(height, PANELS, squeeze=False).ravel()
    for axes, case in zip(panels, cases, strict=False):
        own = [row for row in rows if row["case"] == case]
        floor = max(EXACT, 0.1 * min((row["error"] for row in own if row["error"] > EXACT), default=EXACT))
        for name, (dashes, mark) in looks.items():
            line = [row for row in own if row[series] == name]
            points = [(row["seconds"], max(row["error"], floor)) for row in line]
            style: dict[str, Any] = {"color": "0.0", "linewidth": 0.8, "marker": mark, "markersize": 3.5}
            x, y = zip(*points, strict=True) if points else ((), ())
            axes.plot(x, y, linestyle=dashes, fillstyle="none", label=str(name), **style)
            for row, point in zip(line, points, strict=True):
                if row.get("default"):
                    axes.plot(*point, fillstyle="full", **style)
            for k in {0, len(line) - 1} if line else ():
                text = written("value", line[k]["value"], line[k])
                axes.annotate(text, points[k], (3, 2), textcoords="offset points", fontsize=5)
        axes.set(xscale="log", yscale="log", title="\n".join(case.split(", ", 1)))
        axes.set(xlabel="processor time, s", ylabel="relative error")
        for axis in (axes.xaxis, axes.yaxis):
            # powers as formulas are not typeset in figures
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
    for axes in panels[len(cases) :]:
        axes.set_axis_off()
    lines = panels[0].get_legend_handles_labels()
    figure.legend(*lines, loc="outside lower center", ncols=PANELS, fontsize=6)
    return figure
