"""No test fails because the machine is busy: none limits the time on the wall."""

import re
from pathlib import Path

from tests import ROOT

CLOCKS = r"perf_counter\(|monotonic\(|time\.time\(|timeout=[\d.]|deadline=[\d.]|\.poll\([\d.]|\.join\([\d.]"
LIMITS_NOTHING = {ROOT / "tests" / "stress" / "kills.py"}  # it draws moments from the time a run takes


def test_no_time_on_the_wall_is_measured():
    """What hangs is ended by faulthandler_timeout; the clocks of test_benchmark and test_terminal are their own."""
    sources = {*(ROOT / "tests").rglob("*.py")} - {Path(__file__), *LIMITS_NOTHING}
    assert [path for path in sorted(sources) if re.search(CLOCKS, path.read_text(encoding="utf-8"))] == []
