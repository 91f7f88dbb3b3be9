"""What a run is at, on the terminal, from another one and after a kill; one run at a time in a folder."""

import json
import os
import re
import subprocess
import sys
from io import StringIO
from types import SimpleNamespace

import pytest

from assessment.cli.main import main
from assessment.runtime import progress as terminal
from assessment.runtime.progress import (
    LOCK,
    NAME,
    BusyError,
    Show,
    Stage,
    locked,
    read_journal,
    record_exit,
    status,
)
from tests.support.block_project import ROOT, edit, read_results, run
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


def shown_in(folder):
    """What keeps the journal of a folder, and writes whatever changes."""
    show = Show(every=0.0)
    show.keep_in(folder)
    return show


def test_stages_failures_and_the_time_left_are_told(tmp_path):
    with locked(tmp_path):
        show = shown_in(tmp_path)
        show.begin(stage := Stage("campaign", 10, 4, 600.0))
        show.failed(stage, "wave", ["a step was not solved"])
        stage.done, stage.reached, stage.latest = 2, 200.0, stage.began
        show.changed(stage)
        told = status(tmp_path)
        [stage] = read_journal(tmp_path).stages
        stage.began, stage.latest = 0.0, 20.0
    assert stage.open == 4 and stage.left(0.0) == pytest.approx(60.0)
    assert told.startswith("at work: process ")
    assert "campaign: 6 of 10 done (4 taken over), 1 failed, 4 in flight or waiting" in told
    assert "  failed: wave: a step was not solved" in told
    assert status(tmp_path).startswith("not at work: the run was interrupted or killed")


def test_a_folder_in_which_nothing_has_been_run(tmp_path):
    assert status(tmp_path) == f"nothing has been run in {tmp_path}"
    (tmp_path / "results.json").touch()
    assert status(tmp_path).startswith("results of an earlier run: ")


@pytest.mark.parametrize(
    ("code", "last"), [(2, "correct the input that it names"), (3, "finished analyses are kept")]
)
def test_what_is_to_be_done_follows_from_the_exit_code(tmp_path, code, last):
    with locked(tmp_path):
        shown_in(tmp_path).begin(Stage("pushover", 1, 0, 1.0))
        record_exit(tmp_path, code)
    assert last in status(tmp_path).splitlines()[-1]


def test_status_as_json_has_where_the_run_is_and_how_it_ended(tmp_path, capsys):
    output = tmp_path / "output"

    def told():
        assert main(["status", str(tmp_path), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    assert told()["stage"] is None and told()["exit_code"] is None
    with locked(output):
        show = shown_in(output)
        show.begin(stage := Stage("pushover", 1, 0, 1.0))
        show.failed(stage, "wall +x", ["no capacity"])
        stage.done = 1
        show.end(stage)
        show.begin(stage := Stage("campaign", 10, 4, 600.0, done=1, reached=100.0))
        stage.latest = stage.began + 1.0
        show.changed(stage, "wave, +x")
        found = told()
        rest = read_journal(output).stages[-1]
    assert found["running"] is True and found["pid"] == os.getpid() and found["exit_code"] is None
    assert [found[key] for key in ("stage", "done", "total", "failed", "under_way")] == [
        "campaign", 5, 10, 1, "wave, +x"
    ]  # fmt: skip
    assert 0.0 <= found["seconds_left"] <= rest.left(rest.began)
    assert found["stages"][0]["failures"] == [{"title": "wall +x", "reasons": ["no capacity"]}]
    record_exit(output, 3)
    found = told()
    assert (found["running"], found["exit_code"], found["seconds_left"]) == (False, 3, None)


STAGE = '"name": "campaign", "total": 3, "taken": 0, "work": 3.0, "began": 1.0, "latest": 2.0'
DAMAGED = (
    "1", "[1]", "{}, {}", "[" * 100_000, '{"stages": 3}', '{"stages": [{}]}', '{"exit_code": "x"}',
    f'{{"stages": [{{{STAGE}, "done": "x"}}]}}', f'{{"stages": [{{{STAGE}, "reached": 1e400}}]}}',
    f'{{"stages": [{{{STAGE}, "since": NaN}}]}}', f'{{"stages": [{{{STAGE}, "faults": [3]}}]}}',
)  # fmt: skip


@pytest.mark.parametrize("text", DAMAGED)
def test_a_journal_that_no_run_wrote_is_none(tmp_path, text):
    (tmp_path / NAME).write_text(text, encoding="utf-8")
    assert status(tmp_path).startswith("nothing has been run in")


HOLD = """
import sys, pathlib, assessment.runtime.progress as lock
with lock.locked(pathlib.Path(sys.argv[1])):
    input(print('held'))
"""


def test_a_second_run_is_refused_and_told_by_which_process(project, capsys):
    with locked(project / "output"):
        assert run(project) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {project / 'output' / LOCK}: another run is writing into this folder")
    assert f"(process {os.getpid()} on " in said
    assert said.count("\n") == 1
    assert not (project / "output").exists()


def test_a_killed_run_holds_nothing(tmp_path):
    held = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert held.stdout is not None
    assert held.stdout.readline() == b"held\n"
    with pytest.raises(BusyError, match=f"process {held.pid} on "), locked(tmp_path):
        pass
    held.kill()
    held.communicate()
    assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()


def test_who_waits_for_a_lock_that_is_removed_meanwhile_gets_one_that_others_see(tmp_path):
    """The run before removes its file: who has opened it just before would hold a lock that nobody else sees."""
    with locked(tmp_path):
        (tmp_path / LOCK).unlink()
        (tmp_path / LOCK).touch()  # as of another run, which begins
        with locked(tmp_path), pytest.raises(BusyError), locked(tmp_path):
            pass
