"""The loops of rigid impacts: plain and compiled ones against each other, and what they hold."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

from mechanics import time_history
from mechanics.block import Array
from mechanics.scene import Scene
from mechanics.solvers import impact_kernels
from tests.structures import arch_on_piers, block_on_base
from tests.test_newton import shaken

MODEL = arch_on_piers(voussoirs=7, courses=3)


def both() -> list[ModuleType]:
    return [impact_kernels, pytest.importorskip("mechanics.solvers.compiled_impacts")]


def posed(seed: int) -> tuple[tuple[Any, ...], np.random.Generator]:
    """Blocks and rows of the contact points of a shaken arch, and random numbers."""
    contacts = MODEL.contacts("rigid")
    rows = MODEL.kinematics("rigid", shaken(MODEL, seed).positions)
    return (contacts.a, contacts.b, rows.normal, rows.tangent), np.random.default_rng(seed)


@pytest.mark.parametrize("seed", range(3))
def test_both_sets_of_loops_do_the_same(seed: int) -> None:
    rows, rng = posed(seed)
    c, blocks = len(rows[0]), len(MODEL.blocks)
    forces, load, v = (rng.standard_normal(shape) for shape in ((c, 2), (blocks, 3), (blocks, 3)))
    gap, change, shift, bend, slip = rng.standard_normal((5, c))
    friction = np.where(rng.uniform(size=c) < 0.2, 0.0, 0.6)
    mobility = rng.uniform(size=(blocks, 3))
    found: list[list[Any]] = []
    for loops in both():
        acceleration, written, matters = np.empty((blocks, 3)), np.empty((3, c)), np.empty(c, bool)
        bent, rate, hold = bend.copy(), np.empty((c, 2)), np.empty(c, np.intp)
        dilation = loops.dilation(
            *rows, v, forces, friction, gap, change, shift, bent, 0.3, *written, matters
        )
        held = loops.held(*rows, v, forces, gap, slip, friction, 0.1, 0.5, 0.2, rate, hold)
        struck = [
            loops.strikes(*rows[:3], v, gap, hold, closed, resting)
            for closed, resting in ((0.2, 9.0), (9.0, 9.0), (9.0, 0.2))
        ]
        found.append([
            loops.accelerations(*rows, forces, load, mobility, acceleration), acceleration,
            loops.closing(*rows[:3], v, gap, 0.4), *dilation, written, matters, bent, held, rate, hold, *struck,
        ])  # fmt: skip
    assert set(found[0][10]) == {0, 1, 2} and found[0][11:] == [True, False, True]
    for plain, compiled in zip(*found, strict=True):
        assert compiled == pytest.approx(plain, rel=1e-12, abs=1e-13)


def test_accelerations_are_those_of_newtons_law() -> None:
    """Gravity and its reactions on a block: from nothing but the weight it falls, from its reactions it rests."""
    model = block_on_base(0.5, 1.0)
    scene = Scene(model, "rigid")
    _, *rows = scene.geometry(model.initial.positions)
    forces, found = np.zeros((4, 2)), np.empty((2, 3))
    for loops in both():
        arguments = (scene.contacts.a, scene.contacts.b, *rows)
        assert loops.accelerations(
            *arguments, forces, model.dead_load, scene.mobility, found
        ) == pytest.approx(9.80665)
        assert found[1] == pytest.approx([0.0, -9.80665, 0.0]) and not found[0].any()
        carried = np.tile([model.weight / 4.0, 0.0], (4, 1))
        assert loops.accelerations(*arguments, carried, model.dead_load, scene.mobility, found) < 1e-12


def test_hinge_that_slid_is_held_at_one_contact() -> None:
    """Of the two contacts that see a joint's end the harder pressed; at equal force the first, so always one."""
    for loops in both():
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
