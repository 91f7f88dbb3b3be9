"""The draft judgement claims nothing that a table contradicts: each sentence is read back and held against them."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.assessment.report.tables.test_study_tables import results_with_studies
from tests.support.analysed import analysed
from tests.support.judgement.claims import CLAIMS, PARTS, WORDS, hold
from tests.support.judgement.random_results import random_results
from tests.support.results_example import results_example


def test_every_text_of_the_judgement_is_a_claim_that_is_checked():
    assert set(WORDS.strings["judgement"]) == CLAIMS.keys() | PARTS


@given(random_results())
@settings(max_examples=25)
def test_every_sentence_agrees_with_the_tables(results):
    hold(results)


@pytest.mark.parametrize(
    "make", [results_example, results_with_studies, analysed], ids=lambda make: make.__name__
)
def test_so_does_every_sentence_of_an_analysis(make):
    keys = hold(make("en"))
    assert {"certificates", "limits"} <= set(keys)
