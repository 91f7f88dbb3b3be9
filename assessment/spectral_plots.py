"""Capacity and demand in spectral coordinates: acceleration over displacement, one panel per state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.canvas import DASHES, chart
from assessment.outlines import Array
from assessment.words import Words
from mechanics.block import GRAVITY

Results = Mapping[str, Any]
OFFSET: dict[str, Any] = {"textcoords": "offset points"}
DAMPING = {"SLV": 0.08, "SLC": 0.10}  # Circolare 7/2019 C8.7.1.2


def draw_spectra(results: Results, words: Words, states: Sequence[str], direction: str, limit: str) -> Figure:
    """Draw a* over d* (m) of each state with the spectrum it can bear and the one demanded of it.

    Spectra have the damping of the limit state. The demand spectrum is scaled by a_g capacity / a_g demand;
    it meets the line of period T of the limit state at d*.
    """
    columns = min(2, len(states))
    rows = -(-len(states) // columns)
    figure, panels = chart(words, columns=columns, rows=rows, height_mm=80.0)
    capacities = [results["states"][name]["capacity"][direction] for name in states]
    reach = 1.25 * max(max(_reach(capacity, limit), _needed(capacity[limit])) for capacity in capacities)
    top = max(_top(capacity, limit) for capacity in capacities)
    for axes, name, capacity in zip(panels, states, capacities, strict=False):
        point = capacity[limit]
        demand = _demand(results, limit, point.get("damping"))
        _period_lines(axes, (0.5, 1.0, 2.0, 3.0), reach, top)
        curve = capacity["curve"]
        axes.plot(1000.0 * np.asarray(curve["d_star_m"]), curve["a_star_g"], color="0.0", linewidth=1.9)
        if demand is not None:
            axes.plot(1000.0 * demand[1], demand[0], color="0.0", linewidth=0.9, linestyle=DASHES[2])
            if point.get("a_g_g") and point.get("demand_a_g_g"):
                factor = point["a_g_g"] / point["demand_a_g_g"]
                axes.plot(1000.0 * factor * demand[1], factor * demand[0], color="0.0", linewidth=0.9)
        if point.get("d_star_m") is not None:
            _limit_point(axes, point, limit)
        axes.set(xlim=(0.0, 1000.0 * reach), ylim=(0.0, top), title=words.state(name))
        axes.set(xlabel=words.plain("figure.d_star"), ylabel=words.plain("figure.a_star"))
    for axes in panels[len(states) :]:
        axes.set_axis_off()
    figure.legend(handles=_spectra_handles(words, limit), loc="lower center", ncols=2)
    return figure


def damped(acceleration: Array, period: Array, damping: float) -> Array:
    """Return a 5 % NTC elastic spectrum at another damping: η = √(10/(5+ξ)) ≥ 0.55 (NTC 2018 §3.2.3.2.1).

    Above T_B the spectrum is proportional to η; below, S_e = a_g S (η F0 T/T_B + 1 − T/T_B), so that it
    loses (1 − η) S_max T/T_B. T_B is read as the first period at the plateau.
    """
    eta = max(float(np.sqrt(10.0 / (5.0 + 100.0 * damping))), 0.55)
    peak = acceleration.max()
    t_b = period[np.argmax(acceleration >= (1.0 - 1e-9) * peak)]
    below: Array = acceleration - (1.0 - eta) * peak * period / max(t_b, 1e-12)
    return np.where(period < t_b, below, eta * acceleration)


def _demand(results: Results, limit: str, damping: float | None) -> tuple[Array, Array] | None:
    """Return acceleration (g) and displacement (m) of the demand spectrum at the limit state's damping."""
    spectrum = (results.get("spectra") or {}).get(limit)
    if spectrum is None:
        return None
    if "damped_S_e_g" in spectrum:  # of a record: no rule gives one damping from another
        acceleration, displacement = (
            np.asarray(spectrum[f"damped_{key}"], dtype=float) for key in ("S_e_g", "S_De_m")
        )
        return acceleration, displacement
    period, five = (np.asarray(spectrum[key], dtype=float) for key in ("T_s", "S_e_g"))
    scaled = damped(five, period, DAMPING[limit] if damping is None else damping)
    ratio = np.divide(scaled, five, out=np.ones_like(five), where=five > 0.0)
    return scaled, np.asarray(spectrum["S_De_m"], dtype=float) * ratio


def _reach(capacity: Mapping[str, Any], limit: str) -> float:
    points = [*capacity["curve"]["d_star_m"], capacity[limit].get("d_star_m")]
    return float(max(point for point in points if point is not None))


def _needed(point: Mapping[str, Any]) -> float:
    """Return the demanded displacement in m, at most twice the capacity: the rest is off the sheet."""
    if not point.get("d_star_m") or not point.get("a_g_g") or not point.get("demand_a_g_g"):
        return 0.0
    return float(point["d_star_m"] * min(2.0, point["demand_a_g_g"] / point["a_g_g"]))


def _top(capacity: Mapping[str, Any], limit: str) -> float:
    point = capacity[limit]
    secant = _secant(point["d_star_m"], point["T_s"]) if point.get("d_star_m") and point.get("T_s") else 0.0
    return float(max(3.0 * max(capacity["curve"]["a_star_g"]), 1.8 * secant))


def _secant(displacement: float, period: float) -> float:
    """Return the spectral acceleration in g that has this displacement (m) at this period (s)."""
    return float((2.0 * np.pi / period) ** 2 * displacement / GRAVITY)


def _period_lines(axes: Axes, periods: Sequence[float], reach: float, top: float) -> None:
    for period in periods:
        edge = min(reach, top / _secant(1.0, period))
        axes.plot([0.0, 1000.0 * edge], [0.0, _secant(edge, period)], color="0.7", linewidth=0.5)
        axes.annotate(
            f"{period:g} s",
            (1000.0 * edge, _secant(edge, period)),
            (-2.0, -2.0),
            ha="right",
            va="top",
            color="0.45",
            fontsize=6.0,
            clip_on=True,
            **OFFSET,
        )


def _limit_point(axes: Axes, point: Mapping[str, Any], limit: str) -> None:
    d_star = 1000.0 * point["d_star_m"]
    axes.plot(d_star, point["a_star_g"], marker="s", color="0.0", markersize=4.5, linestyle="none")
    axes.annotate(
        f"$d^*_{{\\mathrm{{{limit}}}}}$",
        (d_star, point["a_star_g"]),
        (-3, -4),
        ha="right",
        va="top",
        **OFFSET,
    )
    if point.get("T_s"):
        height = _secant(point["d_star_m"], point["T_s"])
        axes.plot([0.0, d_star], [0.0, height], color="0.0", linewidth=0.6, linestyle=DASHES[1])
        axes.plot([d_star, d_star], [0.0, height], color="0.0", linewidth=0.4)
        axes.plot(
            d_star, height, marker="o", color="0.0", markerfacecolor="1.0", markersize=5, linestyle="none"
        )
        axes.annotate(f"$T_{{\\mathrm{{{limit}}}}}$", (d_star, height), (4, 3), va="bottom", **OFFSET)


def _spectra_handles(words: Words, limit: str) -> list[Line2D]:
    return [
        Line2D([], [], color="0.0", linewidth=1.9, label=words.plain("figure.capacity_curve")),
        Line2D([], [], color="0.0", linewidth=0.9, label=words.plain("figure.borne_spectrum", limit=limit)),
        Line2D([], [], color="0.0", marker="s", markersize=4.5, linestyle="none",
               label=words.plain("figure.limit_point", limit=limit)),
        Line2D([], [], color="0.0", linewidth=0.9, linestyle=DASHES[2],
               label=words.plain("figure.demand_spectrum", limit=limit)),
    ]  # fmt: skip
