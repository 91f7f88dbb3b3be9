"""One motion: the response to a record, the free motion after it, its numbers, and the state that it begins from."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from assessment.analyses.found import Found, as_part
from assessment.analyses.states import StateResult
from assessment.project.model import StateModel
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, ControlTable, MotionTable, StatesTable
from assessment.results.frames import snapshots, while_shaken
from assessment.results.schema import ConvergenceRow, Pushovers, QualityRow, known, present
from assessment.results.schema.dynamic import AppliedRecord, Counts, Course, EnergyBalance, History
from assessment.runtime.tasks import Workers
from mechanics import Assembly, ConvergenceError, State, TimeHistory, time_history
from mechanics.messages import Message, headed, linked, message
from mechanics.model import Behaviour, Direction
from mechanics.procedures import HISTORY, may_fall, unfinished
from mechanics.progress import stretch
from mechanics.records import response_spectrum
from mechanics.steps import Sliding
from mechanics.types import Array

TAIL = 2.0  # s of free motion that are followed at a time
TAILS = 15  # at most
COUNTS = tuple(name for name in Counts.model_fields if name != "motions")
ENERGIES = tuple(name.removesuffix("_kNm") for name in EnergyBalance.model_fields)


@dataclass(frozen=True)
class Setting:
    """How motions are integrated: the keys that [[history]] and [incremental] share.

    `ultimate` (m): control displacement at which the static capacity vanishes, None where it is not known.
    """

    table: MotionTable
    control: ControlTable
    ultimate: float | None = None
    sliding: Sliding = "coulomb"


Start = State | Message
"""The state at rest that a motion begins from, or why it could not be reached."""


@dataclass(frozen=True, eq=False)
class Shaking:
    """A base motion that shakes a model: how it is integrated, where it starts, and the name of the state there."""

    model: Assembly
    motion: BaseMotion
    setting: Setting
    start: Start
    state: str = ""

    @property
    def starts(self) -> bool:
        """Whether the state at rest was reached."""
        return isinstance(self.start, State)


@dataclass(frozen=True, eq=False)
class Response:
    """A motion and the free one after it: time (k,) s, control displacement (k,) m from rest, positions (k, b, 3)."""

    time: Array
    displacement: Array
    positions: Array
    forces: Array  # (k, j, 3) kN and kNm: N, P and T of the drawn joints
    parts: tuple[TimeHistory, ...]  # its runs

    @property
    def last(self) -> TimeHistory:
        """The last run."""
        return self.parts[-1]

    @property
    def collapsed(self) -> bool:
        """Whether it ends in collapse."""
        return self.last.collapsed

    @property
    def worst(self) -> float:
        """The largest residual of a program, relative."""
        return max(part.worst for part in self.parts)

    @property
    def notes(self) -> tuple[Message, ...]:
        """Warnings about the runs, each once; not that they end before rest."""
        notes = (note for part in self.parts for note in part.notes if note != unfinished(part))
        return tuple(dict.fromkeys(notes))

    def counts(self) -> dict[str, int]:
        """Return steps, skipped, lifting, programs, iterations and halvings of all runs."""
        return {name: sum(getattr(part, name) for part in self.parts) for name in COUNTS}

    def energy(self) -> EnergyBalance:
        """Return the energy balance since the beginning, kNm: stored energies, input, dissipated energies."""
        changes = {
            f"{name}_kNm": float(sum(energy[-1] - energy[0] for energy in series))
            for name in ENERGIES
            for series in [[getattr(part.energy, name) for part in self.parts]]
        }
        return EnergyBalance(**changes)

    def integrator_share(self) -> float:
        """Return what the integrator took over the energy turned over, of all runs; see mechanics' Energy."""
        energies, model = [part.energy for part in self.parts], self.last.model
        least = HISTORY.nothing * model.weight * model.size  # where nothing moves
        taken = sum(float(energy.integrator[-1] - energy.integrator[0]) for energy in energies)
        kinetic = max(float(energy.kinetic.max()) for energy in energies)
        dissipated, put_in = (
            sum(float(getattr(energy, name).max()) for energy in energies) for name in ("dissipated", "input")
        )
        return abs(taken) / max(least, kinetic, dissipated, put_in)


def respond(shaking: Shaking, factor: float = 1.0, to_rest: bool = True) -> Response:
    """Return the response to a base motion times `factor`, and the free motion after it until blocks rest.

    It ends before rest where it cannot fall (mechanics' may_fall); with rigid joints, which come to rest, only if
    `to_rest` is false. Followed are TAILS times TAIL at most. Raises ConvergenceError if a step is not solved.
    """
    motion, setting, start = shaking.motion, shaking.setting, shaking.start
    assert isinstance(start, State)
    table, step = setting.table, motion.record.time_step

    def run(acceleration: Array, vertical: Array | None, state: State) -> TimeHistory:
        return time_history(
            shaking.model, acceleration, step, table.contacts, state, table.integrator, vertical,
            damping_ratio=table.damping_ratio or 0.0, control=setting.control.point_m, ultimate=setting.ultimate,
            sliding=setting.sliding,
        )  # fmt: skip

    vertical = None if motion.vertical is None else factor * motion.vertical.acceleration
    free = np.zeros(round(TAIL / step) + 2)
    record = motion.record.acceleration.size / (motion.record.acceleration.size + free.size)
    with stretch(0.0, record):
        parts = [run(factor * motion.record.acceleration, vertical, start)]
    lies = to_rest and table.contacts == "rigid"  # followed until blocks rest, others until none may fall
    while len(parts) <= TAILS and parts[-1].speed_at_end:
        if not lies and not may_fall([part.energy for part in parts], HISTORY.spent):
            break
        with stretch(record if len(parts) == 1 else 1.0, 1.0):
            parts.append(run(free, None, parts[-1].final))
    time, displacement = parts[0].time, known(parts[0].displacement)
    for part in parts[1:]:
        time = np.concatenate([time, time[-1] + part.time[1:]])
        displacement = np.concatenate([displacement, displacement[-1] + known(part.displacement)[1:]])
    positions, forces = (
        np.concatenate([getattr(parts[0], name), *(getattr(part, name)[1:] for part in parts[1:])])
        for name in ("positions", "forces")
    )
    return Response(time, displacement, positions, forces, tuple(parts))


MOST_POINTS = 2000  # of a curve kept for figures


@dataclass
class FoundHistory(Found[History]):
    """One time history from a state of that name; `convergence`: its row of that table."""

    value: History | None = None
    state: str = ""
    convergence: ConvergenceRow | None = None

    @property
    def numbers(self) -> History:
        """The part of the results."""
        return known(self.value)


def history(shaking: Shaking) -> FoundHistory:
    """Return one time history; displacements are horizontal, of the control point, from the state's own rest, m.

    Times count from the first sample of the record's file, the window's start included. The largest displacement from
    which the structure came back is "sustained_displacement_m", at "time_of_peak_s", with "peak_configuration".
    """
    title, state = history_title(shaking), shaking.state
    if isinstance(shaking.start, str):
        return FoundHistory(_unanswered(shaking, shaking.start), [headed(title, shaking.start)], state=state)
    began = time.perf_counter()
    try:
        response = respond(shaking)
    except ConvergenceError as error:
        nothing = _unanswered(shaking, error.message)
        return FoundHistory(nothing, failures=[headed(title, error.message)], state=state)
    seconds = time.perf_counter() - began
    value = _answered(shaking, response).replace(seconds=seconds)
    notes, last = list(response.notes), response.last
    if last.collapsed:
        at = known(value.time_of_collapse_s)
        notes.append(message("collapse at {time:.4g} s: {reason}", time=at, reason=last.collapse_reason))
    elif falling := unfinished(*response.parts):
        notes.append(falling)
    elif speed := last.speed_at_end:
        moving = message("blocks still move at the end, at {speed:.2g} m/s: the residual displacement is that of this "
                         "moment, not of rest", speed=speed)  # fmt: skip
        notes.append(moving)
    row = quality_row(state, f"history, {shaking.motion.name}", response.counts()["programs"], response.worst)
    warnings = [headed(title, note) for note in notes]
    return FoundHistory(value, warnings, quality=[row], seconds=seconds, state=state)


def history_title(shaking: Shaking) -> Message:
    """Return the beginning of the warnings of a time history."""
    return message("{state}, history of {record}", state=shaking.state, record=shaking.motion.name)


def _unanswered(shaking: Shaking, reason: str | None) -> History:
    """Return a time history without an answer, and the `reason` why there is none."""
    motion, setting = shaking.motion, shaking.setting
    return History(
        record=motion.name, pga_g=motion.pga, scale=motion.scale, time_step_s=motion.record.time_step,
        contacts=setting.table.contacts, integrator=None, amplitude=motion.amplitude, control=setting.control.name,
        peak_displacement_m=None, residual_displacement_m=None, collapsed=None, time_of_collapse_s=None,
        reason=reason, **motion.told_vertical,
    )  # fmt: skip


def _answered(shaking: Shaking, response: Response) -> History:
    """Return peak, residual, collapse, curve, configurations and energies of a response."""
    model, motion, last = shaking.model, shaking.motion, response.last
    drawn, rigid = model.initial.positions, shaking.setting.table.contacts == "rigid"
    moved, times = response.displacement, motion.start + response.time
    peak, kept = sustained_peak(moved, response.collapsed), thinned(moved)
    gone = np.zeros(len(times))  # m, of the corner that is farthest from where it began
    for number, block in enumerate(model.blocks):
        for corner in block.polygon if model.movable[number] else ():
            at = model.point_displacement(corner, number, response.positions)
            gone = np.maximum(gone, np.hypot(*(at - at[0]).T))
    kept_frames = snapshots(model, times, moved, response.positions, response.forces, peak)
    if rigid and model.ties:
        kept_frames = kept_frames.replace(tie_kN=None)
    return _unanswered(shaking, last.collapse_reason or None).replace(
        peak_displacement_m=float(abs(moved).max()),
        sustained_displacement_m=float(abs(moved[peak])),
        time_of_peak_s=motion.start + float(response.time[peak]),
        residual_displacement_m=None if last.collapsed else float(moved[-1]),
        farthest_m=float(gone.max()),
        farthest_left_m=None if last.collapsed else float(gone[-1]),
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
        **present({"ties": while_shaken(model, times, response.forces, last.final, rigid)}),
    )


def quality_row(state: str, stage: str, solves: int, worst: float) -> QualityRow:
    """Return the row of motions in the table of certificates; `worst` bounds their residuals of both kinds."""
    return QualityRow(
        state=state, stage=stage, solves=solves, worst_equilibrium_residual=worst, worst_complementarity=worst
    )


def motion_part(motion: BaseMotion, periods: Array) -> AppliedRecord:
    """Return a base motion for figures: accelerations in the window, thinned, and spectrum at `periods` (k,) s, 5 %."""
    a = motion.record.acceleration
    S_a, S_d = response_spectrum(a, motion.record.time_step, periods)
    kept = thinned(a)
    return as_part(
        AppliedRecord, motion, pga_g=motion.pga, window_s=[motion.start, motion.start + motion.record.duration],
        time_s=(motion.start + motion.record.time[kept]).tolist(), acceleration_g=a[kept].tolist(),
        T_s=periods.tolist(), S_a_g=S_a.tolist(), S_d_m=S_d.tolist(),
    )  # fmt: skip


def sustained_peak(displacement: Array, collapsed: bool) -> int:
    """Return the index of the largest displacement (k,); at a collapse only those before the last way outward count."""
    if collapsed:
        turns = np.flatnonzero(np.diff(np.sign(np.diff(displacement)))) + 1
        displacement = displacement[: turns[-1] + 1] if turns.size else displacement[:1]
    return int(np.argmax(abs(displacement)))


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


WORTHWHILE = 50_000  # joints times steps: below it a second process costs more than it saves


Starts = Mapping[tuple[str, str], tuple[Assembly, Start]]
"""By state and contacts an assembly, and the state at rest in which a motion finds it, or why that was not reached."""


@dataclass(frozen=True)
class MotionInputs:
    """The inputs that all motions of a run share; `pushovers` of each state, by direction."""

    project: Project
    starts: Starts
    pushovers: Mapping[str, Mapping[Direction, Pushovers]]
    workers: Workers

    def tasks(self, table: StatesTable, motion: BaseMotion) -> list[Shaking]:
        """Return the motion from every state that the table asks for."""
        control, sliding = self.project.control_point(table.control), self.project.contacts.sliding
        # without its choice of states: one analysis does not depend on the others
        integrated = table.model_copy(update={"states": None})
        found = []
        for state in self.project.states:
            if table.states is None or state in table.states:
                model, start = self.starts[state, table.contacts]
                ultimate = ultimate_of(self.pushovers.get(state, {}), control.name)
                setting = Setting(integrated, control, ultimate, sliding)
                found.append(Shaking(model, motion, setting, start, state))
        return found

    def histories(self, tasks: Sequence[tuple[Shaking]]) -> list[FoundHistory]:
        """Return the time history of every task, in order."""
        samples = [shaking.motion.record.acceleration.size for (shaking,) in tasks]
        work = sum(len(shaking.model.contacts) * n for (shaking,), n in zip(tasks, samples, strict=True))
        titles = [f"{shaking.state}, {shaking.motion.name}" for (shaking,) in tasks]
        return self.workers.each("history", history, tasks, titles, work > WORTHWHILE, samples)


def starts_of(
    behaviours: Iterable[Behaviour], models: Mapping[str, StateModel], stages: Iterable[StateResult]
) -> dict[tuple[str, str], tuple[Assembly, Start]]:
    """Return what is at rest by state and behaviour, as drawn or settled, or the reason why it was not reached."""
    drawn = models[ORIGINAL].assembly
    starts: dict[tuple[str, str], tuple[Assembly, Start]] = {
        (ORIGINAL, behaviour): (drawn, drawn.initial) for behaviour in behaviours
    }
    for stage in stages:
        if stage.state != ORIGINAL:
            place = stage.state, stage.behaviour
            starts[place] = models[stage.state].assembly, why_not_reached(stage)
            if begun := stage.begun:
                starts[place] = begun.model, begun.state or begun.model.initial
    return starts


def why_not_reached(stage: StateResult) -> Message:
    """Return why a settled state was not reached."""
    return linked(stage.failures) if stage.failures else message("the settled state was not reached")


def ultimate_of(pushed: Mapping[Direction, Pushovers], control: str) -> float | None:
    """Return where the static capacity vanishes (m), if for this control point in both directions."""
    rigid = [(each.control, each.rigid) for each in pushed.values() if each.rigid is not None]
    ends = [curve.d_0_m for _, curve in rigid if curve.reached_zero and curve.d_0_m is not None]
    return max(ends) if len(ends) == 2 and {name for name, _ in rigid} == {control} else None


def least_d_0(pushed: Mapping[Direction, Pushovers], control: str) -> float | None:
    """Return the least d_0 (m) of the rigid curves of a control point; None: no curve has one."""
    rigid = [each.rigid for each in pushed.values() if each.control == control and each.rigid]
    return min((each.d_0_m for each in rigid if each.d_0_m), default=None)
