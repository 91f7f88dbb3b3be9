"""Friction at the corner of a hinge that a settlement has opened, where the other block's corner is near, by statics.

A block b × h leans on a smooth wall; the edge of its foot ends a little before the block's own corner, and bears on the
block's face. Pushed towards the wall it slides off there along that face: three equations of equilibrium of the forces
at the edge and at the wall, each at its angle of friction, and of the push give α.
"""

import math
from functools import cache

import numpy as np
import pytest

from mechanics import Assembly, State, limit_analysis, pushover, time_history
from tests.support.leaning_block import B, H, leaning

WALL, FRICTION = 0.01, 0.3


@cache
def on_its_edge(before: float) -> tuple[Assembly, State]:
    return leaning(FRICTION, WALL, before)


def by_statics(model: Assembly, state: State, before: float) -> float:
    """α at which the block slides off the edge of its foot, along its own face."""
    x, z, turn = state.positions[2]
    across = np.array([math.cos(turn), math.sin(turn)])
    normal = np.array([-math.sin(turn), math.cos(turn)])
    at = np.array([x, z]) + model.blocks[2].centroid - model.initial.positions[2, :2]
    edge = np.array([B - before, 0.0])
    corner = at + 0.5 * B * across + 0.5 * H * normal
    slides, leans = normal - FRICTION * across, np.array([-1.0, -WALL])

    def moment(arm, force):
        return arm[0] * force[1] - arm[1] * force[0]

    rows = [
        [slides[0], leans[0], 1.0],
        [slides[1], leans[1], 0.0],
        [moment(edge - at, slides), moment(corner - at, leans), 0.0],
    ]
    return float(np.linalg.solve(rows, [0.0, 1.0, 0.0])[2])


@pytest.mark.parametrize(("before", "near"), [(0.02, 1e-3), (0.0005, 0.05)])
def test_what_slides_off_a_near_corner_slides_along_the_face_that_bears(before, near):
    model, state = on_its_edge(before)
    exact = by_statics(model, state, before)
    assert limit_analysis(model, "+x", state=state).alpha == pytest.approx(exact, rel=near)


def test_a_curve_begins_there():
    model, state = on_its_edge(0.0005)
    curve = pushover(model, direction="+x", state=state, increment=0.05, until=0.99)
    assert curve.alpha_onset == pytest.approx(by_statics(model, state, 0.0005), rel=0.05)


def test_a_motion_under_a_load_that_is_held_slides_there_too():
    model, state = on_its_edge(0.0005)
    time = np.arange(0.0, 6.0, 0.005)
    motion = time_history(model, -0.1 * np.clip(time / 4.0, 0.0, 1.0), 0.005, contacts="rigid", state=state)
    assert np.linalg.norm(motion.positions[-1, 2, :2] - motion.positions[0, 2, :2]) > 2e-3
