"""Figures are drawn from results alone, the same bytes each time, at the scale and places they claim."""

import math

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.project.project import load_project
from assessment.report.figures.curves import ELASTIC, draw_pushdown, draw_spectra
from assessment.report.figures.deformed import draw_settlement, round_force
from assessment.report.figures.drawing import MM, SCALES, sheet, typeset
from assessment.report.language import words_of
from assessment.report.tables.mechanisms import elastic_capacity
from assessment.results.joint_states import outlines
from mechanics.pictures import STYLE, Shape, magnification, nice
from tests.support.block_project import TURNED, outcome_of, write_block
from tests.support.block_project import block as tables_of_block
from tests.support.results_example import results_example
from tests.support.typed import typed


def test_two_drawings_stand_beside_one_another_unless_below_they_are_twice_as_large():
    high, wide = (sheet((0.0, 0.0, width, 2.0), 2).panels for width in (3.6, 30.0))
    assert high[0].get_position().y0 == high[1].get_position().y0
    assert wide[0].get_position().y0 > wide[1].get_position().y1


def test_sheet_is_to_scale():
    for count in (1, 2, 4):
        page = sheet((0.0, 0.0, 2.7, 1.6), count, border_mm=14.0)
        assert page.scale in SCALES
        for axes in page.panels:
            paper_mm = axes.get_position().size * page.figure.get_size_inches() / MM
            model_mm = 1000.0 * np.ptp([axes.get_xlim(), axes.get_ylim()], axis=1)
            assert paper_mm == pytest.approx(model_mm / page.scale)
            assert paper_mm[1] == pytest.approx(1.6e3 / page.scale + 18.0)


@pytest.fixture(scope="module", params=[-0.02, 0.02])
def turned(request, tmp_path_factory):
    """A rotation, and the results of a block whose base turns by it about its centre, without a displacement."""
    text = tables_of_block() + TURNED.replace("-0.02", str(request.param)).replace("0.01", "0.004")
    project = load_project(write_block(tmp_path_factory.mktemp("turned") / "block", text))
    return request.param, outcome_of(project).results


def base_of(results):
    return next(each for each in results.geometry.blocks if each.support == "base")


def test_a_pure_rotation_has_its_movement_line_at_the_end_of_the_path(turned):
    """The arc at the base's farthest corner; as the largest displacement, 0, the line was left out."""
    rotation, results = turned
    corners = np.array(base_of(results).vertices_m)
    radius = np.hypot(*(corners - corners.mean(axis=0)).T).max()  # a rectangle
    figure = draw_pushdown(results, words_of(results), "base turned")
    for axes in figure.axes:
        [line] = [each for each in axes.lines if "cedimento assegnato" in each.get_label()]
        [curve] = [each for each in axes.lines if each.get_label() == "giunti rigidi"]
        asked = 1000.0 * abs(rotation) * radius
        assert line.get_xdata() == pytest.approx([asked, asked])
        assert curve.get_xdata()[[0, -1]] == pytest.approx([0.0, asked])
        assert axes.get_xlim()[1] > asked


def test_a_pure_rotation_has_an_arc_over_its_support_in_its_sense(turned):
    rotation, results = turned
    figure = draw_settlement(results, words_of(results), "base turned")
    [arrow] = figure.axes[0].texts
    centre, tail, head = base_of(results).centroid_m, arrow.xyann, arrow.xy
    assert (np.array(tail) + head) / 2.0 == pytest.approx(centre)
    # anticlockwise: from the right
    assert math.copysign(1.0, tail[0] - head[0]) == math.copysign(1.0, rotation)
    figure.draw_without_rendering()
    begun, over, *_ = arrow.arrow_patch.get_path().vertices
    assert over[1] > begun[1]


@given(st.floats(1e-6, 1e6))
def test_nice_numbers_are_just_below(value):
    found = nice(value)
    assert found <= value * (1 + 1e-6) < 2.5 * found * (1 + 1e-6)


def test_mechanism_and_finite_motion_agree_to_first_order():
    shape = outlines(typed(results_example()))
    rate = np.random.default_rng(1).normal(size=(7, 3))
    difference = shape.swept(rate, 1e-4).points - shape.moved(1e-4 * rate).points
    assert np.abs(difference).max() < 1e-7


@pytest.mark.parametrize(
    ("largest", "unit"), [(0.124, 0.1), (0.131, 0.2), (999.0, 1000.0), (6.6, 10.0), (1.3, 1.0)]
)
def test_resultants_are_drawn_to_a_round_scale(largest, unit):
    """The legend said "12 mm: 0.124 kN", which no scale reads; the largest is at most 13 mm long."""
    assert round_force(largest) == pytest.approx(unit)


def test_what_is_not_moved_is_not_magnified():
    """A facade at rest was drawn with its last digits, magnified by 1e16; an arch moved there and back, by 2e7."""
    corners = np.array([[-4.5e-4, 1.9e-3], [0.61, 1.7e-3], [0.61, 0.42], [1e-3, 0.421]])
    at_rest = Shape.of(
        [corners, corners + np.array([7.3, 3.1])], [[0.30523, 0.21111], [7.60523, 3.31111]], [False, False]
    )
    assert magnification(at_rest, np.zeros((2, 3))) == 1.0
    assert magnification(at_rest, np.full((2, 3), 1e-8)) == 1.0
    assert magnification(at_rest, np.full((2, 3), 1e-3)) > 1.0


def views(results):
    return [(state, "+x") for state in results.states]


def _drawn(results, limit="SLV"):
    with mpl.rc_context(STYLE):
        return typeset(draw_spectra(results, words_of(results), views(results), limit))


def test_a_spectrum_that_is_in_no_panel_is_told_as_such():
    results = typed(results_example("en"))
    assert _legend(_drawn(results))[-1] == "SLV spectrum demanded"
    far = {
        limit: each.replace(damped_S_e_g=[1e3 * a for a in each.damped_S_e_g])
        for limit, each in results.spectra.items()
    }
    assert _legend(_drawn(results.replace(spectra=far)))[-1] == "SLV spectrum demanded: beyond the panels"


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_elastic_curve_stands_beside_the_fitted_one():
    results = typed(results_example())
    figure = _drawn(results)
    d_star, a_star = elastic_capacity(results, "original", "+x")
    (grey,) = [line for line in figure.axes[0].get_lines() if line.get_color() == ELASTIC["color"]]
    assert grey.get_xydata() == pytest.approx(np.column_stack([1000.0 * d_star, a_star]))
    capacity, elastic = results.states["original"].capacity["+x"], results.states["original"].pushover["+x"]
    factor = results.echo.assessment["confidence_factor"]
    assert a_star.max() == pytest.approx(elastic.elastic.alpha_u / (capacity.e_star * factor))
