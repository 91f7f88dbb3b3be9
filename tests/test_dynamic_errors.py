"""The errors that segments leave in peaks, and segments and time step in the PGA at collapse: against finer runs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment import dynamic_errors
from assessment.base_motion import history_motions, incremental_motions
from assessment.campaign import Campaign
from assessment.convergence import Levels
from assessment.dynamic_errors import collapses_again, in_more_segments, peaks_in_more_segments
from assessment.dynamics import StageResult, history
from assessment.histories import history_tasks
from assessment.incremental import Bracket, collapse_near, search
from assessment.model import build_model
from assessment.parallel import Workers
from assessment.project import load_project
from assessment.states import StateResult
from assessment.store import Store
from assessment.workflow import run
from tests.block_project import TURNED, block, write_block
from tests.test_incremental import Trial

SHAKEN = """[[history]]
record = "pulse.csv"
contacts = "{contacts}"
integrator = "implicit-euler"
"""
SEARCHED = """[incremental]
records = ["pulse.csv"]
contacts = "{contacts}"
tolerance_g = 0.01
max_scale = 8.0
"""
STEP = 0.02  # s


@pytest.fixture
def written(tmp_path):
    """Write a block of two segments on a soft joint, upright and turned, that a pulse shakes; return it loaded."""
    folder = write_block(tmp_path / "block")
    time = STEP * np.arange(75)
    pulse = np.column_stack([time, 0.11 * np.sin(2.0 * np.pi * time / 0.8) * (time <= 0.8)])
    np.savetxt(folder / "pulse.csv", pulse, delimiter=",", fmt="%.8f")

    def load(*tables: str, accuracy: str = "0.1", contacts: str = "elastic"):
        text = f"accuracy = {accuracy}\n" + block(stiffness="2e4") + TURNED
        text += "".join(table.format(contacts=contacts) for table in tables)
        return load_project(write_block(folder, text))

    return load


def results_of(project) -> dict:
    return run(project, build_model(project), jobs=1).results


# A bracket looked for again


@given(
    limit=st.floats(0.005, 3.0),
    safe=st.floats(0.0, 2.9),
    tolerance=st.floats(0.005, 0.1),
    largest=st.floats(3.0, 4.0),
)
def test_a_bracket_is_found_from_any_other(limit, safe, tolerance, largest):
    """Both ends were run, two runs tell a bracket that holds, and what is far away is found by doubling."""
    trial, near = Trial((limit, math.inf)), Bracket(safe, safe + 0.75 * tolerance, ())
    found = collapse_near(trial, near, largest, tolerance)
    assert found.safe < limit <= found.collapse and found.width <= tolerance
    assert {found.safe, found.collapse} <= {0.0, *trial.tried}
    away = abs(limit - safe) / near.width
    assert len(trial.tried) <= 2 + 2 * math.ceil(math.log2(1.0 + away))
    if near.safe < limit <= near.collapse:
        assert found == near


def test_what_never_falls_or_always_does():
    near = Bracket(0.30, 0.31, ())
    assert collapse_near(Trial(), near, 1.0, 0.01) == Bracket(1.0, None, ())
    always = collapse_near(Trial((0.0, 9.0)), near, 1.0, 0.01)
    assert always.safe == 0.0 and always.collapse <= 0.01


def test_no_collapse_is_tried_once_more_at_the_largest_level():
    trial, near = Trial(), Bracket(2.0, None, ())
    assert collapse_near(trial, near, 2.0, 0.01) == near and trial.tried == [2.0]
    fallen = collapse_near(Trial((1.5, 9.0)), near, 2.0, 0.01)
    assert fallen.safe < 1.5 <= fallen.collapse


# The estimate


def test_levels_of_which_the_result_alone_is_reached_have_no_known_error():
    levels = ({"peak_displacement_m": 0.1}, {"peak_displacement_m": None}, {"peak_displacement_m": None})
    assert Levels(1.0, levels, result=0).errors == {"peak_displacement_m": None}
    assert not Levels(1.0, levels, result=0).within(0.5)
    assert Levels(1.0, levels).errors == {}  # a collapse that two steps have seen


def test_what_values_are_known_to_is_part_of_their_error():
    levels = Levels(1.0, ({"pga_collapse_g": 0.30}, {"pga_collapse_g": 0.27}), result=0, resolution=0.01)
    assert levels.errors["pga_collapse_g"] == pytest.approx(2 * 0.03 + 0.01)


# Histories


def test_the_error_of_a_peak_bounds_the_distance_from_many_segments(written):
    """Thirty-two segments; the settled state is settled with as many. The results stay those of two."""
    project = written(SHAKEN)
    results = results_of(project)
    steps = {row["state"]: row for row in results["convergence"]["rows"]}
    rows = {row["state"]: row for row in results["convergence"]["segments"]}
    assert set(rows) == {"original", "base turned"}
    model, motions = build_model(project).assembly, history_motions(project)
    with Workers(1) as workers:
        campaign = Campaign(project, model, {}, {}, workers)
        fine = dynamic_errors._with_segments(campaign, project.history, {}, 16)
    for task in history_tasks(fine, motions):
        row, many = rows[task[3]], history(*task).numbers["peak_displacement_m"]
        given_segments = row["levels"]["peak_displacement_m"][0]
        assert given_segments == steps[task[3]]["levels"]["peak_displacement_m"][0]  # at the time step given
        assert row["peak_displacement_error_m"] >= abs(given_segments - many) > 0.02 * many
    assert [row["met"] for row in rows.values()] == [True, False]
    [said] = [text for text in results["quality"]["warnings"] if "segments_per_joint given" in text]
    assert said.startswith("base turned, history of pulse: estimated error of peak_displacement_m is ")
    assert results["timing_s"]["segments"] > 0.0


@pytest.mark.parametrize("kept", [{"accuracy": '"fast"'}, {"contacts": "rigid"}])
def test_no_joint_is_divided_that_nobody_asks_for_or_that_is_rigid(written, kept, monkeypatch):
    monkeypatch.setattr(dynamic_errors, "finer", lambda *_: pytest.fail("divided"))
    found = results_of(written(SHAKEN, SEARCHED, **kept))["convergence"]
    assert "segments" not in found
    assert ("incremental" in found) == ("accuracy" not in kept)  # with half the time step


def _told(written, monkeypatch, *peaks: float | str | None):
    """Study one history that is made up: a peak, None for a collapse, or why it failed, for each number of segments."""

    def made(peak: float | str | None) -> StageResult:
        failed = isinstance(peak, str)
        numbers = {
            "contacts": "elastic",
            "peak_displacement_m": 9.9 if peak is None else None if failed else peak,
            "collapsed": None if failed else peak is None,
            "reason": peak if failed else None,
        }
        return StageResult("original", "history", numbers)

    first = made(peaks[0])
    levels = {"peak_displacement_m": [peaks[0]]}
    first.convergence = {"state": "original", "record": "r", "levels": levels}
    monkeypatch.setattr(dynamic_errors, "history_tasks", lambda *_: [None])
    project = written(SHAKEN)
    campaign = SimpleNamespace(project=project, model=build_model(project).assembly)
    refined = [SimpleNamespace(each=lambda *_, peak=peak: [made(peak)]) for peak in peaks[1:]]
    found = peaks_in_more_segments(campaign, refined, [], [first])
    [row] = found.rows
    return row, found.warnings


def test_a_collapse_that_not_all_segments_see_leaves_no_number(written, monkeypatch):
    row, said = _told(written, monkeypatch, 0.1, 0.2, None)
    assert row["peak_displacement_error_m"] is None and not row["met"]
    assert "collapses with more segments_per_joint" in said[0]
    row, said = _told(written, monkeypatch, 0.1, None, None)
    assert row["peak_displacement_error_m"] is None and "collapses with more" in said[0]
    row, said = _told(written, monkeypatch, None, None, 0.2)
    assert row["peak_displacement_error_m"] is None and "does not collapse with more" in said[0]
    row, said = _told(written, monkeypatch, None, None, None)
    assert row["met"] and not said and "peak_displacement_error_m" not in row


def test_a_history_that_fails_in_more_segments_is_told(written, monkeypatch):
    row, said = _told(written, monkeypatch, 0.1, "no step is solved", 0.1)
    assert row["peak_displacement_error_m"] is None
    assert said == ["original, history of r: more segments_per_joint fail: no step is solved"]
    row, said = _told(written, monkeypatch, 0.1, 0.1, 0.1)
    assert row["peak_displacement_error_m"] == 0.0 and row["met"] and not said


# The PGA at collapse


def test_the_error_of_the_pga_at_collapse_bounds_the_distance_from_finer_analyses(written):
    """Thirty-two segments and a quarter of the time step."""
    project = written(SEARCHED + 'states = ["base turned"]\n')
    results = results_of(project)
    [row] = results["convergence"]["incremental"]
    model, motions = build_model(project).assembly, incremental_motions(project)
    with Workers(1) as workers:
        fine = dynamic_errors._with_segments(
            Campaign(project, model, {}, {}, workers), [project.incremental], {}, 16
        )
    shortest = [motion.at_half_step().at_half_step() for motion in motions]
    [task] = fine.tasks(project.incremental, shortest)
    exact = search(*task, 8.0, 0.002).numbers["pga_collapse_g"]
    [entry] = results["states"]["base turned"]["incremental"]["records"]
    given_segments, again = row["levels"]["pga_collapse_g"]
    assert given_segments == entry["pga_collapse_g"]
    width = entry["pga_collapse_g"] - entry["pga_safe_g"]
    assert row["pga_collapse_error_g"] == pytest.approx(2.0 * abs(again - given_segments) + width)
    assert row["pga_collapse_error_g"] >= abs(given_segments - exact) > width
    assert results["timing_s"]["incremental error"] > 0.0
    assert any(
        "incremental analysis with pulse: estimated error of" in t for t in results["quality"]["warnings"]
    )


def _searched_again(written, found: dict, again: dict):
    """Study one search that is made up, of elastic contacts: in the most segments."""
    project = written(SEARCHED)
    motions = incremental_motions(project)
    made = StageResult("original", "incremental", found)
    task = (None, motions[0], None, "original", None)

    def each(_, __, tasks, *more) -> list[StageResult]:
        for _, motion, _, _, _, near in tasks:
            assert motion.record.time_step == STEP / 2
            assert near == Bracket(found["pga_safe_g"], found["pga_collapse_g"], ())
        return [StageResult("original", "incremental", again)] * len(tasks)

    campaign = SimpleNamespace(project=project, model=build_model(project).assembly)
    return collapses_again(
        campaign, [campaign, SimpleNamespace(tasks=lambda *_: [task], each=each)], motions, [made]
    )


def test_a_collapse_that_only_one_analysis_finds_leaves_no_number(written):
    none, some = {"pga_safe_g": 0.44, "pga_collapse_g": None}, {"pga_safe_g": 0.30, "pga_collapse_g": 0.31}
    for first, again in ((none, some), (some, none)):
        found = _searched_again(written, first, again)
        assert found.rows[0]["pga_collapse_error_g"] is None and not found.rows[0]["met"]
        assert "pga_collapse_g is not known" in found.warnings[0]
    found = _searched_again(written, none, none)
    assert found.rows[0]["met"] and not found.warnings
    failed = {"pga_safe_g": None, "pga_collapse_g": None, "reason": "no step is solved"}
    found = _searched_again(written, some, failed)
    assert not found.rows[0]["met"] and "no step is solved" in found.warnings[0]
    assert not _searched_again(written, failed, some).rows


# Together


def test_what_errors_cost_is_kept_for_the_next_run(written, tmp_path):
    project = written(SHAKEN, SEARCHED)
    runs = [run(project, build_model(project), 1, Store(tmp_path / "store")) for _ in range(2)]
    first, second = runs
    # self-weight, a settlement, two histories and two searches; four histories, two settlements and two searches again
    assert (first.computed, first.taken) == (14, 0) and (second.computed, second.taken) == (0, 14)
    assert second.results["convergence"] == first.results["convergence"]


def test_states_are_settled_in_more_segments_where_a_motion_begins_from_them(written, monkeypatch):
    """In the increments at which they ended; original ones need no settlement."""
    asked = []

    def settled(requests, *_) -> list[StateResult]:
        asked.extend(requests)
        return [StateResult("base turned", "elastic", reached=each.model.initial) for each in requests]

    monkeypatch.setattr(dynamic_errors, "analyse_states", settled)
    of_original = 'states = ["original"]\n'
    for tables, models in (
        ((SHAKEN, SEARCHED), 2),
        ((SHAKEN + of_original, SEARCHED + of_original), 0),
        ((SHAKEN + of_original, SEARCHED), 2),
        ((SEARCHED,), 1),
    ):
        project = written(*tables)
        model = build_model(project).assembly
        coarse = {(state, "elastic"): f"{state} in few segments" for state in project.states}
        refined = in_more_segments(Campaign(project, model, coarse, {}, Workers(1)), {"base turned": 1})
        assert [each.model.segments_per_joint for each in refined] == [4, 8][-len(refined) :]
        assert len(asked) == models
        for each, request in zip(refined, asked, strict=bool(models)):
            assert request.settlement.increments == 2 * project.settlements[0].increments
            assert request.behaviour == "elastic" and request.directions == ()
            assert request.model is each.model
            assert all(start is each.model.initial for start in each.starts.values())
        asked.clear()
