"""Every stress case ends certified or in the refusal that it may meet, never in a NaN, a hang or a crash."""

from __future__ import annotations

import os

import pytest

from tests.stress.cases import CASES
from tests.stress.harness import apart

LONG = os.environ.get("ASSESTO_STRESS") == "long"


@pytest.mark.parametrize(
    "label",
    [
        pytest.param(label, marks=pytest.mark.skipif(case.long and not LONG, reason="ASSESTO_STRESS=long"))
        for label, case in CASES.items()
    ],
)
def test_certified_or_refused(label):
    outcome = apart(CASES[label])
    assert outcome.verdict != "failed", outcome.words
