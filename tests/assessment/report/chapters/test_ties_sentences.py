"""What is said of ties: pretension that is lost, tensions beside the yield force; and of motions that collapse."""

from markupsafe import Markup

from assessment.report.chapters.remarks import nearly_yielding, slackened
from assessment.report.figures.motions import draw_shapes
from assessment.report.language import words_of
from assessment.report.tables.structure import shaken_ties
from tests.support.results_example import results_example
from tests.support.typed import typed

TIE = {
    "name": "chain",
    "start_m": [0.0, 1.0],
    "end_m": [1.0, 1.0],
    "blocks": [1, 5],
    "yield_force_kN": 120.0,
    "stiffness_kN_m": 25000.0,
    "pretension_kN": 20.0,
    "states": ["original"],
    "set_in": [],
}
HISTORY = {
    "record": "rec",
    "pga_g": 0.3,
    "scale": 1.0,
    "time_step_s": 0.01,
    "contacts": "elastic",
    "integrator": "second-order",
    "amplitude": 1.0,
    "control": "C1",
    "peak_displacement_m": 0.229,
    "residual_displacement_m": None,
    "collapsed": True,
    "time_of_collapse_s": 5.32,
    "reason": "block 3 has fallen by 0.4 m",
    "sustained_displacement_m": 0.06,
    "time_of_peak_s": 2.34,
    "curve": {"time_s": [0.0, 2.34, 5.32], "displacement_m": [0.0, -0.06, -0.229]},
}
MOTION = {"name": "rec", "pga_g": 0.3, "scale": 1.0, "window_s": [0.0, 10.0], "vertical": False}


def _tied(**tension):
    results = results_example("en")
    results["model"]["ties"] = [TIE]
    found = {"tie": "chain", "rest_kN": 15.0, "peak_kN": 60.0, "greatest_kN": 90.0, "yields": False} | tension
    results["states"]["original"]["pushover"]["+x"]["elastic"]["ties"] = [found]
    return results


def _said(sentences, results):
    shared = typed(results)
    return [Markup(each).striptags() for each in sentences(shared, words_of(shared))]


def test_a_pretension_of_which_less_than_half_is_left_is_told():
    assert not _said(slackened, _tied(rest_kN=10.1))
    [said] = _said(slackened, _tied(rest_kN=3.28))
    assert said.startswith(
        "Of the pretension of 20.0 kN of the tie “chain” 3.28 kN are left at rest, in state"
    )


def test_a_tie_just_below_its_yield_force_is_not_passed_over():
    assert not _said(nearly_yielding, _tied(greatest_kN=110.0))
    assert not _said(nearly_yielding, _tied(greatest_kN=120.0, yields=True))
    [said] = _said(nearly_yielding, _tied(greatest_kN=119.99))
    assert "119.990 kN, 99.99 % of its yield force" in said


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
