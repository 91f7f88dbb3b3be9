"""Compile the loops of statics and dynamics, which are then kept beside their sources: so that no first run waits."""

import numpy as np

from assessment.benchmark.structures import arch_on_piers
from mechanics import limit_analysis, pushdown, time_history

model = arch_on_piers()
limit_analysis(model)
for contacts in ("rigid", "elastic"):
    pushdown(model, "right", (0.0, -1e-3), contacts=contacts)
    for integrator in ("implicit-euler", "second-order"):
        time_history(model, np.array([0.0, 0.1, 0.1, 0.0]), 0.005, contacts, integrator=integrator)
