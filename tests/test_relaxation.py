"""States that settled structures are left in: at rest also for a motion that begins there."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, block_on_base
from mechanics import (
    Assembly,
    CollapseError,
    NoEquilibriumError,
    State,
    TimeHistory,
    UnstableError,
    pushdown,
    pushover,
    time_history,
)
from mechanics.equilibrium import check_self_weight, rest
from mechanics.integrators import implicit_euler
from mechanics.relaxation import come_to_rest, lifted, way
from mechanics.scene import Motion, Scene
from mechanics.static_step import Step
from tests.structures import arch_on_piers

WALL = Assembly(assembly("wall").blocks)  # one segment a joint
STILL = 2e-5  # m: a twentieth of a thousandth of its blocks
SETTLED = {"support": "right", "displacement": (0.0, -0.015), "increment": 0.003}


def unshaken(model: Assembly, state: State, contacts: str) -> TimeHistory:
    return time_history(model, np.zeros(60), 0.005, contacts, state)


def farthest(positions: np.ndarray, others: np.ndarray) -> float:
    """The longest way (m) of a block."""
    return float(abs(positions - others)[:, :2].max())


def test_joints_that_slid_in_a_settlement_are_lifted_until_it_comes_to_rest() -> None:
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    settled = path.steps[-1]
    assert lifted(WALL, "elastic", settled) > 1e-3
    assert lifted(WALL, "elastic", come_to_rest(WALL, settled)) <= STILL


def test_an_elastic_settlement_ends_where_a_motion_without_shaking_stays() -> None:
    """From the last point of its path, where joints are lifted, the blocks move by a quarter of a millimetre."""
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    motion = unshaken(WALL, path.final, "elastic")
    assert farthest(motion.positions[-1], path.final.positions) < STILL
    assert farthest(path.final.positions, path.states[-1].positions) > 1e-4


def test_a_rigid_settlement_comes_to_rest_on_elastic_joints_before_it_is_shaken() -> None:
    state = pushdown(WALL, **SETTLED).final
    motion = unshaken(WALL, state, "elastic")
    assert farthest(motion.positions[-1], motion.start.positions) < STILL


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
    assert lifted(model, "elastic", come_to_rest(model, raised(model, 0.1))) <= 1e-4
    monkeypatch.setattr("mechanics.relaxation.MOST_STEPS", 1)
    with pytest.raises(NoEquilibriumError, match=r"comes to no rest: it goes on moving by 0\.1 m"):
        come_to_rest(model, raised(model, 0.1))


def test_a_lift_counts_from_the_compression_that_forces_ask_for() -> None:
    model = block_on_base(0.6, 4.2, stiffness=1e4)
    compression = 4.2 * 20.0 / 1e4
    assert lifted(model, "elastic", raised(model, 0.0)) <= 1e-9
    assert lifted(model, "elastic", raised(model, 0.3 * compression)) == pytest.approx(
        0.3 * compression, rel=1e-6
    )


def test_a_turn_is_a_way_too() -> None:
    model = block_on_base(0.6, 4.2)
    turned = model.initial.positions + np.array([[0.0, 0.0, 0.0], [1e-3, -2e-3, -0.01]])
    assert way(model, model.initial.positions, turned) == pytest.approx(0.01 * model.size)


def test_a_rest_many_lifts_away_is_a_fall(monkeypatch: pytest.MonkeyPatch) -> None:
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    monkeypatch.setattr("mechanics.relaxation.JUMP", 0.9)
    with pytest.raises(NoEquilibriumError, match=r"falls: left to itself on elastic joints lifted by 0\.1 m"):
        come_to_rest(model, raised(model, 0.1))


def test_a_settlement_that_does_not_come_to_rest_is_a_collapse(monkeypatch: pytest.MonkeyPatch) -> None:
    def falls(*_: object) -> State:
        raise NoEquilibriumError("it falls")

    monkeypatch.setattr(import_module("mechanics.pushdown"), "settle", falls)
    with pytest.raises(CollapseError, match=r"after the whole movement of 0\.015 m: it falls") as caught:
        pushdown(WALL, **SETTLED)
    path = caught.value.path
    assert path.movement[-1] == pytest.approx(0.015) and path.final is path.states[-1]
    assert path.ultimate == path.movement[-2]


def test_an_elastic_curve_begins_at_rest() -> None:
    """From a rigid settlement, whose joints in equilibrium are lifted once they are compressed."""
    state = pushdown(WALL, **SETTLED).final
    assert lifted(WALL, "elastic", rest(WALL, "elastic", state)) > 1e-4
    start = pushover(WALL, WALL.blocks[-1].centroid, "+x", "elastic", 0.01, state=state, until=0.01).steps[0]
    assert lifted(WALL, "elastic", start) <= STILL


def test_shears_of_springs_go_on_to_rest() -> None:
    """Joints that are elastic in shear, too: what they carry in rest they carry as a motion begins there."""
    blocks = [
        replace(
            b, material=replace(b.material, tangential_stiffness=0.4 * (b.material.normal_stiffness or 0.0))
        )
        for b in WALL.blocks
    ]
    model = Assembly(blocks, WALL.segments_per_joint)
    path = pushdown(model, **SETTLED, contacts="elastic")
    assert lifted(model, "elastic", path.steps[-1]) > 1e-4
    motion = unshaken(model, path.final, "elastic")
    assert path.final.shear is not None and abs(path.final.shear).max() > 0.1
    assert farthest(motion.positions[-1], path.final.positions) < STILL


def test_an_elastic_settlement_with_hinges_is_at_rest() -> None:
    """Whose forces pass beside the ends of its joints, where rigid ones would have to carry."""
    model = arch_on_piers()
    path = pushdown(model, "right", (0.01, -0.01), increment=0.002, contacts="elastic")
    with pytest.raises(UnstableError):
        check_self_weight(model, path.final)
    assert unshaken(model, path.final, "elastic").forces[0].any()


def test_what_lies_in_its_base_is_pushed_out_by_a_step_of_implicit_euler() -> None:
    """A gap that carries counts as none, a penetration does not."""
    model = block_on_base(0.6, 4.2)
    below = model.initial.positions - np.array([[0.0, 0.0, 0.0], [0.0, 1e-5, 0.0]])
    bears = np.full(len(model.contacts("rigid")), True)
    state = State(below, np.zeros_like(below), carrying=bears)
    motion = time_history(model, np.zeros(3), 0.005, "rigid", state, integrator="implicit-euler")
    assert motion.positions[-1] == pytest.approx(model.initial.positions, abs=1e-7)


def test_steps_to_rest_begin_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """A speed kept would carry beyond a rest near by."""
    begun = []

    def noted(scene: Scene, motion: Motion, *rest: Any) -> Motion:
        begun.append(motion.v)
        return implicit_euler(scene, motion, *rest)

    monkeypatch.setattr("mechanics.relaxation.implicit_euler", noted)
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    come_to_rest(model, raised(model, 0.5))
    assert len(begun) > 1 and not np.any(begun)


def test_what_comes_to_rest_is_certified() -> None:
    path = pushdown(WALL, **SETTLED, contacts="elastic")
    assert len(path.certificates) == len(path.steps) + 2  # the reaction as the movement begins, and the rest


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize("stiffness", [1e4, 1e6])
def test_a_block_pulled_aside_is_released_where_it_was_pulled_to(contacts: str, stiffness: float) -> None:
    """What carried a block aside is no equilibrium under gravity alone, however near on soft joints one is."""
    model = block_on_base(0.6, 4.2, stiffness=stiffness)
    pulled = pushover(model, (0.3, 4.2), "+x", contacts, 0.02, until=0.3).states[-1]
    for state in (pulled, model.rotated(1, (0.6, 0.0), -0.05)):
        motion = unshaken(model, state, "elastic")
        assert np.array_equal(motion.start.positions, state.positions)
        assert farthest(motion.positions[-1], state.positions) > 1e-3
