"""No test fails because the machine is busy: none limits the time on the wall."""

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests import ROOT

CLOCKS = r"perf_counter\(|monotonic\(|time\.time\(|timeout=[\d.]|deadline=[\d.]|\.poll\([\d.]|\.join\([\d.]"
LIMITS_NOTHING = {ROOT / "tests" / "stress" / "kills.py"}  # it draws moments from the time a run takes
SOURCES = sorted({*(ROOT / "tests").rglob("*.py")} - {Path(__file__), *LIMITS_NOTHING})


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_no_time_on_the_wall_is_measured(path):
    """What hangs is ended by faulthandler_timeout; the clocks of test_benchmark and test_terminal are their own."""
    assert not re.findall(CLOCKS, path.read_text(encoding="utf-8"))


def test_no_example_of_hypothesis_is_too_slow():
    """By default one fails after 0.2 s, or because its data took long to draw."""
    assert settings.default.deadline is None
    assert HealthCheck.too_slow in settings.default.suppress_health_check
