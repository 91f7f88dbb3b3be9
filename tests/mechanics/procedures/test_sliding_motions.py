"""Motions by Coulomb's law: what slides does not lift, and what nothing presses has no friction."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.benchmark.structures import assembly
from mechanics import Assembly, Block, Material, TimeHistory, time_history
from mechanics.procedures.time_history import HISTORY, Integrator, _notes
from mechanics.types import Array
from tests.support.structures import block_on_base, rectangle, running_bond

G = 9.80665


def between_walls(friction: float, stiffness: float) -> Assembly:
    """A beam of 1.8 m, 0.8 m high, that fits between two walls."""
    stone = Material(20.0, friction, stiffness)
    left, right = rectangle(-0.5, 0.0, 0.0, 2.0), rectangle(1.8, 0.0, 2.3, 2.0)
    return Assembly(
        [
            Block(left, 1.0, stone, support="left"),
            Block(right, 1.0, stone, support="right"),
            Block(rectangle(0.0, 1.0, 1.8, 1.8), 1.0, stone),
        ]
    )


@pytest.mark.parametrize(("friction", "stiffness"), [(0.84, 1e5), (0.84, 1e7), (5.0, 1e6)])
def test_a_beam_that_nothing_presses_between_walls_falls_freely(friction, stiffness):
    """½gt² in 0.3 s, whatever friction, stiffness and step; it was held by the lift of its slides."""
    model = between_walls(friction, stiffness)
    motion = time_history(model, np.zeros(round(0.3 / 0.005) + 1), 0.005, "elastic")
    fallen = motion.positions[0, 2, 1] - motion.positions[-1, 2, 1]
    assert fallen == pytest.approx(0.5 * G * 0.3**2, rel=1e-6)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_that_slides_does_not_lift(contacts):
    """A slide of millimetres; by the associative law with its lift it would rise by μ times as much."""
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=1e6)
    shaken = 0.6 * np.sin(3.0 * np.pi * np.arange(0.0, 1.0, 0.002))
    motion = time_history(model, shaken, 0.002, contacts)
    slid = float(abs(motion.positions[:, 1, 0] - motion.positions[0, 1, 0]).max())
    lifted = float((motion.positions[:, 1, 1] - motion.positions[0, 1, 1]).max())
    assert slid > 0.02
    assert lifted < 1e-3 * 0.3 * slid
    assert motion.lifting == 0


def test_peaks_of_a_sliding_wall_do_not_hang_on_the_step():
    """Peaks at half the step within 3 %; few steps need the associative law."""
    model = running_bond(4, 6, friction=0.6, stiffness=1e6)
    rng = np.random.default_rng(1)
    frequency, phase = rng.uniform(0.5, 5.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12)
    peaks = []
    for step in (0.005, 0.0025):
        time = np.arange(0.0, 2.0, step)[:, None]
        motion = time_history(model, 0.2 * np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1), step)
        peaks.append(float(abs(motion.positions[:, :, 0] - motion.positions[0, :, 0]).max()))
        assert motion.lifting == 0
    assert peaks[1] == pytest.approx(peaks[0], rel=0.03)


def test_steps_that_lift_are_told():
    """From a thousandth of the programs on."""
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=1e6)
    moved = time_history(model, 0.6 * np.sin(np.arange(0.0, 3.0, 0.03)), 0.002)
    still = moved.energy
    told = _notes(model, moved.positions[-1], still, 0.002, 0.0, HISTORY)
    assert any("Coulomb's law was not solved in 0.2%" in note for note in told)
    assert not any(
        "Coulomb" in note for note in _notes(model, moved.positions[-1], still, 0.0005, 0.0, HISTORY)
    )


def test_a_jammed_arch_hardly_lifts():
    """0.3 s of an arch of 362 blocks: at most one program in 500 lifts, and hardly any begins from nothing."""
    shaken = 0.6 * np.sin(10.0 * np.pi * np.arange(0.0, 0.3, 0.005))
    motion = time_history(assembly("triumphal-arch"), shaken, 0.005)
    assert motion.programs > 100
    assert motion.lifting <= 0.002 * motion.programs
    assert motion.cold <= 0.01 * motion.programs


def shaken_block(stiffness: float, step: float, integrator: Integrator = "auto") -> TimeHistory:
    """A low block that slides forth and back on elastic joints, 5 % of damping; the base motion is that of 10 ms."""
    given = np.arange(0.0, 1.0, 0.01)
    time = np.arange(0.0, given[-1] + 1e-9, step)
    shaken = np.interp(time, given, 0.6 * np.sin(3.0 * np.pi * given))
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=stiffness)
    return time_history(model, shaken, step, "elastic", integrator=integrator, damping_ratio=0.05)


def slid(motion: TimeHistory) -> Array:
    """Way (k,) m of the block every 10 ms."""
    moved = motion.positions[:: round(0.01 / motion.time[1]), 1, 0]
    return moved - moved[0]


def test_elastic_joints_turn_back_where_they_do_at_shorter_steps():
    """Without steps halved where a slide turns it is 11 % off at 10 ms, 4 % at 5 ms."""
    fine = slid(shaken_block(1e6, 0.0003125))
    for step in (0.01, 0.005):
        motion = shaken_block(1e6, step)
        assert abs(slid(motion) - fine).max() < 0.01 * abs(fine).max()
        assert motion.sliding_error < 0.01
        assert motion.energy.imbalance < 1e-4
        assert not [note for note in motion.notes if "steps are long" in note]


def test_steps_too_long_for_slides_are_told_with_the_error():
    """Implicit Euler halves no step; the error that it tells is about that of its motion."""
    fine = slid(shaken_block(1e7, 0.0003125))
    coarse = shaken_block(1e7, 0.01, "implicit-euler")
    assert [note for note in coarse.notes if "steps are long" in note]
    error = abs(slid(coarse) - fine).max() / abs(fine).max()
    assert 0.5 < coarse.sliding_error / error < 1.5


def test_springs_of_joints_that_slide_leave_nothing_to_the_integrator():
    """What a slide takes is friction's, also where a spring reaches the bound of friction within a step."""
    energy = shaken_block(1e6, 0.005).energy
    assert energy.friction[-1] > 0.9 * energy.dissipated[-1]
    assert energy.integrator_share < 1e-3
