"""Rest within a motion that is not computed: the motion is that in which it is."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Assembly, time_history
from mechanics.kernels.joint import H
from mechanics.model.contacts import forces_on_blocks
from mechanics.procedures.time_history import HistoryTolerances
from mechanics.types import GRAVITY
from tests.support.structures import block_on_base, column, running_bond

STEP = 0.005


def two_pulses(step: float) -> np.ndarray:
    """Weak shaking of 12 s with two strong stretches, g."""
    time = np.arange(0.0, 12.0, step)
    strong = np.exp(-(((time - 2.0) / 0.5) ** 2)) + 0.8 * np.exp(-(((time - 8.0) / 0.4) ** 2)) + 0.05
    return np.asarray(0.3 * strong * np.sin(2.0 * np.pi * 1.5 * time) * np.sin(9.0 * time + 1.0))


@pytest.mark.parametrize("model", [block_on_base(0.6, 3.0), column(0.4, 1.6, 3)], ids=["block", "column"])
def test_a_motion_whose_rest_is_skipped_is_the_whole_motion(model: Assembly) -> None:
    """A third of the steps and more are not computed; the peak is that of the whole motion, to 1e-5.

    Programs are solved to 1e-9: the usual 1e-7 leave more open, 1e-4 of the block's peak and 4e-3 of the column's.
    """
    base = two_pulses(STEP)
    skipped, whole = (
        time_history(model, base, STEP, tolerances=HistoryTolerances(skips=skips, accepted=1e-9))
        for skips in (True, False)
    )
    moved = [abs(motion.positions - motion.positions[0]) for motion in (skipped, whole)]
    assert skipped.skipped > 0.3 * skipped.steps and whole.skipped == 0
    assert moved[1].max() > 1e-3
    assert moved[0].max() == pytest.approx(moved[1].max(), rel=1e-5)
    assert skipped.energy.imbalance <= 1e-4


def test_skipping_rest_moves_a_peak_no_more_than_a_sharper_program_does() -> None:
    """Motions turn on the last digits: the median difference is at most three times that of a tenth of the residual."""
    random = np.random.default_rng(5)
    differences: list[list[float]] = []
    for k in range(9):
        model = (
            block_on_base(random.uniform(0.4, 0.9), random.uniform(2.0, 4.0))
            if k % 3
            else column(random.uniform(0.5, 0.7), random.uniform(2.0, 3.0), 2)
        )
        base = random.uniform(1.2, 2.0) * two_pulses(0.01)
        skipped, whole, sharper = (
            time_history(model, base, 0.01, tolerances=HistoryTolerances(skips=skips, accepted=accepted))
            for skips, accepted in ((True, 1e-9), (False, 1e-9), (False, 1e-10))
        )
        assert skipped.collapsed == whole.collapsed
        peaks = [float(abs(m.positions - m.positions[0]).max()) for m in (skipped, whole, sharper)]
        if peaks[1] > 1e-3 and not whole.collapsed:
            differences.append([abs(peaks[n] / peaks[1] - 1.0) for n in (0, 2)])
    assert len(differences) >= 4
    by_rest, by_residual = np.median(np.array(differences), axis=0)
    assert by_rest <= max(3.0 * by_residual, 1e-5)


def test_a_record_below_activation_costs_ten_steps_and_a_try_how_far_rest_goes() -> None:
    """Of 2400 steps tens are computed; blocks stay exactly where they are, and joints carry what balances."""
    model = running_bond(3, 3)
    base = 0.2 * two_pulses(STEP)
    motion = time_history(model, base, STEP)
    assert motion.steps - motion.skipped < 30 and motion.programs < 40
    resting = np.flatnonzero(~motion.velocities.any(axis=(1, 2)))[1:]
    assert abs(motion.positions[resting] - motion.positions[0]).max() < 1e-7
    contacts, places = model.contacts, model.contacts.places(motion.positions[-1])
    for k in resting[:: len(resting) // 20]:
        forces = motion.forces[k]
        assert (abs(forces[:, 1]) <= places[:, H] * forces[:, 0] + 1e-6).all()
        assert (abs(forces[:, 2]) <= contacts.friction * forces[:, 0] + 1e-6).all()
        total = np.zeros((len(model.blocks), 3))
        np.add.at(total, contacts.a, forces_on_blocks(places, forces)[:, :3])
        np.add.at(total, contacts.b, forces_on_blocks(places, forces)[:, 3:])
        total += model.dead_load
        total[:, 0] -= model.mass[:, 0] * GRAVITY * base[k]
        assert abs(total[model.movable]).max() < 1e-2 * model.weight * abs(base).max() + 1e-6


def test_elastic_joints_and_vertical_shaking_skip_nothing() -> None:
    base = 0.1 * two_pulses(0.02)
    assert time_history(block_on_base(), base, 0.02, "elastic").skipped == 0
    assert time_history(block_on_base(), base, 0.02, vertical_acceleration=0.1 * base).skipped == 0
