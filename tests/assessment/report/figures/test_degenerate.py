"""Figures and tables of results that are nothing, very large or very long."""

import re

import matplotlib as mpl
from matplotlib.lines import Line2D
from matplotlib.path import Path

from assessment.report.figures.drawings.model import draw_model
from assessment.report.figures.drawings.parts import ARROW
from assessment.report.figures.studies import draw_tornado
from assessment.report.figures.style import save_svg, sheet
from assessment.report.text.language import words_of
from mechanics.pictures import STYLE
from tests.assessment.report.tables.test_study_tables import results_with_studies
from tests.support.results_example import results_example
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
