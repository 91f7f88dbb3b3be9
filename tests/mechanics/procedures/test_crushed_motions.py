"""Motions of beds that are crushed: what they keep of it, against closed forms of a rigid-plastic bed."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import ArgumentError, Assembly, Block, Material, pushdown, time_history
from mechanics.types import GRAVITY

SIDE, WEIGHT, TIMES = 1.0, 20.0, 3.0  # m, kN; the bed bears three times the weight
STIFFNESS, STIFF = 1e6, 1e7  # kN/m³


def block(strength: float, height: float = SIDE, stiffness: float = STIFFNESS) -> Assembly:
    stone = Material(WEIGHT, 0.7, stiffness, compressive_strength=strength)
    base = Block([[-2, -0.5], [2, -0.5], [2, 0], [-2, 0]], 1.0, stone, support="base")
    return Assembly(
        [base, Block([[-0.5, 0], [0.5, 0], [0.5, height], [-0.5, height]], 1.0, stone)],
        segments_per_joint=None,
    )


@pytest.fixture(scope="module")
def thrown_up():
    """A base thrown upward with 4 g for 50 ms, then 0.6 s of rest."""
    pulse, step = 0.05, 0.0005
    time = np.arange(0.0, 0.65, step)
    upward = np.where(time < pulse, 4.0, 0.0)
    return time_history(
        block(TIMES * WEIGHT, stiffness=STIFF), 0.0 * time, step, "elastic", vertical_acceleration=upward
    )


def test_a_bed_is_crushed_by_what_it_cannot_bear(thrown_up):
    """N = 3 W: relative to the base 1 + 4 − 3 = 2 g down for t, then 2 g up: twice 2 g t²/2 deep."""
    deep = 2.0 * GRAVITY * 0.05**2
    down = -(thrown_up.positions[:, 1, 1] - thrown_up.positions[0, 1, 1])
    assert down.max() == pytest.approx(deep, rel=0.01)


def test_what_is_crushed_stays_so(thrown_up):
    """The block rests where it was pressed to, less the springs: a bed without memory lifted it to where it began."""
    down = -(thrown_up.positions[:, 1, 1] - thrown_up.positions[0, 1, 1])
    assert down[-200:].min() == pytest.approx(down.max(), abs=2.0 * TIMES * WEIGHT / STIFF)
    assert thrown_up.energy.friction[-1] == pytest.approx(TIMES * WEIGHT * down.max(), rel=0.01)
    assert thrown_up.energy.imbalance < 1e-5


@pytest.mark.parametrize("integrator", ["second-order", "moreau-jean", "implicit-euler"])
def test_rocking_on_edges_that_crush_loses_energy_to_them(integrator):
    """4 m high under a pulse that rocks it: the balance is closed, and the strong bed has no loss of yielding."""
    time = np.arange(0.0, 3.0, 0.005)
    record = 0.25 * np.sin(2.4 * np.pi * time) * np.exp(-((time - 1.5) ** 2))
    weak, strong = (
        time_history(block(strength, 4.0), record, 0.005, "elastic", integrator=integrator)
        for strength in (20.0 * WEIGHT, 1e3 * WEIGHT)
    )
    assert max(weak.energy.imbalance, strong.energy.imbalance) < 1e-4
    assert strong.energy.friction[-1] < 1e-6 * strong.energy.turnover
    assert weak.energy.friction[-1] > 0.1 * weak.energy.turnover
    assert weak.positions[-1, 1, 1] < strong.positions[-1, 1, 1]


def test_peaks_of_crushed_edges_converge_and_integrators_agree():
    """Measured: 0.0602, 0.0609, 0.0615 rad by the second order, 0.0562, 0.0589, 0.0602 by implicit Euler."""
    peaks = {}
    for step in (0.005, 0.0025, 0.00125):
        time = np.arange(0.0, 3.0, step)
        record = 0.25 * np.sin(2.4 * np.pi * time) * np.exp(-((time - 1.5) ** 2))
        for integrator in ("second-order", "implicit-euler"):
            motion = time_history(block(20.0 * WEIGHT, 4.0), record, step, "elastic", integrator=integrator)
            peaks[integrator, step] = abs(motion.positions[:, 1, 2]).max()
    finest = peaks["second-order", 0.00125]
    assert peaks["second-order", 0.0025] == pytest.approx(finest, rel=1.5e-2)
    assert peaks["implicit-euler", 0.00125] == pytest.approx(finest, rel=3e-2)


def test_a_crushed_state_at_rest_stays_at_rest():
    """Half the strength's load on a tilted bed: the state of a pushdown, shaken by nothing."""
    model = block(4.0 * WEIGHT, 2.0)
    moved = pushdown(model, "base", rotation=0.1, increment=0.01, contacts="elastic")
    motion = time_history(model, np.zeros(200), 0.005, "elastic", state=moved.final)
    assert abs(motion.positions[:, 1] - moved.final.positions[1]).max() < 1e-5
    assert motion.energy.friction[-1] < 1e-6


def test_rigid_joints_that_can_be_crushed_are_refused():
    """They forgot it at every step: a block that should rock sank into its base and stayed there."""
    with pytest.raises(ArgumentError, match=r"contacts = 'rigid'.*compressive_strength"):
        time_history(block(TIMES * WEIGHT), np.zeros(10), 0.01, "rigid")


def test_a_bed_of_finite_strength_is_exact_whatever_segments_are_asked_for():
    """Newton's method let its points bear any pressure, and the interior point crushed the exact bed."""
    record = 0.3 * np.sin(2.4 * np.pi * np.arange(0.0, 1.5, 0.005))
    exact = block(20.0 * WEIGHT, 4.0)
    motions = [
        time_history(Assembly(exact.blocks, segments_per_joint=number), record, 0.005, "elastic").positions
        for number in (None, 2)
    ]
    assert motions[1] == pytest.approx(motions[0], abs=1e-9)


def test_a_bed_crushed_flat_stays_so_where_the_block_rocks_on_edges_that_crush_deeper():
    """Two lines kept nothing of the flat pressing: the middle was whole again, and a tenth of the work came back."""
    step = 0.001
    time = np.arange(0.0, 2.6, step)
    upward = np.where(time < 0.08, 3.5, 0.0)
    record = np.where(time > 0.6, 0.5 * np.sin(4.0 * np.pi * (time - 0.6)), 0.0)
    motion = time_history(block(8.0 * WEIGHT, 3.0), record, step, "elastic", vertical_acceleration=upward)
    crushed = motion.energy.friction
    assert abs(motion.positions[:, 1, 2]).max() > 0.02
    assert -np.diff(crushed).clip(max=0.0).sum() < 5e-3 * crushed[-1]
