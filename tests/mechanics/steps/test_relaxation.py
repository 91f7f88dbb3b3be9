"""States that settled structures are left in: at rest also for a motion that begins there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechanics import (
    Assembly,
    ConvergenceError,
    NoEquilibriumError,
    State,
    TimeHistory,
    pushdown,
    pushover,
    time_history,
)
from mechanics.errors import RunawayError
from mechanics.kernels.joint import H
from mechanics.steps.equilibrium import rest, rest_size
from mechanics.steps.rest import lifted, motion_to_rest, way
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.steps.tolerances import REST
from tests.support.structures import block_on_base, column, running_bond

SETTLED = {"support": "base", "rotation": 0.03, "increment": 0.01}


def wall() -> Assembly:
    return running_bond(3, 4, stiffness=1e6)


def unshaken(model: Assembly, state: State, contacts: str) -> TimeHistory:
    return time_history(model, np.zeros(60), 0.005, contacts, state)


def farthest(positions: np.ndarray, others: np.ndarray) -> float:
    """The longest way (m) of a block."""
    return float(abs(positions - others)[:, :2].max())


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_settlement_ends_where_a_motion_without_shaking_stays(contacts):
    path = pushdown(wall(), **SETTLED, contacts=contacts)
    motion = unshaken(wall(), path.final, contacts)
    assert farthest(motion.positions[-1], path.final.positions) < 2e-5


def test_a_rigid_settlement_comes_to_rest_on_elastic_joints_before_it_is_shaken():
    state = pushdown(wall(), **SETTLED).final
    motion = unshaken(wall(), state, "elastic")
    assert farthest(motion.positions[-1], motion.start.positions) < 2e-5


def test_a_joint_that_carries_is_closed_in_a_rigid_motion_whatever_gap_was_left():
    """A block a hundredth of a millimetre above its base, which bears it or does not."""
    model = block_on_base(0.6, 4.2)
    above = model.initial.positions.copy()
    above[model.movable, 1] += 1e-5
    still = np.zeros_like(above)
    closed = unshaken(model, State(above, still, carrying=np.array([True])), "rigid")
    falls = unshaken(model, State(above, still), "rigid")
    assert farthest(closed.positions[-1], above) < 1e-8
    assert farthest(falls.positions[-1], above) == pytest.approx(
        1e-5, abs=1e-6 * model.size
    )  # a gap that is none


def raised(model: Assembly, height: float) -> StepProblem:
    """Gravity on a block at a height (m) above its rest."""
    system = static_system(model, "elastic")
    over = rest(system, model.initial).state.positions.copy()
    over[model.movable, 1] += height
    start = State(over, np.zeros_like(over))
    return StepProblem(system, start, model.dead_load, rest_size(model, "elastic"))


def test_what_hangs_above_its_joint_comes_to_rest_on_it():
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    problem = raised(model, 0.1)
    rested = motion_to_rest(problem, problem.start.positions)
    expected = rest(static_system(model, "elastic"), model.initial)
    assert farthest(rested.state.positions, expected.state.positions) < 1e-4
    assert lifted(rested) <= REST.lifted * model.size


def test_what_falls_does_not_come_to_rest():
    """A block far above its base, and one turned beyond its edge."""
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    high = raised(model, 2.0)
    with pytest.raises(NoEquilibriumError, match="falls: left to itself"):
        motion_to_rest(high, high.start.positions)
    turned = model.rotated(1, (0.6, 0.0), -0.2)
    with pytest.raises(NoEquilibriumError, match="falls: left to itself"):
        motion_to_rest(replace(high, start=turned), turned.positions)


def test_what_comes_to_no_rest_is_refused():
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    problem = raised(model, 0.1)
    with pytest.raises(ConvergenceError, match="does not come to rest"):
        motion_to_rest(problem, problem.start.positions, replace(REST, steps=1))


def test_a_lift_counts_from_the_compression_that_forces_ask_for():
    model = block_on_base(0.6, 4.2, stiffness=1e4)
    step = rest(static_system(model, "elastic"), model.initial)
    assert lifted(step) <= 1e-9
    above = replace(step, places=step.places + np.where(np.arange(step.places.shape[1]) == 8, 0.01, 0.0))
    assert above.places[0, H] == step.places[0, H]
    assert lifted(above) == pytest.approx(0.01, rel=1e-6)


def test_a_turn_is_a_way_too():
    positions = np.zeros((2, 3))
    turned = positions + np.array([[0.0, 0.0, 0.0], [1e-3, -2e-3, -0.01]])
    assert way(positions, turned, 0.7) == pytest.approx(0.007)


def test_shears_of_springs_go_on_to_rest():
    """Joints that are elastic in shear, too: what they carry in rest they carry as a motion begins there."""
    blocks = [replace(b, material=replace(b.material, tangential_stiffness=4e5)) for b in wall().blocks]
    path = pushdown(Assembly(blocks), **SETTLED, contacts="elastic")
    motion = unshaken(Assembly(blocks), path.final, "elastic")
    assert path.final.shear is not None and abs(path.final.shear).max() > 0.01
    assert farthest(motion.positions[-1], path.final.positions) < 2e-5


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_pulled_aside_is_released_where_it_was_pulled_to(contacts):
    """What carried a block aside is no equilibrium under gravity alone, however near on soft joints one is."""
    model = block_on_base(0.6, 4.2, stiffness=1e4)
    pulled = pushover(model, (0.3, 4.2), "+x", contacts, 0.02, until=0.3).states[-1]
    for state in (pulled, model.rotated(1, (0.6, 0.0), -0.05)):
        motion = unshaken(model, state, "elastic")
        assert np.array_equal(motion.start.positions, state.positions)
        assert farthest(motion.positions[-1], state.positions) > 1e-3


def leaning(blocks, stiffness, lean):
    """The problem of a column 0.3 m wide and 3 m high on elastic joints, and positions that lean upwards (rad)."""
    model = column(0.3, 3.0, blocks, stiffness=stiffness)
    at = model.initial.positions.copy()
    at[model.movable, 2] += lean * np.arange(1, blocks + 1)
    start = State(at, np.zeros_like(at))
    return StepProblem(static_system(model, "elastic"), start, model.dead_load, 1e-3), at


@pytest.mark.parametrize(
    ("blocks", "stiffness", "lean"), [(3, 4800.0, 1e-5), (1, 1200.0, 1e-8), (3, 1200.0, 1e-8)]
)
def test_what_is_unstable_does_not_rest_however_little_is_unbalanced(blocks, stiffness, lean):
    """A block on a bed of k b³/12 per rad (1 m deep) topples where that is less than W H/2: k < 12 000 kN/m³."""
    problem, at = leaning(blocks, stiffness, lean)
    with pytest.raises(RunawayError):
        motion_to_rest(problem, at)


def test_what_is_stable_comes_back():
    problem, at = leaning(1, 20_000.0, 1e-3)
    assert abs(motion_to_rest(problem, at).state.positions[:, 2]).max() < 1e-9
