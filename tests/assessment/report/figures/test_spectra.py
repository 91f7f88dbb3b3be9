"""Capacity and demand in spectral coordinates: no panel in a corner, the elastic curve beside the fitted one."""

import matplotlib as mpl
import numpy as np
import pytest

from assessment.report.figures.curves import ELASTIC, draw_spectra, one_scale
from assessment.report.figures.index import pictures
from assessment.report.figures.style import typeset
from assessment.report.tables.mechanisms import elastic_capacity
from assessment.report.text.language import words_of
from mechanics.pictures import STYLE
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


def views(results):
    return [(state, "+x") for state in results.states]


def _drawn(results, limit="SLV"):
    with mpl.rc_context(STYLE):
        return typeset(draw_spectra(results, words_of(results), views(results), limit))


def test_panels_share_their_axes_unless_one_would_be_squeezed_into_a_corner():
    for times, shared in ((1.2, True), (5.0, False)):
        results = _strengthened(times)
        figure = _drawn(results)
        assert one_scale(results, views(results), "SLV") == shared
        assert len({(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes}) == (1 if shared else 2)
        captions = {each.caption for each in pictures(results) if each.name == "spectra_SLV"}
        assert captions == {"spectra" if shared else "spectra_own"}


def test_the_elastic_curve_stands_beside_the_fitted_one():
    results = typed(results_example())
    figure = _drawn(results)
    d_star, a_star = elastic_capacity(results, "original", "+x")
    (grey,) = [line for line in figure.axes[0].get_lines() if line.get_color() == ELASTIC["color"]]
    assert grey.get_xydata() == pytest.approx(np.column_stack([1000.0 * d_star, a_star]))
    capacity, elastic = results.states["original"].capacity["+x"], results.states["original"].pushover["+x"]
    factor = results.echo.assessment["confidence_factor"]
    assert a_star.max() == pytest.approx(elastic.elastic.alpha_u / (capacity.e_star * factor))
