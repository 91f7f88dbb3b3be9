"""Capacity and demand in spectral coordinates: no panel in a corner, the elastic curve beside the fitted one."""

import matplotlib as mpl
import numpy as np
import pytest

from assessment.report.figures.curves import ELASTIC, draw_spectra
from assessment.report.figures.style import typeset
from assessment.report.language import words_of
from assessment.report.tables.mechanisms import elastic_capacity
from mechanics.pictures import STYLE
from tests.support.results_example import results_example
from tests.support.typed import typed


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
