"""What the interactive page steps through: the paths of the results with their frames, as data of its script."""

import base64
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from assessment.ntc.tables import QUOTED
from assessment.report.language import Words, label, scale
from assessment.report.tables import moves, pushes
from assessment.results.frames import ties_of
from assessment.results.joint_states import CONDITIONS, IDLE, Situation, faces_of, states_of
from assessment.results.schema import Direction, Frames, Results, Snapshots, StateResults, TieTension

NEAR = 0.01  # of a path's reach: so far beyond its end is at its end


class Code(Markup):
    """What is no text: printed as it is."""


def viewer(results: Results, words: Words) -> Code | None:
    """Return the data of the page that steps through the paths, to be put between tags; None where none was kept."""
    paths = []
    for where, path in moves(results):
        curves = {"Rx": path.reaction_x_kN, "Rz": path.reaction_z_kN}
        tied = _ties(results, where["state"], path.frames, path.ties)
        axes = ("movement_m", path.movement_m), words.plain("viewer.reactions")
        place = words.at(where["state"], None, where["contacts"])
        paths.append(_path(results, words, f"pushdown: {place}", *axes, curves, path.frames, tied))
    for where, push in pushes(results):
        axes = ("displacement_m", push.curve.displacement_m), label("multiplier", words)
        tied = _ties(results, where["state"], push.frames, push.ties)
        title, curves = f"pushover: {words.at(*where.values())}", {"α": push.curve.multiplier}
        found = _path(results, words, title, *axes, curves, push.frames, tied)
        reach = scale("displacement_m") * max(map(abs, push.curve.displacement_m))
        jumps = list(_jumps(results.states[where["state"]], where["direction"], reach))
        paths.append(found | {"jumps": jumps})
    for name, state in results.states.items():
        for entry in state.history:
            if (kept := entry.snapshots) and (curve := entry.curve):
                axes = ("time_s", curve.time_s), label("displacement_m", words)
                title = f"history: {words.state(name)}, {entry.record}"
                curves = {"d": _shown("displacement_m", curve.displacement_m)}
                tied = _ties(results, name, kept)
                paths.append(_path(results, words, title, *axes, curves, kept, tied))
    if not paths:
        return None
    blocks = [
        {"vertices": block.vertices_m, "centroid": block.centroid_m, "layer": block.layer}
        | {"support": block.support, "weight": block.weight_kN}
        for block in results.geometry.blocks
    ]
    ties = [
        {"name": at.name, "ends": [at.start_m, at.end_m], "blocks": at.blocks, "yield": at.yield_force_kN}
        for at in results.model.ties or ()
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
    return Code(text)


def _path(
    results: Results, words: Words, title: str, along: tuple[str, Sequence[float]], y_label: str,
    curves: Mapping[str, Sequence[float]], kept: Frames | Snapshots, ties: dict[str, Any],
) -> dict[str, Any]:  # fmt: skip
    """Return a path of the page: its curves along a quantity, with the digits that can be seen, and its frames.

    `title`: a kind of path, and where it is; `curves`: values by label.
    """
    kind, place = title.split(": ", 1)
    name, values = along
    x, ys = _short(_shown(name, values)), {each: _short(y) for each, y in curves.items()}
    if isinstance(kept, Frames):
        there = {"x": [x[k] for k in kept.index], "y": [[y[k] for k in kept.index] for y in ys.values()]}
    else:
        there = {"x": kept.time_s, "y": [_shown("displacement_m", kept.displacement_m)]}
    return {
        "title": f"{words.plain(f'viewer.{kind}')}: {place}",
        "jumps": [],
        "x_label": label(name, words),
        "y_label": y_label,
        "series": [{"label": each, "x": x, "y": y} for each, y in ys.items()],
        "frames": there | _drawn(results, kept) | ties,
    }


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


def _drawn(results: Results, kept: Frames | Snapshots) -> dict[str, Any]:
    """Where the blocks are and what the joints do at each frame: forces NaN where they are not known.

    Of each joint 15 numbers: both ends and the point of the resultant (m), N and T (kN), eccentricity and contact
    length (m), pressure (kN/m²), openings at the ends and slip (m), and the place of its condition in CONDITIONS.
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
    return {
        "configuration": _coded(kept.configuration),
        "pairs": [joint.blocks for joint in [*results.geometry.joints, *kept.met]],
        "joints": _coded(rows),
    }


def _ties(
    results: Results, state: str, kept: Frames | Snapshots, along: Sequence[TieTension] | None = None
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


def _coded(values: Any) -> str:
    """Return numbers as base64 of 32-bit floats, little-endian."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def _shown(name: str, values: Sequence[float]) -> list[float]:
    return [scale(name) * value for value in values]
