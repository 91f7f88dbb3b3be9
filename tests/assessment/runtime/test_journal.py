"""What a run is at, told from another terminal and after a kill; a killed run goes on where it was."""

from __future__ import annotations

import json
import os
import time
from types import SimpleNamespace

import pytest

from assessment.cli.main import main
from assessment.results.file import as_bytes
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.files import journal as journals
from assessment.runtime.files.journal import NAME, journal, read_journal
from assessment.runtime.files.lock import locked
from assessment.runtime.show import Show
from assessment.runtime.terminal import status as statuses
from assessment.runtime.terminal.status import status
from tests.support.block_project import contents, read_results, timeless
from tests.support.campaign_project import STRIPES, write_campaign
from tests.support.forked import forked
from tests.support.results_example import results_example
from tests.support.typed import typed


def test_stages_failures_and_the_time_left_are_told(tmp_path):
    with locked(tmp_path), journal(tmp_path, Show()) as show:
        show.begin("campaign", 10, 4, 600.0)
        show.fault("wave", ["a step was not solved"])
        show.advance(100.0)
        show.advance(200.0)
        told = status(tmp_path)
        [stage] = read_journal(tmp_path)
        stage.pace.began, stage.pace.latest = 0.0, 20.0
    assert stage.open == 4 and stage.pace.ends == pytest.approx(60.0)
    assert told.startswith("at work: process ")
    assert "campaign: 6 of 10 done (4 taken over), 1 failed, 4 in flight or waiting" in told
    assert "  failed: wave: a step was not solved" in told
    assert not (tmp_path / NAME).exists()
    assert status(tmp_path).startswith("nothing has been run in")


def test_the_time_left_is_told_before_an_analysis_is_finished(tmp_path, monkeypatch):
    """It was not known before; what is reached is written seldom, however often it is told."""
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(journals, "time", SimpleNamespace(time=lambda: clock.now))
    monkeypatch.setattr(statuses, "time", SimpleNamespace(time=lambda: clock.now))
    with locked(tmp_path), journal(tmp_path, Show()) as show:
        show.begin("history", 1, 0, 500.0)
        clock.now += 0.5
        show.reached(10.0)
        assert "left: not known yet" in status(tmp_path)
        clock.now += 39.5
        show.reached(100.0)
        assert "history: 0 of 1 done, 1 in flight or waiting; 0:00:40 gone, left: 0:02:40" in status(tmp_path)
        clock.now += 60.0
        assert "0:01:40 gone, left: 0:01:40" in status(tmp_path)
        clock.now += 200.0
        assert "0:05:00 gone, left: longer than expected" in status(tmp_path)
        clock.now -= 200.0
        lines = len((tmp_path / NAME).read_text().splitlines())
        for number in range(100):
            clock.now += 0.1
            show.reached(200.0 + number)
        assert 5 <= len((tmp_path / NAME).read_text().splitlines()) - lines <= 10


def test_a_line_that_a_kill_cut_short_is_left_out(tmp_path):
    lines = [
        {"event": "begin", "stage": "campaign", "total": 3, "taken": 0, "work": 3.0, "time": 1.0},
        {"event": "done", "work": 1.0, "time": 2.0},
    ]
    (tmp_path / NAME).write_text("\n".join(map(json.dumps, lines)) + '\n{"event": "do')
    [stage] = read_journal(tmp_path)
    assert (stage.done, stage.open) == (1, 2)
    assert status(tmp_path).splitlines() == [
        "not at work: the run was interrupted or killed",
        "campaign: 1 of 3 done",
        "finished analyses are kept: run again to go on",
    ]


BEGUN = '{"event": "begin", "stage": "campaign", "total": 3, "taken": 0, "work": 3.0, "time": 1.0}'
DAMAGED = (
    b"1",
    b"[1]",
    b'"x"',
    b"null",
    b"{}",
    b'{"event": "done", "work": 1.0, "time": 1e400}',
    b'{"event": "done", "work": 1.0, "time": "x"}',
    b'{"event": "done", "work": 1e400, "time": 2.0}',
    b'{"event": "reached", "time": 2.0}',
    b'{"event": "reached", "work": NaN, "time": 2.0}',
    b'{"event": "begin", "stage": "campaign", "total": "x", "taken": 0, "work": 3.0, "time": 1.0}',
    b'{"event": "begin", "stage": "campaign", "total": 1e400, "taken": 0, "work": 3.0, "time": 1.0}',
    b'{"event": "begin", "time": 1.0}',
    b'{"event": "fault", "time": 1.0, "title": "wave", "reasons": 3}',
    b"[" * 100_000,
    b"\xff\xfe\x00",
)


@pytest.mark.parametrize("line", DAMAGED)
def test_a_journal_that_is_damaged_is_read_as_far_as_it_tells_of_events(tmp_path, line):
    """Each was a traceback of `assesto status`."""
    done = b'{"event": "done", "work": 1.0, "time": 2.0}'
    (tmp_path / NAME).write_bytes(b"\n".join((done, line, BEGUN.encode(), line, done, line)))
    assert status(tmp_path).splitlines()[1] == "campaign: 1 of 3 done"
    (tmp_path / NAME).write_bytes(line + b"\n" + done)
    assert status(tmp_path).startswith("nothing has been run in")


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"assesto": "0.1.0"}', "[" * 10_000])
def test_the_status_of_damaged_results_is_told_in_a_message(tmp_path, capsys, content):
    """They were a traceback, or nothing was said to have been run."""
    (tmp_path / "output").mkdir()
    (tmp_path / "output" / "results.json").write_text(content, encoding="utf-8")
    assert main(["status", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert (
        said.startswith(f"error: {tmp_path / 'output' / 'results.json'}: ")
        and "run the project again" in said
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the child is not to write figures either")
@pytest.mark.usefixtures("no_figures")
def test_a_run_that_is_killed_again_and_again_is_told_of_and_goes_on_with_equal_results(tmp_path, capsys):
    folder = write_campaign(tmp_path / "block", STRIPES, 1)
    arguments = ["run", str(folder), "--no-report"]
    for number in (1, 2, 3):  # times, each a little further on
        with forked(*arguments, "--jobs", "1") as run:
            while not any(
                stage.name == "campaign" and stage.done and stage.taken + stage.done >= number
                for stage in read_journal(folder / "output")
            ):
                assert run.at_work
                time.sleep(0.02)
        store = Store(folder / "output" / FOLDER)
        assert all(store.read(key.name) for key in store.folder.iterdir() if not key.name.startswith("."))
        assert not (folder / "output" / "results.json").exists()
    assert main(["status", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "not at work" in told and "campaign: " in told
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["analyses"]["taken_over"] > 0
    found, tables = timeless(read_results(folder / "output")), contents(folder / "output" / "tables")
    assert main([*arguments, "--fresh"]) == 0
    assert timeless(read_results(folder / "output")) == found
    assert contents(folder / "output" / "tables") == tables
    assert main(["status", str(folder)]) == 0
    assert "finished: " in capsys.readouterr().out


def test_a_finished_run_without_a_campaign_has_no_failures_of_one(tmp_path):
    results = typed(results_example())
    (tmp_path / "results.json").write_bytes(as_bytes(results))
    assert status(tmp_path) == f"finished: {tmp_path}, {results.quality.solves} solves"
