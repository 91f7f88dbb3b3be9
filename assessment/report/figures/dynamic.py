"""Figures of the dynamic stages: records, control displacements, deformed shapes, IDA curves, fragility."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from assessment.report.figures.drawings.parts import draw_ties, ghost_handle, moved_ends, tie_handles
from assessment.report.figures.style import DASHES, chart, comma_ticks, sheet, state_style
from assessment.report.text.language import Words
from assessment.report.text.quantities import label
from assessment.results.configurations.outlines import outlines
from assessment.results.schema import Results
from assessment.results.schema.dynamic import History, Incremental, Search
from assessment.results.schema.part import known
from mechanics.pictures import Shape, fill_roles, ghost

MARKERS = ("o", "s", "^", "v", "D", "P", "X", "*")
BAND = "0.82"  # grey between the members of an ensemble
FALLING = 0.03  # of the model's size: how far the curve of a collapse is followed at least
LEAST_M = 1e-5  # what an axis of displacements shows at least: where nothing moves, no rounding
SHADE, FAINT = "0.0", 0.12  # of the bounds of a fragility: colour and opacity
AROUND = 0.5  # of the model's size: how far from it fallen blocks are still drawn


def draw_motion(results: Results, words: Words, index: int) -> Figure:
    """Draw a base motion over time and its acceleration spectrum at 5 % damping."""
    motion = known(results.motions)[index]
    figure, panels = chart(words, columns=2, height_mm=48.0, foot_mm=0.0)
    panels[0].plot(motion.time_s, motion.acceleration_g, color="0.0", linewidth=0.5)
    panels[0].set(xlabel=label("time_s", words), ylabel=label("acceleration_g", words))
    panels[0].set_xlim(*motion.window_s)
    panels[1].plot(motion.T_s, motion.S_a_g, color="0.0")
    panels[1].set(xlabel=label("T_s", words), ylabel=label("S_a_g", words))
    panels[1].set(xlim=(0.0, motion.T_s[-1]), ylim=(0.0, None))
    return figure


def draw_history(results: Results, words: Words, index: int) -> Figure:
    """Draw the control displacement of every state under one record; a cross marks collapse."""
    found = shaken(results, known(results.motions)[index].name)
    figure, (axes,) = chart(words, height_mm=68.0)
    size = outlines(results).size
    falls = [entry for entry in found.values() if entry.collapsed]
    sustained = [1.3 * known(entry.sustained_displacement_m) for entry in found.values()]
    bound = max([*sustained, *(min(FALLING * size, known(entry.peak_displacement_m)) for entry in falls)])
    for number, entry in enumerate(found.values()):
        curve = known(entry.curve)
        time, displacement = np.asarray(curve.time_s), np.asarray(curve.displacement_m)
        if entry.band:
            low, high = 1000.0 * np.asarray(entry.band.low_m), 1000.0 * np.asarray(entry.band.high_m)
            axes.fill_between(time, low, high, color=BAND, linewidth=0.0)
        axes.plot(time, 1000.0 * displacement, linewidth=0.9, **state_style(number).keywords)
        if entry.collapsed:
            out = int(np.flatnonzero(abs(displacement) <= bound)[-1])
            place = 1000.0 * displacement[out]
            axes.plot(time[out], place, marker="x", color="0.0", markersize=6.0, clip_on=False)
    until = [entry.free_motion_from_s for entry in found.values() if entry.free_motion_from_s is not None]
    if until:
        axes.axvline(min(until), color="0.0", linewidth=0.5, linestyle=DASHES[2])
    axes.set(xlabel=label("time_s", words), ylabel=label("displacement_m", words))
    axes.set_ylim(*(1050.0 * max(bound, LEAST_M) * side for side in (-1.0, 1.0)))
    handles: list[Artist] = [
        Line2D([], [], linewidth=0.9, label=_outcome(state, entry, words), **state_style(number).keywords)
        for number, (state, entry) in enumerate(found.items())
    ]
    if falls:
        named = words.plain("figure.collapse")
        handles.append(Line2D([], [], color="0.0", marker="x", linestyle="none", label=named))
    if any(entry.band for entry in found.values()):
        handles.append(Patch(color=BAND, linewidth=0.0, label=words.plain("figure.members")))
    if until:
        named = words.plain("figure.free_motion")
        handles.append(Line2D([], [], color="0.0", linewidth=0.5, linestyle=DASHES[2], label=named))
    figure.legend(handles=handles, loc="lower center", ncols=min(2, len(handles)))
    return figure


def draw_shapes(results: Results, words: Words, state: str, index: int) -> Figure:
    """Draw a state at its largest control displacement under a record and at collapse or at the end, to true scale.

    Where it collapses, the largest is that from which it still came back.
    """
    entry = shaken(results, known(results.motions)[index].name)[state]
    shape = outlines(results)
    start = shape.moved(results.states[state].configuration)
    kind = "sustained" if entry.collapsed else "at_peak"
    peak = words.plain(f"figure.{kind}", time=entry.time_of_peak_s)
    views = {peak: shape.moved(known(entry.peak_configuration))}
    title = (
        words.plain("figure.at_collapse", time=entry.time_of_collapse_s)
        if entry.collapsed
        else words.plain("figure.at_end", time=known(entry.curve).time_s[-1])
    )
    views[title] = shape.moved(known(entry.final_configuration))
    moved = [known(entry.peak_configuration), known(entry.final_configuration)]
    page = sheet(
        bounds_of_views(start, list(views.values())), len(views), border_mm=5.0, height_mm=90.0, below_mm=5.0
    )
    for axes, (title, view), at in zip(page.panels, views.items(), moved, strict=True):
        axes.set_title(title)
        ghost(axes, start)
        fill_roles(axes, view)
        draw_ties(page, axes, moved_ends(results, state, at))
    page.legend([ghost_handle(words.plain("figure.at_rest")), *tie_handles(results, words, state)], words)
    return page.figure


def draw_incremental(results: Results, words: Words, states: Sequence[str]) -> Figure:
    """Draw PGA over peak displacement of each record, a panel per state; arrows at the lowest collapse of each.

    Dotted: the levels of which 16, 50 and 84 % of the records and signs collapse.
    """
    columns = min(2, len(states))
    figure, panels = chart(words, columns=columns, rows=-(-len(states) // columns), height_mm=75.0)
    found = [results.states[name].incremental for name in states]
    records = [record for each in found for record in known(each.records)]
    stood = [point for record in records for point in record.points if not point.collapsed]
    reach = 1.25 * max((known(point.peak_displacement_m) for point in stood), default=0.0)
    tops = [level for record in records for level in (record.lowest_collapse_g, record.pga_safe_g) if level]
    tops += [level for record in records for level in record.resurrections_g]
    for axes, name, each in zip(panels, states, found, strict=False):
        own = known(each.records)
        for marker, record in zip(_cycle(len(own), MARKERS), own, strict=True):
            _curve(axes, record, marker, 1000.0 * reach)
        low, high = each.pga_collapse_g_range or (None, None)
        if low is not None and high is not None and high > low:
            axes.axhspan(low, high, color=BAND, linewidth=0.0, zorder=0.5)
        if each.pga_collapse_g is not None:
            axes.axhline(each.pga_collapse_g, color="0.0", linewidth=0.6, linestyle=DASHES[1])
        if fit := each.fragility:
            for level in (fit.level_16_g, fit.median_g, fit.level_84_g):
                axes.axhline(known(level), color="0.4", linewidth=0.6, linestyle=":")
        axes.set(xlabel=label("peak_displacement_m", words), ylabel=label("pga_g", words))
        axes.set(title=words.state(name), ylim=(0.0, 1.15 * max(tops, default=1.0)))
        axes.set_xlim(0.0, 1000.0 * reach if reach > 0.0 else None)
        if (d_0 := _ultimate(results, name)) and reach > 0.0:
            _over_ultimate(axes, reach / d_0, words)
    for axes in panels[len(states) :]:
        axes.set_axis_off()
    names = [record.record for record in known(found[0].records)]
    handles: list[Artist] = [
        Line2D([], [], color="0.0", linewidth=0.6, marker=marker, markersize=3.0, label=name)
        for marker, name in zip(_cycle(len(names), MARKERS), names, strict=True)
    ]
    named = words.plain("figure.quoted_pga")
    handles.append(Line2D([], [], color="0.0", linewidth=0.6, linestyle=DASHES[1], label=named))
    if any(each.fragility for each in found):
        probable = words.plain("figure.probable")
        handles.append(Line2D([], [], color="0.4", linewidth=0.6, linestyle=":", label=probable))
    if any((each.pga_collapse_g_range or (None, None))[1] is not None for each in found):
        handles.append(Patch(color=BAND, linewidth=0.0, label=words.plain("figure.to_all_collapse")))
    if any(record.resurrections_g for record in records):
        mark: dict[str, Any] = {
            "marker": "o",
            "markerfacecolor": "1.0",
            "markersize": 3.0,
            "linestyle": "none",
        }
        handles.append(Line2D([], [], color="0.0", **mark, label=words.plain("figure.resurrection")))
    figure.legend(handles=handles, loc="lower center", ncols=min(4, len(handles)))
    return figure


def _over_ultimate(axes: Axes, end: float, words: Words) -> None:
    """Add a second axis inside the upper edge: displacements over d_0, up to `end`."""
    beside = axes.twiny()
    beside.set_xlim(0.0, end)
    comma_ticks(beside, words)
    beside.grid(visible=False)
    beside.tick_params(top=False, pad=-9.0, labelsize="x-small", colors="0.4")
    beside.text(0.99, 0.90, "d/d₀", transform=beside.transAxes, ha="right", fontsize="x-small", color="0.4")


def _ultimate(results: Results, state: str) -> float | None:
    """Return the least d_0 (m) of the rigid curves of a state whose control point is that of the motions."""
    asked = (results.echo.incremental or {}).get("control") or (results.echo.control or [{}])[0].get("name")
    pushed = [
        each for each in results.states[state].pushover.values() if each.control == asked and each.rigid
    ]
    return min((d for each in pushed if (d := known(each.rigid).d_0_m)), default=None)


def draw_fragility(results: Results, words: Words) -> Figure:
    """Draw the probability of collapse over PGA of each state: lognormal curve, and the 50 % levels it is fitted to."""
    from scipy.special import ndtr  # late: few reports need it, and it takes long to import

    found = fragile(results)
    figure, (axes,) = chart(words, height_mm=75.0, foot_mm=0.0)
    fits = [known(each.fragility) for each in found.values()]
    top = max(fit.median_g * np.exp(max(2.5 * fit.dispersion, 0.1)) for fit in fits)
    low = 0.9 * min(fit.median_g * np.exp(-max(2.5 * fit.dispersion, 0.1)) for fit in fits)
    pga = np.linspace(low, top, 200)
    for number, (fit, (state, each)) in enumerate(zip(fits, found.items(), strict=True)):
        named = words.plain(
            "figure.fragility", state=words.state(state), median=fit.median_g, dispersion=fit.dispersion
        )
        curve = ndtr(np.log(pga / fit.median_g) / max(fit.dispersion, 1e-3))
        style = state_style(number)
        draw_band(axes, fit.band or (), style.color)
        axes.plot(pga, curve, label=named, **style.keywords)
        signs = [part for record in known(each.records) for part in record.signs]
        fallen = sorted(part.level_50_g for part in signs if part.level_50_g is not None)
        share = (np.arange(len(fallen)) + 0.5) / max(len(signs), 1)
        axes.plot(fallen, share, linestyle="none", marker="o", markersize=3.5, color=style.color,
                  markerfacecolor="1.0" if state != "original" else style.color)  # fmt: skip
    axes.set(xlabel=label("pga_g", words), ylabel=words.plain("figure.probability"))
    axes.set(xlim=(low, top), ylim=(0.0, 1.0))
    if any(fit.band for fit in fits):
        axes.fill_between(
            [], [], color=SHADE, alpha=FAINT, linewidth=0.0, label=words.plain("figure.fragility_band")
        )
    axes.legend(loc="lower right")
    return figure


def draw_band(axes: Axes, band: Sequence[Sequence[float]], color: str) -> None:
    """Shade between the bounds of the level at which each probability is reached."""
    p, low, high = (list(each) for each in zip(*band, strict=True)) if band else ([], [], [])
    axes.fill_betweenx(p, low, high, color=color, alpha=FAINT, linewidth=0.0)


def shaken(results: Results, record: str) -> dict[str, History]:
    """Return the time history of each state under a record, where the state was reached."""
    return {
        state: entry
        for state, content in results.states.items()
        for entry in content.history
        if entry.record == record and entry.curve
    }


def fragile(results: Results) -> dict[str, Incremental]:
    """Return the incremental analysis of each state that has a fragility."""
    return {
        state: content.incremental
        for state, content in results.states.items()
        if content.incremental.fragility
    }


def _curve(axes: Axes, record: Search, marker: str, edge: float) -> None:
    """Draw one IDA curve (mm, g): the runs withstood below collapse, the arrow of collapse, resurrections alone."""
    line: dict[str, Any] = {"color": "0.0", "linewidth": 0.6, "marker": marker, "markersize": 3.0}
    collapse = record.lowest_collapse_g
    stood = [point for point in record.points if not point.collapsed]
    below = [p for p in stood if collapse is None or p.pga_g < collapse]
    above = [p for p in stood if p not in below]
    x, y = [known(p.peak_displacement_m) for p in below], [p.pga_g for p in below]
    axes.plot([0.0, *(1000.0 * d for d in x)], [0.0, *y], **line)
    axes.plot(
        [1000.0 * known(p.peak_displacement_m) for p in above],
        [p.pga_g for p in above],
        **(line | {"linestyle": "none", "markerfacecolor": "1.0"}),
    )
    if collapse is not None and x:
        arrow = {"arrowstyle": "-|>", "lw": 0.6, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", (edge, collapse), (1000.0 * x[-1], y[-1]), arrowprops=arrow)


def _outcome(state: str, entry: History, words: Words) -> str:
    key = "figure.collapses" if entry.collapsed else "figure.peak"
    return words.plain(
        key,
        state=words.state(state),
        time=entry.time_of_collapse_s,
        peak=words.millimetres(entry.peak_displacement_m),
    )


def bounds_of_views(start: Shape, views: Sequence[Shape]) -> tuple[float, float, float, float]:
    """Return the bounds of all views, no farther than AROUND from the state at rest: fallen blocks may be anywhere."""
    boxes = np.array([start.bounds, *(view.bounds for view in views)])
    room = AROUND * start.size
    low = np.maximum(boxes[:, :2].min(axis=0), boxes[0, :2] - room)
    high = np.minimum(boxes[:, 2:].max(axis=0), boxes[0, 2:] + room)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _cycle(count: int, of: Sequence[Any] = DASHES) -> list[Any]:
    return [of[index % len(of)] for index in range(count)]
