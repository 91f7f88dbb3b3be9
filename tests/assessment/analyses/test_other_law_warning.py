"""What is told of the other law of friction: both multipliers at α0, where they differ there."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from assessment.analyses.lateral import _rigid_notes, rests_or_moves, rigid_push
from assessment.project.schema import ControlTable
from assessment.results.schema.static import RigidPush
from mechanics import Assembly, Block, Material, Pushover, limit_analysis, pushdown, pushover
from mechanics.messages import Message
from tests.support.random_masonry import small_wall
from tests.support.structures import rectangle


def leaning(seed: int, direction: str) -> Pushover:
    """The curve of a random wall whose base has turned by 0.02 rad."""
    wall = small_wall(seed)
    settled = pushdown(wall, "base", rotation=0.02, increment=0.01).final
    return pushover(wall, direction=direction, increment=0.02, state=settled)


def told(path: Pushover) -> tuple[RigidPush, list[Message]]:
    curve = rigid_push(ControlTable(name="C", point_m=tuple(path.control.tolist())), path)
    return curve, [note for note in _rigid_notes(curve, path) if note.template.startswith("by {law}")]


def test_the_other_law_is_compared_at_alpha_0_where_the_mechanism_is_another():
    """The control point takes no part at α0: both multipliers were those of the point from which it does."""
    path = leaning(2, "-x")
    path = replace(path, formed=path.peak + 1)
    at_peak = limit_analysis(path.model, "-x", path.states[path.peak], "associative").alpha
    curve, [note] = told(path)
    assert note.fields["multiplier"] == curve.alpha_0 == path.alpha_0
    assert note.fields["other"] == curve.other_law.alpha_0 == pytest.approx(at_peak, rel=1e-8)
    assert curve.other_law.mechanism.alpha != pytest.approx(at_peak, rel=1e-4)


@pytest.mark.parametrize(("friction", "rests"), [(1, 1.0), (0.4, None)])
def test_rigid_joints_that_may_rest_where_they_may_move_are_told(friction, rests):
    """Three courses of two bricks, friction 1: it may move from 4/7 on, and may rest up to μ.

    With 0.4 the wall slides, and both laws have one multiplier.
    """
    stone, rows = Material(18.0, friction), [(0.0, 0.4, 0.8), (0.0, 0.2, 0.6, 0.8), (0.0, 0.4, 0.8)]
    blocks = [Block(rectangle(-0.5, -0.3, 1.3, 0.0), 1.0, stone, support="base")]
    blocks += [
        Block(rectangle(left, 0.25 * course, right, 0.25 * (course + 1)), 1.0, stone)
        for course, ends in enumerate(rows)
        for left, right in pairwise(ends)
    ]
    model = Assembly(blocks)
    found = rests_or_moves(model, "original", model.initial)
    if rests is None:
        assert found.value == pytest.approx(1.0, abs=1e-6)
        assert not found.warnings
        return
    assert found.value == pytest.approx(rests / (4.0 / 7.0), rel=1e-6)
    assert [warning.fields["text"].fields["direction"] for warning in found.warnings] == ["+x", "-x"]
