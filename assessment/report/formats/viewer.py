"""What the interactive page steps through: the paths of the results with their frames, as data of its script."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from markupsafe import Markup

from assessment.ntc.tables import QUOTED
from assessment.report.tables.rows import moves, pushes
from assessment.report.text.language import Words, label, scale
from assessment.results.configurations.frames import ties_of
from assessment.results.configurations.joint_states import CONDITIONS, IDLE, Situation, faces_of, states_of
from assessment.results.schema import Direction, Frames, Results, Snapshots, StateResults, TieTension

VALUES = 15  # of a joint at a frame
Series = dict[str, Any]
NEAR = 0.01  # of a path's reach: so far beyond its end is at its end


class Code(Markup):
    """What is no text: printed as it is."""


@dataclass(frozen=True)
class Viewer:
    """The script of the page and its data, ready to be put between tags."""

    data: Code
    script: Code


def viewer(results: Results, words: Words) -> Viewer | None:
    """Return script and data of the page that steps through the paths; None where no path was kept."""
    paths = [*_pushdowns(results, words), *_pushovers(results, words), *_histories(results, words)]
    if not paths:
        return None
    blocks = [
        {"vertices": block.vertices_m, "centroid": block.centroid_m, "layer": block.layer}
        | {"support": block.support, "weight": block.weight_kN}
        for block in results.geometry.blocks
    ]
    ties = [
        {
            "name": tie.name,
            "ends": [tie.start_m, tie.end_m],
            "blocks": tie.blocks,
            "yield": tie.yield_force_kN,
        }
        for tie in results.model.ties or ()
    ]
    data = {
        "blocks": blocks,
        "ties": ties,
        "slack": IDLE * results.model.weight_kN,
        "conditions": CONDITIONS,
        "paths": paths,
        "words": dict(words.strings["viewer"]) | {"decimal_mark": words.plain("value.decimal_mark")},
    }
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    script = (files("templates") / "viewer.js").read_text(encoding="utf-8")
    return Viewer(Code(text), Code(script))


def _pushdowns(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for where, path in moves(results):
        movement = _shown("movement_m", path.movement_m)
        series = [_series("Rx", movement, path.reaction_x_kN), _series("Rz", movement, path.reaction_z_kN)]
        labels = label("movement_m", words), words.plain("viewer.reactions")
        kept = _frames(results, path.frames, series) | _ties(results, where["state"], path.frames, path.ties)
        place = words.at(where["state"], None, where["contacts"])
        yield _path(words, "pushdown", place, labels, series, kept)


def _pushovers(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for where, push in pushes(results):
        along = _shown("displacement_m", push.curve.displacement_m)
        series = [_series("α", along, push.curve.multiplier)]
        labels = label("displacement_m", words), label("multiplier", words)
        kept = _frames(results, push.frames, series) | _ties(results, where["state"], push.frames, push.ties)
        found = _path(words, "pushover", words.at(*where.values()), labels, series, kept)
        reach = max(map(abs, along))
        yield found | {"jumps": list(_jumps(results.states[where["state"]], where["direction"], reach))}


def _path(
    words: Words,
    stage: str,
    place: str,
    labels: tuple[str, str],
    series: Sequence[Series],
    frames: dict[str, Any],
) -> dict[str, Any]:
    """Return a path of the page: its curves over the labels of both axes, and its frames."""
    title, (x_label, y_label) = f"{words.plain(f'viewer.{stage}')}: {place}", labels
    found = {"title": title, "jumps": [], "x_label": x_label, "y_label": y_label}
    return found | {"series": series, "frames": frames}


def _series(label: str, x: Sequence[float], y: Sequence[float]) -> Series:
    """Return a curve of the page: its label and its points, with the digits that can be seen."""
    return {"label": label, "x": _short(x), "y": _short(y)}


def _jumps(state: StateResults, direction: Direction, reach: float) -> Iterator[dict[str, Any]]:
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
            along = _shown("displacement_m", rigid.curve.displacement_m)
            d = float(np.interp(d_star, np.maximum.accumulate(rigid.d_star_m), along))
            if abs(d) <= (1.0 + NEAR) * reach:
                yield {"label": f"d_{limit}", "x": float(f"{d:.6g}")}


def _histories(results: Results, words: Words) -> Iterator[dict[str, Any]]:
    for name, state in results.states.items():
        for entry in state.history:
            kept, curve = entry.snapshots, entry.curve
            if kept and curve:
                place = f"{words.state(name)}, {entry.record}"
                labels = label("time_s", words), label("displacement_m", words)
                series = [_series("d", curve.time_s, _shown("displacement_m", curve.displacement_m))]
                y = _shown("displacement_m", kept.displacement_m)
                frames = {"x": kept.time_s, "y": [y]} | _drawn(results, kept)
                frames |= _ties(results, name, kept, None)
                yield _path(words, "history", place, labels, series, frames)


def _frames(results: Results, kept: Frames, series: Sequence[Series]) -> dict[str, Any]:
    """Frames of a static path: values on its curves at each, and what the script draws."""
    y = [[each["y"][index] for index in kept.index] for each in series]
    return {"x": [series[0]["x"][index] for index in kept.index], "y": y, **_drawn(results, kept)}


def _drawn(results: Results, kept: Frames | Snapshots) -> dict[str, Any]:
    """Where the blocks are and what the joints do at each frame: forces NaN where they are not known.

    Of each joint `VALUES` numbers: both ends and the point of the resultant (m), N and T (kN), eccentricity and contact
    length (m), pressure (kN/m²), openings at the ends and slip (m), and the place of its condition in CONDITIONS:
    integers, of which −32768 is NaN, 32767 infinite.
    """
    faces = faces_of(results, kept.met)
    count = len(faces.depth)
    rows = []
    for at, force, centre in zip(kept.configuration, kept.force_kN, kept.centre, strict=True):
        known = np.zeros((count, 2)), np.full(count, np.nan)
        if force is not None and centre is not None:
            known[0][: len(force)], known[1][: len(centre)] = force, np.array(centre, dtype=float)
        found = Situation("", None, "rigid", 0.0, np.asarray(at, dtype=float), *known, kept.met)
        states = states_of(faces, results.model.weight_kN, found)
        forces = [states.normal, states.shear, states.eccentricity, states.contact, states.pressure]
        condition = np.array([CONDITIONS.index(each) for each in states.condition], dtype=float)
        if force is None:
            forces, condition = [np.full(count, np.nan)] * 5, np.full(count, np.nan)
        places = [states.ends.reshape(-1, 4), states.point]
        rows.append(np.column_stack([*places, *forces, states.opening, states.slip, condition]))
    # as base64: positions in 32-bit floats, joints in 16-bit integers with the unit of each column
    values = np.array(rows).reshape(len(rows), count, VALUES)
    finite = np.where(np.isfinite(values), values, 0.0)
    unit = np.maximum(abs(finite).max(axis=(0, 1), initial=0.0), 1e-12) / 32000.0
    whole = np.where(np.isnan(values), -32768, np.where(np.isinf(values), 32767, np.round(finite / unit)))
    return {
        "configuration": _coded(kept.configuration, "<f4"),
        "pairs": [joint.blocks for joint in [*results.geometry.joints, *kept.met]],
        "joints": {"unit": _short(unit), "values": _coded(whole, "<i2")},
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


def _short(values: Sequence[float]) -> list[float]:
    return [float(f"{value:.6g}") for value in values]


def _coded(values: Any, kind: str) -> str:
    """Return numbers as base64 of a little-endian kind."""
    return base64.b64encode(np.asarray(values, dtype=float).astype(kind).tobytes()).decode()


def _shown(name: str, values: Sequence[float]) -> list[float]:
    return [scale(name) * value for value in values]
