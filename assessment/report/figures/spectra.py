"""Demand spectra over the period; capacity and demand in spectral coordinates, one panel per state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.report.figures.style import DASHES, OVER_LINES, chart
from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Check, Direction
from assessment.results.schema.part import known
from assessment.results.table import reference_of
from mechanics.types import GRAVITY

OFFSET: dict[str, Any] = {"textcoords": "offset points"}
LONGEST = 4.0  # s: what is drawn of the spectra


def draw_spectra(
    results: Results, words: Words, states: Sequence[str], direction: Direction, limit: str
) -> Figure:
    """Draw a* over d* (m) of each state with the spectrum it can bear and the one demanded of it.

    Spectra have the damping of the limit state and are scaled to the a_g demanded and to the a_g borne; the
    latter meets the line of period T of the limit state at d*.
    """
    columns = min(2, len(states))
    rows = -(-len(states) // columns)
    figure, panels = chart(words, columns=columns, rows=rows, height_mm=80.0)
    capacities = [results.states[name].capacity[direction] for name in states]
    reach = 1.25 * max(
        max(_reach(capacity, limit), _needed(capacity.checks[limit])) for capacity in capacities
    )
    top = max(_top(capacity, limit) for capacity in capacities)
    demanded = False  # some of the demand is on the sheet
    for axes, name, capacity in zip(panels, states, capacities, strict=False):
        point = capacity.checks[limit]
        spectrum = (results.spectra or {}).get(limit)
        _period_lines(axes, words, (0.5, 1.0, 2.0, 3.0), reach, top)
        curve = capacity.curve
        axes.plot(1000.0 * np.asarray(curve.d_star_m), curve.a_star_g, color="0.0", linewidth=1.9)
        if spectrum is not None:
            for level, dashes in ((point.demand_a_g_g, DASHES[2]), (point.a_g_g, DASHES[0])):
                factor = (level or np.nan) / spectrum.a_g_g
                shown = np.asarray(spectrum.T_s) <= max(LONGEST, 1.2 * (point.T_s or 0.0))
                displacement = factor * np.asarray(spectrum.damped_S_De_m)[shown]
                acceleration = factor * np.asarray(spectrum.damped_S_e_g)[shown]
                visible = bool(np.any((displacement > 0.0) & (displacement < reach) & (acceleration < top)))
                demanded |= visible and dashes == DASHES[2]
                axes.plot(
                    1000.0 * displacement,
                    acceleration,
                    color="0.0",
                    linewidth=0.9,
                    linestyle=dashes,
                )
        if point.d_star_m is not None:
            _limit_point(axes, point, limit)
        axes.set(xlim=(0.0, 1000.0 * reach), ylim=(0.0, top), title=words.state(name))
        axes.set(xlabel=words.plain("figure.d_star"), ylabel=words.plain("figure.a_star"))
    for axes in panels[len(states) :]:
        axes.set_axis_off()
    figure.legend(
        handles=_spectra_handles(words, limit, reference_of(results), shown=demanded),
        loc="lower center",
        ncols=2,
    )
    return figure


def draw_demand(results: Results, words: Words) -> Figure:
    """Draw S_e (g) and S_De (mm) of each limit state over the period, 5 % damping."""
    figure, (above, below) = chart(words, columns=2, height_mm=66.0, foot_mm=12.0)
    for dashes, (limit, spectrum) in zip(DASHES, known(results.spectra).items(), strict=False):
        T = np.asarray(spectrum.T_s, dtype=float)
        shown = T <= LONGEST
        for axes, ordinates, factor in ((above, spectrum.S_e_g, 1.0), (below, spectrum.S_De_m, 1000.0)):
            values = factor * np.asarray(ordinates, dtype=float)
            axes.plot(T[shown], values[shown], color="0.0", linewidth=1.2, linestyle=dashes, label=limit)
    for axes, label in ((above, "figure.S_e"), (below, "figure.S_De")):
        axes.set(xlabel=words.plain("figure.period"), ylabel=words.plain(label), xlim=(0.0, LONGEST))
        axes.set_ylim(bottom=0.0)
    figure.legend(*above.get_legend_handles_labels(), loc="lower center", ncols=4)
    return figure


def _reach(capacity: Capacity, limit: str) -> float:
    points = [*capacity.curve.d_star_m, capacity.checks[limit].d_star_m]
    return float(max(point for point in points if point is not None))


def _needed(point: Check) -> float:
    """Return the demanded displacement in m, at most twice the capacity: the rest is off the sheet."""
    if not point.d_star_m or not point.a_g_g or not point.demand_a_g_g:
        return 0.0
    return float(point.d_star_m * min(2.0, point.demand_a_g_g / point.a_g_g))


def _top(capacity: Capacity, limit: str) -> float:
    point = capacity.checks[limit]
    secant = _secant(point.d_star_m, point.T_s) if point.d_star_m and point.T_s else 0.0
    return float(max(3.0 * max(capacity.curve.a_star_g), 1.8 * secant))


def _secant(displacement: float, period: float) -> float:
    """Return the spectral acceleration in g that has this displacement (m) at this period (s)."""
    return float((2.0 * np.pi / period) ** 2 * displacement / GRAVITY)


def _period_lines(axes: Axes, words: Words, periods: Sequence[float], reach: float, top: float) -> None:
    for period in periods:
        edge = min(reach, top / _secant(1.0, period))
        axes.plot([0.0, 1000.0 * edge], [0.0, _secant(edge, period)], color="0.7", linewidth=0.5, zorder=1.2)
        axes.annotate(
            words.comma(f"{period:g} s"),
            (1000.0 * edge, _secant(edge, period)),
            (-4.0, -3.0),
            ha="right",
            va="top",
            color="0.45",
            fontsize=6.0,
            clip_on=True,
            bbox=OVER_LINES,
            zorder=1.5,  # over its line and the grid, under the curves
            **OFFSET,
        )


def _limit_point(axes: Axes, point: Check, limit: str) -> None:
    reached, a_star = known(point.d_star_m), known(point.a_star_g)
    d_star = 1000.0 * reached
    axes.plot(d_star, a_star, marker="s", color="0.0", markersize=4.5, linestyle="none")
    axes.annotate(
        f"$d^*_{{\\mathrm{{{limit}}}}}$",
        (d_star, 0.0),
        (3, 3),  # by the axis: curve and secant are above
        ha="left",
        va="bottom",
        parse_math=True,
        bbox=OVER_LINES,
        **OFFSET,
    )
    if point.T_s:
        height = _secant(reached, point.T_s)
        axes.plot([0.0, d_star], [0.0, height], color="0.0", linewidth=0.6, linestyle=DASHES[1])
        axes.plot([d_star, d_star], [0.0, height], color="0.0", linewidth=0.4)
        axes.plot(
            d_star, height, marker="o", color="0.0", markerfacecolor="1.0", markersize=5, linestyle="none"
        )
        axes.annotate(
            f"$T_{{\\mathrm{{{limit}}}}}$",
            (d_star, height),
            (4, 3),
            va="bottom",
            parse_math=True,
            bbox=OVER_LINES,
            **OFFSET,
        )


def _spectra_handles(words: Words, limit: str, reference: str, shown: bool) -> list[Line2D]:
    """Return the legend; `shown`: whether any of the demand is on the sheet, else it says so."""
    demand = "figure.demand_spectrum" if shown else "figure.demand_beyond"
    borne = words.plain("figure.borne_spectrum", limit=limit, reference=words.plain(f"value.on_{reference}"))
    return [
        Line2D([], [], color="0.0", linewidth=1.9, label=words.plain("figure.capacity_curve")),
        Line2D([], [], color="0.0", linewidth=0.9, label=borne),
        Line2D([], [], color="0.0", marker="s", markersize=4.5, linestyle="none",
               label=words.plain("figure.limit_point", limit=limit)),
        Line2D([], [], color="0.0", linewidth=0.9, linestyle=DASHES[2],
               label=words.plain(demand, limit=limit)),
    ]  # fmt: skip
