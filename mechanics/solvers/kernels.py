"""The states of a contact, and the certificate of residuals: what the compiled loops share with the rest."""

from __future__ import annotations

import numpy as np

from mechanics.program import Certificate, Program

OPEN, STICKING, SLIDING_ON, SLIDING_BACK = 0, 1, 2, 3  # the slip of a sliding contact: w_t < 0, w_t > 0
Residuals = tuple[float, float, float, float]


def certificate(residuals: Residuals, program: Program, work: float = 0.0) -> Certificate:
    """The certificate of a solution with these residuals (see compiled.residuals); `work`: as in Certificate."""
    unbalanced, cone, power, penetration = residuals
    weight = program.weight
    return Certificate(unbalanced / weight, cone / weight, power / (weight * program.step), penetration, work)


def worst(residuals: Residuals, weight: float, step: float) -> float:
    """The largest residual, as Certificate.worst; infinite where one is not a number."""
    unbalanced, cone, power, penetration = residuals
    if not power < np.inf:  # max() skips nan, the sum in `power` does not
        return np.inf
    return max(
        unbalanced / weight, cone / weight, power / (weight * step) / 100.0, penetration / step / 100.0
    )
