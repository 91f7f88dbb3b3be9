"""Curves: pushdown of a state, pushover of all states in one plot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.report.figures.style import COLOURS, DASHES, chart, state_style
from assessment.report.text.language import Words, direction_name
from assessment.results.outlines import Array
from assessment.results.table import sense

Results = Mapping[str, Any]
WIDTHS = {"rigid": 0.8, "elastic": 1.9}


def draw_pushdown(results: Results, words: Words, state: str) -> Figure:
    """Draw both reactions of the moved support over the movement; applied and ultimate movement marked."""
    content = results["states"][state]
    figure, panels = chart(words, columns=2)
    for axes, component in zip(panels, ("x", "z"), strict=True):
        for contacts, stage in content["pushdown"].items():
            axes.plot(
                _mm(stage["movement_m"]),
                stage[f"reaction_{component}_kN"],
                color="0.0",
                linewidth=WIDTHS[contacts],
                label=words.plain(f"value.{contacts}"),
            )
        axes.set(xlabel=words.plain("figure.movement"), ylabel=words.plain(f"figure.reaction_{component}"))
        _keep_rounding_small(axes, content["pushdown"])
        _movement_lines(axes, content, words)
    _legend_below(figure, panels[0])
    return figure


def _keep_rounding_small(axes: Axes, pushdown: Mapping[str, Any]) -> None:
    """Draw a reaction that does not change as a level line, not its rounding."""
    largest = max(
        max(map(abs, stage[f"reaction_{component}_kN"]))
        for stage in pushdown.values()
        for component in ("x", "z")
    )
    low, high = axes.get_ylim()
    if high - low < 1e-3 * largest:
        middle = (low + high) / 2.0
        axes.set_ylim(middle - 0.1 * largest, middle + 0.1 * largest)


def draw_pushover(results: Results, words: Words, direction: str) -> Figure:
    """Draw the pushover curves of all states in one direction, and their first branch enlarged.

    Rigid contacts are thin, elastic ones thick; each state has its colour and dashes; α0, (d_y, α_y), d_0 are marked.
    Displacements are counted along the push.
    """
    states = {name: content["pushover"][direction] for name, content in pushed(results, direction).items()}
    yields = [p["elastic"]["d_y_m"] for p in states.values() if "elastic" in p and p["elastic"]["d_y_m"]]
    figure, panels = chart(words, columns=2 if yields else 1, height_mm=85.0)
    for axes in panels:
        for number, pushover in enumerate(states.values()):
            for contacts in ("rigid", "elastic"):
                if contacts in pushover:
                    curve = pushover[contacts]["curve"]
                    for other in pushover[contacts].get("members", []):  # of the ensemble
                        others = sense(direction) * _mm(other["displacement_m"]), other["multiplier"]
                        axes.plot(
                            *others, color="0.65", linewidth=0.4, linestyle=state_style(number)["linestyle"]
                        )
                    axes.plot(
                        sense(direction) * _mm(curve["displacement_m"]),
                        curve["multiplier"],
                        linewidth=WIDTHS[contacts],
                        **state_style(number),
                    )
            _key_points(axes, pushover, COLOURS[number % len(COLOURS)], len(panels) == 1 or axes is panels[1])
        along = words.plain("figure.push_displacement", direction=direction_name(direction))
        axes.set(xlabel=along, ylabel=words.plain("figure.multiplier"))
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
    if yields:
        panels[0].set_title(words.plain("figure.whole_curve"))
        panels[1].set_title(words.plain("figure.first_branch"))
        panels[1].set_xlim(0.0, 6000.0 * max(yields))
    handles = [
        Line2D([], [], **state_style(number), label=_key_numbers(name, pushover, words))
        for number, (name, pushover) in enumerate(states.items())
    ]
    handles += [
        Line2D([], [], color="0.0", linewidth=WIDTHS[contacts], label=words.plain(f"figure.{contacts}_line"))
        for contacts in ("rigid", "elastic")
        if any(contacts in pushover for pushover in states.values())
    ]
    figure.legend(handles=handles, loc="lower center", ncols=1 if len(handles) < 4 else 2)
    return figure


def pushed(results: Results, direction: str) -> dict[str, Any]:
    """Return the states that have a pushover in the direction."""
    return {n: s for n, s in results["states"].items() if (s.get("pushover") or {}).get(direction)}


def _key_points(axes: Axes, pushover: Mapping[str, Any], colour: str, names_yield: bool) -> None:
    mark: dict[str, Any] = {"color": colour, "markerfacecolor": "1.0", "linestyle": "none", "clip_on": True}
    rigid, elastic = pushover.get("rigid"), pushover.get("elastic")
    text: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": True, "parse_math": True}
    if rigid:
        peak = int(np.argmax(rigid["curve"]["multiplier"]))
        onset = 1000.0 * abs(rigid["curve"]["displacement_m"][peak]), rigid["curve"]["multiplier"][peak]
        axes.plot(*onset, marker="o", markersize=4.5, **(mark | {"clip_on": False}))
        axes.annotate("$\\alpha_0$", onset, (5, 3), **text)
        if rigid["d_0_m"] is not None:
            axes.plot(1000.0 * rigid["d_0_m"], 0.0, marker="^", markersize=5.0, **(mark | {"clip_on": False}))
            axes.annotate("$d_0$", (1000.0 * rigid["d_0_m"], 0.0), (-2, 7), ha="right", **text)
    if elastic and elastic["alpha_y"] is not None and elastic["d_y_m"] is not None:
        axes.plot(1000.0 * elastic["d_y_m"], elastic["alpha_y"], marker="s", markersize=4.0, **mark)
        if names_yield:
            place = (1000.0 * elastic["d_y_m"], elastic["alpha_y"])
            axes.annotate("$d_y, \\alpha_y$", place, (0, 5), ha="center", **text)


def _key_numbers(name: str, pushover: Mapping[str, Any], words: Words) -> str:
    """Return the state's line of the legend."""
    rigid, elastic = pushover.get("rigid"), pushover.get("elastic")
    parts = []
    if rigid:
        parts += [f"α₀ = {words.show(rigid['alpha_0'])}", f"d₀ = {words.millimetres(rigid['d_0_m'])}"]
    if elastic:
        parts += [f"α_y = {words.show(elastic['alpha_y'])}", f"d_y = {words.millimetres(elastic['d_y_m'])}"]
    return f"{words.state(name)}: " + ", ".join(parts)


def _movement_lines(axes: Axes, content: Mapping[str, Any], words: Words) -> None:
    applied = max(stage["applied_movement_m"] for stage in content["pushdown"].values())
    if applied > 0.0:
        axes.axvline(1000.0 * applied, color="0.0", linewidth=0.7, linestyle=DASHES[1],
                     label=words.plain("figure.applied", movement=words.millimetres(applied)))  # fmt: skip
    for contacts, stage in content["pushdown"].items():
        ultimate = stage.get("ultimate_movement_m")
        if ultimate is not None:
            label = words.plain(
                "figure.ultimate_line",
                contacts=words.plain(f"value.{contacts}"),
                movement=words.millimetres(ultimate),
            )
            axes.axvline(
                1000.0 * ultimate, color="0.0", linewidth=WIDTHS[contacts], linestyle=DASHES[2], label=label
            )


def _legend_below(figure: Figure, axes: Axes) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=2)


def _mm(metres: Sequence[float]) -> Array:
    return 1000.0 * np.asarray(metres, dtype=float)
