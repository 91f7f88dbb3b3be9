"""What the report says of curves: how one begins, where equilibrium is lost, where the fitted one is the higher."""

import numpy as np
import pytest
from markupsafe import Markup

from assessment.report.chapters.remarks import fitted_above, lost_before_zero, onsets
from assessment.report.figures.curves import draw_pushover
from assessment.report.figures.deformed import draw_overturned
from assessment.report.language import words_of
from assessment.report.tables.mechanisms import alpha_at_d_0, elastic_capacity, excesses
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def _with_curve(displacement, multiplier, **changes):
    results = results_example("en")
    rigid = results["states"][SETTLED]["pushover"]["+x"]["rigid"]
    rigid["curve"] = {"displacement_m": displacement, "multiplier": multiplier}
    rigid |= {"alpha_onset": multiplier[0], "alpha_0": max(multiplier), "d_0_m": displacement[-1]}
    rigid |= changes
    return typed(results)


def _plain(sentences):
    return [Markup(each).striptags() for each in sentences]


def test_a_later_peak_is_not_said_to_be_where_the_hinges_close():
    results = _with_curve([0.0, 0.0, 0.0017, 0.04, 0.0438, 0.1], [0.02, 0.004, 0.2178, 0.2048, 0.2197, 0.0])
    [said] = [each for each in _plain(onsets(results, words_of(results))) if "+x" in each]
    assert "; then as little as 0.00400, 0.218 at d = 1.70 mm already;" in said
    assert said.endswith("largest at d = 43.80 mm: α0 = 0.220.")
    assert ": first motion at α = 0.0200; then" in said


def test_a_first_peak_that_stays_low_is_not_told():
    results = _with_curve([0.0, 0.001, 0.002, 0.004, 0.1], [0.02, 0.05, 0.03, 0.2, 0.0])
    [said] = [each for each in _plain(onsets(results, words_of(results))) if "+x" in each]
    assert "already" not in said


def test_d_0_where_equilibrium_is_lost_is_said_to_be_that():
    results = _with_curve([0.0, 0.2, 0.371], [0.2, 0.13, 0.0907], lost=True, reached_zero=False)
    words = words_of(results)
    assert alpha_at_d_0(results.states[SETTLED].pushover["+x"].rigid) == 0.0907
    [said] = _plain(lost_before_zero(results, words))
    assert said.endswith(f"state “{SETTLED}”, direction +x (α = 0.0907).")
    [title] = [
        axes.get_title()
        for axes in draw_overturned(results, words, [(SETTLED, "+x")]).axes
        if axes.get_title()
    ]
    assert title.endswith("d₀ = 371\u00a0mm, α = 0.0907")
    figure = draw_pushover(results, words, ["+x"])
    triangles = [line.get_xydata() for line in figure.axes[0].get_lines() if line.get_marker() == "^"]
    assert any(place[0] == pytest.approx([371.0, 0.0907]) for place in triangles)


def test_a_fitted_curve_far_above_the_elastic_one_is_told_with_the_side_it_errs_on():
    results = results_example("en")
    original = results["states"]["original"]
    check = original["capacity"]["+x"]["SLC"]
    curve = original["pushover"]["+x"]["elastic"]["curve"]
    d, alpha = np.array(curve["displacement_m"]), np.array(curve["multiplier"])
    reach = check["d_star_m"] / original["capacity"]["+x"]["gamma_star"]
    curve["displacement_m"] = [*d, float(d[-1] + 2.0 * reach)]
    curve["multiplier"] = [*alpha, float(alpha[-1])]
    shared = typed(results)
    at = np.interp(check["d_star_m"], *elastic_capacity(shared, "original", "+x"))
    for share, told in ((1.1, False), (4.0, True)):
        check["a_star_g"] = float(share * at)
        changed = typed(results)
        found = [
            e
            for e in excesses(changed)
            if (e["state"], e["direction"], e["limit_state"]) == ("original", "+x", "SLC")
        ]
        assert bool(found) == told
        if told:
            assert (found[0]["fitted_g"], found[0]["elastic_g"]) == pytest.approx((share * at, at))
            [said] = _plain(fitted_above(changed, words_of(changed)))
            assert "errs on the unsafe side" in said and "down to 0.50 times" in said
