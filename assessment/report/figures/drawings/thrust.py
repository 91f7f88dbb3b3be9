"""Drawings of what the joints carry: resultants, the line of thrust, the state of every joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from assessment.report.figures.drawings.parts import draw_ties, moved_ends, push_arrow, tie_handles
from assessment.report.figures.style import foot, key, sheet
from assessment.report.text.language import Words
from assessment.results.configurations.faces import outlines
from assessment.results.configurations.joint_states import Situation, joint_states, thrust_lines
from assessment.results.schema import Results
from mechanics.pictures import HINGE, INK, THRUST, fill_roles, union

UNIT_MM = 10.0  # on paper, of a round force
LONGEST = 1.3  # times that, the largest resultant
CROWD = 150  # joints: beyond them marks become finer, so that a wall stays readable
RESULTANT: dict[str, Any] = {"color": "0.45", "linewidth": 0.6}
JOINTS: dict[str, dict[str, Any]] = {  # by condition; a joint that presses as a whole is a plain outline
    "partial": {"color": INK, "linewidth": 1.2, "linestyle": (0, (1.2, 0.8))},
    "sliding": {"color": INK, "linewidth": 2.4},
    "idle": {"color": "0.6", "linewidth": 1.0, "linestyle": (0, (0.8, 1.6))},
}


def draw_thrust(results: Results, words: Words, shown: Sequence[Situation]) -> Figure:
    """Draw each situation: resultants as lines as long as they are large, joined through blocks of two joints.

    Joints are marked by their condition (JointStates.condition); a hinge is a circle where the resultant crosses.
    """
    drawing = outlines(results)
    shapes = [drawing.moved(situation.configuration) for situation in shown]
    joints = [joint_states(results, situation) for situation in shown]
    largest = max(float(np.hypot(*states.force.T).max()) for states in joints)
    unit = round_force(largest)
    scale = words.plain("figure.resultant", force=words.comma(f"{unit:g}"), length=f"{UNIT_MM:g}")
    handles: list[Any] = [key(words.plain("figure.thrust"), **THRUST), key(scale, **RESULTANT)]
    conditions = {each for states in joints for each in states.condition}
    named = [(each, style) for each, style in (*JOINTS.items(), ("edge", HINGE)) if each in conditions]
    handles += [key(words.plain(f"figure.joint_{each}"), **style) for each, style in named]
    handles += tie_handles(results, words, *(situation.state for situation in shown))
    above = 7.0 if any(situation.direction for situation in shown) else 3.0  # the arrow of the loads
    below = foot([each.get_label() for each in handles])
    page = sheet(union(shapes), len(shown), border_mm=above, foot_mm=below, height_mm=150.0)
    for axes, situation, shape, states in zip(page.panels, shown, shapes, joints, strict=True):
        if situation.direction is None:
            forces = words.plain("figure.at_rest_forces", contacts=situation.contacts)
            axes.set_title(f"{words.state(situation.state)}\n{forces}")
        else:
            axes.set_title(
                f"{words.at(situation.state, situation.direction)}\nα = {words.show(situation.alpha)}"
            )
        fill_roles(axes, shape)
        fine = min(1.0, (CROWD / len(states.condition)) ** 0.5)
        are = np.array(states.condition)
        for condition, style in JOINTS.items():
            width = style["linewidth"] * fine
            ends = list(states.ends[are == condition])
            axes.add_collection(LineCollection(ends, **(style | {"linewidth": width})))
        half = 0.5 * page.paper(UNIT_MM) / unit * states.force
        resultants = np.stack([states.point - half, states.point + half], axis=1)[are != "idle"]
        axes.add_collection(LineCollection(list(resultants), **RESULTANT))
        axes.add_collection(LineCollection(thrust_lines(states), **THRUST))
        mark = HINGE | {"markersize": 3.6 * fine, "markeredgewidth": 0.9 * fine}
        axes.plot(*states.point[are == "edge"].T, **mark)
        draw_ties(page, axes, moved_ends(results, situation.state, situation.configuration))
        if situation.direction:
            push_arrow(page, axes, shape.bounds, situation.direction)
    page.legend(handles, words)
    return page.figure


def round_force(largest: float) -> float:
    """Return 1, 2 or 5 times a power of ten, the least of which the largest force is at most `LONGEST` times."""
    least = largest / LONGEST
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * (1.0 - 1e-9))
