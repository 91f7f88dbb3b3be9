"""Time histories of a project: every record from every state."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.dynamic.ensemble import sustained_peak
from assessment.analyses.dynamic.response import Response, Setting, respond, speed_at_end
from assessment.project.schema import HistoryTable
from assessment.results.configurations.frames import snapshots
from assessment.results.configurations.ties import while_shaken
from assessment.results.schema.dynamic import AnimationFrames, Course, History, Motion
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import known
from assessment.results.schema.studies import ConvergenceRow
from mechanics import Assembly, ConvergenceError, State
from mechanics.messages import Message, headed, message
from mechanics.records import response_spectrum
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion

Start = State | Message
"""The state at rest that a motion begins from, or why it could not be reached."""

FRAMES = 150  # of an animation
SHORTEST_FRAME = 0.05  # s
MOST_POINTS = 2000  # of a curve kept for figures


@dataclass
class DynamicResult:
    """One time history from one state.

    `numbers`: the part of the results; `quality`, `convergence`: its rows of these tables; `failures`: why it could not
    be completed; `seconds`: computing time.
    """

    state: str
    stage: str
    numbers: History
    quality: list[QualityRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)
    failures: list[Message] = field(default_factory=list)
    seconds: float = 0.0
    convergence: ConvergenceRow | None = None


@dataclass(frozen=True, eq=False)
class Shaking:
    """A base motion that shakes a model from a state: how it is integrated, the state's name, and where it starts."""

    model: Assembly
    motion: BaseMotion
    setting: Setting
    state: str
    start: Start


def history(shaking: Shaking) -> DynamicResult:
    """Return one time history; displacements are horizontal, of the control point, from the state's own rest, m.

    Times count from the first sample of the record's file, the window's start included. The largest displacement from
    which the structure came back is "sustained_displacement_m", at "time_of_peak_s", with "peak_configuration".
    """
    model, motion, start = shaking.model, shaking.motion, shaking.start
    title = history_title(shaking)
    if isinstance(start, str):
        nothing = _unanswered(motion, shaking.setting, start)
        return DynamicResult(shaking.state, "history", nothing, warnings=[headed(title, start)])
    began = time.perf_counter()
    try:
        response = respond(model, motion, shaking.setting, start)
    except ConvergenceError as error:
        nothing = _unanswered(motion, shaking.setting, error.message)
        return DynamicResult(shaking.state, "history", nothing, failures=[headed(title, error.message)])
    seconds = time.perf_counter() - began

    found = _answered(model, motion, shaking.setting, response).replace(seconds=seconds)
    table = shaking.setting.table
    if isinstance(table, HistoryTable) and table.animation:
        found = found.replace(frames=frames(response, motion.start, model.initial.positions))
    result = DynamicResult(shaking.state, "history", found, seconds=seconds)
    programs = response.counts()["programs"]
    result.quality.append(quality_row(shaking.state, f"history, {motion.name}", programs, response.worst))
    result.warnings += [headed(title, note) for note in response.notes]
    last = response.last
    if last.collapsed:
        collapse = message(
            "collapse at {time:.4g} s: {reason}",
            time=known(result.numbers.time_of_collapse_s),
            reason=last.collapse_reason,
        )
        result.warnings.append(headed(title, collapse))
    elif speed := speed_at_end(model, last):
        moving = message(
            "blocks still move at the end, at {speed:.2g} m/s: the residual displacement is that of this moment, "
            "not of rest",
            speed=speed,
        )
        result.warnings.append(headed(title, moving))
    return result


def history_title(shaking: Shaking) -> Message:
    """Return the beginning of the warnings of a time history."""
    return message("{state}, history of {record}", state=shaking.state, record=shaking.motion.name)


def _unanswered(motion: BaseMotion, setting: Setting, reason: str | None) -> History:
    """Return a time history without an answer, and the `reason` why there is none."""
    return History(
        record=motion.name,
        pga_g=motion.pga,
        scale=motion.scale,
        time_step_s=motion.record.time_step,
        contacts=setting.table.contacts,
        integrator=None,
        amplitude=motion.amplitude,
        control=setting.control.name,
        peak_displacement_m=None,
        residual_displacement_m=None,
        collapsed=None,
        time_of_collapse_s=None,
        reason=reason,
    )


def _answered(model: Assembly, motion: BaseMotion, setting: Setting, response: Response) -> History:
    """Return peak, residual, collapse, curve, configurations and energies of a response."""
    last, drawn = response.last, model.initial.positions
    moved, times = response.displacement, motion.start + response.time
    peak, kept = sustained_peak(moved, response.collapsed), thinned(moved)
    rigid = setting.table.contacts == "rigid"
    kept_frames = snapshots(model, times, moved, response.positions, response.forces, peak)
    if rigid and model.ties:
        kept_frames = kept_frames.replace(tie_kN=None)
    found = _unanswered(motion, setting, last.collapse_reason or None).replace(
        peak_displacement_m=float(abs(moved).max()),
        sustained_displacement_m=float(abs(moved[peak])),
        time_of_peak_s=motion.start + float(response.time[peak]),
        residual_displacement_m=None if last.collapsed else float(moved[-1]),
        collapsed=last.collapsed,
        time_of_collapse_s=motion.start + float(response.time[-1]) if last.collapsed else None,
        free_motion_from_s=motion.start + motion.record.duration if len(response.parts) > 1 else None,
        curve=Course(time_s=times[kept].tolist(), displacement_m=moved[kept].tolist()),
        snapshots=kept_frames,
        peak_configuration=(response.positions[peak] - drawn).tolist(),
        final_configuration=(response.positions[-1] - drawn).tolist(),
        energy=response.energy(),
        integrator=last.integrator,
        integrator_chosen=last.chosen,
        integrator_share=response.integrator_share(),
        **response.counts(),
        notes=list(response.notes),
    )
    ties = while_shaken(model, times, response.forces, last.final, rigid)
    return found.replace(ties=ties) if ties else found


def frames(response: Response, start: float, drawn: Array) -> AnimationFrames:
    """Return at most FRAMES displacements (b, 3) from the positions `drawn`, at equal times from `start` (s)."""
    steps = max(math.ceil(len(response.time) / FRAMES), round(SHORTEST_FRAME / float(response.time[1])), 1)
    every = slice(None, None, steps)
    moved = response.positions[every] - drawn
    return AnimationFrames(
        time_s=(start + response.time[every]).tolist(), configuration=moved.round(7).tolist()
    )


def quality_row(state: str, stage: str, solves: int, worst: float) -> QualityRow:
    """Return the row of motions in the table of certificates; `worst`: the largest residual of all their programs.

    It bounds the residuals of equilibrium and complementarity. The method itself keeps forces inside the cone.
    """
    return QualityRow(
        state=state,
        stage=stage,
        solves=solves,
        worst_equilibrium_residual=worst,
        worst_complementarity=worst,
    )


def motion_part(motion: BaseMotion, periods: Array) -> Motion:
    """Return a base motion for figures: accelerations in the window, thinned, and spectrum at `periods` (k,) s, 5 %."""
    a = motion.record.acceleration
    S_a, S_d = response_spectrum(a, motion.record.time_step, periods)
    kept = thinned(a)
    return Motion(
        name=motion.name,
        pga_g=motion.pga,
        scale=motion.scale,
        window_s=[motion.start, motion.start + motion.record.duration],
        time_s=(motion.start + motion.record.time[kept]).tolist(),
        acceleration_g=a[kept].tolist(),
        T_s=periods.tolist(),
        S_a_g=S_a.tolist(),
        S_d_m=S_d.tolist(),
        vertical=motion.vertical is not None,
    )


def thinned(values: Array, most: int = MOST_POINTS) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Return indices (k,) of at most `most` of values (n,) that keep a curve's shape: extremes of stretches, ends."""
    if values.size <= most:
        return np.arange(values.size)
    bounds = np.linspace(0, values.size, (most - 2) // 2 + 1).astype(int)
    extremes = [
        start + index
        for start, end in pairwise(bounds)
        for index in (int(values[start:end].argmin()), int(values[start:end].argmax()))
    ]
    return np.unique([0, *extremes, values.size - 1])
