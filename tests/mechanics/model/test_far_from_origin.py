"""What is drawn at geographic coordinates behaves as it does at (0, 0)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechanics import Assembly, limit_analysis, pushdown, pushover
from tests.support.structures import column, tied_arch

UTM = np.array([498123.4, 4601237.7])  # m, of no use to binary fractions


def elsewhere(model: Assembly) -> Assembly:
    """The model drawn at UTM coordinates."""
    blocks = [replace(block, vertices=block.polygon + UTM) for block in model.blocks]
    ties = [replace(tie, start=tie.start + UTM, end=tie.end + UTM) for tie in model.ties]
    return Assembly(blocks, model.segments_per_joint, model.tolerance, model.collisions, ties)


def test_positions_count_from_whole_metres_near_what_is_drawn_far_away():
    near, far = column(0.5, 3.0, 4), elsewhere(column(0.5, 3.0, 4))
    assert near.origin.tolist() == [0.0, 0.0]
    assert far.origin.tolist() == [498122.0, 4601237.0]
    drawn = far.as_drawn(far.initial.positions[:, :2])
    assert drawn == pytest.approx(near.initial.positions[:, :2] + UTM, abs=2e-9)
    assert far.joints.ends == pytest.approx(near.joints.ends + UTM, abs=2e-9)
    assert far.block_at(np.add(UTM, (0.2, 2.9))) == near.block_at((0.2, 2.9)) == 4
    turned = far.rotated(1, np.add(UTM, (0.5, 0.0)), -0.1), near.rotated(1, (0.5, 0.0), -0.1)
    assert far.as_drawn(turned[0].positions[1, :2]) == pytest.approx(turned[1].positions[1, :2] + UTM)


def test_elastic_paths_are_those_at_the_origin():
    """Joints that are stiff beside the weight: a billionth of a metre would be a load."""
    near = column(0.5, 3.0, 3, 1e9)
    curves = [
        pushover(model, np.add(at, (0.5, 3.0)), "+x", "elastic", 0.005)
        for model, at in ((near, 0.0 * UTM), (elsewhere(near), UTM))
    ]
    assert curves[1].multiplier == pytest.approx(curves[0].multiplier, rel=1e-6)
    assert curves[1].displacement == pytest.approx(curves[0].displacement, rel=1e-6)
    assert curves[1].end.template == curves[0].end.template


def test_rigid_paths_movements_and_ties_are_those_at_the_origin():
    near = tied_arch(2.0)
    far = elsewhere(near)
    assert limit_analysis(far).alpha == pytest.approx(limit_analysis(near).alpha, rel=1e-7)
    settled = [pushdown(m, "right", (0.01, -0.01), increment=0.002, contacts="rigid") for m in (near, far)]
    assert settled[1].reaction == pytest.approx(settled[0].reaction, rel=1e-6, abs=1e-8)
    assert settled[1].final.positions + np.append(far.origin - UTM, 0.0) == pytest.approx(
        settled[0].final.positions, abs=1e-8
    )
    alphas = [limit_analysis(m, state=s.final).alpha for m, s in zip((near, far), settled, strict=True)]
    assert alphas[1] == pytest.approx(alphas[0], rel=1e-6)
