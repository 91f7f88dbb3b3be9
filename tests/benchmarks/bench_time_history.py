"""Time of a dynamic step, elastic and rigid, against PIQP called once per step on freshly built matrices.

    python -m tests.benchmarks.bench_time_history [steps]

Processor time; ratios to the baseline of the same run carry over to other machines. The state at rest from which a
motion begins is not counted. `geometry`, `solve` (the Newton solver) and `other` are milliseconds a step; `fact.`
factorisations a step, `same` the share of solves that repeated the last contact states. Last, the exponent of the time
of a step over the number of blocks.

Tried, and not kept (wall 18 x 19, elastic, strong motion): semismooth Newton alone, with augmented Lagrangian rounds
and an exact line search, 38 to 50 factorisations a step where the interior point method takes 8 (line searches end at
the next contact that slips). Of the interior point method, 5.9 iterations a step of which each costs 0.5 ms: Gondzio's
correctors, one and two, 5.3 and 5.0 iterations at 0.1 ms each; a start on the central path through the last solution,
5.5, but 12 where arches take 8.8; one from forces and gaps extrapolated over two steps, 7.4, and 19 where the midpoint
rule takes 10; one from the last iterate of semismooth Newton, 6 to 9; another distance from the cone (a third, double),
5.6 and 6.3, for arches the other way round; another power for the centring, 6.6 and 5.6, or share of the way to the
cone, 5.9 to 6.3. Contacts that are too far open to touch in a step, left out and checked afterwards: in the steps of
these cases fewer than one in fifty are open by more than a step's displacement, and the time stays the same. Tiles of
16 x 6, 24 x 6, 8 x 12 and 16 x 12 in the factorisation: 0.20, 0.21, 0.27 and 0.29 ms where 8 x 6 take 0.20 and LAPACK
0.47; loops that leave the vectors to the compiler, 0.60.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from mechanics import Assembly, time_history
from mechanics.program import Program
from mechanics.scene import Scene
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

WALLS = ((9, 10), (18, 19), (31, 32), (54, 55))


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


def measure(
    label: str, model: Assembly, amplitude: float, contacts: str, integrator: str, steps: int
) -> float:
    """Print the line of a case; milliseconds a step."""
    rng = np.random.default_rng(1)
    t = STEP * np.arange(steps)
    noise = np.convolve(rng.standard_normal(steps), np.ones(5) / 5.0, "same")
    record = amplitude * np.minimum(t / 0.5, 1.0) * (np.sin(2.0 * np.pi * 2.0 * t) + noise)
    time_history(model, record[:4], STEP, contacts, integrator=integrator)
    geometry, solving, settling = Watch(), Watch(), Watch()
    newtons: list[Newton] = []
    histories: Any = sys.modules["mechanics.time_history"]
    kept = Scene.geometry, Newton.solve, Newton.__post_init__, histories._settled

    def laid_out(newton: Newton) -> None:
        kept[2](newton)
        newtons.append(newton)

    Scene.geometry = geometry.around(kept[0])
    Newton.solve, Newton.__post_init__ = solving.around(kept[1], compare=True), laid_out
    histories._settled = settling.around(kept[3])
    try:
        start = time.process_time()
        motion = time_history(model, record, STEP, contacts, integrator=integrator)
        total = time.process_time() - start - solving.baseline - settling.spent
    finally:
        Scene.geometry, Newton.solve, Newton.__post_init__, histories._settled = kept
    n, newton = len(motion.time) - 1, newtons[-1]
    step, one = 1e3 * total / n, 1e3 * solving.baseline / max(solving.compared, 1)
    parts = [1e3 * t / n for t in (geometry.spent, solving.spent)]
    print(
        f"{label:30s} {step:8.3f} {parts[0]:8.3f} {parts[1]:8.3f} {step - sum(parts):8.3f} {one:8.3f}"
        f" {step / one:6.2f} {motion.solves / n:6.1f} {newton.factorisations / n:6.2f}"
        f" {newton.repeated / max(newton.solved, 1):5.2f} {motion.resolved:5d} {motion.fallbacks:5d} {n:6d}"
        f"  {motion.collapse_reason}",
        flush=True,
    )
    return step


def main() -> None:
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    heads = ["ms/step", "geometry", "solve", "other", "PIQP"]
    print(
        f"{'case':30s}", *(f"{head:>8s}" for head in heads), " ratio solves  fact.  same again fall.  steps"
    )
    for name, model, amplitude in CASES:
        for contacts in ("elastic", "rigid"):
            for integrator in ("implicit-euler", "second-order"):
                c = len(model.contacts(contacts))
                label = f"{name}, {c}, {contacts[0]}, {integrator[:8]}"
                measure(label, model, amplitude, contacts, integrator, steps)
    for contacts in ("elastic", "rigid"):
        times = []
        for columns, courses in WALLS:
            model = running_bond(columns, courses, stiffness=1e7)
            label = f"wall {columns} x {courses}, {contacts[0]}"
            blocks = int(model.movable.sum())
            times.append((blocks, measure(label, model, 0.5, contacts, "implicit-euler", steps // 4)))
        print(f"exponent, {contacts}: {np.polyfit(*np.log(times).T, 1)[0]:.2f}")
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
