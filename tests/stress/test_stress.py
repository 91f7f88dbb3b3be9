"""Every stress case ends certified or in the refusal that it may meet, never in a NaN, a hang or a crash."""

from __future__ import annotations

import os
import signal
from functools import partial

import numpy as np
import pytest

from mechanics.errors import UnstableError
from mechanics.procedures.limit_analysis import Limit
from mechanics.program import Certificate
from tests.stress.cases import CASES
from tests.stress.harness import Case, Outcome, apart, judge, sound, table
from tests.structures import block_on_base

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


def fault(kind: str) -> None:
    """Go wrong in a way that the harness must see."""
    if kind == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif kind == "hang":
        while True:
            pass
    elif kind == "NaN":
        sound(limit_with(np.nan))
    elif kind == "certificate":
        sound(Certificate(1e-5, 0.0, 0.0, 0.0, 0.0))
    elif kind == "unnamed refusal":
        raise ValueError("bad")


def limit_with(alpha: float) -> Limit:
    return Limit(
        alpha,
        np.zeros((1, 3)),
        np.zeros((1, 3)),
        block_on_base().contacts,
        Certificate(0.0, 0.0, 0.0, 0.0, 0.0),
    )


@pytest.mark.parametrize("kind", ["crash", "hang", "NaN", "certificate", "unnamed refusal"])
def test_the_harness_sees_what_goes_wrong(kind, monkeypatch):
    monkeypatch.setattr("tests.stress.harness.SECONDS", 1)
    outcome = apart(Case("harness", kind, partial(fault, kind), (UnstableError,)))
    assert outcome.verdict == "failed"
    assert outcome.words == "no answer within 1 s of processor time" if kind == "hang" else outcome.words


def test_an_answer_where_there_is_none_is_a_failure():
    answered = Case("harness", "answered", partial(fault, "nothing"), (UnstableError,), must_refuse=True)
    assert judge(answered).verdict == "failed"


def test_the_table_counts():
    case = Case("g", "n", partial(fault, "nothing"))
    rows = table(
        [(case, Outcome("certified")), (case, Outcome("refused")), (case, Outcome("failed"))]
    ).splitlines()
    assert rows[-2:] == ["| g | 3 | 1 | 1 | 1 |", "| **all** | 3 | 1 | 1 | 1 |"]
