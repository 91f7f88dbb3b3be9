"""Cases in which the draft judgement once said what a table contradicts, or left out what counts."""

from __future__ import annotations

import re

from markupsafe import Markup

from assessment.report.chapters.judgement import draft_judgement
from assessment.report.figures.curves import draw_pushdown
from assessment.report.figures.drawings.deformed import draw_settlement
from assessment.report.text.language import words_of
from tests.assessment.report.tables.test_study_tables import results_with_studies
from tests.support.analysed import analysed
from tests.support.judgement.claims import REFERENCES, Results, hold
from tests.support.judgement.random_results import summed_up
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def text_of(results: Results) -> str:
    hold(results)
    return " ".join(draft_judgement(typed(results), words_of(typed(results))))


def capacity_of(results: Results, state: str, direction: str, check: str, a_g: float | None) -> None:
    """Give a check another result."""
    found = results["states"][state]["capacity"][direction].setdefault(check, {"demand_a_g_g": 0.261})
    ratio = None if a_g is None else a_g / found["demand_a_g_g"]
    found |= {"a_g_g": a_g, "zeta_E": ratio, "verified": None if ratio is None else ratio >= 1.0}


def rising(results: Results) -> Results:
    """Every capacity rises with the settlement, by a tenth."""
    for direction, capacity in results["states"]["original"]["capacity"].items():
        for check in ("SLD", "SLV", "SLC"):
            capacity_of(results, SETTLED, direction, check, 1.1 * capacity[check]["a_g_g"])
    return results


def test_a_loss_at_another_limit_state_than_the_farthest_is_told():
    """ "None of the movements reduces the capacity" stood beside SLV −3.7 %: SLC alone was compared."""
    results = rising(results_example("en"))
    assert "The largest reduction" not in text_of(results)
    before = results["states"]["original"]["capacity"]["-x"]["SLV"]["a_g_g"]
    capacity_of(results, SETTLED, "-x", "SLV", (1.0 - 0.037) * before)
    text = text_of(results)
    assert f"whole movement: state “{SETTLED}”, direction −x: 3.7 % (SLV)." in text
    assert " at SLV: none" not in text
    assert all(f"borne, {REFERENCES[False]}, at {check}: none" in text for check in ("SLC", "SLD"))


ACCELERATION = re.compile(r"\d g\b|of the a_g borne|no a_g borne|The a_g borne")


def sentences(results: Results) -> list[str]:
    return [Markup(each).striptags() for each in draft_judgement(typed(results), words_of(typed(results)))]


def test_a_sentence_that_prints_an_acceleration_says_what_it_refers_to():
    """Chapter 1 alone said that a_g is on rock, without S; the judgement is read, and quoted, without it."""
    for make in (results_example, results_with_studies, analysed):
        found = [
            each
            for each in sentences(make("en"))
            if ACCELERATION.search(each.replace("ag borne", "a_g borne"))
        ]
        assert len(found) >= 2
        assert [
            each for each in found if REFERENCES[False] not in each and "at the surface" not in each
        ] == []


def test_reductions_are_one_sentence_with_the_ranges_that_results_have():
    """a_g of 0.2 (0.2 to 0.25 g) falls to 0.1 (0.1 to 0.12 g): by 50 %, by 1 − 0.12/0.2 = 40 to 1 − 0.1/0.25 = 60 %.

    Five items of a list began with the same words.
    """
    results = results_example("en")
    for state, a_g, highest in (("original", 0.2, 0.25), (SETTLED, 0.1, 0.12)):
        for direction in ("+x", "-x"):
            capacity_of(results, state, direction, "SLC", a_g)
        results["states"][state]["capacity"]["+x"]["SLC"]["a_g_g_range"] = [a_g, highest]
        capacity_of(results, state, "-x", "SLC", 0.2)
    said = [each for each in sentences(results) if each.startswith("Largest reduction")]
    assert len(said) == 1 and said[0].count("state “") == 1 and "% (SLV)" in said[0]
    assert "50 % (SLC; 40 to 60 % with the ranges of both states)" in said[0]
    results["states"][SETTLED]["capacity"]["+x"]["SLC"]["a_g_g_range"] = [0.1, None]
    assert "50 % (SLC)" in " ".join(sentences(results))


def test_a_settled_state_without_a_result_is_no_state_without_loss():
    results = rising(results_example("en"))
    capacity_of(results, SETTLED, "-x", "SLC", None)
    text = text_of(results)
    assert (
        " at SLC: none" not in text
        and "was found at: SLC." in text
        and "; 1 of 12 that were asked for could not be carried out" in text
    )
    del results["states"][SETTLED]["capacity"]["+x"]
    assert f"no a<sub>g</sub> borne, {REFERENCES[False]}, was found at: SLD, SLV, SLC." in text_of(results)


def test_the_linear_check_may_be_the_least_favourable_and_sld_is_no_index():
    """SLD 0.119 was named, as ζ_E, where Table 8 has 0.0975 at SLV, linear."""
    results = results_example("en")
    capacity_of(results, SETTLED, "-x", "SLD", 0.119 * 0.104)
    capacity_of(results, SETTLED, "-x", "SLV linear", 0.0975 * 0.261)
    first, second, *_ = draft_judgement(typed(results), words_of(typed(results)))
    assert f"is that at SLV, linear (state “{SETTLED}”, direction −x)" in first and "ratio 0.098" in first
    assert "ζ" not in first and "ζ" in second and "SLD" not in second
    keys = hold(results)
    assert keys[:2] == ["governing", "zeta"]
    only = results_example("en")
    for content in only["states"].values():
        for capacity in content["capacity"].values():
            del capacity["SLV"], capacity["SLC"]
    assert "ζ" not in text_of(only)


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
    """The largest displacement of a pure rotation is 0: the sentence was left out, and the line of the plot."""
    results = results_example("en")
    results["states"][SETTLED]["settlement"] |= {"displacement_m": [0.0, 0.0], "rotation_rad": 0.01}
    text = text_of(results)
    assert "rigid contacts: the movement of 20.0 mm is 31 % of the ultimate one (65.0 mm)." in text
    found = typed(results)
    labels = [line.get_label() for line in draw_pushdown(found, words_of(found), SETTLED).axes[0].lines]
    assert "assigned movement, 20.0 mm" in labels
    arrows = list(draw_settlement(found, words_of(found), SETTLED).axes[0].texts)
    assert len(arrows) == 1 and arrows[0].arrowprops["connectionstyle"] == "arc3,rad=1.0"  # anticlockwise


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


def test_the_italian_draft_says_the_same():
    """Both languages are filled from the same fields: as many sentences, the same numbers."""
    english, italian = (
        [
            sorted(re.findall(r"\d+(?:\.\d+)?", text.replace(",", ".")))
            for text in draft_judgement(typed(results), words_of(typed(results)))
        ]
        for results in (analysed("en"), analysed("it"))
    )
    assert english == italian
