"""Runs that are killed at random moments, a few of those that `python -m tests.stress.kills` tries."""

import os

import pytest

from tests.stress.kills import tried
from tests.stress.test_stress import LONG


@pytest.mark.skipif(os.name != "posix" or not LONG, reason="ASSESTO_STRESS=long, and signals")
def test_nothing_is_lost_and_the_next_run_gives_the_same():
    counts = tried(4, 5)
    assert counts["killed"] == 4 and counts["over earlier results"] and counts["analyses kept"]
