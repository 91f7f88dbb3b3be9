"""The errors that the time step leaves in the PGA at collapse: against finer searches."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.analyses.dynamic.bracket import Bracket, collapse_near
from assessment.analyses.dynamic.ensemble import Scatter
from assessment.analyses.dynamic.errors import collapses_again
from assessment.analyses.dynamic.incremental import search
from assessment.analyses.dynamic.inputs import Campaign, Resting
from assessment.analyses.dynamic.time_history import DynamicResult, Shaking
from assessment.project.motions import incremental_motions
from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.results.plain import plain
from assessment.results.schema.dynamic import Search
from assessment.runtime.cache import Store
from assessment.runtime.tasks import Workers
from assessment.workflow.stages import run
from tests.assessment.analyses.dynamic.test_incremental import Trial
from tests.support.block_project import block, write_block
from tests.support.typed import made

SEARCHED = """[incremental]
records = ["pulse.csv"]
contacts = "rigid"
integrator = "implicit-euler"
tolerance_g = 0.01
max_scale = 8.0
"""
STEP = 0.02  # s


@pytest.fixture
def project(tmp_path):
    """A block that a pulse shakes."""
    time = STEP * np.arange(75)
    pulse = np.column_stack([time, 0.11 * np.sin(2.0 * np.pi * time / 0.8) * (time <= 0.8)])
    folder = write_block(tmp_path / "block", "accuracy = 0.1\nscatter = 1\n" + block() + SEARCHED)
    np.savetxt(folder / "pulse.csv", pulse, delimiter=",", fmt="%.8f")
    return load_project(folder)


# A bracket looked for again


@given(
    limit=st.floats(0.005, 3.0),
    safe=st.floats(0.0, 2.9),
    tolerance=st.floats(0.005, 0.1),
    largest=st.floats(3.0, 4.0),
)
def test_a_bracket_is_found_from_any_other(limit, safe, tolerance, largest):
    """Both ends were run, two runs tell a bracket that holds, and what is far away is found by doubling."""
    trial, near = Trial((limit, math.inf)), Bracket(safe, safe + 0.75 * tolerance, None, ())
    found = collapse_near(trial, near, largest, tolerance)
    assert found.safe < limit <= found.collapse and found.width <= tolerance
    assert {found.safe, found.collapse} <= {0.0, *trial.tried}
    away = abs(limit - safe) / near.width
    assert len(trial.tried) <= 2 + 2 * math.ceil(math.log2(1.0 + away))
    if near.safe < limit <= near.collapse:
        assert found == near


def test_what_never_falls_or_always_does():
    near = Bracket(0.30, 0.31, None, ())
    assert collapse_near(Trial(), near, 1.0, 0.01) == Bracket(1.0, None, None, ())
    always = collapse_near(Trial((0.0, 9.0)), near, 1.0, 0.01)
    assert always.safe == 0.0 and always.collapse <= 0.01


def test_no_collapse_is_tried_once_more_at_the_largest_level():
    trial, near = Trial(), Bracket(2.0, None, None, ())
    assert collapse_near(trial, near, 2.0, 0.01) == near and trial.tried == [2.0]
    fallen = collapse_near(Trial((1.5, 9.0)), near, 2.0, 0.01)
    assert fallen.safe < 1.5 <= fallen.collapse


# The PGA at collapse


def test_the_error_of_the_pga_at_collapse_bounds_the_distance_from_finer_analyses(project):
    """An eighth of the time step, and no bracket to speak of."""
    results = plain(run(project, build_model(project), jobs=1).results)
    [row] = results["convergence"]["incremental"]
    model, motions = build_model(project).assembly, incremental_motions(project)
    motion = motions[0].at_half_step().at_half_step().at_half_step()
    with Workers(1) as workers:
        starts = {("original", "rigid"): Resting(model, model.initial)}
        [task] = Campaign(project, starts, {}, workers).tasks(project.incremental, [motion])
    exact = search(task, Scatter(1, 0.1), 8.0, 0.002).numbers.pga_collapse_g
    [entry] = results["states"]["original"]["incremental"]["records"]
    given_step, *_ = row["levels"]["pga_collapse_g"]
    assert given_step == entry["pga_collapse_g"] and len(row["levels"]["pga_collapse_g"]) == 3
    width = entry["pga_collapse_g"] - entry["pga_safe_g"]
    assert row["pga_collapse_error_g"] >= width and row["pga_collapse_error_g"] >= abs(given_step - exact)
    assert results["timing_s"]["incremental error"] > 0.0


def made_up(numbers: dict) -> DynamicResult[Search]:
    return DynamicResult("original", "incremental", made(Search, {"reason": None} | numbers))


def again(project, found: dict, *finer: dict):
    """Study one search that is made up, and what the two finer ones find."""
    motions = incremental_motions(project)
    task = Shaking(None, motions[0], None, "original", None)

    def each(_, __, tasks, *more) -> list[DynamicResult]:
        assert [task.motion.record.time_step for task, *_ in tasks] == [STEP / 2, STEP / 4][: len(tasks)]
        return [made_up(one) for one in finer][: len(tasks)]

    campaign = SimpleNamespace(project=project, tasks=lambda *_: [task], each=each)
    return collapses_again(campaign, motions, [made_up(found)])


NONE = {"pga_safe_g": 0.44, "pga_collapse_g": None}
SOME = {"pga_safe_g": 0.30, "pga_collapse_g": 0.31, "pga_collapse_g_range": [0.31, 0.31]}


def test_a_collapse_that_not_every_time_step_finds_leaves_no_number(project):
    for first, half in ((NONE, SOME), (SOME, NONE)):
        found = again(project, first, half, half)
        assert found.rows[0].pga_collapse_error_g is None and not found.rows[0].met
        assert "pga_collapse_g not known" in found.warnings[0]
    found = again(project, NONE, NONE, NONE)
    assert found.rows[0].met and not found.warnings
    failed = {"pga_safe_g": None, "pga_collapse_g": None, "reason": "no step is solved"}
    found = again(project, SOME, SOME, failed)
    assert not found.rows[0].met and "no step is solved" in found.warnings[0]
    assert not again(project, failed).rows


def test_an_ensemble_wider_than_the_time_steps_is_told_as_scatter(project):
    wide = SOME | {"pga_collapse_g_range": [0.31, 0.42]}
    found = again(project, wide, SOME, SOME)
    assert found.rows[0].pga_collapse_scatter_g == pytest.approx(0.11) and not found.rows[0].met
    assert "scatters by 35 %" in found.warnings[0]


def test_nothing_is_run_where_no_accuracy_is_asked_for(project):
    found = again(project.model_copy(update={"accuracy": "fast"}), SOME)
    assert not found.rows and not found.warnings


def test_what_errors_cost_is_kept_for_the_next_run(project, tmp_path):
    first, second = (run(project, build_model(project), 1, Store(tmp_path / "store")) for _ in range(2))
    # self-weight, the search, and two again
    assert (first.computed, first.taken) == (4, 0) and (second.computed, second.taken) == (0, 4)
    assert second.results.convergence == first.results.convergence
