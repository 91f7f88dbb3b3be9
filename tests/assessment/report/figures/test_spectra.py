"""Capacity and demand in spectral coordinates: no panel in a corner, every label in its frame and off the curves."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from assessment.report.figures.index import pictures
from assessment.report.figures.spectra import ELASTIC, draw_spectra, one_scale
from assessment.report.figures.style import STYLE, typeset
from assessment.report.tables.curves import elastic_capacity
from assessment.report.text.language import words_of
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def _strengthened(times):
    """Return results whose second state bears `times` the displacement and the acceleration of before."""
    results = results_example()
    for capacity in results["states"][SETTLED]["capacity"].values():
        for points in (capacity["curve"], *(capacity[limit] for limit in ("SLV", "SLC"))):
            for key in ("d_star_m", "a_star_g", "a_g_g"):
                if key in points:
                    points[key] = (times * np.asarray(points[key])).tolist()
    return typed(results)


def _drawn(results, limit="SLV"):
    with mpl.rc_context(STYLE):
        figure = typeset(draw_spectra(results, words_of(results), list(results.states), "+x", limit))
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        boxes = [
            (axes, text, text.get_window_extent(canvas.get_renderer()))
            for axes in figure.axes
            for text in axes.texts
        ]
    return figure, boxes


def test_panels_share_their_axes_unless_one_would_be_squeezed_into_a_corner():
    for times, shared in ((1.2, True), (5.0, False)):
        results = _strengthened(times)
        figure, _ = _drawn(results)
        assert one_scale(results, list(results.states), "+x", "SLV") == shared
        assert len({(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes}) == (1 if shared else 2)
        captions = {each.caption for each in pictures(results) if each.name == "spectra_plus_x_SLV"}
        assert captions == {"spectra" if shared else "spectra_own"}


@pytest.mark.parametrize("limit", ["SLV", "SLC"])
@pytest.mark.parametrize("times", [0.3, 1.0, 5.0])
def test_labels_are_whole_in_their_frame_off_the_curves_and_off_each_other(times, limit):
    _, boxes = _drawn(_strengthened(times), limit)
    assert {text.get_text() for _, text, _ in boxes} >= {"0,5 s", "1 s", "2 s", "3 s"}
    for axes, text, box in boxes:
        frame = axes.get_window_extent()
        assert frame.x0 <= box.x0 and box.x1 <= frame.x1, text.get_text()
        assert frame.y0 - 8.0 <= box.y0 and box.y1 <= frame.y1 + 8.0, text.get_text()
        for line in axes.get_lines():
            if line.get_zorder() < 2.0:
                continue
            assert text.get_zorder() < line.get_zorder(), "its white box covers no curve"
            corners = axes.transData.transform(line.get_xydata())
            along = np.linspace(0.0, len(corners) - 1.0, 40 * len(corners))
            places = [np.interp(along, range(len(corners)), corners[:, axis]) for axis in (0, 1)]
            inside = (places[0] > box.x0 + 2) & (places[0] < box.x1 - 2)
            inside &= (places[1] > box.y0 + 4) & (places[1] < box.y1 - 4)
            assert not inside.any(), text.get_text()
    for number, (axes, _, box) in enumerate(boxes):
        assert not any(other is axes and box.overlaps(its) for other, _, its in boxes[:number])


def test_the_elastic_curve_stands_beside_the_fitted_one():
    results = typed(results_example())
    figure, _ = _drawn(results)
    d_star, a_star = elastic_capacity(results, "original", "+x")
    (grey,) = [line for line in figure.axes[0].get_lines() if line.get_color() == ELASTIC["color"]]
    assert grey.get_xydata() == pytest.approx(np.column_stack([1000.0 * d_star, a_star]))
    capacity, elastic = results.states["original"].capacity["+x"], results.states["original"].pushover["+x"]
    factor = results.echo.assessment["confidence_factor"]
    assert a_star.max() == pytest.approx(elastic.elastic.alpha_u / (capacity.e_star * factor))
