"""Motions on joints of the paper's contact points: energy, damping and frequency of the bed that the forces are of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechanics import TimeHistory, time_history
from mechanics.procedures import settled
from mechanics.procedures.elastic_periods import first_frequency
from mechanics.types import GRAVITY
from tests.support.structures import column

SIDE, STIFFNESS, SPIN, STEP = 0.8, 2e5, 0.002, 1e-4  # m, kN/m³, rad/s, s
SEGMENTS = [None, 1, 2, 4, 7]


def swing(segments: int | None, duration: float, damping: float = 0.0) -> tuple[TimeHistory, float, float]:
    """A cube that is turned about the middle of its base so slowly that all of its bed remains pressed.

    The motion; its stiffness, kNm, and its inertia, t m², about there: the bed's kL³/12 (1 + 2/n²) less what the weight
    takes of it.
    """
    model = column(SIDE, SIDE, 1, stiffness=STIFFNESS, segments=segments)
    start = settled(model, None).state
    velocities = np.zeros_like(start.velocities)
    velocities[1] = -0.5 * SIDE * SPIN, 0.0, SPIN
    motion = time_history(
        model, np.zeros(round(duration / STEP) + 1), STEP, "elastic",
        replace(start, velocities=velocities, carrying=None), control=(0.5 * SIDE, SIDE), damping_ratio=damping,
    )  # fmt: skip
    n, m = (motion.forces[1:, 0, i] for i in range(2))
    assert (abs(m) < n * SIDE / 6.0).all()  # within the core
    mass, _, inertia = model.mass[1]
    turns = STIFFNESS * SIDE**3 / 12.0 * (1.0 if segments is None else 1.0 + 2.0 / segments**2)
    return motion, turns - mass * GRAVITY * 0.5 * SIDE, inertia + mass * (0.5 * SIDE) ** 2


@pytest.mark.parametrize("segments", SEGMENTS)
def test_a_block_that_rocks_on_its_closed_bed_swings_for_ever(segments: int | None) -> None:
    motion, stiffness, inertia = swing(segments, 0.1)
    energy, rate = motion.energy, np.sqrt(stiffness / inertia)
    assert abs(energy.integrator).max() < 1e-7 * energy.kinetic[0]
    assert energy.mechanical == pytest.approx(energy.mechanical[0], abs=2e-5 * energy.kinetic[0])
    assert motion.notes == () and motion.halvings < 0.5 * motion.steps
    expected = -SIDE * SPIN / rate * np.sin(rate * motion.time)
    assert motion.displacement == pytest.approx(expected, abs=5e-3 * abs(expected).max())


@pytest.mark.parametrize("segments", SEGMENTS)
def test_dashpots_let_it_decay_as_the_damping_ratio_says(segments: int | None) -> None:
    """Of the first frequency, which knows no weight and very stiff shear: nearly that of this swing."""
    ratio = 0.05
    motion, stiffness, inertia = swing(segments, 0.1, ratio)
    model = column(SIDE, SIDE, 1, stiffness=STIFFNESS, segments=segments)
    rate = np.sqrt(stiffness / inertia)
    assert first_frequency(model) == pytest.approx(rate, rel=2e-3)
    decay, damped = ratio * rate, rate * np.sqrt(1.0 - ratio**2)
    expected = -SIDE * SPIN / damped * np.exp(-decay * motion.time) * np.sin(damped * motion.time)
    assert motion.displacement == pytest.approx(expected, abs=5e-3 * abs(expected).max())
    energy = motion.energy
    assert energy.viscous[-1] == pytest.approx(energy.mechanical[0] - energy.mechanical[-1], rel=1e-4)
    assert abs(energy.integrator).max() < 1e-6 * energy.viscous[-1]


@pytest.mark.parametrize("segments", [1, 4])
def test_a_column_that_rocks_on_its_points_is_warned_of_nothing(segments: int) -> None:
    """With lift-off, damped: closing points take little, and few steps are halved."""
    record = 0.15 * np.sin(6.0 * np.pi * np.arange(0.0, 1.0, 0.005))
    model = column(0.4, 1.6, 3, stiffness=2e5, segments=segments)
    motion = time_history(model, record, 0.005, "elastic", damping_ratio=0.05)
    assert all("may fall after it" in note for note in motion.notes)
    assert motion.halvings < 0.6 * motion.steps
    assert motion.energy.integrator_share < 0.1
