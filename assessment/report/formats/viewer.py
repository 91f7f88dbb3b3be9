"""What the interactive page steps through: the paths of the results with their frames, as data of its script."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from markupsafe import Markup

from assessment.ntc.limit_states import QUOTED
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.joint_states import EDGE, FRICTION, IDLE
from assessment.results.configurations.tie_ends import ties_of
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Direction
from assessment.results.schema.dynamic import Snapshots
from assessment.results.schema.model import Face, Joint
from assessment.results.schema.static import Frames, TieTension

NEAR = 0.01  # of a path's reach: so far beyond its end is at its end


class Code(Markup):
    """What is no text: printed as it is."""


@dataclass(frozen=True)
class Viewer:
    """The script of the page and its data, ready to be put between tags."""

    data: Code
    script: Code


@dataclass(frozen=True)
class Series:
    """A curve of the page: its label and its points, with the digits that can be seen."""

    label: str
    x: list[float]
    y: list[float]

    @classmethod
    def of(cls, label: str, x: Sequence[float], y: Sequence[float]) -> Series:
        """Return the curve through the points (x, y), in the units of its axes."""
        return cls(label, _short(x), _short(y))


def viewer(results: Results, words: Words) -> Viewer | None:
    """Return script and data of the page that steps through the paths; None where no path was kept."""
    paths = [*_pushdowns(results, words), *_pushovers(results, words), *_histories(results, words)]
    if not paths:
        return None
    geometry = results.geometry
    data = {
        "blocks": [
            {
                "vertices": block.vertices_m,
                "centroid": block.centroid_m,
                "layer": block.layer,
                "support": block.support,
                "weight": block.weight_kN,
            }
            for block in geometry.blocks
        ],
        "joints": [_joint(joint) for joint in geometry.joints],
        "ties": [
            {
                "name": tie.name,
                "ends": [tie.start_m, tie.end_m],
                "blocks": tie.blocks,
                "yield": tie.yield_force_kN,
            }
            for tie in results.model.ties or ()
        ],
        "tolerance": geometry.joint_tolerance_m,
        "weight": results.model.weight_kN,
        "limits": {"idle": IDLE, "friction": FRICTION, "edge": EDGE},
        "paths": paths,
        "words": dict(words.strings["viewer"]) | {"decimal_mark": words.plain("value.decimal_mark")},
    }
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    script = (files("templates") / "viewer.js").read_text(encoding="utf-8")
    return Viewer(Code(text), Code(script))


def _pushdowns(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for name, state in results.states.items():
        for contacts, path in state.pushdown.items():
            movement = [1000.0 * value for value in path.movement_m]
            series = [
                Series.of("Rx", movement, path.reaction_x_kN),
                Series.of("Rz", movement, path.reaction_z_kN),
            ]
            yield {
                "title": _title(words, "pushdown", name, words.plain(f"value.{contacts}")),
                "jumps": [],
                "x_label": words.plain("figure.movement"),
                "y_label": words.plain("viewer.reactions"),
                "series": [asdict(each) for each in series],
                "frames": _frames(path.frames, series) | _ties(results, name, path.frames, path.ties),
            }


def _pushovers(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for name, state in results.states.items():
        for direction, pushover in state.pushover.items():
            for contacts, push in pushover.by_contacts.items():
                along = [1000.0 * value for value in push.curve.displacement_m]
                series = [Series.of("α", along, push.curve.multiplier)]
                where = f"{direction_name(direction)}, {words.plain(f'value.{contacts}')}"
                yield {
                    "title": _title(words, "pushover", name, where),
                    "jumps": list(_jumps(state, direction, max(map(abs, along)))),
                    "x_label": words.plain("figure.x_displacement"),
                    "y_label": words.plain("figure.multiplier"),
                    "series": [asdict(each) for each in series],
                    "frames": _frames(push.frames, series) | _ties(results, name, push.frames, push.ties),
                }


def _jumps(state: State, direction: Direction, reach: float) -> Iterator[dict[str, Any]]:
    """Yield the control displacements (mm, along x) at the d* of the limit states that a path of this reach has.

    The rigid activation has none: that of SLO and SLD is the end of the elastic branch, where the curve has one.
    """
    capacity, pushed = state.capacity.get(direction), state.pushover.get(direction)
    rigid = pushed.rigid if pushed else None
    if not capacity or not rigid or not rigid.d_star_m:
        return
    for limit in reversed(QUOTED):
        checks = (capacity.checks.get(name) for name in (limit, f"{limit} elastic"))
        d_star = next((check.d_star_m for check in checks if check and check.d_star_m is not None), None)
        if d_star is not None:
            along = [1000.0 * displacement for displacement in rigid.curve.displacement_m]
            d = float(np.interp(d_star, np.maximum.accumulate(rigid.d_star_m), along))
            if abs(d) <= (1.0 + NEAR) * reach:
                yield {"label": f"d_{limit}", "x": float(f"{d:.6g}")}


def _histories(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for name, state in results.states.items():
        for entry in state.history:
            kept, curve = entry.snapshots, entry.curve
            if kept and curve:
                displacement = [1000.0 * value for value in curve.displacement_m]
                yield {
                    "title": _title(words, "history", name, entry.record),
                    "jumps": [],
                    "x_label": words.plain("figure.time"),
                    "y_label": words.plain("figure.x_displacement"),
                    "series": [asdict(Series.of("d", curve.time_s, displacement))],
                    "frames": {
                        "x": kept.time_s,
                        "y": [[1000.0 * value for value in kept.displacement_m]],
                        **_drawn(kept),
                        **_ties(results, name, kept, None),
                    },
                }


def _frames(kept: Frames, series: Sequence[Series]) -> dict[str, Any]:
    """Frames of a static path: values on its curves at each, and what the script draws."""
    return {
        "x": [series[0].x[index] for index in kept.index],
        "y": [[each.y[index] for index in kept.index] for each in series],
        **_drawn(kept),
    }


def _drawn(kept: Frames | Snapshots) -> dict[str, Any]:
    """Where the blocks are and what the joints carry at each frame, NaN where that is not known."""
    joints = max((len(each) for each in kept.centre if each is not None), default=0)
    force = [np.full((joints, 2), np.nan) if each is None else each for each in kept.force_kN]
    centre = [np.full(joints, np.nan) if each is None else each for each in kept.centre]
    return {
        "configuration": _floats(kept.configuration),
        "force": _floats(force),
        "centre": _floats(centre),
        "met": [_joint(each) for each in kept.met],
    }


def _ties(
    results: Results, state: str, kept: Frames | Snapshots, along: Sequence[TieTension] | None
) -> dict[str, Any]:
    """Which ties are in a state, by their places in the list of all, and their tension (kN) at each frame.

    None where it is not known, or nowhere determined `along` the path.
    """
    every = list(results.model.ties or ())
    own = ties_of(results, state)
    unknown = {each.tie for each in along or () if each.greatest_kN is None}
    tension = [
        None
        if each is None
        else [None if tie.name in unknown else value for tie, value in zip(own, _short(each), strict=True)]
        for each in kept.tie_kN or [None] * len(kept.force_kN)
    ]
    return {"ties": [every.index(tie) for tie in own], "tension": tension if own else []}


def _joint(joint: Face) -> dict[str, Any]:
    """What the script needs of a pair of faces; `drawn`: whether its slip counts from the drawing."""
    return {
        "blocks": joint.blocks,
        "middle": joint.middle_m,
        "faces": joint.faces_m,
        "friction": joint.friction,
        "depth": joint.depth_m,
        "strength": joint.compressive_strength_kN_m2,
        "drawn": isinstance(joint, Joint),
    }


def _short(values: Sequence[float]) -> list[float]:
    return [float(f"{value:.6g}") for value in values]


def _floats(values: Any) -> str:
    """Return numbers as base64 of little-endian 32-bit floats, NaN for None."""
    return base64.b64encode(np.asarray(values, dtype=float).astype("<f4").tobytes()).decode()


def _title(words: Words, stage: str, state: str, what: str) -> str:
    return f"{words.plain(f'viewer.{stage}')}: {words.state(state)}, {what}"
