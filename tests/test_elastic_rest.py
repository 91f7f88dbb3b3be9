"""Elastic structures come to rest wherever they do: how far is no matter of how stiff they are."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.benchmark.structures import arch_on_piers
from mechanics.steps.equilibrium import rest, rest_size
from mechanics.steps.static_system import static_system


def test_a_slender_arch_sinks_by_a_hundred_times_what_its_joints_are_compressed():
    """Stiff joints: twice as stiff, half as far."""
    sunk = []
    for stiffness in (1e8, 2e8):
        model = arch_on_piers(stiffness=stiffness)
        step = rest(static_system(model, "elastic"), model.initial)
        sunk.append(abs(step.state.positions - model.initial.positions)[:, 1].max())
        assert step.certificate.worst(rest_size(model, "elastic")) < 1e-6
        assert sunk[-1] > 50.0 * rest_size(model, "elastic")
    assert sunk[0] / sunk[1] == pytest.approx(2.0, rel=1e-3)
    assert np.isfinite(sunk).all()
