"""The response of the structure to a base motion, and its free motion after it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from assessment.results.schema.dynamic import Energy
from mechanics import Assembly, State, TimeHistory, time_history
from mechanics.messages import Message
from mechanics.procedures import HISTORY, SEARCH
from mechanics.progress import stretch
from mechanics.types import GRAVITY, Array

if TYPE_CHECKING:
    from assessment.project.motions import BaseMotion
    from assessment.project.schema import ControlTable, MotionTable
    from mechanics.steps import Sliding

TAIL = 2.0  # s of free motion that are followed at a time
TAILS = 15  # at most
SPENT = 0.5  # of the potential energy from which the structure has come back: with less it does not fall
LATELY = 0.5  # s
COUNTS = ("steps", "skipped", "lifting", "programs", "iterations", "halvings")
STILL = 0.01  # of √(g·size): speed below which a block rests
STORED = ("kinetic", "potential", "elastic")
ENERGIES = (*STORED, "input", "friction", "impact", "viscous", "integrator", "residual")


@dataclass(frozen=True)
class Setting:
    """How motions are integrated: the keys that [[history]] and [incremental] share.

    `ultimate` (m): control displacement at which the static capacity vanishes, None where it is not known.
    """

    table: MotionTable
    control: ControlTable
    ultimate: float | None = None
    sliding: Sliding = "coulomb"


@dataclass(frozen=True, eq=False)
class Response:
    """A motion and the free one after it: time (k,) s from the beginning, control displacement (k,) m from rest.

    `positions` (k, b, 3); `forces` (k, j, 3) kN and kNm: N, P and T of the drawn joints; `parts`: the runs that it
    is made of.
    """

    time: Array
    displacement: Array
    positions: Array
    forces: Array
    parts: tuple[TimeHistory, ...]

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
        """Warnings about the runs, each once."""
        return tuple(dict.fromkeys(note for part in self.parts for note in part.notes))

    def counts(self) -> dict[str, int]:
        """Return steps, skipped, lifting, programs, iterations and halvings of all runs."""
        return {name: sum(getattr(part, name) for part in self.parts) for name in COUNTS}

    def energy(self) -> Energy:
        """Return the energy balance since the beginning, kNm: stored energies, input, dissipated energies."""
        changes = {
            f"{name}_kNm": float(sum(energy[-1] - energy[0] for energy in series))
            for name in ENERGIES
            for series in [[getattr(part.energy, name) for part in self.parts]]
        }
        return Energy(**changes)

    def integrator_share(self) -> float:
        """Return what the integrator took over the energy turned over, of all runs; see mechanics' Energy."""
        energies, model = [part.energy for part in self.parts], self.last.model
        least = HISTORY.nothing * model.weight * model.size  # where nothing moves
        taken = sum(float(energy.integrator[-1] - energy.integrator[0]) for energy in energies)
        return abs(taken) / max(least, *(energy.turnover for energy in energies))


def respond(
    model: Assembly,
    motion: BaseMotion,
    setting: Setting,
    start: State,
    factor: float = 1.0,
    to_rest: bool = True,
) -> Response:
    """Return the response to a base motion times `factor`, and the free motion after it until blocks rest.

    Free motion gains no energy. It ends before rest where what is left is less than SPENT of that from which the
    structure has come back; with rigid joints, which come to rest, only if `to_rest` is false. Followed are TAILS times
    TAIL at most. Raises ConvergenceError if a step is not solved.
    """
    table, point = setting.table, setting.control.point_m
    step = motion.record.time_step

    def run(acceleration: Array, vertical: Array | None, state: State, ultimate: float | None) -> TimeHistory:
        return time_history(
            model, acceleration, step, table.contacts, state, table.integrator, vertical,
            damping_ratio=table.damping_ratio or 0.0, control=point, ultimate=ultimate,
            sliding=setting.sliding, tolerances=HISTORY if to_rest else SEARCH,
        )  # fmt: skip

    vertical = None if motion.vertical is None else factor * motion.vertical
    free = np.zeros(round(TAIL / step) + 2)
    record = motion.record.acceleration.size / (motion.record.acceleration.size + free.size)
    with stretch(0.0, record):
        parts = [run(factor * motion.record.acceleration, vertical, start, setting.ultimate)]
    while len(parts) <= TAILS and _goes_on(model, parts, to_rest and table.contacts == "rigid"):
        with stretch(record if len(parts) == 1 else 1.0, 1.0):
            parts.append(run(free, None, parts[-1].final, None))
    return _joined(parts)


def speed_at_end(model: Assembly, last: TimeHistory) -> float:
    """Return the largest component (m/s) of a centroid's velocity in the last LATELY of a run; 0 if all blocks rest.

    At the very end a block that rocks may just be turning back.
    """
    lately = last.time >= last.time[-1] - LATELY
    speed = float(abs(last.velocities[lately, :, :2]).max())
    return speed if speed > STILL * np.sqrt(GRAVITY * model.size) else 0.0


def _goes_on(model: Assembly, parts: list[TimeHistory], to_rest: bool) -> bool:
    """Whether free motion follows: blocks move, and may fall; of motions followed `to_rest` whether they move."""
    last = parts[-1]
    if last.collapsed or not speed_at_end(model, last):
        return False
    if to_rest:
        return True
    begun = np.cumsum([0.0, *(float(part.energy.potential[-1]) for part in parts[:-1])])
    stored = np.concatenate(
        [part.energy.potential + part.energy.elastic + high for part, high in zip(parts, begun, strict=True)]
    )
    lowest = float(stored[-len(last.time) :].min())
    left = float(stored[-1] + last.energy.kinetic[-1]) - lowest
    return left >= SPENT * (float(stored.max()) - lowest)


def _joined(parts: list[TimeHistory]) -> Response:
    """Return the runs joined, times and displacements continued."""
    time, displacement = parts[0].time, parts[0].displacement
    for part in parts[1:]:
        assert displacement is not None and part.displacement is not None
        time = np.concatenate([time, time[-1] + part.time[1:]])
        displacement = np.concatenate([displacement, displacement[-1] + part.displacement[1:]])
    assert displacement is not None
    positions, forces = (
        np.concatenate([getattr(parts[0], name), *(getattr(part, name)[1:] for part in parts[1:])])
        for name in ("positions", "forces")
    )
    return Response(time, displacement, positions, forces, tuple(parts))
