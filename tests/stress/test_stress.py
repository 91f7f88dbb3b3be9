"""Stress cases end certified or in the refusal that they may meet, never in a NaN, a hang or a crash.

A sample of every group, and what is open; `python -m tests.stress` runs all of them, as ASSESTO_STRESS=long does here.
"""

import os
import signal
from dataclasses import replace
from functools import partial
from itertools import groupby

import numpy as np
import pytest

from mechanics.errors import UnstableError
from mechanics.procedures.limit_analysis import limit_analysis
from mechanics.program import Certificate
from tests.stress.cases import CASES
from tests.stress.harness import Case, apart, judge, sound
from tests.support.structures import block_on_base

LONG = os.environ.get("ASSESTO_STRESS") == "long"
# what the program does not yet decide, nor refuse in the words that it should have
OPEN = {
    "lengths of 1 µm beside 10 m": (
        "1 µm beside 10 m: ledge of 1e-06 m",
        "1 µm beside 10 m: ledge of 0.0001 m",
    )
}
REASON = {label: reason for reason, labels in OPEN.items() for label in labels}


SAMPLE = 6  # of the cases of a group the first and every sixth are run every time


def chosen() -> list[object]:
    """The labels to run; those of what is open are expected to fail."""
    groups = [list(group) for _, group in groupby(CASES.values(), key=lambda case: (case.group, case.long))]
    sample = {case.label for group in groups for case in group[::SAMPLE] if not case.long} | REASON.keys()
    return [
        pytest.param(label, marks=pytest.mark.xfail(strict=True, reason=f"open: {REASON[label]}"))
        if label in REASON
        else label
        for label in CASES
        if LONG or label in sample
    ]


@pytest.mark.parametrize("label", chosen())
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


def limit_with(alpha: float):
    return replace(limit_analysis(block_on_base()), alpha=alpha)


@pytest.mark.parametrize("kind", ["crash", "hang", "NaN", "certificate", "unnamed refusal"])
def test_the_harness_sees_what_goes_wrong(kind):
    outcome = apart(Case("harness", kind, partial(fault, kind), (UnstableError,)), seconds=1)
    assert outcome.verdict == "failed"
    assert outcome.words
    if kind == "hang":
        assert outcome.words == "no answer within 1 s of processor time"


def test_an_answer_where_there_is_none_is_a_failure():
    answered = Case("harness", "answered", partial(fault, "nothing"), (UnstableError,), must_refuse=True)
    assert judge(answered).verdict == "failed"
