"""Compile the loops of statics and dynamics, which are then kept beside their sources: so that no first run waits."""

import numpy as np

from assessment.benchmark.measure import running_bond
from assessment.project.catalogue.geometry import rectangle
from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover, time_history
from mechanics.model.assembly import Behaviour
from mechanics.procedures.motion_start import Integrator

SHAKING = np.array([0.0, 0.1, 0.1, 0.0])  # g
INTEGRATORS: dict[Behaviour, tuple[Integrator, ...]] = {
    "rigid": ("implicit-euler", "moreau-jean", "second-order"),
    "elastic": ("implicit-euler", "second-order"),
}


def lintel(segments: int | None) -> Assembly:
    """A lintel on two supports."""
    stone = Material(18.0, 0.65, 1e6)
    return Assembly(
        [
            Block(rectangle(0.0, 0.0, 0.5, 1.0), 1.0, stone, support="left"),
            Block(rectangle(2.0, 0.0, 2.5, 1.0), 1.0, stone, support="right"),
            Block(rectangle(0.0, 1.0, 2.5, 1.5), 1.0, stone),
        ],
        segments,
    )


print("compiling the loops, once: this takes about a minute", flush=True)
for model in (lintel(None), running_bond(18, 19)):  # matrices in a band and in fronts
    limit_analysis(model)
    for contacts, integrators in INTEGRATORS.items():
        for integrator in integrators:
            time_history(model, SHAKING, 0.005, contacts, integrator=integrator)
for bed in (None, 4):
    for contacts in INTEGRATORS:
        pushdown(lintel(bed), "right", (0.0, -1e-3), contacts=contacts)
        pushover(lintel(bed), (1.25, 1.5), contacts=contacts, increment=0.05)
