"""Figures and tables of results that are nothing, very large or very long."""

import re

import matplotlib as mpl
import pytest
from markupsafe import Markup
from matplotlib.lines import Line2D
from matplotlib.path import Path

from assessment.report.chapters.grid import Grid, _Column, summary_grids
from assessment.report.figures.drawings.deformed import ARROW
from assessment.report.figures.drawings.model import draw_model
from assessment.report.figures.studies import draw_tornado
from assessment.report.figures.style import STYLE, save_svg, sheet
from assessment.report.text.language import words_of
from tests.assessment.report.tables.test_study_tables import results_with_studies
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def test_a_property_that_changes_nothing_is_said_to():
    """The axis had six times the same label."""
    results = results_with_studies()
    runs = [run for run in results["sensitivity"]["runs"] if run["state"] == "original"]
    results["sensitivity"]["runs"] = [run for run in runs if run["property"] == "friction"]
    for run, tiny in zip(results["sensitivity"]["runs"], (0.0, 1e-16, -1e-16, 0.0), strict=False):
        base = results["states"]["original"]["capacity"][run["direction"]]["SLC"]["a_g_g"]
        run["a_g_g"] = base * (1.0 + tiny)
    shared = typed(results)
    with mpl.rc_context(STYLE):
        figure = draw_tornado(shared, words_of(shared), ["original"])
    [axes] = figure.axes
    labels = axes.xaxis.get_major_formatter().format_ticks(axes.get_xticks())
    assert len(set(labels)) == len(labels)
    [text] = [each.get_text() for each in axes.texts]
    assert re.fullmatch(r"a_g non varia, da ×0,\d+ a ×1,\d+", text)
    assert not axes.patches


def test_arrows_of_loads_are_whole_and_have_their_mark_in_the_legend(tmp_path):
    """The picture was cut where the outline ends."""

    def draw_sheet():
        return sheet((0.0, 0.0, 0.4, 0.1), border_mm=30.0, below_mm=20.0, most_mm=90.0)

    def draw():
        page = draw_sheet()
        page.panels[0].annotate("", (0.2, 0.0), (0.2, 0.1), arrowprops=ARROW)
        return page.figure

    save_svg(draw, tmp_path / "arrow.svg")
    box = re.search(r'viewBox="([^"]*)"', (tmp_path / "arrow.svg").read_text())[1].split()
    assert float(box[3]) * 25.4 / 72.0 > 100.0 / draw_sheet().scale
    results = results_example()
    results["geometry"]["blocks"][2]["vertical_load_kN"] = 4.0
    figure = draw_model(typed(results), words_of(typed(results)))
    [legend] = figure.legends
    marks = [handle.get_marker() for handle in legend.legend_handles if isinstance(handle, Line2D)]
    assert any(isinstance(mark, Path) for mark in marks), "an arrow"


def test_a_value_that_grows_many_times_has_its_factor():
    results = results_example()
    for state, value in (("original", 0.00049), (SETTLED, 0.142)):
        results["states"][state]["pushover"]["+x"]["elastic"]["d_y_m"] = value
    shared = typed(results)
    grids = list(summary_grids(shared, words_of(shared)))
    [row] = [row for row in grids[0].rows if "d<sub>y</sub>" in row[0]]
    assert row[-1] == "× 290"


@pytest.mark.parametrize("name", ["pila sinistra, −40 mm e rotazione", "short"])
def test_long_headings_take_the_room_that_the_row_leaves(name):
    head = [Markup("Grandezza"), Markup(name), Markup("Riduzione [%]")]
    rows = [[Markup("α"), Markup("0,102"), Markup("8,0")]]
    made = Grid(Markup(""), head, rows, [True, False, False])
    width = 109.0 * made.widths[1] / 100.0
    assert _Column.of(head[1], [rows[0][1]], text=False).lines(width)[0] <= 2
