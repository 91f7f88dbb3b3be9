"""The report on the multiplier by a second program: table, which multiplier, and why there is none."""

from __future__ import annotations

import pytest

from assessment.report.chapters.remarks import agreement
from assessment.report.chapters.remarks import second_solver as comparison
from assessment.report.language import cell, words_of
from assessment.report.tables.mechanisms import second_solver
from tests.support.results_example import results_example
from tests.support.typed import typed

NOTHING = {"alpha_0": 0.1, "alpha_program": 0.1, "alpha_linear_program": None, "relative_difference": None}


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


def test_the_judgement_says_whether_they_agree():
    words = words_of(example())
    assert "the same multipliers" in next(iter(agreement(example(found=pair()), words)))
    assert "must be explained" in next(iter(agreement(example(found=pair(-2e-3)), words)))
    [missing] = agreement(example(found=NOTHING), words)
    assert missing.startswith("Multipliers that could not be compared") and ": 4;" in missing
