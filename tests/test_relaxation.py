"""States that settled structures are left in: at rest also for a motion that begins there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, block_on_base
from mechanics import Assembly, NoEquilibriumError, State, TimeHistory, pushdown, pushover, time_history
from mechanics.equilibrium import rest
from mechanics.relaxation import LIFTED, come_to_rest, lifted
from mechanics.static_step import Step
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


def raised(model: Assembly, height: float) -> Step:
    """The rest of a block on its base, as if a step had led it to a height (m) above."""
    step = rest(model, "elastic", model.initial)
    over = step.state.positions.copy()
    over[model.movable, 1] += height
    return replace(step, state=replace(step.state, positions=over))


def test_what_falls_does_not_come_to_rest() -> None:
    """A block far above its base falls on it, one turned beyond its edge on its head: not the rest sought."""
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    with pytest.raises(NoEquilibriumError, match=r"falls: left to itself on elastic joints lifted by 2 m"):
        come_to_rest(model, raised(model, 2.0))
    step, turned = rest(model, "elastic", model.initial), model.rotated(1, (0.6, 0.0), -0.2)
    with pytest.raises(NoEquilibriumError, match=r"falls: left to itself"):
        come_to_rest(model, replace(step, state=replace(step.state, positions=turned.positions)))


def test_what_comes_to_no_rest_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    assert lifted(model, come_to_rest(model, raised(model, 0.1))) <= LIFTED * model.size
    monkeypatch.setattr("mechanics.relaxation.MOST_STEPS", 1)
    with pytest.raises(NoEquilibriumError, match=r"comes to no rest: it goes on moving by 0\.1 m"):
        come_to_rest(model, raised(model, 0.1))


def test_what_comes_to_rest_is_certified() -> None:
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    assert len(path.certificates) == len(path.steps) + 2  # the reaction as the movement begins, and the rest


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize("stiffness", [1e4, 1e6])
def test_a_block_pulled_aside_is_released_where_it_was_pulled_to(contacts: str, stiffness: float) -> None:
    """What carried a block aside is no equilibrium under gravity alone, however near on soft joints one is."""
    model = block_on_base(0.6, 4.2, stiffness=stiffness)
    pulled = pushover(model, (0.3, 4.2), "+x", contacts, 0.02, until=0.3).states[-1]
    motion = unshaken(model, pulled, "elastic")
    assert np.array_equal(motion.start.positions, pulled.positions)
    assert farthest(motion.positions[-1], pulled.positions) > 1e-3
