"""Time histories of a project: every record from every state, as plain numbers for results.json."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.dynamic.ensemble import sustained_peak
from assessment.analyses.dynamic.response import Response, Setting, respond
from assessment.project.schema import HistoryTable
from assessment.results.frames import snapshots
from mechanics import Assembly, ConvergenceError, State
from mechanics.records import response_spectrum
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion

Numbers = dict[str, Any]
Start = State | str
"""The state at rest that a motion begins from, or why it could not be reached."""

FRAMES = 150  # of an animation
SHORTEST_FRAME = 0.05  # s
MOST_POINTS = 2000  # of a curve kept for figures


@dataclass
class StageResult:
    """What one motion, or one search, from one state gave; `failures`: what could not be completed."""

    state: str
    stage: str
    numbers: Numbers
    quality: list[Numbers] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    seconds: float = 0.0
    convergence: Numbers | None = None


def history(model: Assembly, motion: BaseMotion, setting: Setting, state: str, start: Start) -> StageResult:
    """One time history in numbers; displacements are horizontal, of the control point, from the state's own rest.

    Times count from the first sample of the record's file, the window's start included. "peak_configuration" is that of
    the largest displacement that the structure came back from, "sustained_displacement_m" at "time_of_peak_s".
    """
    title = f"{state}, history of {motion.name}"
    numbers: Numbers = {
        "record": motion.name,
        "pga_g": motion.pga,
        "scale": motion.scale,
        "time_step_s": motion.record.time_step,
        "contacts": setting.table.contacts,
        "integrator": None,
        "amplitude": motion.amplitude,
        "control": setting.control.name,
        "peak_displacement_m": None,
        "residual_displacement_m": None,
        "collapsed": None,
        "time_of_collapse_s": None,
        "reason": None,
    }
    result = StageResult(state, "history", numbers)
    if isinstance(start, str):
        numbers["reason"] = start
        result.warnings.append(f"{title}: {start}")
        return result
    began = time.perf_counter()
    try:
        response = respond(model, motion, setting, start)
    except ConvergenceError as error:
        numbers["reason"] = str(error)
        result.failures.append(f"{title}: {error}")
        return result
    result.seconds = time.perf_counter() - began
    last, drawn = response.last, model.initial.positions
    peak = sustained_peak(response.displacement, response.collapsed)
    kept = thinned(response.displacement)
    numbers |= {
        "peak_displacement_m": float(abs(response.displacement).max()),
        "sustained_displacement_m": float(abs(response.displacement[peak])),
        "time_of_peak_s": motion.start + float(response.time[peak]),
        "residual_displacement_m": None if last.collapsed else float(response.displacement[-1]),
        "collapsed": last.collapsed,
        "time_of_collapse_s": motion.start + float(response.time[-1]) if last.collapsed else None,
        "reason": last.collapse_reason or None,
        "free_motion_from_s": motion.start + motion.record.duration if len(response.parts) > 1 else None,
        "curve": {
            "time_s": (motion.start + response.time[kept]).tolist(),
            "displacement_m": response.displacement[kept].tolist(),
        },
        "snapshots": snapshots(
            model,
            motion.start + response.time,
            response.displacement,
            response.positions,
            response.forces,
            peak,
        ),
        "peak_configuration": (response.positions[peak] - drawn).tolist(),
        "final_configuration": (response.positions[-1] - drawn).tolist(),
        "energy": response.energy(),
        "integrator": last.integrator,
        "integrator_chosen": last.chosen,
        "integrator_share": response.integrator_share(),
        "programs": response.total("programs"),
        "halvings": response.total("halvings"),
        "notes": list(response.notes),
        "seconds": result.seconds,
    }  # fmt: skip
    if isinstance(setting.table, HistoryTable) and setting.table.animation:
        numbers["frames"] = frames(response, motion.start, drawn)
    result.quality.append(
        quality_row(state, f"history, {motion.name}", response.total("programs"), response.worst)
    )
    result.warnings += [f"{title}: {note}" for note in response.notes]
    if last.collapsed:
        result.warnings.append(
            f"{title}: collapse at {numbers['time_of_collapse_s']:.4g} s: {last.collapse_reason}"
        )
    return result


def frames(response: Response, start: float, drawn: Array) -> Numbers:
    """At most FRAMES configurations (b, 3) of a motion, from positions as `drawn`, at equal times from `start` (s)."""
    steps = max(math.ceil(len(response.time) / FRAMES), round(SHORTEST_FRAME / float(response.time[1])), 1)
    every = slice(None, None, steps)
    moved = response.positions[every] - drawn
    return {
        "time_s": (start + response.time[every]).tolist(),
        "configuration": moved.round(7).tolist(),
    }


def quality_row(state: str, stage: str, solves: int, worst: float) -> Numbers:
    """The row of motions in the table of certificates; `worst`: the largest residual of all their programs.

    It bounds that of equilibrium and that of the products. Forces stay inside the cone by the method itself.
    """
    return {
        "state": state,
        "stage": stage,
        "solves": solves,
        "worst_equilibrium_residual": worst,
        "worst_complementarity": worst,
    }


def motion_numbers(motion: BaseMotion, periods: Array) -> Numbers:
    """A base motion for figures: its accelerations in the window, thinned, and its spectrum at 5 % damping."""
    a = motion.record.acceleration
    S_a, S_d = response_spectrum(a, motion.record.time_step, periods)
    kept = thinned(a)
    return {
        "name": motion.name,
        "pga_g": motion.pga,
        "scale": motion.scale,
        "window_s": [motion.start, motion.start + motion.record.duration],
        "time_s": (motion.start + motion.record.time[kept]).tolist(),
        "acceleration_g": a[kept].tolist(),
        "T_s": periods.tolist(),
        "S_a_g": S_a.tolist(),
        "S_d_m": S_d.tolist(),
        "vertical": motion.vertical is not None,
    }


def thinned(values: Array, most: int = MOST_POINTS) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Indices of at most `most` samples that keep a curve's shape: the extremes of equal stretches, and its ends."""
    if values.size <= most:
        return np.arange(values.size)
    bounds = np.linspace(0, values.size, (most - 2) // 2 + 1).astype(int)
    extremes = [
        start + index
        for start, end in pairwise(bounds)
        for index in (int(values[start:end].argmin()), int(values[start:end].argmax()))
    ]
    return np.unique([0, *extremes, values.size - 1])
