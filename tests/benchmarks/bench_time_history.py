"""Time of a dynamic step, elastic and rigid, against PIQP called once per step on freshly built matrices.

    python -m tests.benchmarks.bench_time_history [steps]

Processor time; ratios to the baseline of the same run carry over to other machines.
`geometry`, `solve` and `other` are milliseconds a step.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from mechanics import Assembly, time_history
from mechanics.integrators import Scene
from mechanics.program import Program
from mechanics.solvers import interior_point
from mechanics.solvers.newton import Newton
from tests.structures import arch_on_piers, block_on_base, running_bond

STEP = 0.005
BASELINE_EVERY = 10
CASES: list[tuple[str, Assembly, float]] = [
    ("2 blocks", block_on_base(0.6, 4.2, stiffness=1e6), 0.25),
    ("arch on piers", arch_on_piers(voussoirs=31, courses=17), 0.04),
    ("wall 18 x 19", running_bond(18, 19, stiffness=1e7), 0.5),
]


class Watch:
    """Processor time spent in a function, its calls, and the time of PIQP on every tenth of its programs."""

    def __init__(self) -> None:
        self.spent, self.calls, self.baseline, self.compared = 0.0, 0, 0.0, 0

    def around(self, function: Callable[..., Any], compare: bool = False) -> Callable[..., Any]:
        def watched(*args: Any) -> Any:
            start = time.process_time()
            result = function(*args)
            self.spent += time.process_time() - start
            self.calls += 1
            if compare and self.calls % BASELINE_EVERY == 0:
                program = next(a for a in args if isinstance(a, Program))
                start = time.process_time()
                interior_point.solve(program, 1e-9)
                self.baseline += time.process_time() - start
                self.compared += 1
            return result

        return watched


def measure(model: Assembly, amplitude: float, contacts: str, integrator: str, steps: int) -> str:
    rng = np.random.default_rng(1)
    t = STEP * np.arange(steps)
    noise = np.convolve(rng.standard_normal(steps), np.ones(5) / 5.0, "same")
    record = amplitude * np.minimum(t / 0.5, 1.0) * (np.sin(2.0 * np.pi * 2.0 * t) + noise)
    time_history(model, record[:4], STEP, contacts, integrator=integrator)
    geometry, solving = Watch(), Watch()
    kept = Scene.geometry, Newton.solve
    Scene.geometry, Newton.solve = geometry.around(kept[0]), solving.around(kept[1], compare=True)
    try:
        start = time.process_time()
        motion = time_history(model, record, STEP, contacts, integrator=integrator)
        total = time.process_time() - start - solving.baseline
    finally:
        Scene.geometry, Newton.solve = kept
    n = len(motion.time) - 1
    step, one = 1e3 * total / n, 1e3 * solving.baseline / max(solving.compared, 1)
    parts = 1e3 * geometry.spent / n, 1e3 * solving.spent / n
    return (
        f"{step:8.3f} {parts[0]:8.3f} {parts[1]:8.3f} {step - sum(parts):8.3f} {one:8.3f} {step / one:6.2f}"
        f" {motion.solves / n:6.1f} {motion.resolved:5d} {motion.fallbacks:5d} {n:6d}  {motion.collapse_reason}"
    )


def main() -> None:
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print(f"{'case':32s} {'ms/step':>8s} {'geometry':>8s} {'solve':>8s} {'other':>8s} {'PIQP':>8s} {'ratio':>6s}"
          f" {'solves':>6s} {'again':>5s} {'fall.':>5s} {'steps':>6s}")  # fmt: skip
    for name, model, amplitude in CASES:
        for contacts in ("elastic", "rigid"):
            for integrator in ("implicit-euler", "second-order"):
                c = len(model.contacts(contacts))
                label = f"{name}, {c}, {contacts[0]}, {integrator[:8]}"
                print(f"{label:32s} {measure(model, amplitude, contacts, integrator, steps)}", flush=True)
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
