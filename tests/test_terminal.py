"""What the terminal shows: one table or JSON on standard output, bars on standard error."""

from __future__ import annotations

import json
import sys
from io import StringIO

import pytest

from assessment import figures
from assessment.terminal import Bars
from tests.block_project import edit, read_results
from tests.every_stage import assesto, write_every_stage


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch):
    monkeypatch.setattr(figures, "write_figures", lambda _, folder: folder.mkdir())


@pytest.fixture
def project(tmp_path):
    return write_every_stage(tmp_path / "block")


def test_the_summary_as_json_is_all_there_is_on_standard_output(project, capsys):
    assert assesto(project) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    results = read_results(project / "output")
    rigid = results["states"]["base turned"]["pushover"]["+x"]["rigid"]
    check = results["states"]["base turned"]["capacity"]["+x"]["SLV"]
    assert err == ""
    assert found["complete"] is True
    assert found["capacities"][1] == {
        "state": "base turned",
        "direction": "+x",
        "alpha_0": rigid["alpha_0"],
        "d_0_m": rigid["d_0_m"],
        "limit_state": "SLV",
        "a_g_g": check["a_g_g"],
        "zeta_E": check["zeta_E"],
    }
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
    for stage in ("self-weight: 1", "pushdown: 1", "pushover: 2", "history: 2", "incremental: 2"):
        assert f"· {stage}, " in first.err
    assert "· pushdown: 1, 1 taken over, inputs unchanged, " in second.err
    assert "· pushover: 2, 0." in second.err


def test_the_bar_moves_with_the_analyses():
    from rich.console import Console

    bars = Bars(Console(file=StringIO(), force_terminal=True))
    bars.begin("history", 4, 1)
    bars.under_way("original, history of [wave]")
    bars.advance()
    [task] = bars.progress.tasks
    assert (task.completed, task.total) == (2, 4)
    assert task.description == "history: original, history of [wave]"
    bars.end()
    assert not bars.progress.tasks
