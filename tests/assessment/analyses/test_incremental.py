"""Incremental dynamic analysis: what records and signs come to, at which time steps, and what is shared."""

import numpy as np
import pytest

from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema.dynamic import Search, SignScan
from assessment.results.schema.part import plain
from assessment.runtime.cache import Store
from assessment.studies.searches import summarise
from assessment.workflow.stages import run
from tests.support.block_project import TURNED, block, write_block
from tests.support.campaign_project import SEARCHES
from tests.support.typed import made


def _record(collapse, safe=None, **more):
    numbers = {
        "pga_collapse_g": collapse,
        "pga_safe_g": collapse if safe is None else safe,
        "level_50_g": collapse,
    }
    name = more.pop("record", f"{collapse} {safe}")
    sign = made(SignScan, numbers | {"sign": 1})
    return made(Search, numbers | {"record": name, "signs": [sign]} | more)


def test_what_the_standard_takes_of_the_records():
    levels = [0.30, 0.36, 0.42, 0.33, 0.39, 0.35, 0.37]
    for count, rule, value in ((3, "lowest", 0.30), (6, "lowest", 0.30), (7, "mean", np.mean(levels))):
        warnings = []
        found = summarise([_record(level) for level in levels[:count]], warnings, "original")
        assert (found.rule, found.pga_collapse_g) == (rule, pytest.approx(value))
        assert found.mean_pga_collapse_g == pytest.approx(np.mean(levels[:count]))
        assert warnings == []


@pytest.mark.parametrize("levels", [[0.33], [0.3, 0.4]])
def test_of_fewer_than_three_records_the_standard_takes_nothing(levels):
    """The lowest of two records was printed as the PGA of §7.3.5."""
    warnings = []
    found = summarise([_record(level) for level in levels], warnings, "original")
    assert (found.rule, found.pga_collapse_g) == (None, min(levels))
    assert found.mean_pga_collapse_g == pytest.approx(np.mean(levels))
    assert len(warnings) == 1 and "at least 3" in warnings[0]


def test_the_range_of_a_state_is_that_of_what_the_standard_takes():
    records = [_record(low, pga_collapse_g_range=[low, high]) for low, high in ((0.3, 0.5), (0.4, 0.4))]
    assert summarise(records, [], "original").pga_collapse_g_range == [0.3, 0.4]
    seven = [_record(0.3, record=f"{k}", pga_collapse_g_range=[0.3, 0.4]) for k in range(7)]
    assert summarise(seven, [], "original").pga_collapse_g_range == pytest.approx([0.3, 0.4])
    seven[0] = _record(0.3, record="0", pga_collapse_g_range=[0.3, None])
    assert summarise(seven, [], "original").pga_collapse_g_range[1] is None
    assert summarise([_record(0.3)], [], "original").pga_collapse_g_range is None


def test_records_without_collapse_leave_the_mean_open_and_the_lowest_where_they_cannot_be_lower():
    found = summarise([_record(0.30), _record(0.40), _record(None, 0.9)], [], "original")
    assert found.mean_pga_collapse_g is None
    assert found.pga_collapse_g == 0.30
    assert found.fragility.censored == 1
    assert summarise([_record(0.30), _record(0.40), _record(None, 0.2)], [], "s").pga_collapse_g is None
    never = _record(None, signs=[made(SignScan, {"sign": 1, "pga_safe_g": None})])
    never = never.replace(pga_safe_g=None)
    found = summarise([_record(0.30), _record(0.40), never], [], "s")
    assert found.pga_collapse_g is None
    assert found.fragility is None


def test_each_direction_has_its_own_sign_and_the_worse_one_counts():
    both = [
        made(
            SignScan, {"sign": sign, "pga_collapse_g": level, "pga_safe_g": 0.9 * level, "level_50_g": level}
        )
        for sign, level in ((1, 0.4), (-1, 0.3))
    ]
    records = [_record(0.3, record=f"{k}", signs=both) for k in range(3)]
    found = summarise(records, [], "original")
    assert found.directions == {"+x": 0.4, "-x": 0.3} and found.pga_collapse_g == 0.3


SHAKEN = """[incremental]
records = ["wave*.csv"]
contacts = "rigid"
tolerance_g = 0.05
max_scale = 3.0
"""


@pytest.fixture
def project(tmp_path):
    """A block that turns about its corner, shaken by a wave, and a campaign of the same."""
    folder = write_block(tmp_path / "block", "scatter = 1\n" + block() + TURNED + SHAKEN + SEARCHES)
    time = 0.02 * np.arange(36)
    wave = 0.3 * np.sin(4.0 * time) * np.exp(-0.3 * time)
    np.savetxt(folder / "wave.csv", np.column_stack([time, wave]), delimiter=",")
    return load_project(folder)


def test_incremental_analysis_and_campaign_are_one_set_of_motions_and_have_the_same_numbers(
    project, tmp_path
):
    outcome = run(project, build_model(project), 1, Store(tmp_path / "store"))
    results = plain(outcome.results)
    rows = {(row["record"], row["share"], row["sign"]): row for row in results["campaign"]["combinations"]}
    for state, share in (("original", 0.0), ("base turned", 1.0)):
        found = results["states"][state]["incremental"]
        for record in found["records"]:
            [sign] = [each for each in record["signs"] if each["sign"] == 1]
            row = rows[record["record"], share, 1]
            for key in (
                "pga_collapse_g",
                "lowest_collapse_g",
                "level_50_g",
                "pga_safe_g",
                "time_step_s",
                "runs",
            ):
                assert sign[key] == row[key]
            assert record["pga_collapse_g"] == min(each["pga_collapse_g"] for each in record["signs"])
    assert results["states"]["original"]["incremental"].get("loss") is None
    loss = results["states"]["base turned"]["incremental"]["loss"]
    low, high = loss["dynamic_range"]
    assert low <= loss["dynamic"] <= high and loss["left_out"] == 0
    # both signs from two states, and three of these at half the time step; the campaign's are among them
    assert outcome.computed == 4 + 3 + len(STATICS) and results["timing_s"]["campaign"] == 0.0
    again = run(project, build_model(project), 1, Store(tmp_path / "store"))
    assert again.computed == 0 and again.results.states == outcome.results.states


STATICS = ("self-weight", "settlement", "friction at rest, as drawn", "friction at rest, settled")


def test_the_time_step_is_halved_over_all_levels_and_the_finest_counts(project):
    asked = project.incremental.model_copy(update={"states": ("original",), "records": ("wave.csv",)})
    standard = project.model_copy(update={"campaign": None, "incremental": asked, "accuracy": 0.1})
    fine = plain(run(standard, build_model(standard), 1).results)
    rows = fine["convergence"]["incremental"]
    assert len(rows) == 2
    for row in rows:
        assert len(row["levels"]["pga_collapse_g"]) == row["halvings"] + 1 >= 3
    [record] = fine["states"]["original"]["incremental"]["records"]
    assert record["time_step_s"] <= 0.005
    lowest, points = record["lowest_collapse_g"], record["signs"][0]["points"] or record["points"]
    assert sum(0.7 * lowest <= point["pga_g"] < lowest for point in points) >= 7


def test_a_state_that_was_not_reached_has_the_reason(project):
    """The block falls as its base turns by more than it can."""
    [turned] = project.settlements
    far = project.model_copy(
        update={
            "settlements": (turned.model_copy(update={"rotation_rad": -0.5, "increment_rad": 0.05}),),
            "incremental": project.incremental.model_copy(update={"states": (turned.name,)}),
            "campaign": None,
            "accuracy": "fast",
        }
    )
    found = plain(run(far, build_model(far), 1).results)["states"]["base turned"]["incremental"]
    assert all(each["pga_collapse_g"] is None and each["reason"] for each in found["records"])
    assert all(each["runs"] == 0 for each in found["records"]) and found["pga_collapse_g"] is None
