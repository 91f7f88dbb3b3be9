"""What is told of the other law of friction: both multipliers at α0, where they differ there."""

from __future__ import annotations

from dataclasses import replace

import pytest

from assessment.analyses.static.lateral import _rigid_notes, rigid_push
from assessment.project.schema import ControlTable
from assessment.results.schema.static import RigidPush
from mechanics import Pushover, limit_analysis, pushdown, pushover
from mechanics.messages import Message
from tests.support.random_masonry import small_wall


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
