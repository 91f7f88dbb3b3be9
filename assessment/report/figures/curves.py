"""Curves: pushdown of a state, pushovers of all states by direction."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from assessment.report.figures.style import COLOURS, DASHES, chart, key, state_style
from assessment.report.tables.curves import alpha_at_d_0
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import label
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Direction
from assessment.results.schema.static import PushdownPath, Pushovers
from assessment.results.table import sense
from mechanics.pictures import MARKS
from mechanics.types import Array

WIDTHS = {"rigid": 1.4, "elastic": 2.4}
ONSET, END, YIELD = MARKS


def draw_pushdown(results: Results, words: Words, state: str) -> Figure:
    """Draw both reactions of the moved support over the movement; applied and ultimate movement marked."""
    content = results.states[state]
    figure, panels = chart(words, columns=2, height_mm=54.0, foot_mm=12.0)
    for axes, component in zip(panels, ("x", "z"), strict=True):
        for contacts, path in content.pushdown.items():
            force = path.reaction_x_kN if component == "x" else path.reaction_z_kN
            named = words.plain(f"value.{contacts}")
            axes.plot(_mm(path.movement_m), force, color="0.0", linewidth=WIDTHS[contacts], label=named)
        axes.set(xlabel=label("movement_m", words), ylabel=label(f"reaction_{component}_kN", words))
        _keep_rounding_small(axes, content.pushdown.values())
        _movement_lines(axes, content, words)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncols=2)
    return figure


def draw_pushover(results: Results, words: Words, directions: Sequence[Direction]) -> Figure:
    """Draw the pushover curves of all states, a row a direction: whole, and their first branch enlarged.

    Rigid contacts are thin, elastic ones thick; each state has its colour and dashes; α0, (d_y, α_y), d_0 are marked.
    Displacements are counted along the push.
    """
    states = {direction: pushed(results, direction) for direction in directions}
    names = list(dict.fromkeys(name for found in states.values() for name in found))
    every = [pushover for found in states.values() for pushover in found.values()]
    yields = [p.elastic.d_y_m for p in every if p.elastic and p.elastic.d_y_m]
    handles = [key(words.state(name), **state_style(n)) for n, name in enumerate(names)]
    handles += [key(name, **MARKS[name]) for name in _points(every)]
    handles += [
        key(words.plain(f"value.{contacts}"), linewidth=width)
        for contacts, width in WIDTHS.items()
        if any(contacts in pushover.by_contacts for pushover in every)
    ]
    columns = 2 if yields else 1
    foot = 4.0 + 4.0 * -(-len(handles) // 3)
    figure, panels = chart(words, columns=columns, rows=len(directions), height_mm=58.0, foot_mm=foot)
    for at, axes in enumerate(panels):
        direction = directions[at // columns]
        for name, pushover in states[direction].items():
            style = state_style(names.index(name))
            for contacts, push in pushover.by_contacts.items():
                for other in push.members or []:  # of the ensemble
                    others = sense(direction) * _mm(other.displacement_m), other.multiplier
                    axes.plot(*others, color="0.65", linewidth=0.4, linestyle=style["linestyle"])
                along = sense(direction) * _mm(push.curve.displacement_m)
                axes.plot(along, push.curve.multiplier, linewidth=WIDTHS[contacts], **style)
            _key_points(axes, pushover, COLOURS[names.index(name) % len(COLOURS)])
        title = direction_name(direction)
        if yields:
            title += ", " + words.plain(f"figure.{'first_branch' if at % 2 else 'whole_curve'}")
        axes.set(xlabel=label("displacement_m", words), ylabel=label("multiplier", words), title=title)
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(0.0, 6000.0 * max(yields) if at % columns else None)
    figure.legend(handles=handles, loc="lower center", ncols=3)
    return figure


def pushed(results: Results, direction: Direction) -> dict[str, Pushovers]:
    """Return the pushovers in a direction by the states that have one."""
    return {
        name: state.pushover[direction]
        for name, state in results.states.items()
        if direction in state.pushover
    }


def _keep_rounding_small(axes: Axes, paths: Iterable[PushdownPath]) -> None:
    """Draw a reaction that does not change as a level line, not its rounding."""
    largest = max(abs(force) for path in paths for force in (*path.reaction_x_kN, *path.reaction_z_kN))
    low, high = axes.get_ylim()
    if high - low < 1e-3 * largest:
        middle = (low + high) / 2.0
        axes.set_ylim(middle - 0.1 * largest, middle + 0.1 * largest)


def _points(pushovers: Iterable[Pushovers]) -> list[str]:
    """Return the names of the points that any of the curves has."""
    found = list(pushovers)
    there = {
        ONSET: any(each.rigid for each in found),
        END: any(each.rigid and each.rigid.d_0_m is not None for each in found),
        YIELD: any(each.elastic and each.elastic.d_y_m is not None for each in found),
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
            left = alpha_at_d_0(rigid) or 0.0
            axes.plot(1000.0 * rigid.d_0_m, left, color=colour, clip_on=False, **MARKS[END])
    if elastic and elastic.alpha_y is not None and elastic.d_y_m is not None:
        axes.plot(1000.0 * elastic.d_y_m, elastic.alpha_y, color=colour, **MARKS[YIELD])


def _movement_lines(axes: Axes, content: State, words: Words) -> None:
    applied = max(path.applied_movement_m for path in content.pushdown.values())
    if applied > 0.0:
        named = words.plain("figure.applied", movement=words.millimetres(applied))
        axes.axvline(1000.0 * applied, color="0.0", linewidth=0.7, linestyle=DASHES[1], label=named)
    for contacts, path in content.pushdown.items():
        if (ultimate := path.ultimate_movement_m) is not None:
            movement, width = words.millimetres(ultimate), 0.5 * WIDTHS[contacts]
            named = words.plain("figure.ultimate_line", contacts=contacts, movement=movement)
            axes.axvline(1000.0 * ultimate, color="0.0", linewidth=width, linestyle=DASHES[2], label=named)


def _mm(metres: Sequence[float]) -> Array:
    return 1000.0 * np.asarray(metres, dtype=float)
