"""Incremental dynamic analysis: what records and signs come to, at which time steps, and what is shared."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.analyses.scan import Reach
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.document import render_html, tables
from assessment.report.figures.index import pictures
from assessment.report.language import words_of
from assessment.report.tables.dynamic import incremental
from assessment.results.schema.dynamic import Fragility, Scanned
from assessment.results.schema.part import plain
from assessment.runtime.cache import Store
from assessment.studies.scans import Asked, Place, Scans
from assessment.studies.searches import UNITS, Measures, Searches, _search, findings, standard_of
from assessment.studies.variants import Study
from assessment.workflow.stages import run
from mechanics.messages import message
from tests.support.block_project import ASSESSMENT, PUSHED, edit, results_of
from tests.support.campaign_project import SEARCHES, write_campaign
from tests.support.pictured import draw_sections
from tests.support.typed import made


def _row(collapse, safe=None, **more):
    numbers = dict.fromkeys(("pga_collapse_g", "level_50_g", "lowest_collapse_g"), collapse)
    numbers |= {"pga_safe_g": collapse if safe is None else safe, "sign": 1}
    return made(Scanned, numbers | {"record": f"{collapse} {safe}"} | more)


def _fragility(rows):
    """The fragility of rows of one state, by the estimator of [incremental] and [campaign]."""
    place = Place(message("{state}", state="original"), "", None, None, None, None)
    asked = [
        Asked(
            SimpleNamespace(start=None, motion=SimpleNamespace(name=row.record)),
            row.sign,
            row.sign,
            Reach(5.0),
            state=place,
        )
        for row in rows
    ]
    over_pga = {row.record: dict.fromkeys(UNITS, 1.0) for row in rows}
    searches = Searches("incremental", asked, Scans(None, None), Study(), Measures(1.0, over_pga))
    fit = searches.fragility(Fragility, place, rows)
    return fit, [*findings(searches, len({row.record for row in rows}), [(place, fit, None)])]


def test_what_the_standard_takes_of_the_records():
    levels = [0.30, 0.36, 0.42, 0.33, 0.39, 0.35, 0.37]
    for count, rule, value in ((3, "lowest", 0.30), (6, "lowest", 0.30), (7, "mean", np.mean(levels))):
        rows = [_row(level) for level in levels[:count]]
        found, warnings = _fragility(rows)
        assert (found.rule, found.pga_collapse_g) == (rule, pytest.approx(value))
        assert standard_of(rows).mean == pytest.approx(np.mean(levels[:count]))
        assert warnings == []


@pytest.mark.parametrize("levels", [[0.33], [0.3, 0.4]])
def test_of_fewer_than_three_records_the_standard_takes_nothing(levels):
    """The lowest of two records was printed as the PGA of §7.3.5; of one record there was a scatter."""
    found, warnings = _fragility([_row(level) for level in levels])
    assert (found.rule, found.pga_collapse_g) == (None, min(levels))
    assert found.median_g == pytest.approx(math.exp(np.mean(np.log(levels))))
    assert (found.beta is None) == (len(levels) == 1) and found.median_range is None
    assert len(warnings) == 1 and "at least 3" in warnings[0]


def test_the_range_of_a_state_is_that_of_what_the_standard_takes():
    rows = [_row(low, pga_collapse_range=[low, high]) for low, high in ((0.3, 0.5), (0.4, 0.4))]
    assert _fragility(rows)[0].pga_collapse_g_range == [0.3, 0.4]
    seven = [_row(0.3, record=f"{k}", pga_collapse_range=[0.3, 0.4]) for k in range(7)]
    assert _fragility(seven)[0].pga_collapse_g_range == pytest.approx([0.3, 0.4])
    seven[0] = _row(0.3, record="0", pga_collapse_range=[0.3, None])
    assert _fragility(seven)[0].pga_collapse_g_range[1] is None
    assert _fragility([_row(0.3)])[0].pga_collapse_g_range is None


def test_records_without_collapse_leave_the_mean_open_and_the_lowest_where_they_cannot_be_lower():
    rows = [_row(0.30), _row(0.40), _row(None, 0.9)]
    found, warnings = _fragility(rows)
    assert standard_of(rows).mean is None
    assert found.pga_collapse_g == 0.30
    assert found.withstood == 1 and "count as lower" in warnings[0]
    assert _fragility([_row(0.30), _row(0.40), _row(None, 0.2)])[0].pga_collapse_g is None


def test_a_record_that_was_not_completed_decides_nothing_and_is_in_no_median():
    never = _row(None, record="c", pga_safe_g=None, reason="not solved")
    found, warnings = _fragility([_row(0.30), _row(0.40), never])
    assert found.pga_collapse_g is None
    assert found.median_g == pytest.approx(math.sqrt(0.12)) and found.failed == 1
    assert "1 of 3 combinations could not be completed" in warnings[0]


def test_each_direction_has_its_own_sign_and_the_worse_one_counts():
    rows = [_row(level, record=f"{k}", sign=sign) for k in range(3) for sign, level in ((1, 0.4), (-1, 0.3))]
    found, _ = _fragility(rows)
    assert found.directions == {"+x": 0.4, "-x": 0.3} and found.pga_collapse_g == 0.3


SHAKEN = """[incremental]
records = ["wave*.csv"]
contacts = "rigid"
tolerance_g = 0.05
max_scale = 3.0
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A block that turns about its corner, shaken by a wave, and a campaign of the same."""
    folder = write_campaign(tmp_path_factory.mktemp("incremental") / "block", SHAKEN + SEARCHES, 1)
    edit(folder, "scatter = 2", "scatter = 1")
    edit(folder, PUSHED, "")
    edit(folder, ASSESSMENT, "")
    return load_project(folder)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="module")
def outcome(project, kept):
    return run(project, build_model(project), 1, kept)


def test_incremental_analysis_and_campaign_are_one_set_of_motions_and_have_the_same_numbers(
    project, kept, outcome
):
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
    again = run(project, build_model(project), 1, kept)
    assert again.computed == 0 and again.results.states == outcome.results.states


def test_a_state_is_compared_with_the_original_by_what_its_records_bear(outcome):
    found = {name: state.incremental for name, state in outcome.results.states.items()}
    for each in found.values():
        [record] = each.records
        assert 0.0 < record.pga_collapse_g - record.pga_safe_g <= 0.05
        assert each.fragility.pga_collapse_g == each.mean_pga_collapse_g == record.pga_collapse_g
    before, after = (found[name].mean_pga_collapse_g for name in ("original", "base turned"))
    [row] = outcome.results.comparison
    assert (row.dynamic_pga_g, row.static_pga_g) == (after, None)
    assert row.dynamic_reduction == pytest.approx(1.0 - after / before)


def test_its_figures_tables_and_chapter_are_there(outcome, tmp_path):
    names = {picture.name for picture in pictures(outcome.results)}
    assert "incremental" in names and "fragility" not in names  # one record has no scatter
    draw_sections(outcome.results, tmp_path, "incremental")
    filled = {table.name for table in tables(outcome.results) if table.rows}
    assert {"incremental", "incremental_states", "incremental_curves", "static_dynamic"} <= filled
    words = words_of(outcome.results)
    assert f"<h3>{words('section.incremental')}</h3>" in render_html(outcome.results, tmp_path, words)


STATICS = ("self-weight", "settlement", "friction at rest, as drawn", "friction at rest, settled")


def test_the_time_step_is_halved_over_all_levels_and_the_finest_counts(project):
    asked = project.incremental.model_copy(update={"states": ("original",), "records": ("wave1.csv",)})
    standard = project.model_copy(update={"campaign": None, "incremental": asked, "accuracy": 0.1})
    fine = results_of(standard)
    rows = fine["convergence"]["incremental"]
    assert len(rows) == 2
    for row in rows:
        assert len(row["levels"]["pga_collapse_g"]) == row["halvings"] + 1 >= 3
    [record] = fine["states"]["original"]["incremental"]["records"]
    worse = next(each for each in record["signs"] if each["sign"] == record["sign"])
    assert worse["time_step_s"] <= 0.005
    lowest, points = worse["lowest_collapse_g"], worse["points"]
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
    found = results_of(far)["states"]["base turned"]["incremental"]
    assert all(each["pga_collapse_g"] is None and each["reason"] for each in found["records"])
    assert (
        all(each["runs"] == 0 for each in found["records"]) and found["fragility"]["pga_collapse_g"] is None
    )


def test_a_record_whose_worse_sign_is_not_known_has_a_reason_in_place_of_levels():
    """The table had the levels of the other sign."""
    known = {"record": "r", "resurrections_g": [], "widest_gap_g": None}
    stood = _row(0.2, 0.19, sign=1, pga_collapse_range=[0.2, 0.21], runs=5, **known)
    open_ = {"pga_safe_g": None, "level_50_g": None, "pga_collapse_range": None, "reason": "not solved"}
    failed = _row(None, sign=-1, runs=3, **open_, **known)
    record = _search(SimpleNamespace(name="r", pga=0.3, told_vertical={}), [stood, failed])
    state = SimpleNamespace(incremental=SimpleNamespace(records=[record]))
    [row] = incremental(SimpleNamespace(states={"original": state})).rows
    assert row["reason"] == "not solved"
    assert all(
        row.get(key) is None for key in ("pga_safe_g", "pga_collapse_g", "lowest_collapse_g", "level_50_g")
    )
