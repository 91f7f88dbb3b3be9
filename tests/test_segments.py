"""The error that the number of segments leaves in elastic capacities: against finer joints, and by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment import segments
from assessment.convergence import Levels
from assessment.model import build_model
from assessment.parallel import Workers
from assessment.project import load_project
from assessment.segments import finer, in_more_segments
from assessment.states import Request, StateResult, analyse_states
from assessment.study import Demands
from assessment.workflow import run
from mechanics import Assembly
from tests.block_project import TURNED, block, write_block
from tests.structures import running_bond

PUSHED = """[pushover]
contacts = ["rigid", "elastic"]
directions = ["+x"]
increment_m = 0.02
"""
ASSESSED = """[assessment]
limit_states = ["SLD"]
[assessment.site]
soil = "B"
SLD = {ag_g = 0.104, F0 = 2.33, Tc_star_s = 0.28}
"""


@pytest.fixture
def project(tmp_path):
    """A block of two segments on a soft joint, upright and turned; to be analysed as accurately as it says."""
    text = block(segments=2, stiffness="2e4") + TURNED + PUSHED + ASSESSED
    return load_project(write_block(tmp_path / "block", 'accuracy = "standard"\n' + text))


@given(
    exact=st.floats(0.01, 1.0),
    factor=st.floats(-0.5, 0.5),
    order=st.floats(0.35, 4.0),
)
def test_the_error_of_the_first_level_is_bounded_whatever_the_order(exact, factor, order):
    """v_k = v (1 + C 2^(−pk)) with k = 0, 1, 2, of which the first is the result."""
    values = [exact * (1.0 + factor * 2.0 ** (-order * k)) for k in range(3)]
    levels = Levels(1.0, tuple({"alpha_u": value} for value in values), result=0)
    error = levels.errors["alpha_u"]
    assert error is not None and error >= abs(values[0] - exact) * (1.0 - 1e-6) - 1e-12
    assert levels.relative["alpha_u"] == pytest.approx(error / values[0])
    assert replace(levels, result=-1).errors["alpha_u"] <= error


def test_a_result_that_is_not_there_has_no_error():
    levels = Levels(1.0, ({"alpha_u": None}, {"alpha_u": 0.1}, {"alpha_u": 0.1}), result=0)
    assert levels.errors == {"alpha_u": None}


def test_every_joint_gets_its_multiple():
    wall = running_bond(3, 3)
    model = Assembly([replace(b, segments=3 if i % 2 else None) for i, b in enumerate(wall.blocks)], 2)
    assert finer(model, 4).segments.tolist() == (4 * model.segments).tolist()
    assert {2, 3} >= set(model.segments.tolist())
    np.testing.assert_array_equal(finer(model, 4).joints.ends, model.joints.ends)


def test_the_estimate_bounds_the_distance_from_many_segments(project):
    """Thirty-two segments leave 3 % at most of what two do: rotational stiffness k l²/12 (1 + 2/m²)."""
    results = run(project, build_model(project), jobs=1).results
    rows = results["convergence"]["segments"]
    assert [(row["state"], row["direction"]) for row in rows] == [("original", "+x"), ("base turned", "+x")]
    model = finer(build_model(project).assembly, 16)
    with Workers(1) as workers:
        fine = analyse_states(
            [Request(project, model, each, "elastic") for each in (None, *project.settlements)], workers
        )
    for row, stage in zip(rows, fine, strict=True):
        given, close = row["levels"]["alpha_u"][0], stage.pushover["+x"]["alpha_u"]
        assert row["alpha_u_error"] >= given - close > 0.05 * given
        result = results["states"][row["state"]]["pushover"]["+x"]["elastic"]["alpha_u"]
        assert given == pytest.approx(result, rel=0.03)  # which has finer increments
        assert not row["met"] and row["a_g_error_g"] > 0.01  # at SLD, whose limit lies on the elastic branch
    said = [text for text in results["quality"]["warnings"] if "segments_per_joint given" in text]
    assert [text.partition(":")[0] for text in said] == ["original, +x", "base turned, +x"]
    assert results["timing_s"]["segments"] > 0.0


@pytest.mark.parametrize("kept", [{"accuracy": "fast"}, {"contacts": ("rigid",)}])
def test_nothing_is_analysed_that_nobody_asks_for(project, kept, monkeypatch):
    if "contacts" in kept:
        kept = {"pushover": project.pushover.model_copy(update=kept)}
    monkeypatch.setattr(segments, "analyse_states", lambda *_: pytest.fail("analysed"))
    results = run(project.model_copy(update=kept), build_model(project), jobs=1).results
    assert "segments" not in results["convergence"]


def _pushed(state: str, alpha_u: float | None, *failures: str) -> StateResult:
    pushover = {} if alpha_u is None else {"+x": {"alpha_u": alpha_u, "control": "right"}}
    return StateResult(state, "elastic", pushover=pushover, failures=list(failures))


def _studied(project, monkeypatch, *levels: list[StateResult]):
    """Study states that are made up: with the segments given, twice and four times as many."""
    finest = iter(levels[1:])
    monkeypatch.setattr(segments, "analyse_states", lambda *_: next(finest))
    project = project.model_copy(update={"assessment": None})
    return in_more_segments(project, build_model(project).assembly, Demands({}, None), levels[0], Workers(1))


def test_what_converges_is_within_the_tolerance(project, monkeypatch):
    found = _studied(project, monkeypatch, *([_pushed("original", 0.1 + e)] for e in (0.002, 0.001, 0.0005)))
    (row,) = found.rows
    assert row["alpha_u_error"] == pytest.approx(0.002)
    assert row["met"] and not found.warnings


def test_finer_joints_that_fail_leave_an_error_that_is_not_known(project, monkeypatch):
    found = _studied(
        project,
        monkeypatch,
        [_pushed("original", 0.10), _pushed("base turned", None, "no way")],
        [_pushed("original", 0.09), _pushed("base turned", None, "no way")],
        [_pushed("original", None, "the structure falls"), _pushed("base turned", None, "no way")],
    )
    (row,) = found.rows  # what failed with the segments given has said so itself
    assert row["alpha_u_error"] is None and row["relative_error"] is None and not row["met"]
    assert found.warnings == ["original, +x: more segments_per_joint fail: the structure falls"]
