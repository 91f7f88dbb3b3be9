"""Joints that come apart: they do not touch the motion of the others, and steps are solved all the same."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.analyses.time_history import Setting, respond
from assessment.project.model import build_model
from assessment.project.motions import history_motions
from assessment.project.project import load_project
from mechanics import Assembly, Block, Material, State, time_history
from tests.support.analysed import arch
from tests.support.structures import rectangle

STONE = Material(18.0, 0.6, 1e6)
STACK = [
    Block(rectangle(0.0, 0.0, 0.2, 0.6), 1.0, STONE),
    Block(rectangle(-0.02, 0.6, 0.2, 1.1), 1.0, STONE),
    Block(rectangle(-0.3, -0.2, 0.3, 0.0), 1.0, STONE, support="base"),
]
BESIDE = Block(rectangle(-0.2, 0.0, 0.0, 0.4), 1.0, STONE)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_carried_away_leaves_the_stack_as_it_would_move_alone(contacts):
    """Its joint comes first in the model; the matrix has a place for it, and nothing there."""
    shaking = 0.5 * np.sin(8.0 * np.pi * 0.005 * np.arange(40))
    alone = Assembly(STACK)
    both = Assembly([BESIDE, *STACK])
    assert (both.joints.a[0], both.joints.b[0]) == (0, 1)
    positions = both.initial.positions.copy()
    positions[0, 0] -= 0.7
    # moving, so that neither settles on its springs first
    states = [State(p, np.full_like(p, 1e-9)) for p in (alone.initial.positions, positions)]
    one, other = (
        time_history(model, shaking, 0.005, contacts, state, "implicit-euler")
        for model, state in zip((alone, both), states, strict=True)
    )
    assert abs(one.positions - one.positions[0]).max() > 1e-3
    assert other.positions[:, 1:] == pytest.approx(one.positions, abs=1e-5)


def test_a_small_arch_that_breaks_apart_is_solved_to_its_collapse(tmp_path):
    """An impact in a step of 10 µs: forces that stop the blocks are thousands of weights, gaps thousands of steps."""
    project = load_project(arch(tmp_path / "arch"))
    [motion] = history_motions(project)
    setting = Setting(project.history[0], project.control_point(None))
    model = build_model(project).assembly
    found = respond(model, motion, setting, model.initial)
    assert found.collapsed and found.worst <= 1e-7


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_blocks_without_any_joint_fall(contacts):
    """Free fall from 0.5 m above the base for 0.2 s: g t²/2, as trapezes have it exactly."""
    base = Block(rectangle(-0.3, -0.2, 0.3, 0.0), 1.0, STONE, support="base")
    apart = Assembly([base, Block(rectangle(0.0, 0.5, 0.2, 1.0), 1.0, STONE)])
    assert len(apart.contacts) == 0
    motion = time_history(apart, np.zeros(41), 0.005, contacts)
    fallen = motion.positions[0] - motion.positions[-1]
    assert fallen[1] == pytest.approx([0.0, 0.5 * 9.80665 * 0.2**2, 0.0], abs=1e-9)
