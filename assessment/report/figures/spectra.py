"""Demand spectra over the period; capacity and demand in spectral coordinates, one panel per state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from assessment.report.figures.style import DASHES, OVER_LINES, chart
from assessment.report.tables.curves import elastic_capacity
from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Check, Direction
from assessment.results.schema.part import known
from assessment.results.table import reference_of
from mechanics.types import GRAVITY

LONGEST = 4.0  # s: what is drawn of the spectra
SCALES_APART = 1.8  # panels whose axes would differ by a larger factor have axes of their own
ELASTIC: dict[str, Any] = {"color": "0.5", "linewidth": 1.4}
PERIODS = (0.5, 1.0, 2.0, 3.0)  # s: of the grey lines
LETTER_PT, SMALL_PT, LINE_PT = 5.0, 4.0, 11.0  # of a text: a letter's width, a small one's, its height
Places = NDArray[np.float64]
Spot = tuple[tuple[float, float], tuple[float, float]]  # a place of a panel, and points from there


def draw_spectra(
    results: Results, words: Words, states: Sequence[str], direction: Direction, limit: str
) -> Figure:
    """Draw a* over d* (m) of each state with the spectrum it can bear and the one demanded of it.

    Spectra have the damping of the limit state and are scaled to the a_g demanded and to the a_g borne; the
    latter meets the line of period T of the limit state at d*. The curve with elastic joints is grey.
    """
    columns = min(2, len(states))
    rows = -(-len(states) // columns)
    figure, panels = chart(words, columns=columns, rows=rows, height_mm=80.0, foot_mm=20.0)
    demanded, elastic = False, False  # some of it is on the sheet
    frames = _frames(results, states, direction, limit)
    for axes, name, (reach, top) in zip(panels, states, frames, strict=False):
        capacity = results.states[name].capacity[direction]
        point = capacity.checks[limit]
        spectrum = (results.spectra or {}).get(limit)
        axes.set(xlim=(0.0, 1000.0 * reach), ylim=(0.0, top), title=words.state(name))
        axes.set(xlabel=words.plain("figure.d_star"), ylabel=words.plain("figure.a_star"))
        _period_lines(axes, reach, top)
        if found := elastic_capacity(results, name, direction):
            axes.plot(1000.0 * found[0], found[1], **ELASTIC)
            elastic = True
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
            _limit_point(axes, point)
        texts = _Texts(axes)
        if point.d_star_m is not None:
            _name_limit_point(texts, point, limit)
        _period_labels(texts, words, reach, top)
    for axes in panels[len(states) :]:
        axes.set_axis_off()
    handles = _spectra_handles(words, limit, reference_of(results), demanded, elastic)
    figure.legend(handles=handles, loc="lower center", ncols=2)
    return figure


def one_scale(results: Results, states: Sequence[str], direction: Direction, limit: str) -> bool:
    """Return whether the panels of the states have the same axes: none of them would be squeezed into a corner."""
    return len(set(_frames(results, states, direction, limit))) == 1


def _frames(
    results: Results, states: Sequence[str], direction: Direction, limit: str
) -> list[tuple[float, float]]:
    """Return the ends of both axes, m and g, of each state's panel: those of the largest if they differ little."""
    capacities = [results.states[name].capacity[direction] for name in states]
    reaches = [1.25 * max(_reach(each, limit), _needed(each.checks[limit])) for each in capacities]
    tops = [_top(each, limit) for each in capacities]
    if all(max(each) <= SCALES_APART * min(each) for each in (reaches, tops)):
        return [(max(reaches), max(tops))] * len(states)
    return list(zip(reaches, tops, strict=True))


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


def _period_lines(axes: Axes, reach: float, top: float) -> None:
    for edge, height in _period_ends(reach, top).values():
        axes.plot([0.0, 1000.0 * edge], [0.0, height], color="0.7", linewidth=0.5, zorder=1.2)


def _period_labels(texts: _Texts, words: Words, reach: float, top: float) -> None:
    """Write the periods at their lines, inside the frame: right of a steep one, below a flat one, near its end."""
    for period, (edge, height) in _period_ends(reach, top).items():
        text = words.comma(f"{period:g} s")
        sides = ((3.0, -1.0), (-3.0, -1.0)) if edge < 0.85 * reach else ((-5.0, -6.0), (-5.0, 7.0))
        spots = [
            ((1000.0 * share * edge, share * height), (x, y - 0.5 * LINE_PT * (height == top)))
            for share in (1.0, 0.9, 0.8, 0.7, 0.6)
            for x, y in sides
        ]
        texts.write(text, SMALL_PT * len(text), spots, color="0.45", fontsize=6.0, zorder=1.5)


def _period_ends(reach: float, top: float) -> dict[float, tuple[float, float]]:
    """Return where the line of each period leaves the frame, m and g."""
    edges = {period: min(reach, top / _secant(1.0, period)) for period in PERIODS}
    return {period: (edge, top if edge < reach else _secant(edge, period)) for period, edge in edges.items()}


def _limit_point(axes: Axes, point: Check) -> None:
    d_star = 1000.0 * known(point.d_star_m)
    axes.plot(d_star, known(point.a_star_g), marker="s", color="0.0", markersize=4.5, linestyle="none")
    if point.T_s:
        height = _secant(d_star / 1000.0, point.T_s)
        axes.plot([0.0, d_star], [0.0, height], color="0.0", linewidth=0.6, linestyle=DASHES[1])
        axes.plot([d_star, d_star], [0.0, height], color="0.0", linewidth=0.4)
        axes.plot(
            d_star, height, marker="o", color="0.0", markerfacecolor="1.0", markersize=5, linestyle="none"
        )


def _name_limit_point(texts: _Texts, point: Check, limit: str) -> None:
    reached = known(point.d_star_m)
    style: dict[str, Any] = {"parse_math": True, "zorder": 1.6}  # white boxes over grid and periods only
    if point.T_s:
        place = 1000.0 * reached, _secant(reached, point.T_s)
        spots = [(place, offset) for offset in ((4.0, 6.0), (-4.0, 6.0), (8.0, 14.0), (-8.0, 14.0))]
        texts.write(*_symbol("T", limit), spots, **style)
    place = 1000.0 * reached, 0.0
    spots = [(place, offset) for offset in ((3.0, 7.0), (-3.0, 7.0), (3.0, 20.0), (-3.0, 20.0))]
    texts.write(*_symbol("d^*", limit), spots, **style)


def _symbol(letter: str, limit: str) -> tuple[str, float]:
    """Return a symbol with the limit state as its index, and about how wide it is, points."""
    return f"${letter}_{{\\mathrm{{{limit}}}}}$", LETTER_PT * (1.6 + 0.7 * len(limit))


class _Texts:
    """The texts of a panel whose curves are drawn: each in the frame, where no curve and no other text crosses it."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._lines = list(_lines_in_points(axes))
        self._taken: list[tuple[Places, Places]] = []  # lower left and upper right corners, points

    def write(self, text: str, width: float, spots: Sequence[Spot], **style: Any) -> None:
        """Write a text so wide (points) at the first spot that is free, else at the first one, below the curves.

        A spot is a place of the panel and from there the middle of the text's near side, in points: to the left of
        the place where it is negative.
        """
        place, offset = next((spot for spot in spots if self._free(self._box(spot, width))), spots[0])
        self._taken.append(self._box((place, offset), width))
        side = "right" if offset[0] < 0 else "left"
        self._axes.annotate(
            text, place, offset, textcoords="offset points", ha=side, va="center", bbox=OVER_LINES, **style
        )

    def _box(self, spot: Spot, width: float) -> tuple[Places, Places]:
        place, offset = spot
        x, y = _points(self._axes, np.array([place]))[0] + offset
        low = np.array([x - (width if offset[0] < 0 else 0.0), y - LINE_PT / 2.0])
        return low, low + np.array([width, LINE_PT])

    def _free(self, box: tuple[Places, Places]) -> bool:
        low, high = box
        least, most = _points(
            self._axes, np.column_stack([self._axes.get_xlim(), self._axes.get_ylim()])
        ) + np.array([[0.0, -2.0], [0.0, 2.0]])
        inside = bool((least <= low).all() and (high <= most).all())
        crossed = any(((line > low) & (line < high)).all(axis=1).any() for line in self._lines)
        covered = any((low < end).all() and (start < high).all() for start, end in self._taken)
        return inside and not crossed and not covered


def _lines_in_points(axes: Axes) -> Iterator[Places]:
    """Yield the curves of a panel as places (n, 2) in points, so near that no text slips between them."""
    for line in axes.get_lines():
        corners = _points(axes, np.asarray(line.get_xydata(), dtype=float))
        corners = corners[np.isfinite(corners).all(axis=1)]
        if line.get_zorder() < 2.0 or len(corners) < 2:  # below 2: grid and periods
            continue
        along = np.r_[0.0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T))]
        at = np.arange(0.0, along[-1], 2.0)
        yield np.column_stack([np.interp(at, along, corners[:, axis]) for axis in (0, 1)])


def _points(axes: Axes, places: Places) -> Places:
    """Return places (n, 2) of a panel's data in points of the figure."""
    return np.asarray(axes.transData.transform(places), dtype=float) * 72.0 / axes.figure.dpi


def _spectra_handles(words: Words, limit: str, reference: str, shown: bool, elastic: bool) -> list[Line2D]:
    """Return the legend; `shown`: whether any of the demand is on the sheet, else it says so."""
    demand = "figure.demand_spectrum" if shown else "figure.demand_beyond"
    borne = words.plain("figure.borne_spectrum", limit=limit, reference=words.plain(f"value.on_{reference}"))
    curve = "figure.capacity_curve" if not elastic else "figure.fitted_curve"
    pushed = Line2D([], [], **ELASTIC, label=words.plain("figure.elastic_capacity"))
    return [
        Line2D([], [], color="0.0", linewidth=1.9, label=words.plain(curve)),
        *([pushed] if elastic else []),
        Line2D([], [], color="0.0", linewidth=0.9, label=borne),
        Line2D([], [], color="0.0", marker="s", markersize=4.5, linestyle="none",
               label=words.plain("figure.limit_point", limit=limit)),
        Line2D([], [], color="0.0", linewidth=0.9, linestyle=DASHES[2],
               label=words.plain(demand, limit=limit)),
    ]  # fmt: skip
