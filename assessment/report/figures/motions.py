"""Figures of motions: records, control displacements, deformed shapes, IDA curves, fragility, campaigns."""

import math
from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from assessment.report.figures import drawing as parts
from assessment.report.figures.drawing import DASHES, chart, key, legend, sheet, state_style
from assessment.report.language import COARSE, Words, label, scale
from assessment.report.tables.dynamic import Shaken
from assessment.results.frames import tie_ends
from assessment.results.joint_states import outlines
from assessment.results.schema import Results, dynamic, known
from mechanics.pictures import fill_roles, ghost

MARKERS = ("o", "s", "^", "v", "D", "P", "X", "*")
BAND = "0.82"  # grey between the members of an ensemble, and bounds
SIGNS = {1: DASHES[0], -1: DASHES[1]}  # of a record
FALLING = 0.03  # of the model's size: how far the curve of a collapse is followed at least
LEAST_M = 1e-5  # what an axis of displacements shows at least: where nothing moves, no rounding
AROUND = 0.5  # of the model's size: how far from it fallen blocks are still drawn
SHADE = 0.12  # opacity of the bounds of a fragility
STEEP = 0.1  # ln of the measure shown beyond the median of equal levels, which has no dispersion


def moving(results: Results, record: str) -> dict[str, dynamic.History]:
    """Return the time history of each state under a record, where the state was reached."""
    return {
        state: entry
        for state, content in results.states.items()
        for entry in content.history
        if entry.record == record and entry.curve
    }


def draw_motion(results: Results, words: Words, index: int) -> Figure:
    """Draw a base motion over time and its acceleration spectrum at 5 % damping."""
    motion = known(results.motions)[index]
    figure, panels = chart(words, 2, height_mm=48.0)
    panels[0].plot(motion.time_s, motion.acceleration_g, color="0.0", linewidth=0.5)
    panels[0].set(xlabel=label("time_s", words), ylabel=label("acceleration_g", words))
    panels[0].set_xlim(*motion.window_s)
    panels[1].plot(motion.T_s, motion.S_a_g, color="0.0")
    panels[1].set(xlabel=label("T_s", words), ylabel=label("S_a_g", words))
    panels[1].set(xlim=(0.0, motion.T_s[-1]), ylim=(0.0, None))
    return figure


def draw_history(results: Results, words: Words, index: int) -> Figure:
    """Draw the control displacement of every state under one record; a cross marks collapse."""
    found = moving(results, known(results.motions)[index].name)
    figure, (axes,) = chart(words, height_mm=68.0)
    size, mm = outlines(results).size, scale("displacement_m")
    falls = [entry for entry in found.values() if entry.collapsed]
    sustained = [1.3 * known(entry.sustained_displacement_m) for entry in found.values()]
    bound = max([*sustained, *(min(FALLING * size, known(entry.peak_displacement_m)) for entry in falls)])
    for number, (state, entry) in enumerate(found.items()):
        curve, style = known(entry.curve), {"linewidth": 0.9} | state_style(number)
        time, displacement = np.asarray(curve.time_s), np.asarray(curve.displacement_m)
        if entry.band:
            low, high = mm * np.array([entry.band.low_m, entry.band.high_m])
            axes.fill_between(time, low, high, color=BAND, linewidth=0.0, label=words.plain("figure.members"))
        name = f"figure.{'collapses' if entry.collapsed else 'peak'}"
        peak, fallen = entry.peak_displacement_m, entry.time_of_collapse_s
        named = words.plain(name, state=state, time=fallen, peak=peak)
        axes.plot(time, mm * displacement, label=named, **style)
        if entry.collapsed:
            out = int(np.flatnonzero(abs(displacement) <= bound)[-1])
            at = time[out], mm * displacement[out]
            mark: dict[str, Any] = {"marker": "x", "markersize": 6.0, "linestyle": "none", "clip_on": False}
            axes.plot(*at, color="0.0", label=words.plain("figure.collapse"), **mark)
    until = [entry.free_motion_from_s for entry in found.values() if entry.free_motion_from_s is not None]
    if until:
        named = words.plain("figure.free_motion")
        axes.axvline(min(until), color="0.0", linewidth=0.5, linestyle=DASHES[2], label=named)
    axes.set(xlabel=label("time_s", words), ylabel=label("displacement_m", words))
    axes.set_ylim(*(1.05 * mm * max(bound, LEAST_M) * side for side in (-1.0, 1.0)))
    legend(figure)
    return figure


def draw_shapes(results: Results, words: Words, state: str, index: int) -> Figure:
    """Draw a state at its largest control displacement under a record and at collapse or at the end, to true scale.

    Where it collapses, the largest is that from which it still came back.
    """
    entry = moving(results, known(results.motions)[index].name)[state]
    shape = outlines(results)
    start = shape.moved(results.states[state].configuration)
    kinds = ("sustained", "at_collapse") if entry.collapsed else ("at_peak", "at_end")
    end = entry.time_of_collapse_s if entry.collapsed else known(entry.curve).time_s[-1]
    times = (entry.time_of_peak_s, end)
    moved = [known(entry.peak_configuration), known(entry.final_configuration)]
    views = [shape.moved(at) for at in moved]
    boxes, room = np.array([start.bounds, *(view.bounds for view in views)]), AROUND * start.size
    low = np.maximum(boxes[:, :2].min(axis=0), boxes[0, :2] - room).tolist()
    high = np.minimum(boxes[:, 2:].max(axis=0), boxes[0, 2:] + room).tolist()
    page = sheet((*low, *high), 2, border_mm=5.0, height_mm=80.0, below_mm=5.0)
    for axes, kind, time, view, at in zip(page.panels, kinds, times, views, moved, strict=True):
        axes.set_title(words.plain(f"figure.{kind}", time=time))
        ghost(axes, start)
        fill_roles(axes, view)
        parts.draw_ties(page, axes, tie_ends(results, state, at))
    outline = parts.ghost_handle(words.plain("figure.at_rest"))
    page.legend([outline, *parts.tie_handles(results, words, state)], words)
    return page.figure


def _title(each: Shaken, words: Words) -> str:
    if each.share:
        return words.plain("figure.share", share=f"{100.0 * each.share:g}")
    return words.state("original" if each.campaign else each.state)


def _runs(results: Results, row: dynamic.Scanned) -> Sequence[dynamic.Level]:
    """Return the levels of a row, of a campaign those of the one that has them; of a mirror image there are none."""
    same = row.same_as
    if same is None or same.settlement is None or same.sign != row.sign:
        return row.points
    of = (same.settlement, same.share, row.record, row.sign)
    every = known(results.campaign).combinations
    return next(each.points for each in every if (each.settlement, each.share, each.record, each.sign) == of)


def draw_ida(results: Results, words: Words, of: Sequence[Shaken]) -> Figure:
    """Draw the IDA curves of some states: PGA over peak displacement, the same axes in all panels.

    A record has its mark, +x a full line and −x a dashed one; arrows at the lowest collapse of each curve; empty marks:
    levels withstood above it; the levels that 16, 50 and 84 % collapse at, the one that counts, and where all do.
    """
    panels = [[(row, _runs(results, row)) for row in each.rows] for each in of]
    curves, mm = [curve for panel in panels for curve in panel], scale("peak_displacement_m")
    records = list(dict.fromkeys(row.record for row, _ in curves))
    style = {
        record: {"color": state_style(n)["color"], "marker": mark, "markersize": 3.0, "linewidth": 0.6}
        for n, (record, mark) in enumerate(zip(records, cycle(MARKERS), strict=False))
    }
    stood = (known(p.peak_displacement_m) for _, points in curves for p in points if not p.collapsed)
    reach = 1.1 * mm * max(stood, default=0.0) or 1.0
    ends = [(row.lowest_collapse_g, row.pga_safe_g, *row.resurrections_g) for row, _ in curves]
    top = 1.15 * max((level for each in ends for level in each if level), default=1.0)
    dotted: dict[str, Any] = {"color": "0.4", "linewidth": 0.6, "linestyle": ":"}
    quoted: dict[str, Any] = {"color": "0.0", "linewidth": 0.6, "linestyle": DASHES[3]}
    all_fall = words.plain("figure.to_all_collapse")
    handles: list[Artist] = [key(record, **style[record]) for record in records]
    if any(row.sign < 0 and points for row, points in curves):
        handles.append(key(words.plain("figure.other_sign"), linewidth=0.6, linestyle=SIGNS[-1]))
    if any(row.resurrections_g for row, _ in curves):
        mark = {"marker": "o", "markerfacecolor": "1.0", "markersize": 3.0, "linestyle": "none"}
        handles.append(key(words.plain("figure.resurrection"), **mark))
    figure, axes_of = chart(words, len(panels))
    for axes, each, panel in zip(axes_of, of, panels, strict=True):
        for row, points in panel:
            _curve(axes, row, points, reach, style[row.record] | {"linestyle": SIGNS[row.sign]})
        fit, certain = each.fit, (each.fit.pga_collapse_g_range or [None, None])[1]
        if (counts := fit.pga_collapse_g) is not None:
            axes.axhline(counts, label=words.plain("figure.quoted_pga"), **quoted)
            if (certain or 0.0) > counts:
                axes.axhspan(counts, certain or 0.0, label=all_fall, color=BAND, linewidth=0.0, zorder=0.5)
        middle = fit.median_g if fit.level_16_g else None
        for level in filter(None, (fit.level_16_g, middle, fit.level_84_g) if each.by_pga else ()):
            axes.axhline(level, label=words.plain("figure.probable"), **dotted)
        axes.set(xlabel=label("peak_displacement_m", words), xlim=(0.0, reach), ylim=(0.0, top))
        axes.set(ylabel=label("pga_g", words), title=_title(each, words))
        if fit.d_0_m:  # a second axis inside the upper edge: displacements over d_0
            beside = axes.twiny()
            beside.set_xlim(0.0, reach / mm / fit.d_0_m)
            parts.comma_ticks(beside, words)
            beside.grid(visible=False)
            beside.tick_params(top=False, pad=-9.0, labelsize="x-small", colors="0.4")
            beside.annotate("d/d₀", (0.99, 0.90), xycoords="axes fraction", ha="right", fontsize="x-small")
    legend(figure, handles=handles)
    return figure


def _curve(
    axes: Axes, of: dynamic.Scanned, points: Sequence[dynamic.Level], edge: float, line: dict[str, Any]
) -> None:
    """Draw one IDA curve (mm, g): the levels withstood below its lowest collapse, its arrow, the others alone."""
    mm, collapse = scale("peak_displacement_m"), of.lowest_collapse_g
    stood = [(mm * known(p.peak_displacement_m), p.pga_g) for p in points if not p.collapsed]
    below = [(0.0, 0.0), *(each for each in stood if collapse is None or each[1] < collapse)]
    axes.plot(*zip(*below, strict=True), **line)
    if above := stood[len(below) - 1 :]:
        axes.plot(*zip(*above, strict=True), **(line | {"linestyle": "none", "markerfacecolor": "1.0"}))
    if collapse is not None and len(below) > 1:
        arrow = {"arrowstyle": "-|>", "lw": 0.6, "shrinkA": 0.0, "shrinkB": 0.0, "color": line["color"]}
        axes.annotate("", (edge, collapse), below[-1], arrowprops=arrow)


def draw_fragility(_: Results, words: Words, of: Sequence[Shaken]) -> Figure:
    """Draw the probability of collapse over the measure: lognormal curves with their 95 % bounds.

    Circles: the levels of 50 % that they are fitted to, or the shares that collapse at each of the stripes.
    """
    from scipy.special import ndtr  # late: few reports need it, and it takes long to import

    measure = label("pga_g", words)
    if not of[0].by_pga:
        measure = label("sa_g", words).replace("(T)", f"({words.show(known(of[0].campaign).period_s)} s)")
    fits = [(each, known(each.fit.median_g), known(each.fit.beta), _seen(each)) for each in of]
    figure, (axes,) = chart(words, height_mm=75.0)
    top = max(median * np.exp(max(2.0 * beta, STEEP)) for _, median, beta, _ in fits)
    low = min(median * np.exp(-3.0 * beta) for _, median, beta, _ in fits)
    low = min([low, *(level for *_, seen in fits for level in seen[0])])
    start = 0.1 * math.floor(9.5 * low)  # below it nothing collapses
    level = np.linspace(max(start, 1e-3 * top), top, 300)
    handles: list[Artist] = []
    shades = np.linspace(1.0, 0.0, len(fits))
    for dashes, (each, median, beta, seen), shade in zip(cycle(DASHES), fits, shades, strict=False):
        mark: dict[str, Any] = {"marker": "o", "markersize": 3.0, "markeredgewidth": 0.5, "color": "0.0"}
        mark["markerfacecolor"] = str(shade)
        if each.fit.band:
            p, least, most = map(list, zip(*each.fit.band, strict=True))
            bounds: dict[str, Any] = {"color": "0.0", "alpha": SHADE, "linewidth": 0.0}
            axes.fill_betweenx(p, least, most, label=words.plain("figure.fragility_band"), **bounds)
        probability = ndtr(np.log(level / median) / max(beta, 1e-3 * STEEP))
        axes.plot(level, probability, color="0.0", linestyle=dashes)
        axes.plot(*seen, linestyle="none", **mark)
        named = {"state": _title(each, words), "median": median, "dispersion": words.number(beta, COARSE)}
        name = words.plain("figure.fragility", **named)
        handles.append(key(name, linestyle=dashes, **mark))
    axes.set(xlabel=measure, xlim=(start, top), ylabel=words.plain("figure.probability"), ylim=(0.0, 1.0))
    legend(figure, 1, handles, handlelength=4.0)
    return figure


def _seen(of: Shaken) -> tuple[Sequence[float], Sequence[float]]:
    """Return the levels at which collapse was seen, by the measure, and the share of records and signs that fell."""
    rows = [row for row in of.rows if row.reason is None]
    if of.campaign and of.campaign.method == "stripes":
        fallen = np.array([known(row.collapsed) for row in rows], dtype=float)
        return of.campaign.levels_g, fallen.mean(axis=0).tolist()
    listed = of.campaign.records if of.campaign else ()
    ratio = {each.record: (each.sa_g or each.record_pga_g) / each.record_pga_g for each in listed}
    found = sorted(ratio.get(row.record, 1.0) * row.level_50_g for row in rows if row.level_50_g is not None)
    return found, ((np.arange(len(found)) + 0.5) / max(len(rows), 1)).tolist()


def draw_campaign_loss(results: Results, words: Words) -> Figure:
    """Draw the loss of capacity over the movement, a panel per settlement: dynamic with its bounds, static beside."""
    campaign = known(results.campaign)
    names = list(dict.fromkeys(row.settlement for row in campaign.loss))
    figure, panels = chart(words, len(names))
    every = (loss for row in campaign.loss for loss in (row.dynamic, row.static, *row.dynamic_range))
    drawn = [loss for loss in every if loss is not None]
    least, most = min([0.0, *drawn]), max([0.01, *drawn])
    mm, per_cent = scale("movement_m"), scale("capacity_loss")
    room = 0.05 * per_cent * (most - least)
    solid: dict[str, Any] = {"color": "0.0", "marker": "o", "markersize": 3.5, "linestyle": "-"}
    static: dict[str, Any] = solid | {"linestyle": DASHES[1], "markerfacecolor": "1.0"}
    for axes, name in zip(panels, names, strict=True):
        own = [row for row in campaign.loss if row.settlement == name]
        band = [(row.movement_m, *row.dynamic_range) for row in own if None not in row.dynamic_range]
        if band:
            x, low, high = np.array(band).T * [[mm], [per_cent], [per_cent]]
            named = words.plain("figure.loss_band")
            axes.fill_between(x, low, high, label=named, color=BAND, linewidth=0.0)
        for kind, style in (("dynamic", solid), ("static", static)):
            lost = [(row.movement_m, loss) for row in own if (loss := getattr(row, kind)) is not None]
            pairs = np.array(lost).reshape(-1, 2).T * [[mm], [per_cent]]
            axes.plot(*pairs, label=words.plain(f"figure.{kind}_loss"), **style)
        axes.set(xlabel=label("movement_m", words), ylabel=label("capacity_loss", words), title=name)
        axes.set(xlim=(0.0, None), ylim=(per_cent * least - room, per_cent * most + room))  # the same in all
    legend(figure, 3)
    return figure
