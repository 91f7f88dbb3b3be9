"""Curves: pushdown of a state, pushover of all states in one plot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.report.figures.style import COLOURS, DASHES, chart, state_style
from assessment.report.tables.curves import alpha_at_d_0
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.outlines import Array
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Direction
from assessment.results.schema.static import PushdownPath, Pushovers
from assessment.results.table import sense

WIDTHS = {"rigid": 0.8, "elastic": 1.9}
MARKS: dict[str, dict[str, Any]] = {  # of the points of a curve, by their names in the legend
    name: {"marker": marker, "markersize": size, "markerfacecolor": "1.0", "linestyle": "none"}
    for name, marker, size in (("α₀", "o", 4.5), ("d₀", "^", 5.0), ("d_y, α_y", "s", 4.0))
}
ONSET, END, YIELD = MARKS


def draw_pushdown(results: Results, words: Words, state: str) -> Figure:
    """Draw both reactions of the moved support over the movement; applied and ultimate movement marked."""
    content = results.states[state]
    figure, panels = chart(words, columns=2, height_mm=66.0)
    for axes, component in zip(panels, ("x", "z"), strict=True):
        for contacts, path in content.pushdown.items():
            axes.plot(
                _mm(path.movement_m),
                path.reaction_x_kN if component == "x" else path.reaction_z_kN,
                color="0.0",
                linewidth=WIDTHS[contacts],
                label=words.plain(f"value.{contacts}"),
            )
        axes.set(xlabel=words.plain("figure.movement"), ylabel=words.plain(f"figure.reaction_{component}"))
        _keep_rounding_small(axes, content.pushdown.values())
        _movement_lines(axes, content, words)
    _legend_below(figure, panels[0])
    return figure


def _keep_rounding_small(axes: Axes, paths: Iterable[PushdownPath]) -> None:
    """Draw a reaction that does not change as a level line, not its rounding."""
    largest = max(abs(force) for path in paths for force in (*path.reaction_x_kN, *path.reaction_z_kN))
    low, high = axes.get_ylim()
    if high - low < 1e-3 * largest:
        middle = (low + high) / 2.0
        axes.set_ylim(middle - 0.1 * largest, middle + 0.1 * largest)


def draw_pushover(results: Results, words: Words, direction: Direction) -> Figure:
    """Draw the pushover curves of all states in one direction, and their first branch enlarged.

    Rigid contacts are thin, elastic ones thick; each state has its colour and dashes; α0, (d_y, α_y), d_0 are marked.
    Displacements are counted along the push.
    """
    states = pushed(results, direction)
    yields = [p.elastic.d_y_m for p in states.values() if p.elastic and p.elastic.d_y_m]
    handles = _pushover_handles(states, words)
    ncols = 1 if len(handles) < 4 else 2
    foot_mm = max(16.0, 4.0 * math.ceil(len(handles) / ncols) + 4.0)
    figure, panels = chart(words, columns=2 if yields else 1, height_mm=68.0, foot_mm=foot_mm)
    for axes in panels:
        for number, pushover in enumerate(states.values()):
            for contacts, push in pushover.by_contacts.items():
                for other in push.members or []:  # of the ensemble
                    others = sense(direction) * _mm(other.displacement_m), other.multiplier
                    axes.plot(*others, color="0.65", linewidth=0.4, linestyle=state_style(number).linestyle)
                axes.plot(
                    sense(direction) * _mm(push.curve.displacement_m),
                    push.curve.multiplier,
                    linewidth=WIDTHS[contacts],
                    **state_style(number).keywords,
                )
            _key_points(axes, pushover, COLOURS[number % len(COLOURS)])
        along = words.plain("figure.push_displacement", direction=direction_name(direction))
        axes.set(xlabel=along, ylabel=words.plain("figure.multiplier"))
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
    if yields:
        panels[0].set_title(words.plain("figure.whole_curve"))
        panels[1].set_title(words.plain("figure.first_branch"))
        panels[1].set_xlim(0.0, 6000.0 * max(yields))
    figure.legend(handles=handles, loc="lower center", ncols=ncols)
    return figure


def pushed(results: Results, direction: Direction) -> dict[str, Pushovers]:
    """Return the pushovers in a direction by the states that have one."""
    return {
        name: state.pushover[direction]
        for name, state in results.states.items()
        if direction in state.pushover
    }


def _pushover_handles(states: Mapping[str, Pushovers], words: Words) -> list[Line2D]:
    """Return the legend: the states with their numbers, the points of curves, the kinds of joints."""
    handles = [
        Line2D([], [], **state_style(number).keywords, label=_key_numbers(name, pushover, words))
        for number, (name, pushover) in enumerate(states.items())
    ]
    handles += [Line2D([], [], color="0.0", **MARKS[name], label=name) for name in _points(states.values())]
    handles += [
        Line2D([], [], color="0.0", linewidth=WIDTHS[contacts], label=words.plain(f"figure.{contacts}_line"))
        for contacts in ("rigid", "elastic")
        if any(contacts in pushover.by_contacts for pushover in states.values())
    ]
    return handles


def _points(pushovers: Iterable[Pushovers]) -> list[str]:
    """Return the names of the points that any of the curves has."""
    rigid = [push.rigid for push in pushovers if push.rigid]
    elastic = [push.elastic for push in pushovers if push.elastic]
    there = {
        ONSET: bool(rigid),
        END: any(each.d_0_m is not None for each in rigid),
        YIELD: any(each.d_y_m is not None for each in elastic),
    }
    return [name for name, has in there.items() if has]


def _key_points(axes: Axes, pushover: Pushovers, colour: str) -> None:
    """Mark α0, d_0 and (d_y, α_y): named in the legend, beside a point they met others."""
    rigid, elastic = pushover.rigid, pushover.elastic
    if rigid:
        peak = int(np.argmax(rigid.curve.multiplier))
        onset = 1000.0 * abs(rigid.curve.displacement_m[peak]), rigid.curve.multiplier[peak]
        axes.plot(*onset, color=colour, clip_on=False, **MARKS[ONSET])
        if rigid.d_0_m is not None:
            axes.plot(
                1000.0 * rigid.d_0_m, alpha_at_d_0(rigid) or 0.0, color=colour, clip_on=False, **MARKS[END]
            )
    if elastic and elastic.alpha_y is not None and elastic.d_y_m is not None:
        axes.plot(1000.0 * elastic.d_y_m, elastic.alpha_y, color=colour, **MARKS[YIELD])


def _key_numbers(name: str, pushover: Pushovers, words: Words) -> str:
    """Return the state's line of the legend."""
    rigid, elastic = pushover.rigid, pushover.elastic
    parts = []
    if rigid:
        left = alpha_at_d_0(rigid)
        lost = "" if left is None else f" (α = {words.show(left)})"
        parts += [f"α₀ = {words.show(rigid.alpha_0)}", f"d₀ = {words.millimetres(rigid.d_0_m)}{lost}"]
    if elastic:
        parts += [f"α_y = {words.show(elastic.alpha_y)}", f"d_y = {words.millimetres(elastic.d_y_m)}"]
    return f"{words.state(name)}: " + ", ".join(parts)


def _movement_lines(axes: Axes, content: State, words: Words) -> None:
    applied = max(path.applied_movement_m for path in content.pushdown.values())
    if applied > 0.0:
        axes.axvline(1000.0 * applied, color="0.0", linewidth=0.7, linestyle=DASHES[1],
                     label=words.plain("figure.applied", movement=words.millimetres(applied)))  # fmt: skip
    for contacts, path in content.pushdown.items():
        ultimate = path.ultimate_movement_m
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
