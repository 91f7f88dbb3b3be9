"""An identification in results, report, drawing, tables and on the terminal: the arch with a support that moved out."""

import re
import tomllib

import numpy as np
import pytest

from assessment.project.project import load_project
from assessment.project.schema import SettlementTable
from assessment.report.chapters.judgement import told
from assessment.report.chapters.remarks import ready_lines
from assessment.report.document import tables
from assessment.report.figures.deformed import MEASURED, draw_identification
from assessment.report.language import words_of
from assessment.results.joint_states import outlines
from assessment.results.summary import fits
from assessment.studies import identification
from assessment.workflow.run import select
from tests.support.block_project import outcome_of
from tests.support.pictured import pages_of
from tests.support.surveyed_arch import PIER, SPRINGING, entry, write_surveyed


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    """Right support out by 10 mm, or left one by as much; a lean of the pier that contradicts either."""
    folder = write_surveyed(
        tmp_path_factory.mktemp("arch"),
        '[{ destro = ["x"] }, { sinistro = ["x"] }]',
        entry("span", "span", SPRINGING, 10.0),
        entry("pier", "lean", PIER, 1.0),
    )
    project = select(load_project(folder), ["identification"])
    with pytest.MonkeyPatch.context() as patch:  # the joints only open: increments tell nothing
        for name, value in {"FARTHEST": 2.0, "COARSE": 5, "FINE": 10}.items():
            patch.setattr(identification, name, value)
        return outcome_of(project)


@pytest.fixture(scope="module")
def results(outcome):
    return outcome.results


@pytest.fixture(scope="module")
def pages(results, tmp_path_factory):
    return pages_of(results, tmp_path_factory.mktemp("page"))


def test_the_results_have_what_was_asked_for(outcome, results):
    found = results.identification
    assert outcome.complete and results.quality.solves > 0 and "identification" in results.timing_s
    assert [each.movement[0].x_m for each in found.hypotheses] == pytest.approx([0.01, -0.01], abs=1e-5)
    assert all(not each.distinguished and each.contradicting == ["pier"] for each in found.hypotheses)
    assert found.hypotheses[0].chi_squared == pytest.approx(25.0, abs=1e-3)  # (1 mrad/0.2)²
    error = found.hypotheses[0].movement[0].x_standard_error_m
    assert error == pytest.approx(0.2e-3, rel=1e-3)  # σ of the span, which moves with the support


def test_that_stage_alone_moves_no_support_of_a_settlement(tmp_path):
    folder = write_surveyed(tmp_path, '[{ destro = ["x"] }]', entry("span", "span", SPRINGING, 10.0))
    with (folder / "project.toml").open("a") as file:
        file.write('[[settlements]]\nname = "moved"\nsupport = "destro"\ndisplacement_m = [0.01, 0.0]\n')
    project = load_project(folder)
    assert select(project, ["identification"]).settlements == ()
    assert select(project, ["identification", "pushdown"]).settlements == project.settlements
    assert select(project, ["pushdown"]).identification is None


def test_the_page_tells_it_in_both_languages(pages):
    for language, phrases in {
        "it": (
            "Movimento che spiega il rilievo",
            "Le misure non distinguono",
            "contraddicono le altre",
            "Previsto",
        ),
        "en": ("Movement that explains the survey", "do not distinguish", "contradict the rest", "Predicted"),
    }.items():
        assert all(phrase in pages[language] for phrase in phrases), language
        assert "displacement_m = [0.01, 0.0]" in pages[language]
    assert "the measurement pier contradicts" not in pages["it"]
    assert "la misura pier contraddice le altre: previsto" in pages["it"]


def test_the_lines_are_a_settlement_of_a_project_file(results):
    ready = ready_lines(results, words_of(results))
    assert ready.startswith("# ")  # a movement that a measurement contradicts is not to be pasted unread
    assert not ready_lines(explained(results), words_of(results)).startswith("#")
    [given] = tomllib.loads(ready)["settlements"]
    settlement = SettlementTable.model_validate(given)
    assert settlement.support == "destro" and settlement.displacement_m == pytest.approx(
        (0.01, 0.0), abs=1e-5
    )


def explained(results):
    """The same with a movement that explains the measurements."""
    found = results.identification
    hypotheses = [
        each.replace(contradicting=[], probability=0.5, chi_squared=0.5) for each in found.hypotheses
    ]
    return results.replace(identification=found.replace(hypotheses=hypotheses))


@pytest.mark.parametrize(("left", "square", "fit"), [(0, 83.6, False), (0, 1e-6, True), (1, 0.5, True)])
def test_a_movement_fits_unless_nothing_is_left_and_the_measurements_are_missed(results, left, square, fit):
    """χ² 83.6 with as many unknowns as measurements was offered as a settlement to paste."""
    best = explained(results).identification.hypotheses[0]
    assert fits(best.replace(degrees_of_freedom=left, chi_squared=square, probability=None)) == fit


def test_the_drawing_marks_the_measurements_where_the_magnified_movement_takes_them(results):
    [axes] = draw_identification(results, words_of(results)).axes
    [marks] = [line.get_xydata() for line in axes.lines if line.get_marker() == MEASURED["marker"]]
    found = results.identification
    sites, configuration = found.sites, found.hypotheses[found.best].configuration
    [times] = {float(found) for found in re.findall(r"([\d.]+)", axes.get_title())}
    for site, mark in zip(sites, marks, strict=True):
        x, z, turn = configuration[site.block]
        arm = np.subtract(site.point_m, results.geometry.blocks[site.block].centroid_m)
        c, s = np.cos(turn), np.sin(turn)
        moved = [x + (c - 1.0) * arm[0] - s * arm[1], z + s * arm[0] + (c - 1.0) * arm[1]]
        assert mark - site.point_m == pytest.approx(times * np.array(moved), abs=1e-9)
    drawn = np.vstack([each.get_path().vertices for each in axes.get_children() if hasattr(each, "get_path")])
    corners = outlines(results).moved(np.array(configuration), times).points
    assert max(abs(drawn - corner).sum(axis=1).min() for corner in corners) < 1e-9, (
        "the blocks are magnified as much"
    )
    assert {text.get_text() for text in axes.texts} >= {"1", "2"}
    assert marks[0, 0] - sites[0].point_m[0] == pytest.approx(times * 0.01, rel=1e-3), (
        "the springing moved out"
    )


def test_the_terminal_has_the_movement_with_its_error_and_that_it_is_not_to_be_used(results):
    def moved(of):
        return told(of)[told(of).index("best movement") :].splitlines()

    best, unfit, *lines = moved(results)
    assert best == "best movement: destro: x 10 ± 0.2 mm (χ² 25, 1 degrees of freedom)"
    assert unfit == "  # does not fit the measurements: not to be used"
    assert moved(explained(results))[1:] == lines and "  displacement_m = [0.01, 0.0]" in lines


def test_the_tables_have_every_hypothesis(results):
    found = {table.name: table for table in tables(results)}
    assert len(found["hypotheses"].rows) == 2 and len(found["identified_movements"].rows) == 2
    rows = found["measurements"].rows
    assert [row["number"] for row in rows] == [1, 2, 1, 2]
    assert rows[1]["residual"] == pytest.approx(-1.0, abs=1e-5)
