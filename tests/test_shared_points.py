"""Neighbouring segments of a joint share their points: the same results as with points of their own (paper, §2).

The two differ by what solvers leave: a static step is over once its geometry changes by less than a thousandth of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assessment.benchmark.dynamics import certified_to
from assessment.benchmark.structures import segments_apart
from assessment.frames import joint_forces
from mechanics import Assembly, pushdown, pushover, time_history
from mechanics.equilibrium import rest_size
from tests.structures import arch_on_piers

TIME = 0.005 * np.arange(60)


def arch(segments: int, tangential: float) -> Assembly:
    """A small arch on piers; its blocks have their segments in turn: one, or as many as asked for."""
    model = arch_on_piers(voussoirs=7, courses=2)
    blocks = [
        replace(b, segments=1 + (segments - 1) * (i % 2), material=replace(b.material, tangential_stiffness=tangential))
        for i, b in enumerate(model.blocks)
    ]  # fmt: skip
    return Assembly(blocks)


@settings(max_examples=4, deadline=None)
@given(segments=st.integers(2, 5), tangential=st.sampled_from([np.inf, 5e4]))
def test_the_elastic_curve_the_reactions_and_a_history_are_the_same(segments, tangential):
    shared = arch(segments, tangential)
    apart = segments_apart(shared)
    assert len(shared.elastic_contacts) < len(apart.elastic_contacts)
    assert rest_size(shared, "elastic") == rest_size(apart, "elastic")
    movement = {"support": "right", "displacement": (0.01, -0.01), "increment": 0.005, "contacts": "elastic"}
    with certified_to(1e-10):  # the steps in which it comes to rest
        moved, expected = pushdown(shared, **movement), pushdown(apart, **movement)
    assert moved.reaction == pytest.approx(expected.reaction, abs=1e-6 * shared.weight)
    assert moved.final.positions == pytest.approx(expected.final.positions, abs=1e-7)
    for one, other in zip(moved.steps, expected.steps, strict=True):
        carried = joint_forces(shared, "elastic", one.state.positions, one.forces)
        same = joint_forces(apart, "elastic", other.state.positions, other.forces)
        assert carried[0] == pytest.approx(same[0], abs=1e-5 * shared.weight)
        assert carried[1] == pytest.approx(same[1], abs=1e-4, nan_ok=True)

    settled = ((shared, moved), (apart, expected))
    push = {"control": (0.6, 0.85), "contacts": "elastic", "increment": 0.01}
    curve, same = (pushover(m, state=s.final, **push) for m, s in settled)
    assert curve.multiplier == pytest.approx(same.multiplier, abs=3e-5)
    assert curve.displacement == pytest.approx(same.displacement, abs=5e-6)

    with certified_to(1e-10):
        motion, same = (
            time_history(m, 0.3 * np.sin(20.0 * TIME), 0.005, "elastic", state=s.final, damping_ratio=0.05)
            for m, s in settled
        )
    assert motion.positions == pytest.approx(same.positions, abs=2e-7)
