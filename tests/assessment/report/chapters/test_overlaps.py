"""A deep overlap of blocks does not pass without a word."""

from markupsafe import Markup

from assessment.report.chapters.remarks import overlaps
from assessment.report.language import words_of
from tests.support.results_example import results_example
from tests.support.typed import typed


def _said(penetration, language):
    results = results_example(language)
    row = {"state": "original", "stage": "pushover, elastic", "solves": 3, "worst_complementarity": 0.0}
    row |= {"worst_equilibrium_residual": 0.0, "worst_penetration_m": penetration}
    results["quality"]["by_stage"] = [row]
    shared = typed(results)
    return [Markup(each).striptags() for each in overlaps(shared, words_of(shared))]


def test_an_overlap_of_more_than_a_hundredth_of_a_block_is_told_with_where():
    assert not _said(1e-6, "en")
    [english], [italian] = _said(0.0392, "en"), _said(0.0392, "it")
    assert "in: original, pushover, elastic contacts: 39.2 mm. " in english
    assert "in: originale, pushover, giunti elastici: 39,2 mm. " in italian
