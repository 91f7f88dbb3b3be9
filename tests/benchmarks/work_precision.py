"""Accuracy of the integrators against their work, and what the time stepping dissipates.

    python -m tests.benchmarks.work_precision [work | dissipation | collapse]

Every function returns rows of plain numbers. Processor time, seconds.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from mechanics import Assembly, State, TimeHistory, time_history
from mechanics.assembly import Behaviour
from mechanics.block import Array
from tests.structures import arch_on_piers, block_on_base, running_bond

Row = dict[str, Any]
Integrator = Literal["implicit-euler", "second-order"]
INTEGRATORS: tuple[Integrator, ...] = ("implicit-euler", "second-order")
STEPS = (0.02, 0.01, 0.005, 0.0025, 0.00125)
REFERENCE = 0.0003125  # s
DAMPING = 0.05


@dataclass(frozen=True, eq=False)
class Case:
    """A motion to be computed at several steps: `record` gives base accelerations in g at times (k,) s.

    `damping`: ratio; `after` (s): from when on the largest displacement counts.
    """

    name: str
    model: Assembly
    contacts: Behaviour
    control: tuple[float, float]
    duration: float
    record: Callable[[Array], Array]
    damping: float = 0.0
    state: State | None = None
    after: float = 0.0

    def run(self, step: float, integrator: Integrator) -> TimeHistory:
        """The motion at a time step (s)."""
        times: Array = step * np.arange(round(self.duration / step) + 1, dtype=float)
        return time_history(
            self.model, self.record(times), step, self.contacts, self.state, integrator, control=self.control,
            damping_ratio=self.damping,
        )  # fmt: skip


def shaking(amplitude: float, frequency: float = 1.5) -> Callable[[Array], Array]:
    """Two sines that grow over half a second, for two seconds; then rest."""

    def at(times: Array) -> Array:
        phase = 2.0 * np.pi * frequency * times
        wave = np.sin(phase) + 0.5 * np.sin(2.7 * phase + 1.0)
        envelope = np.minimum(times / 0.5, 1.0) * np.clip((2.0 - times) / 0.2, 0.0, 1.0)
        motion: Array = amplitude * envelope * wave
        return motion

    return at


def pulse(amplitude: float, duration: float) -> Callable[[Array], Array]:
    """A half sine."""

    def at(times: Array) -> Array:
        motion: Array = amplitude * np.sin(np.pi * times / duration) * (times < duration)
        return motion

    return at


def rest(times: Array) -> Array:
    """No base motion."""
    return np.zeros_like(times)


def cases() -> list[Case]:
    """From one block to an arch on piers."""
    rigid, tall = block_on_base(0.6, 4.2, stiffness=1e6), (0.6, 4.2)
    soft = block_on_base(0.6, 4.2, stiffness=1e5, segments=4)
    column = block_on_base(0.5, 2.0, friction=2.0, stiffness=2e6, segments=4)
    arch, crown = arch_on_piers(), (0.4, 1.2)
    wall = running_bond(4, 5)
    turned = rigid.rotated(1, (0.6, 0.0), -0.5 * float(np.arctan(0.6 / 4.2)))
    moving = np.zeros_like(column.initial.positions)
    moving[1] = (-5e-3, 0.0, 5e-3)
    swinging = State(time_history(column, np.zeros(2), 1e-3, "elastic").start.positions, moving)
    top = (float(max(b.polygon[:, 0].max() for b in wall.blocks[1:])), 5 * 0.175)
    return [
        Case("block, free rocking, rigid", rigid, "rigid", tall, 3.0, rest, state=turned, after=1.5),
        Case("block, pulse, rigid", rigid, "rigid", tall, 3.0, pulse(0.3, 0.5)),
        Case("block, pulse, elastic", soft, "elastic", tall, 3.0, pulse(0.25, 0.5), DAMPING),
        Case(
            "column, free vibration, elastic",
            column,
            "elastic",
            (0.5, 2.0),
            0.5,
            rest,
            state=swinging,
            after=0.4,
        ),
        Case("wall, shaken, elastic", wall, "elastic", top, 3.0, shaking(0.6), DAMPING),
        Case("wall, shaken, rigid", wall, "rigid", top, 3.0, shaking(0.6)),
        Case("arch on piers, shaken, elastic", arch, "elastic", crown, 3.0, shaking(0.06), DAMPING),
        Case("arch on piers, shaken, rigid", arch, "rigid", crown, 3.0, shaking(0.16)),
    ]


def peak(motion: TimeHistory, after: float) -> tuple[float, float]:
    """Largest control displacement (m) after a time (s), and its time: of the parabola through three samples."""
    assert motion.displacement is not None
    d, step = abs(motion.displacement), motion.time[1]
    first = min(round(after / step), len(d) - 1)
    k = first + int(d[first:].argmax())
    if k in (0, len(d) - 1):
        return float(d[k]), float(motion.time[k])
    a, b, c = d[k - 1 : k + 2]
    bend = a - 2.0 * b + c
    shift = 0.5 * (a - c) / bend if bend < 0.0 else 0.0
    return float(b - 0.25 * (a - c) * shift), float(motion.time[k] + shift * step)


def work_precision(chosen: Sequence[Case], steps: Sequence[float] = STEPS) -> Iterator[Row]:
    """Error of the largest displacement and of its time, against processor time, of every integrator and step.

    Reference: the second-order result at the step REFERENCE, of each case.
    """
    for case in chosen:
        exact = peak(case.run(REFERENCE, "second-order"), case.after)
        for integrator in INTEGRATORS:
            for step in steps:
                start = time.process_time()
                motion = case.run(step, integrator)
                seconds = time.process_time() - start
                size, at = peak(motion, case.after)
                yield {
                    "case": case.name,
                    "integrator": integrator,
                    "step_s": step,
                    "seconds": seconds,
                    "peak_m": size,
                    "peak_error": size / exact[0] - 1.0,
                    "time_error_s": at - exact[1],
                    "integrator_share": float(motion.energy.integrator[-1]) / motion.energy.turnover,
                    "imbalance": motion.energy.imbalance,
                    "fallbacks": motion.fallbacks,
                    "collapsed": motion.collapsed,
                }


def dissipation(
    steps: Sequence[float] = (0.01, 0.005, 0.002, 0.001), stiffness: Sequence[float] = (5e5, 5e6, 5e7, np.inf)
) -> Iterator[Row]:
    """The paper's Fig. 9: energy dissipated in the first cycle of free rocking, per cent of that at release.

    Specimen 2 of its §6.1: 0.17 × 1.0 m, μ = 0.58, released at 0.64 of the slenderness angle. `stiffness` kN/m³ of the
    joint, infinite: rigid contacts. A cycle: from release to the second largest rotation on the same side.
    """
    alpha = float(np.arctan(0.17))
    for k in stiffness:
        contacts: Behaviour = "rigid" if np.isinf(k) else "elastic"
        model = block_on_base(0.17, 1.0, friction=0.58, stiffness=5e6 if np.isinf(k) else k, segments=4)
        state = model.rotated(1, (0.17, 0.0), -0.64 * alpha)
        weight, radius = model.weight, 0.5 * float(np.hypot(0.17, 1.0))
        released = weight * radius * float(np.cos(0.36 * alpha) - np.cos(alpha))
        for integrator in INTEGRATORS:
            for step in steps:
                motion = time_history(model, np.zeros(round(1.6 / step)), step, contacts, state, integrator)
                rotation, energy = motion.positions[:, 1, 2], motion.energy
                left = np.flatnonzero(rotation > 0.0)
                back = left[0] + np.flatnonzero(rotation[left[0] :] < 0.0)
                end = int(back[0] + rotation[back[0] : back[0] + round(0.6 / step)].argmin())
                yield {
                    "stiffness_kN_m3": None if np.isinf(k) else k,
                    "integrator": integrator,
                    "step_s": step,
                    "dissipated": float(energy.dissipated[end]) / released,
                    "by_integrator": float(energy.integrator[end]) / released,
                    "by_impact": float(energy.impact[end]) / released,
                    "by_friction": float(energy.friction[end]) / released,
                }


def collapse(steps: Sequence[float] = (0.01, 0.005, 0.0025)) -> Iterator[Row]:
    """Least amplitude (g) found to collapse an arch on piers, by bisection to 2 %, for every integrator and step."""
    shaken = next(case for case in cases() if case.name == "arch on piers, shaken, elastic")
    for integrator in INTEGRATORS:
        for step in steps:
            low, high = 0.04, 0.32
            while high > 1.02 * low:
                middle = (low * high) ** 0.5
                fallen = replace(shaken, record=shaking(middle)).run(step, integrator).collapsed
                low, high = (low, middle) if fallen else (middle, high)
            yield {
                "case": shaken.name,
                "integrator": integrator,
                "step_s": step,
                "stands_g": low,
                "collapse_g": high,
            }


def show(rows: Iterator[Row]) -> None:
    """Print rows as they come."""
    for n, row in enumerate(rows):
        if n == 0:
            print("  ".join(f"{key:>16s}" for key in row))
        print("  ".join(f"{_text(value):>16s}" for value in row.values()), flush=True)


def _text(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Print what is asked for; everything without an argument."""
    wanted = sys.argv[1:] or ["work", "dissipation", "collapse"]
    made: Mapping[str, Callable[[], Iterator[Row]]] = {
        "work": lambda: work_precision(cases()),
        "dissipation": dissipation,
        "collapse": collapse,
    }
    for name in wanted:
        show(made[name]())


if __name__ == "__main__":
    main()
