"""The loops of rigid impacts: against their definitions, and what they hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mechanics import time_history
from mechanics.block import Array
from mechanics.scene import Scene
from mechanics.solvers import compiled_impacts as loops
from tests.structures import arch_on_piers, block_on_base
from tests.test_newton import shaken

MODEL = arch_on_piers(voussoirs=7, courses=3)


def posed(seed: int) -> tuple[tuple[Any, ...], np.random.Generator]:
    """Blocks and rows of the contact points of a shaken arch, and random numbers."""
    contacts = MODEL.contacts("rigid")
    rows = MODEL.kinematics("rigid", shaken(MODEL, seed).positions)
    return (contacts.a, contacts.b, rows.normal, rows.tangent), np.random.default_rng(seed)


@pytest.mark.parametrize("seed", range(3))
def test_closing_strikes_and_dilation_are_those_of_their_definitions(seed: int) -> None:
    (a, b, normal, tangent), rng = posed(seed)
    c, blocks = len(a), len(MODEL.blocks)
    forces, v = rng.standard_normal((c, 2)), rng.standard_normal((blocks, 3))
    gap, change, shift, bend = rng.standard_normal((4, c))
    friction, moved = rng.uniform(size=c), np.concatenate([v[a], v[b]], axis=1)
    along, across = ((rows * moved).sum(axis=1) for rows in (normal, tangent))

    assert loops.closing(a, b, normal, v, gap, 0.4) == pytest.approx(along[gap <= 0.4].min(initial=0.0))
    hold = rng.integers(0, 3, c)
    for closed, resting in ((0.2, 9.0), (9.0, 9.0), (9.0, 0.2)):
        struck = ((hold > 0) & ((gap > closed) | (along < -resting))).any()
        assert loops.strikes(a, b, normal, v, gap, hold, closed, resting) == struck

    (opening, slip, off), matters, bent = np.empty((3, c)), np.empty(c, bool), bend.copy()
    largest = loops.dilation(
        a, b, normal, tangent, v, forces, friction, gap, change, shift, bent, 0.3, opening, slip, off, matters
    )
    assert (opening, slip) == (pytest.approx(along), pytest.approx(across))
    assert bent == pytest.approx(change - along)
    assert off == pytest.approx(friction * abs(across) + change - along - shift)
    assert (matters == ((forces[:, 0] > 0.3) | (gap + change <= abs(off)))).all()
    assert largest == pytest.approx((abs(off[matters]).max(), abs(bent - bend)[matters].max()))


def test_a_slide_is_held_where_it_sticks_or_turns_back() -> None:
    """A closed contact that carries is held; its slide with it, unless it goes on, or nothing rubs."""
    rate, hold = np.empty((4, 2)), np.empty(4, np.intp)
    tangent = np.zeros((4, 6))
    tangent[:, 0] = 1.0
    for slip, friction, expected in ((0.0, 0.6, 2), (0.5, 0.6, 1), (-0.5, 0.6, 2), (0.0, 0.0, 1)):
        largest = loops.held(
            np.zeros(4, np.intp), np.ones(4, np.intp), np.zeros((4, 6)), tangent, np.array([[2.0, 0, 0], [0, 0, 0]]),
            np.array([[1.0, 0.0], [0.05, 0.0], [0.0, 0.0], [1.0, 0.0]]), np.array([0.0, 0.0, 0.0, 1.0]),
            np.full(4, slip), np.full(4, friction), 0.1, 0.5, 0.2, rate, hold,
        )  # fmt: skip
        assert hold.tolist() == [expected, 0, 0, 0], "one carries too little, one not at all, one is open"
        assert largest == (2.0 if expected == 2 else 0.0)
        assert rate.tolist() == [[0.0, 2.0]] * 4


def test_accelerations_are_those_of_newtons_law() -> None:
    """Gravity and its reactions on a block: from nothing but the weight it falls, from its reactions it rests."""
    model = block_on_base(0.5, 1.0)
    scene = Scene(model, "rigid")
    _, *rows = scene.geometry(model.initial.positions)
    forces, found = np.zeros((4, 2)), np.empty((2, 3))
    arguments = (scene.contacts.a, scene.contacts.b, *rows)
    assert loops.accelerations(*arguments, forces, model.dead_load, scene.mobility, found) == pytest.approx(
        9.80665
    )
    assert found[1] == pytest.approx([0.0, -9.80665, 0.0]) and not found[0].any()
    carried = np.tile([model.weight / 4.0, 0.0], (4, 1))
    assert loops.accelerations(*arguments, carried, model.dead_load, scene.mobility, found) < 1e-12


def test_hinge_that_slid_is_held_at_one_contact() -> None:
    """Of the two contacts that see a joint's end the harder pressed; at equal force the first, so always one."""
    for normal, expected in (
        ([3.0, 0.0, 1.0, 2.0, 1.0, 1.0, 1.0, 4.0], [1, 0, 0, 1, 1, 0, 0, 1]),
        ([1.0] * 8, [1, 1, 0, 0] * 2),
    ):
        hold, rows = np.empty(8, np.intp), np.zeros((2, 8, 6))
        loops.held(
            np.zeros(8, np.intp), np.zeros(8, np.intp), *rows, np.zeros((1, 3)),
            np.stack([normal, np.zeros(8)], axis=1), np.zeros(8), np.ones(8), np.full(8, 0.6),
            0.5, 0.0, 0.0, np.empty((8, 2)), hold,
        )  # fmt: skip
        assert hold.tolist() == expected


def test_a_configuration_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of the midpoint rule needs its guess's end, its middle and its own end, where the next one begins."""
    seen: list[bytes] = []
    geometry = Scene.geometry

    def counted(scene: Scene, x: Array) -> tuple[Array, Array, Array]:
        before = scene._configuration
        found = geometry(scene, x)
        if scene._configuration is not before:
            seen.append(x.tobytes())
        return found

    monkeypatch.setattr(Scene, "geometry", counted)
    motion = time_history(
        block_on_base(0.5, 2.0), 0.1 * np.ones(101), 0.005, "rigid", integrator="second-order"
    )
    assert motion.solves == 100
    assert len(seen) <= 3 * 100 + 1


def test_a_configuration_that_changes_in_place_is_looked_at_again() -> None:
    scene, x = Scene(MODEL, "rigid"), MODEL.initial.positions.copy()
    before = scene.geometry(x)[0]
    x[-1, 0] += 0.01
    assert abs(scene.geometry(x)[0] - before).max() > 1e-3
