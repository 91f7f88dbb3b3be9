"""Remarks: curves, overlaps, ties, the second solver; and motions that collapse."""

import numpy as np
import pytest
from markupsafe import Markup

from assessment.report.chapters.remarks import fitted_above, lost_before_zero, onsets, overlaps, slackened
from assessment.report.chapters.remarks import second_solver as comparison
from assessment.report.figures.curves import draw_pushover
from assessment.report.figures.deformed import draw_overturned
from assessment.report.figures.motions import draw_shapes
from assessment.report.language import cell, words_of
from assessment.report.tables.mechanisms import alpha_at_d_0, elastic_capacity, excesses, second_solver
from assessment.report.tables.structure import shaken_ties
from assessment.results.schema import Results
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def _with_curve(displacement, multiplier, **changes):
    results = results_example("en")
    rigid = results["states"][SETTLED]["pushover"]["+x"]["rigid"]
    rigid["curve"] = {"displacement_m": displacement, "multiplier": multiplier}
    rigid |= {"alpha_onset": multiplier[0], "alpha_0": max(multiplier), "d_0_m": displacement[-1]}
    rigid |= changes
    return typed(results)


def _said(sentences, results):
    shared = results if isinstance(results, Results) else typed(results)
    return [Markup(each).striptags() for each in sentences(shared, words_of(shared))]


def test_a_later_peak_is_not_said_to_be_where_the_hinges_close():
    results = _with_curve([0.0, 0.0, 0.0017, 0.04, 0.0438, 0.1], [0.02, 0.004, 0.2178, 0.2048, 0.2197, 0.0])
    [said] = [each for each in _said(onsets, results) if "+x" in each]
    assert "; then as little as 0.00400;" in said
    assert said.endswith("at d = 43.80 mm the largest that, held, is borne: α0 = 0.220.")
    assert ": first motion at α = 0.0200; then" in said


def test_d_0_where_equilibrium_is_lost_is_said_to_be_that():
    results = _with_curve([0.0, 0.2, 0.371], [0.2, 0.13, 0.0907], lost=True, reached_zero=False)
    words = words_of(results)
    assert alpha_at_d_0(results.states[SETTLED].pushover["+x"].rigid) == 0.0907
    [said] = _said(lost_before_zero, results)
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
            [said] = _said(fitted_above, changed)
            assert "errs on the unsafe side" in said and "down to 0.50 times" in said


def _overlapping(penetration, language):
    results = results_example(language)
    row = {"state": "original", "stage": "pushover, elastic", "solves": 3, "worst_complementarity": 0.0}
    row |= {"worst_equilibrium_residual": 0.0, "worst_penetration_m": penetration}
    results["quality"]["by_stage"] = [row]
    return _said(overlaps, results)


def test_an_overlap_of_more_than_a_hundredth_of_a_block_is_told_with_where():
    assert not _overlapping(1e-6, "en")
    [english], [italian] = _overlapping(0.0392, "en"), _overlapping(0.0392, "it")
    assert "in: original, pushover, elastic contacts: 39.2 mm. " in english
    assert "in: originale, pushover, giunti elastici: 39,2 mm. " in italian


TIE = {
    "name": "chain", "start_m": [0.0, 1.0], "end_m": [1.0, 1.0], "blocks": [1, 5], "yield_force_kN": 120.0,
    "stiffness_kN_m": 25000.0, "pretension_kN": 20.0, "states": ["original"], "set_in": [],
}  # fmt: skip
HISTORY = {
    "record": "rec", "pga_g": 0.3, "scale": 1.0, "time_step_s": 0.01, "contacts": "elastic",
    "integrator": "second-order", "amplitude": 1.0, "control": "C1", "peak_displacement_m": 0.229,
    "residual_displacement_m": None, "collapsed": True, "time_of_collapse_s": 5.32,
    "reason": "block 3 has fallen by 0.4 m", "sustained_displacement_m": 0.06, "time_of_peak_s": 2.34,
    "curve": {"time_s": [0.0, 2.34, 5.32], "displacement_m": [0.0, -0.06, -0.229]},
}  # fmt: skip
MOTION = {"name": "rec", "pga_g": 0.3, "scale": 1.0, "window_s": [0.0, 10.0]}


def _tied(**tension):
    results = results_example("en")
    results["model"]["ties"] = [TIE]
    found = {"tie": "chain", "rest_kN": 15.0, "peak_kN": 60.0, "greatest_kN": 90.0, "yields": False} | tension
    results["states"]["original"]["pushover"]["+x"]["elastic"]["ties"] = [found]
    return results


def test_a_pretension_of_which_less_than_half_is_left_is_told():
    assert not _said(slackened, _tied(rest_kN=10.1))
    [said] = _said(slackened, _tied(rest_kN=3.28))
    assert said.startswith(
        "Of the pretension of 20.0 kN of the tie “chain” 3.28 kN are left at rest, in state"
    )


def test_a_tie_that_yields_between_two_instants_has_its_yield_force_in_the_table():
    results = _tied()
    for greatest, yields, shown, time in ((117.0, True, 120.0, None), (117.0, False, 117.0, 4.76)):
        shaken = {"tie": "chain", "greatest_kN": greatest, "time_s": 4.76, "yields": yields}
        results["states"]["original"]["history"] = [HISTORY | {"ties": [shaken]}]
        [row] = shaken_ties(typed(results)).rows
        assert (row["greatest_kN"], row.get("time_of_greatest_s")) == (shown, time)


def test_what_a_collapsing_structure_withstood_is_not_called_its_peak():
    results = results_example("en")
    at = results["states"]["original"]["configuration"]
    motion = MOTION | {key: [0.0, 1.0] for key in ("time_s", "acceleration_g", "T_s", "S_a_g", "S_d_m")}
    results["motions"] = [motion]
    results["states"]["original"]["history"] = [
        HISTORY | {"peak_configuration": at, "final_configuration": at}
    ]
    shared = typed(results)
    titles = [axes.get_title() for axes in draw_shapes(shared, words_of(shared), "original", 0).axes]
    assert titles == ["Largest withstood before collapse, 2.34\u00a0s", "At collapse, 5.32\u00a0s"]


def example(language="en", sliding="associative", found=None):
    """The example whose rigid curves have a comparison, or None in its place."""
    results = results_example(language)
    for state in results["states"].values():
        for pushover in state["pushover"].values():
            pushover["rigid"] |= {"sliding": sliding, "second_solver": found}
    return typed(results)


def pair(difference=3e-10):
    return {
        "alpha_0": 0.13,
        "alpha_program": 0.123456789,
        "alpha_linear_program": 0.123456789 * (1.0 + difference),
        "relative_difference": difference,
    }


def test_the_table_has_enough_digits_to_compare():
    results = example("it", found=pair())
    words = words_of(results)
    rows = second_solver(results).rows
    differences = [str(cell("relative_difference", row, words, 5)) for row in rows]
    assert differences == [words.number(3e-10, 2)] * 4
    text = " ".join(comparison(results, words))
    assert "HiGHS" in text and "Coulomb" not in text
    from assessment.report.chapters.grids import printed_tables

    cells = printed_tables(results, words)["second_solver"].rows[0]
    assert cells.count("0,12346") == 2


@pytest.mark.parametrize(
    ("language", "said"),
    [("en", "α<sub>0</sub> may be another"), ("it", "α<sub>0</sub> può esserne diverso")],
)
def test_with_coulomb_friction_it_says_which_multiplier_is_compared(language, said):
    results = example(language, "coulomb", pair())
    text = " ".join(comparison(results, words_of(results)))
    assert said in text and "Coulomb" in text
