"""Elastic structures come to rest wherever they do: how far is no matter of how stiff they are."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import Assembly, Block, pushdown, time_history
from mechanics.steps.equilibrium import rest, rest_size
from mechanics.steps.static_system import static_system
from tests.support.structures import arch_on_piers, rectangle, running_bond


def test_a_slender_arch_sinks_by_a_hundred_times_what_its_joints_are_compressed():
    """Stiff joints: twice as stiff, half as far."""
    shape = {
        "radius": 2.0,
        "thickness": 0.3,
        "voussoirs": 27,
        "pier_height": 2.0,
        "pier_width": 0.8,
        "courses": 19,
    }
    sunk = []
    for stiffness in (1e8, 2e8):
        model = arch_on_piers(**shape, stiffness=stiffness)
        step = rest(static_system(model, "elastic"), model.initial)
        sunk.append(abs(step.state.positions - model.initial.positions)[:, 1].max())
        assert step.certificate.worst(rest_size(model, "elastic")) < 1e-6
        assert sunk[-1] > 50.0 * rest_size(model, "elastic")
    assert sunk[0] / sunk[1] == pytest.approx(2.0, rel=1e-3)
    assert np.isfinite(sunk).all()


def on_two_supports(wall: Assembly) -> Assembly:
    """A wall whose base is cut in two, left and right."""
    base = wall.blocks[0]
    (x0, z0), (x1, z1) = base.polygon.min(axis=0), base.polygon.max(axis=0)
    middle = 0.5 * (x0 + x1) + 0.13 * wall.size
    halves = [
        Block(rectangle(a, z0, b, z1), base.depth, base.material, support=name)
        for a, b, name in ((x0, middle, "left"), (middle, x1, "right"))
    ]
    return Assembly([*halves, *wall.blocks[1:]])


@pytest.mark.parametrize("integrator", ["implicit-euler", "auto"])
@pytest.mark.parametrize("seed", range(3))
def test_a_settled_elastic_wall_left_alone_for_a_second_stays_where_it_is(seed, integrator):
    """Within 0.1 mm: supports moved by up to a seventh of a block, bricks slide, lift and come down."""
    rng = np.random.default_rng(seed)
    columns, courses = (int(n) for n in rng.integers(3, 6, 2))
    size = rng.uniform(0.2, 0.6), rng.uniform(0.1, 0.3)
    wall = on_two_supports(
        running_bond(columns, courses, *size, rng.uniform(0.3, 0.9), 10.0 ** rng.uniform(5.0, 7.0))
    )
    angle = rng.uniform(0.0, 0.5 * np.pi)
    movement = wall.size * rng.uniform(0.02, 0.15) * np.array([np.cos(angle), -np.sin(angle)])
    final = pushdown(wall, "right", movement, 0.0, abs(movement).max() / 5.0, "elastic").final
    motion = time_history(wall, np.zeros(200), 0.005, "elastic", final, integrator)
    assert abs(motion.positions - final.positions)[:, :, :2].max() < 1e-4
