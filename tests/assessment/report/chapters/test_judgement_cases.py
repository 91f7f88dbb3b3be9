"""Cases in which the draft judgement once said what a table contradicts, or left out what counts."""

from __future__ import annotations

from assessment.report.chapters.judgement import draft_judgement
from assessment.report.language import NO_BREAK, words_of
from tests.support.judgement.claims import Results, hold
from tests.support.judgement.random_results import summed_up
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def text_of(results: Results) -> str:
    hold(results)
    return " ".join(draft_judgement(typed(results), words_of(typed(results)))).replace(NO_BREAK, " ")


def test_a_mechanism_chosen_by_the_engineer_is_not_forgotten():
    results = results_example("en")
    check = {
        "a_g_g": 0.01,
        "demand_a_g_g": 0.261,
        "zeta_E": 0.038,
        "verified": False,
        "return_period_years": None,
    }
    given_mechanism = {
        "name": "gable",
        "state": "original",
        "direction": "+x",
        "alpha_0": 0.1,
        "SLV linear": check,
    }
    results["mechanisms"] = [given_mechanism]
    assert "“gable”, SLV, linear, state “original”: ratio 0.038" in text_of(results)


def test_a_turn_of_a_support_has_its_margin():
    """The largest displacement of a pure rotation is 0: the sentence was left out."""
    results = results_example("en")
    results["states"][SETTLED]["settlement"] |= {"displacement_m": [0.0, 0.0], "rotation_rad": 0.01}
    text = text_of(results)
    assert "rigid contacts: the movement of 20.0 mm is 31 % of the ultimate one (65.0 mm)." in text


def test_a_collapse_before_the_whole_movement_is_no_margin():
    results = results_example("en")
    results["states"][SETTLED]["pushdown"]["rigid"]["ultimate_movement_m"] = 0.015
    assert "is 133 % of the ultimate one (15.0 mm): the structure collapses before." in text_of(results)


def test_poor_certificates_and_a_poor_hand_check_are_not_hidden():
    for name, residual in (
        ("equilibrium_residual", 1e-4),
        ("cone_violation", 1e-3),
        ("complementarity", 0.1),
    ):
        results = results_example("en")
        results["quality"]["by_stage"][1][f"worst_{name}"] = residual
        results["quality"] = summed_up(results["quality"])
        assert "must be checked" in text_of(results)
    results = results_example("en")
    results["states"]["original"]["pushover"]["+x"]["rigid"]["virtual_work_alpha"] = 0.2
    assert "must be explained" in text_of(results)
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    rigid["virtual_work_alpha"] = 0.5 * rigid["mechanism"]["alpha"]  # the rest is what sliding joints take
    rigid["mechanism"]["sliding_joints"] = [0]
    assert "leaves out the work of friction" in text_of(results)
    rigid["mechanism"]["sliding_joints"] = []
    assert "must be explained" in text_of(results)
