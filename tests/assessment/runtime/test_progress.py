"""What the terminal shows: one table or JSON on standard output, bars on standard error."""

import json
import re
import sys
from io import StringIO
from types import SimpleNamespace

import pytest

from assessment.runtime import progress as terminal
from assessment.runtime.progress import Show, Stage
from tests.support.block_project import edit, read_results
from tests.support.every_stage import assesto, write_every_stage

pytestmark = pytest.mark.usefixtures("no_figures")


@pytest.fixture
def project(tmp_path):
    return write_every_stage(tmp_path / "block")


def test_the_summary_as_json_is_all_there_is_on_standard_output(project, capsys):
    assert assesto(project) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    results = read_results(project / "output")
    assert err == ""
    assert found["complete"] is True
    assert found["summary"] == results["summary"]
    checks = results["states"]["base turned"]["capacity"]["+x"]
    borne = {
        row["limit_state"]: (row["a_g_g"], row["zeta_E"])
        for row in found["verification"]
        if (row["state"], row["direction"]) == ("base turned", "+x")
    }
    assert borne == {name: (checks[name]["a_g_g"], checks[name]["zeta_E"]) for name in ("SLV linear", "SLV")}
    assert [row["state"] for row in found["settlements"]] == ["base turned"]
    assert found["warnings"] == results["model"]["warnings"] + results["quality"]["warnings"]


def test_bars_on_a_terminal(project, capsys, monkeypatch):
    """A line per stage, saying what was taken over; nothing of it on standard output."""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert assesto(project) == 0
    first = capsys.readouterr()
    edit(project, "increment_m = 0.2", "increment_m = 0.1")
    assert assesto(project) == 0
    second = capsys.readouterr()
    json.loads(second.out)
    for stage in ("self-weight: 1", "pushdown: 1", "pushover: 2", "history: 2", "incremental: "):
        assert f"· {stage}" in first.err
    assert "· pushdown: 1, 1 taken over, inputs unchanged, " in second.err
    assert re.search(r"· pushover: 2, \d", second.err)


@pytest.fixture
def clock(monkeypatch):
    """The time that bars are drawn at, s."""
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(terminal, "time", SimpleNamespace(time=lambda: clock.now))
    return clock


@pytest.fixture
def bars(clock):
    from rich.console import Console

    return Show(Console(file=StringIO(), force_terminal=True, width=120))


@pytest.fixture
def shown(bars):
    """What bars show, without colours."""

    def drawn(width: int = 120) -> str:
        from rich.console import Console

        console = Console(file=StringIO(), force_terminal=True, width=width)
        with console.capture() as capture:
            console.print(bars.bars.get_renderable())
        return re.sub(r"\x1b\[[0-9;]*m", "", capture.get())

    return drawn


def test_the_time_left_is_known_before_an_analysis_is_finished(clock, bars, shown):
    """Two of four were taken over. A third of one takes 30 s, as do the other five thirds: 150 s are left."""
    bars.begin(stage := Stage("pushover", 4, 2, 2.0, clock.now))
    assert "left -:--:--" in shown()
    clock.now += 30.0
    stage.reach(1.0 / 3.0)
    assert "left 0:02:30" in shown()
    clock.now += 60.0
    assert "left 0:01:30" in shown()
    stage.reach(1.0)
    assert "left 0:01:30" in shown()
    clock.now += 30.0
    assert "left 0:01:00" in shown()
    clock.now += 70.0
    assert "left longer than expected" in shown(), "it said 0:00:00 while nothing ended"
    stage.reach(2.0)
    assert "left 0:00:00" in shown()
