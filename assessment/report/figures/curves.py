"""Curves: pushdown, pushovers by direction, spectra, capacity and demand in spectral coordinates; of studies too."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from assessment.report.figures.drawing import COLOURS, DASHES, OVER_LINES, chart, key, legend, state_style
from assessment.report.language import Words, direction_name, label, scale
from assessment.report.tables.mechanisms import alpha_at_d_0, elastic_capacity
from assessment.report.tables.studies import ROUNDING, bars
from assessment.results.schema import Direction, Pushovers, Results, known, present
from assessment.results.table import ORIGINAL, compared, sense
from mechanics.pictures import MARKS
from mechanics.types import GRAVITY

Views = Sequence[tuple[str, Direction]]
WIDTHS = {"rigid": 1.4, "elastic": 2.4}
ONSET, END, YIELD = MARKS


def draw_pushdown(results: Results, words: Words, state: str) -> Figure:
    """Draw both reactions of the moved support over the movement; applied and ultimate movement marked."""
    content, mm = results.states[state], scale("movement_m")
    figure, panels = chart(words, 2, height_mm=54.0)
    for axes, component in zip(panels, ("x", "z"), strict=True):
        for contacts, path in content.pushdown.items():
            force = path.reaction_x_kN if component == "x" else path.reaction_z_kN
            named = words.plain(f"value.{contacts}")
            along, width = mm * np.asarray(path.movement_m), WIDTHS[contacts]
            axes.plot(along, force, color="0.0", linewidth=width, label=named)
        axes.set(xlabel=label("movement_m", words), ylabel=label(f"reaction_{component}_kN", words))
        reactions = [f for way in content.pushdown.values() for f in (*way.reaction_x_kN, *way.reaction_z_kN)]
        largest, (low, high) = max(map(abs, reactions)), axes.get_ylim()
        if high - low < 1e-3 * largest:  # a reaction that does not change is a level line, not its rounding
            axes.set_ylim(*((low + high) / 2.0 + side * largest for side in (-0.1, 0.1)))
        applied = max(path.applied_movement_m for path in content.pushdown.values())
        if applied > 0.0:
            named = words.plain("figure.applied", movement=applied)
            axes.axvline(mm * applied, color="0.0", linewidth=0.7, linestyle=DASHES[1], label=named)
        for contacts, path in content.pushdown.items():
            if (ultimate := path.ultimate_movement_m) is not None:
                named = words.plain("figure.ultimate_line", contacts=contacts, movement=ultimate)
                style = {"linewidth": 0.5 * WIDTHS[contacts], "linestyle": DASHES[2], "label": named}
                axes.axvline(mm * ultimate, color="0.0", **style)
    legend(figure)
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
    there = {
        ONSET: any(each.rigid for each in every),
        END: any(each.rigid and each.rigid.d_0_m is not None for each in every),
        YIELD: any(each.elastic and each.elastic.d_y_m is not None for each in every),
    }
    handles += [key(name, **MARKS[name]) for name, has in there.items() if has]
    handles += [
        key(words.plain(f"value.{contacts}"), linewidth=width)
        for contacts, width in WIDTHS.items()
        if any(contacts in pushover.by_contacts for pushover in every)
    ]
    if any(push.members for each in every for push in each.by_contacts.values()):
        handles.append(key(words.plain("figure.ensemble"), color="0.65", linewidth=0.4))
    columns, mm = 2 if yields else 1, scale("displacement_m")
    figure, panels = chart(words, columns * len(directions), columns, height_mm=58.0)
    for at, axes in enumerate(panels):
        direction = directions[at // columns]
        for name, pushover in states[direction].items():
            style = state_style(names.index(name))
            for contacts, push in pushover.by_contacts.items():
                for other in push.members or []:  # of the ensemble
                    others = sense(direction) * mm * np.asarray(other.displacement_m), other.multiplier
                    axes.plot(*others, color="0.65", linewidth=0.4, linestyle=style["linestyle"])
                along = sense(direction) * mm * np.asarray(push.curve.displacement_m)
                axes.plot(along, push.curve.multiplier, linewidth=WIDTHS[contacts], **style)
        title = direction_name(direction)
        if yields:
            title += ", " + words.plain(f"figure.{'first_branch' if at % 2 else 'whole_curve'}")
        axes.set(xlabel=label("displacement_m", words), ylabel=label("multiplier", words), title=title)
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(0.0, 6.0 * mm * max(yields) if at % columns else None)
        for name, pushover in states[direction].items():
            rigid, elastic, found = pushover.rigid, pushover.elastic, dict[str, tuple[float, float]]()
            if rigid:
                found[ONSET] = abs(rigid.curve.displacement_m[rigid.peak]), rigid.alpha_0
                if rigid.d_0_m is not None:
                    found[END] = rigid.d_0_m, alpha_at_d_0(rigid) or 0.0
            if elastic and elastic.alpha_y is not None and elastic.d_y_m is not None:
                found[YIELD] = elastic.d_y_m, elastic.alpha_y
            colour = COLOURS[names.index(name) % len(COLOURS)]
            for mark, (displacement, alpha) in found.items():
                if mm * displacement <= axes.get_xlim()[1]:
                    axes.plot(mm * displacement, alpha, color=colour, clip_on=False, **MARKS[mark])
    legend(figure, 3, handles)
    return figure


def pushed(results: Results, direction: Direction) -> dict[str, Pushovers]:
    """Return the pushovers in a direction by the states that have one."""
    states = results.states.items()
    return {name: state.pushover[direction] for name, state in states if direction in state.pushover}


LONGEST = 4.0  # s: what is drawn of the spectra
ELASTIC: dict[str, Any] = {"color": "0.5", "linewidth": 1.4}
PERIODS = (0.5, 1.0, 2.0, 3.0)  # s: of the grey lines
PERIOD: dict[str, Any] = {"color": "0.45", "fontsize": 6.0, "bbox": OVER_LINES, "zorder": 1.5}
NAMED: dict[str, Any] = {"textcoords": "offset points", "bbox": OVER_LINES, "zorder": 1.6}


def draw_spectra(results: Results, words: Words, views: Views, limit: str) -> Figure:
    """Draw a* over d* (m) of states and directions with the spectrum each can bear and the one demanded of it.

    Spectra have the damping of the limit state and are scaled to the a_g demanded and to the a_g borne; the
    latter meets the line of period T of the limit state at d*. The curve with elastic joints is grey.
    """
    mm, demand = scale("d_star_m"), "outside"
    figure, panels = chart(words, len(views), height_mm=60.0)
    spectrum = (results.spectra or {}).get(limit)
    for axes, (name, direction) in zip(panels, views, strict=True):
        capacity = results.states[name].capacity[direction]
        point = capacity.checks[limit]
        curve = capacity.curve
        reach, secant = max([*curve.d_star_m, point.d_star_m or 0.0]), 0.0
        if point.d_star_m and point.a_g_g and point.demand_a_g_g:  # beyond twice the capacity off the sheet
            reach = max(reach, point.d_star_m * min(2.0, point.demand_a_g_g / point.a_g_g))
        if point.d_star_m and point.T_s:
            secant = _secant(point.d_star_m, point.T_s)
        reach, top = 1.25 * reach, max(3.0 * max(curve.a_star_g), 1.8 * secant)
        axes.set(xlim=(0.0, mm * reach), ylim=(0.0, top), title=words.at(name, direction))
        axes.set(xlabel=label("d_star_m", words), ylabel=label("a_star_g", words))
        for period in PERIODS:  # their lines, each named where it leaves the frame
            edge = min(reach, top / _secant(1.0, period))
            height, steep = _secant(edge, period), edge < reach
            axes.plot([0.0, mm * edge], [0.0, height], color="0.7", linewidth=0.5, zorder=1.2)
            place: dict[str, Any] = {"ha": "center" if steep else "right", "va": "center", **PERIOD}
            text, away = words.comma(f"{period:g} s"), (0, -7) if steep else (-3, 0)
            axes.annotate(text, (mm * edge, height), away, textcoords="offset points", **place)
        if found := elastic_capacity(results, name, direction):
            named = words.plain("figure.elastic_capacity")
            axes.plot(mm * found[0], found[1], label=named, **ELASTIC)
        along, named = mm * np.asarray(curve.d_star_m), words.plain("figure.fitted_curve")
        axes.plot(along, curve.a_star_g, color="0.0", linewidth=1.9, label=named)
        if spectrum is not None:
            shown = np.asarray(spectrum.T_s) <= max(LONGEST, 1.2 * (point.T_s or 0.0))
            for level, dashes in ((point.demand_a_g_g, DASHES[2]), (point.a_g_g, DASHES[0])):
                factor = (level or np.nan) / spectrum.a_g_g
                displacement = mm * factor * np.asarray(spectrum.damped_S_De_m)[shown]
                acceleration = factor * np.asarray(spectrum.damped_S_e_g)[shown]
                axes.plot(displacement, acceleration, color="0.0", linewidth=0.9, linestyle=dashes)
                if dashes == DASHES[2] and ((displacement < mm * reach) & (acceleration < top)).any():
                    demand = "spectrum"
        if point.d_star_m is not None:
            d_star = mm * point.d_star_m
            axes.plot(d_star, known(point.a_star_g), "s", color="0.0", markersize=4.5)
            axes.annotate(f"d*_{limit}", (d_star, 0.0), (3.0, 7.0), **NAMED)
            if point.T_s:
                axes.plot([0.0, d_star], [0.0, secant], color="0.0", linewidth=0.6, linestyle=DASHES[1])
                axes.plot([d_star, d_star], [0.0, secant], color="0.0", linewidth=0.4)
                circle: dict[str, Any] = {"marker": "o", "markerfacecolor": "1.0", "markersize": 5}
                axes.plot(d_star, secant, color="0.0", linestyle="none", **circle)
                axes.annotate(f"T_{limit}", (d_star, secant), (5.0, 6.0), **NAMED)
    reference = words.plain(f"value.on_{words.reference}")
    borne = words.plain("figure.borne_spectrum", limit=limit, reference=reference)
    demanded = words.plain(f"figure.demand_{demand}", limit=limit)
    lines = [key(borne, linewidth=0.9), key(demanded, linewidth=0.9, linestyle=DASHES[2])]
    legend(figure, handles=lines)
    return figure


def draw_demand(results: Results, words: Words) -> Figure:
    """Draw S_e (g) and S_De (mm) of each limit state over the period, 5 % damping."""
    figure, panels = chart(words, 2, height_mm=48.0)
    for axes, name in zip(panels, ("S_e_g", "S_De_m"), strict=True):
        for dashes, (limit, spectrum) in zip(DASHES, known(results.spectra).items(), strict=False):
            T = np.asarray(spectrum.T_s, dtype=float)
            values = np.asarray(getattr(spectrum, name), dtype=float) * scale(name)
            line: dict[str, Any] = {"color": "0.0", "linewidth": 1.2, "linestyle": dashes, "label": limit}
            axes.plot(T[T <= LONGEST], values[T <= LONGEST], **line)
        axes.set(xlabel=label("T_s", words), ylabel=label(name, words), xlim=(0.0, LONGEST))
        axes.set_ylim(bottom=0.0)
    legend(figure, 4)
    return figure


def _secant(displacement: float, period: float) -> float:
    """Return the spectral acceleration in g that has this displacement (m) at this period (s)."""
    return float((2.0 * np.pi / period) ** 2 * displacement / GRAVITY)


SIDES = {"+x": (">", "0.0"), "-x": ("<", "1.0")}  # of the directions: full to the right, empty to the left
BESIDE: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 6.5}
BARS: dict[str, dict[str, Any]] = {  # of the factors: light and hatched below, dark above
    "low": {"facecolor": "0.9", "hatch": "////", "edgecolor": "0.0", "linewidth": 0.5},
    "high": {"facecolor": "0.55", "edgecolor": "0.0", "linewidth": 0.5},
}


def draw_scenarios(results: Results, words: Words) -> Figure:
    """Draw the capacity over the movement: dashes per scenario, a curve per direction, worst case ringed.

    Ultimate movements (the smallest of the contact behaviours) are crosses on the axis: nothing is left there.
    """
    found, mm = known(results.scenarios), scale("movement_m")
    names = list(dict.fromkeys(point.state for point in found.points if point.movement_m > 0.0))
    figure, (axes,) = chart(words, height_mm=95.0)
    for number, name in enumerate(names):
        style = state_style(number)
        begins = known(results.states[name].settlement).after or ORIGINAL
        start = max((point.movement_m for point in found.points if point.state == begins), default=0.0)
        for direction, (marker, face) in SIDES.items():
            own = [
                (mm * point.movement_m, capacity)
                for point in found.points
                if point.direction == direction
                and (capacity := compared(point, found.quantity)) is not None
                and (point.state == name or (point.state == begins and point.movement_m == start))
            ]
            inside, named = style["color"] if face != "1.0" else face, words.at(name, direction)
            if own:
                x, y = zip(*own, strict=True)
                axes.plot(x, y, marker=marker, markerfacecolor=inside, markersize=4.5, label=named, **style)
        reached = [path.ultimate_movement_m for path in results.states[name].pushdown.values()]
        if ultimate := present(dict(enumerate(reached))):
            mark: dict[str, Any] = {"marker": "x", "markersize": 6.0, "linestyle": "none", "clip_on": False}
            named = words.plain("figure.ultimate_mark", state=name)
            axes.plot(mm * (start + min(ultimate.values())), 0.0, color=style["color"], label=named, **mark)
    if worst := found.worst:  # where the structure has fallen no capacity is left
        height = 0.0 if worst.collapses else known(compared(worst, found.quantity))
        place = {"state": worst.state, "direction": worst.direction, "movement": worst.movement_m}
        named = words.plain(f"figure.{'worst_collapses' if worst.collapses else 'worst'}", **place)
        ring: dict[str, Any] = {"marker": "o", "markerfacecolor": "none", "markersize": 11, "clip_on": False}
        axes.plot(mm * worst.movement_m, height, color="0.0", linestyle="none", label=named, **ring)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(label("movement_m", words))
    axes.set_ylabel(_capacity(words, found.quantity, found.limit_state))
    legend(figure)
    return figure


def draw_tornado(results: Results, words: Words, states: Sequence[str]) -> Figure:
    """Draw per state a bar for each property from its low to its high factor, the widest on top."""
    of_state = {state: [bar for bar in bars(results) if bar.state == state][::-1] for state in states}
    tallest = max(map(len, of_state.values()))
    figure, panels = chart(words, len(states), 1, height_mm=22.0 + 9.0 * tallest)
    shown = [capacity for own in of_state.values() for bar in own for capacity in bar.capacities()]
    for axes, (state, own) in zip(panels, of_state.items(), strict=True):
        base = known(own[0].a_g_base_g)
        for place, bar in enumerate(own):
            low, high = (bar.low_factor, bar.a_g_low_g), (bar.high_factor, bar.a_g_high_g)
            for side, above, (factor, end) in (("low", 0.2, low), ("high", -0.2, high)):
                moved = base if end is None else end
                named = words.plain(f"figure.{side}_factor")
                axes.barh(place + above, moved - base, left=base, height=0.36, label=named, **BARS[side])
                text = f"×{words.comma(f'{factor:g}')}" + (f": {words.show(None)}" if end is None else "")
                right = moved > base or (moved == base and side == "high")
                said = {"ha": "left" if right else "right", **BESIDE}
                axes.annotate(text, (moved, place + above), (3 if right else -3, 0), **said)
        axes.axvline(base, color="0.0", linewidth=0.9)
        axes.set_yticks(range(len(own)), [words.plain(f"value.{bar.property}") for bar in own])
        axes.set_ylim(-0.7, len(own) - 0.3)
        span = max(shown) - min(shown)
        margin = 0.18 * span if span > ROUNDING * max(shown) else 0.2 * max(shown)
        axes.set_xlim(min(shown) - margin, max(shown) + margin)
        axes.grid(visible=False, axis="y")
        reference = words.plain(f"value.on_{words.reference}")
        told = {"state": state, "capacity": base, "reference": reference}
        axes.set_title(words.plain("figure.tornado_base", **told))
    limit = known(results.sensitivity).limit_state
    panels[-1].set_xlabel(_capacity(words, "a_g_g", limit))
    legend(figure)
    return figure


def _capacity(words: Words, name: str, limit: str | None) -> str:
    """Return the label of an axis of a capacity: an acceleration with its limit state."""
    return f"{limit}: {label(name, words)}" if name == "a_g_g" else label(name, words)


def varied(results: Results) -> list[str]:
    """Return the states whose tornado can be drawn: the capacity that the bars start from is known."""
    return list(dict.fromkeys(bar.state for bar in bars(results) if bar.a_g_base_g is not None))
