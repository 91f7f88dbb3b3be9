"""Capacity against settlement, and the tornado of the sensitivity."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from assessment.report.figures.style import chart, key, state_style
from assessment.report.tables.studies import ROUNDING, bars
from assessment.report.text.language import Words, label, scale
from assessment.results.schema import Results, known
from assessment.results.table import compared, reference_of

MARKS = {"+x": (">", "0.0"), "-x": ("<", "1.0")}  # of the directions: full to the right, empty to the left
RING: dict[str, Any] = {"marker": "o", "markerfacecolor": "none", "markeredgewidth": 1.2, "linestyle": "none"}
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
    figure, (axes,) = chart(words, height_mm=95.0, foot_mm=9.0 + 5.0 * len(names))
    labels: list[tuple[str, float, float]] = []
    for number, name in enumerate(names, 1):
        style = state_style(number - 1)
        for direction, (marker, face) in MARKS.items():
            own = [
                (point, capacity)
                for point in found.points
                if point.direction == direction
                and (capacity := compared(point, found.quantity)) is not None
                and (point.state == name or point.movement_m == 0.0)
            ]
            x, y = [mm * point.movement_m for point, _ in own], [capacity for _, capacity in own]
            inside = style["color"] if face != "1.0" else face
            axes.plot(x, y, marker=marker, markerfacecolor=inside, markersize=4.5, **style)
            if own and own[-1][0].state == name:
                labels.append((str(number), x[-1], y[-1]))
        if (ultimate := _ultimate(results, name)) is not None:
            axes.plot(mm * ultimate, 0.0, color="0.0", marker="x", markersize=6.0, clip_on=False)
            labels.append((str(number), mm * ultimate, 0.0))
    if worst := found.worst:  # where the structure has fallen no capacity is left
        height = 0.0 if worst.collapses else known(compared(worst, found.quantity))
        axes.plot(mm * worst.movement_m, height, markersize=11, color="0.0", clip_on=False, **RING)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(label("movement_m", words))
    axes.set_ylabel(_capacity(results, words, found.quantity, found.limit_state))
    for text, right, top in labels:
        axes.annotate(text, (right, top), (7, -2), textcoords="offset points", annotation_clip=False)
    figure.legend(handles=_scenario_legend(results, names, words), loc="lower center", ncols=2)
    return figure


def draw_tornado(results: Results, words: Words, states: Sequence[str]) -> Figure:
    """Draw per state a bar for each property from its low to its high factor, the widest on top."""
    of_state = {state: [bar for bar in bars(results) if bar.state == state][::-1] for state in states}
    tallest = max(map(len, of_state.values()))
    figure, panels = chart(
        words, rows=len(states), height_mm=22.0 + 9.0 * tallest, foot_mm=10.0, left_mm=30.0
    )
    shown = [capacity for own in of_state.values() for bar in own for capacity in bar.capacities()]
    for axes, (state, own) in zip(panels, of_state.items(), strict=True):
        base = known(own[0].a_g_base_g)
        for place, bar in enumerate(own):
            for side, above in (("low", 0.2), ("high", -0.2)):
                factor, end = bar.ends()[side]
                moved = base if end is None else end
                axes.barh(place + above, moved - base, left=base, height=0.36, **BARS[side])
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
        reference = words.plain(f"value.on_{reference_of(results)}")
        told = {"state": state, "capacity": base, "reference": reference}
        axes.set_title(words.plain("figure.tornado_base", **told))
    limit = known(results.sensitivity).limit_state
    panels[-1].set_xlabel(_capacity(results, words, "a_g_g", limit))
    handles = [Patch(**BARS[side], label=words.plain(f"figure.{side}_factor")) for side in ("low", "high")]
    figure.legend(handles=handles, loc="lower center", ncols=2)
    return figure


def _capacity(results: Results, words: Words, name: str, limit: str | None) -> str:
    """Return the label of an axis of a capacity: an acceleration with its limit state."""
    text = label(name, words, reference_of(results))
    return f"{limit}: {text}" if name == "a_g_g" else text


def varied(results: Results) -> list[str]:
    """Return the states whose tornado can be drawn: the capacity that the bars start from is known."""
    return list(dict.fromkeys(bar.state for bar in bars(results) if bar.a_g_base_g is not None))


def _ultimate(results: Results, name: str) -> float | None:
    found = [path.ultimate_movement_m for path in results.states[name].pushdown.values()]
    return min((value for value in found if value is not None), default=None)


def _scenario_legend(results: Results, names: Sequence[str], words: Words) -> list[Line2D]:
    found = known(results.scenarios)
    handles = [key(f"{number}  {name}", **state_style(number - 1)) for number, name in enumerate(names, 1)]
    for way, (marker, face) in MARKS.items():
        if any(point.direction == way for point in found.points):
            mark = {"marker": marker, "markerfacecolor": face, "linestyle": "none"}
            handles.append(key(words.plain("figure.direction", direction=way), **mark))
    if any(_ultimate(results, name) is not None for name in names):
        handles.append(key(words.plain("figure.ultimate_mark"), marker="x", linestyle="none"))
    if worst := found.worst:
        place = {"state": worst.state, "direction": worst.direction}
        named = f"figure.{'worst_collapses' if worst.collapses else 'worst'}"
        text = words.plain(named, **place, movement=worst.movement_m)
        handles.append(key(text, markersize=9, **RING | {"markeredgewidth": 1.0}))
    return handles
