"""States that settled structures are left in: at rest also for a motion that begins there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, block_on_base
from mechanics import Assembly, NoEquilibriumError, State, TimeHistory, pushdown, time_history
from mechanics.equilibrium import rest
from mechanics.relaxation import LIFTED, come_to_rest, lifted
from tests.structures import arch_on_piers

WALL = assembly("wall")
SETTLED = {"support": "right", "displacement": (0.0, -0.015), "increment": 0.003}


def unshaken(model: Assembly, state: State, contacts: str) -> TimeHistory:
    return time_history(model, np.zeros(60), 0.005, contacts, state)


def farthest(positions: np.ndarray, others: np.ndarray) -> float:
    """The longest way (m) of a block."""
    return float(abs(positions - others)[:, :2].max())


def test_joints_that_slid_in_a_settlement_are_lifted_until_it_comes_to_rest() -> None:
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    settled = path.steps[-1]
    assert lifted(WALL, settled) > 1e-3
    assert lifted(WALL, come_to_rest(WALL, settled)) <= LIFTED * WALL.size


def test_an_elastic_settlement_ends_where_a_motion_without_shaking_stays() -> None:
    """From the last point of its path, where joints are lifted, the blocks move by a quarter of a millimetre."""
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    motion = unshaken(WALL, path.final, "elastic")
    assert farthest(motion.positions[-1], path.final.positions) < LIFTED * WALL.size
    assert farthest(path.final.positions, path.states[-1].positions) > 1e-4


def test_a_rigid_settlement_comes_to_rest_on_elastic_joints_before_it_is_shaken() -> None:
    state = pushdown(WALL, **SETTLED).final
    motion = unshaken(WALL, state, "elastic")
    assert farthest(motion.positions[-1], motion.start.positions) < LIFTED * WALL.size


def test_a_joint_that_carries_is_closed_in_a_rigid_motion_whatever_gap_was_left() -> None:
    """A block a hundredth of a millimetre above its base, which bears it or does not."""
    model = block_on_base(0.6, 4.2)
    above = model.initial.positions.copy()
    above[model.movable, 1] += 1e-5
    still = np.zeros_like(above)
    bears = np.full(len(model.contacts("rigid")), True)
    closed = unshaken(model, State(above, still, carrying=bears), "rigid")
    falls = unshaken(model, State(above, still), "rigid")
    assert farthest(closed.positions[-1], above) < 1e-9
    assert farthest(falls.positions[-1], above) == pytest.approx(1e-5, rel=0.01)


def test_joints_that_only_turn_are_at_rest_already() -> None:
    model = arch_on_piers(voussoirs=7, courses=3)
    step = rest(model, "elastic", model.initial)
    assert come_to_rest(model, step) is step


def test_what_comes_to_no_rest_is_refused() -> None:
    """A block far above its base, as if a step had led there, falls on and on."""
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    step = rest(model, "elastic", model.initial)
    over = step.state.positions.copy()
    over[model.movable, 1] += 1e4
    with pytest.raises(NoEquilibriumError, match=r"comes to no rest: it goes on moving by"):
        come_to_rest(model, replace(step, state=replace(step.state, positions=over)))
