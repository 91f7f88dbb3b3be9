"""The multiplier by a second program: in the results of a run, with Coulomb friction, where the two differ."""

from __future__ import annotations

from dataclasses import replace

import pytest

from assessment.analyses import lateral as module
from assessment.analyses.lateral import second_solver
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema.part import plain
from assessment.workflow.stages import run
from mechanics.procedures import limit_in
from tests.support.analysed import SETTLED, analysed
from tests.support.block_project import PROJECT, write_block
from tests.support.structures import block_on_base, column
from tests.support.wording import in_italian


@pytest.mark.parametrize("state", ["original", SETTLED])
@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_every_state_and_direction_of_a_run_has_it(state, direction):
    rigid = analysed()["states"][state]["pushover"][direction]["rigid"]
    found = rigid["second_solver"]
    low, high = rigid.get("alpha_0_range", [rigid["alpha_0"]] * 2)
    assert (
        low <= found["alpha_0"] <= (high or 1.0)
    )  # of an ensemble the least counts; this is that of the own run
    assert found["alpha_program"] == pytest.approx(found["alpha_0"], rel=1e-4)
    assert found["alpha_linear_program"] == pytest.approx(found["alpha_program"], rel=1e-6)
    difference = found["alpha_linear_program"] / found["alpha_program"] - 1.0
    assert found["relative_difference"] == pytest.approx(difference, abs=1e-15)


def test_with_coulomb_friction_the_associative_multiplier_is_compared(tmp_path):
    """A block that slides: the law of the run is kept apart, and what is compared is named in the results."""
    text = PROJECT.replace("[material]", '[contacts]\nsliding = "coulomb"\n\n[material]')
    project = load_project(write_block(tmp_path / "block", text))
    results = plain(run(project, build_model(project), jobs=1).results)
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    assert rigid["sliding"] == "coulomb"
    assert rigid["second_solver"]["alpha_linear_program"] == pytest.approx(1.0 / 7.0, rel=1e-9)


@pytest.mark.parametrize(("share", "warned"), [(5e-7, False), (-2e-6, True)])
def test_a_difference_above_one_in_a_million_is_warned_of(monkeypatch, share, warned):
    def wrong(model, direction, state, sliding):
        limit = limit_in(model, direction, state, sliding)
        return replace(limit, alpha=limit.alpha / (1.0 + share))

    monkeypatch.setattr(module.procedures, "limit_in", wrong)
    model = block_on_base()
    part = second_solver(model, "moved", "-x", model.initial, 0.2)
    assert part.value.relative_difference == pytest.approx(share, rel=1e-3)
    assert bool(part.warnings) == warned
    for warning in part.warnings:
        italian = in_italian(warning)
        assert "moved" in italian and "scarto relativo" in italian and "written apart" not in italian


def test_a_multiplier_of_zero_by_both_is_no_difference():
    """Without friction: α = 0 by one, 1e-9 by the other."""
    model = block_on_base(friction=0.0)
    part = second_solver(model, "original", "+x", model.initial, 0.0)
    assert part.value.alpha_linear_program == pytest.approx(0.0, abs=1e-8)
    assert not part.warnings


def test_an_optimum_that_highs_does_not_find_is_warned_of(monkeypatch):
    monkeypatch.setattr(module.procedures, "static_theorem", lambda *_: None)
    model = block_on_base()
    part = second_solver(model, "original", "+x", model.initial, 0.2)
    assert part.value.alpha_linear_program is None and part.value.relative_difference is None
    assert part.value.alpha_program == pytest.approx(0.2)
    [warning] = part.warnings
    assert "ottimo" in in_italian(warning)


def test_joints_that_crush_have_no_comparison():
    model = column(0.5, 1.0, 2, strength=1000.0)
    part = second_solver(model, "original", "+x", model.initial, 0.2)
    assert part.value is None and not part.warnings
