"""Curves: pushdown of a state, pushover of all states in one plot."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from assessment.report.figures.style import COLOURS, DASHES, chart, state_style
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.outlines import Array
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Direction
from assessment.results.schema.static import PushdownPath, Pushovers
from assessment.results.table import sense

WIDTHS = {"rigid": 0.8, "elastic": 1.9}
YIELD: dict[str, Any] = {"marker": "s", "markersize": 4.0, "markerfacecolor": "1.0", "linestyle": "none"}


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
    figure, panels = chart(words, columns=2 if yields else 1, height_mm=68.0)
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
    handles = [
        Line2D([], [], **state_style(number).keywords, label=_key_numbers(name, pushover, words))
        for number, (name, pushover) in enumerate(states.items())
    ]
    if yields:
        handles.append(Line2D([], [], color="0.0", **YIELD, label="d_y, α_y"))
    handles += [
        Line2D([], [], color="0.0", linewidth=WIDTHS[contacts], label=words.plain(f"figure.{contacts}_line"))
        for contacts in ("rigid", "elastic")
        if any(contacts in pushover.by_contacts for pushover in states.values())
    ]
    figure.legend(handles=handles, loc="lower center", ncols=1 if len(handles) < 4 else 2)
    return figure


def pushed(results: Results, direction: Direction) -> dict[str, Pushovers]:
    """Return the pushovers in a direction by the states that have one."""
    return {
        name: state.pushover[direction]
        for name, state in results.states.items()
        if direction in state.pushover
    }


def _key_points(axes: Axes, pushover: Pushovers, colour: str) -> None:
    """Mark α0 (of an ensemble the least), d_0 and (d_y, α_y); the last, among the curves, is named in the legend."""
    mark: dict[str, Any] = {"color": colour, "markerfacecolor": "1.0", "linestyle": "none", "clip_on": True}
    rigid, elastic = pushover.rigid, pushover.elastic
    text: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": True, "parse_math": True}
    if rigid:
        curve = min([rigid.curve, *(rigid.members or [])], key=lambda each: max(each.multiplier))
        peak = int(np.argmax(curve.multiplier))
        onset = 1000.0 * abs(curve.displacement_m[peak]), curve.multiplier[peak]
        axes.plot(*onset, marker="o", markersize=4.5, **(mark | {"clip_on": False}))
        axes.annotate("$\\alpha_0$", onset, (5, 3), **text)
        if rigid.d_0_m is not None:
            axes.plot(1000.0 * rigid.d_0_m, 0.0, marker="^", markersize=5.0, **(mark | {"clip_on": False}))
            axes.annotate("$d_0$", (1000.0 * rigid.d_0_m, 0.0), (4, 4), **text)
    if elastic and elastic.alpha_y is not None and elastic.d_y_m is not None:
        axes.plot(1000.0 * elastic.d_y_m, elastic.alpha_y, color=colour, **YIELD)


def _key_numbers(name: str, pushover: Pushovers, words: Words) -> str:
    """Return the state's line of the legend."""
    rigid, elastic = pushover.rigid, pushover.elastic
    parts = []
    if rigid:
        parts += [f"α₀ = {words.show(rigid.alpha_0)}", f"d₀ = {words.millimetres(rigid.d_0_m)}"]
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
