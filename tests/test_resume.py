"""Analyses taken over from earlier runs: exactly what was computed, only what has not changed, whatever was killed."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from assessment import figures, fingerprint
from assessment.cli import main
from assessment.fingerprint import fingerprint as digest
from assessment.model import build_model
from assessment.new_project import template_layout, write_drawing
from assessment.parallel import Workers
from assessment.project import load_project
from assessment.stages import Part, settle
from assessment.store import FOLDER, Store, packed, unpacked
from assessment.workflow import run
from mechanics import State
from tests.structures import block_on_base

ROOT = Path(__file__).parents[1]
PROJECT = """title = "Block"
[geometry]
drawing = "geometry.dxf"
unit = "m"
depth_m = 1.0
segments_per_joint = 2
[material]
unit_weight_kN_m3 = 18.0
friction = 0.7
normal_stiffness_kN_m3 = 1e6
[layers.BASE]
support = "base"
[[control]]
name = "top"
point_m = [0.3, 4.2]
[[settlements]]
name = "base turned"
support = "base"
rotation_rad = -0.02
increment_rad = 0.01
[pushover]
contacts = ["rigid"]
directions = ["+x"]
increment_m = 0.1
[[history]]
record = "wave.csv"
contacts = "rigid"
[incremental]
records = ["wave*.csv"]
contacts = "rigid"
tolerance_g = 0.2
max_scale = 2.0
[assessment]
limit_states = ["SLV"]
model = "none"
[assessment.site]
soil = "B"
SLV = {ag_g = 0.261, F0 = 2.36, Tc_star_s = 0.35}
SLC = {ag_g = 0.334, F0 = 2.40, Tc_star_s = 0.36}
[report]
language = "it"
"""
ALL = 8  # analyses: self-weight, a pushdown, two pushovers, histories and searches


@pytest.fixture(autouse=True)
def _no_figures(monkeypatch):
    monkeypatch.setattr(figures, "write_figures", lambda _, folder: folder.mkdir())
    monkeypatch.setattr(figures, "write_images", lambda *_: [])


@pytest.fixture
def project(tmp_path):
    folder = tmp_path / "block"
    folder.mkdir()
    write_drawing(folder / "geometry.dxf", template_layout("block"))
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    _wave(folder / "wave.csv", 0.1)
    return folder


def _wave(path: Path, peak: float) -> None:
    time_s = 0.02 * np.arange(40)
    np.savetxt(path, np.column_stack([time_s, peak * np.sin(6.0 * time_s)]), delimiter=",", fmt="%.8f")


def edit(folder: Path, old: str, new: str) -> None:
    text = (folder / "project.toml").read_text(encoding="utf-8")
    assert old in text
    (folder / "project.toml").write_text(text.replace(old, new), encoding="utf-8")


def assesto(folder: Path, *options: str) -> int:
    return main(["run", str(folder), "--no-report", "--json", *options])


def counts(folder: Path, capsys, *options: str) -> tuple[int, int]:
    """Run and return how many analyses were computed and taken over."""
    capsys.readouterr()
    assert assesto(folder, *options) == 0
    found = json.loads(capsys.readouterr().out)["analyses"]
    return found["computed"], found["taken_over"]


def output(folder: Path) -> dict[str, bytes]:
    """Return every file of results, without the one time that is not an analysis'."""
    files = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted((folder / "output").rglob("*"))
        if path.is_file() and FOLDER not in path.parts
    }
    content = json.loads(files["output/results.json"])
    del content["timing_s"]["assessment"]
    return files | {"output/results.json": json.dumps(content).encode()}


def entries(folder: Path) -> list[Path]:
    return sorted((folder / "output" / FOLDER).iterdir())


def test_what_is_taken_over_is_what_was_computed_byte_for_byte(project, capsys):
    assert counts(project, capsys) == (ALL, 0)
    computed = output(project)
    assert counts(project, capsys) == (0, ALL)
    assert output(project) == computed


def test_the_answer_is_the_same_without_any_store(project):
    """Everything but the times, which no two computations share."""
    loaded = load_project(project)
    store = Store(project / "kept")
    outcomes = [
        run(loaded, build_model(loaded)),
        run(loaded, build_model(loaded), store=store),
        run(loaded, build_model(loaded), store=store),
        run(loaded, build_model(loaded), store=store, fresh=True),
    ]
    assert [(each.computed, each.taken) for each in outcomes] == [(ALL, 0), (ALL, 0), (0, ALL), (ALL, 0)]
    first, *others = [json.dumps(_timeless(each.results)) for each in outcomes]
    assert all(other == first for other in others)


def _timeless(value):
    if isinstance(value, dict):
        return {key: _timeless(item) for key, item in value.items() if key not in {"timing_s", "seconds"}}
    return [_timeless(item) for item in value] if isinstance(value, list) else value


# what is edited, and how many analyses are then computed
EDITS = {
    "nothing": ("", "", 0),
    "friction": ("friction = 0.7", "friction = 0.71", ALL),
    "segments": ("segments_per_joint = 2", "segments_per_joint = 3", ALL),
    "the increment of the pushover": ("increment_m = 0.1", "increment_m = 0.05", 2),
    "another direction": ('["+x"]', '["+x", "-x"]', 6),  # and what a history may reach before it has fallen
    "elastic contacts too": ('contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]', 3),
    "the movement": ("rotation_rad = -0.02", "rotation_rad = -0.03", 4),
    "a sweep": ("increment_rad = 0.01", "increment_rad = 0.01\nsteps = 2", 2),
    "the record's scale": ('record = "wave.csv"', 'record = "wave.csv"\nscale = 0.9', 2),
    "the tolerance of the search": ("tolerance_g = 0.2", "tolerance_g = 0.1", 2),
    "fewer states": ('[[history]]\nrecord = "wave.csv"', '[[history]]\nstates = ["original"]\nrecord = "wave.csv"', 0),
    "limit states": ('["SLV"]', '["SLV", "SLC"]', 0),
    "the report's language": ('language = "it"', 'language = "en"', 0),
}  # fmt: skip


@pytest.mark.parametrize("what", EDITS)
def test_only_what_depends_on_an_edit_is_computed_again(project, capsys, what):
    old, new, computed = EDITS[what]
    assert assesto(project) == 0
    edit(project, old, new)
    assert counts(project, capsys)[0] == computed
    resumed = output(project)
    assert counts(project, capsys, "--fresh")[1] == 0
    fresh = output(project)
    assert resumed.keys() == fresh.keys()
    old, new = (json.loads(each["output/results.json"]) for each in (resumed, fresh))
    assert _timeless(old) == _timeless(new)


def test_a_record_that_changed_is_seen(project, capsys):
    assert assesto(project) == 0
    _wave(project / "wave.csv", 0.11)
    assert counts(project, capsys) == (4, 4)


def test_another_record_leaves_the_first_as_it_is(project, capsys):
    assert assesto(project) == 0
    _wave(project / "wave2.csv", 0.15)
    assert counts(project, capsys) == (2, ALL)


def test_another_version_of_the_program_takes_over_nothing(project, capsys, monkeypatch):
    assert assesto(project) == 0
    monkeypatch.setattr(fingerprint, "program", lambda: "of tomorrow")
    assert counts(project, capsys) == (ALL, 0)


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "of another", "a folder", "not text"])
def test_a_damaged_entry_counts_as_absent(project, capsys, damage):
    assert assesto(project) == 0
    before, (first, second, *_) = output(project), entries(project)
    content = bytearray(first.read_bytes())
    if damage == "a folder":
        first.unlink()
        first.mkdir()
    else:
        content[-2] ^= 1
        broken = {
            "cut": bytes(content[:-2]),
            "flipped": bytes(content),
            "empty": b"",
            "of another": second.read_bytes(),
            "not text": b"\xff\xfe",
        }
        first.write_bytes(broken[damage])
    assert counts(project, capsys) == (1, ALL - 1)
    timeless = [_timeless(json.loads(each["output/results.json"])) for each in (before, output(project))]
    assert timeless[0] == timeless[1]


def test_a_disk_that_refuses_entries_costs_no_results(project, capsys, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("assessment.store.write_atomically", full)
    assert counts(project, capsys) == (ALL, 0)
    assert counts(project, capsys) == (ALL, 0)


@pytest.mark.parametrize("finished", range(ALL + 1))
def test_a_run_killed_at_any_boundary_goes_on_from_there(project, capsys, finished):
    """SIGKILL as soon as some analyses are kept, in a process of its own; after the last, before files are written."""
    assert counts(project, capsys, "--out", str(project / "whole")) == (ALL, 0)
    child = os.fork()
    if child == 0:
        _die_after(finished)
        assesto(project)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert not (project / "output" / "results.json").exists()
    assert counts(project, capsys) == (ALL - finished, finished)
    whole = json.loads((project / "whole" / "results.json").read_text(encoding="utf-8"))
    resumed = json.loads((project / "output" / "results.json").read_text(encoding="utf-8"))
    assert _timeless(resumed) == _timeless(whole)


def _die_after(finished: int) -> None:
    keep, find = Store.keep, Store.find
    left = [finished]

    def counted(store, key, text):
        keep(store, key, text)
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    def none_left(store, key):
        if finished == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return find(store, key)

    Store.keep, Store.find = counted, none_left


def test_an_interrupted_run_keeps_what_is_finished_and_says_so(project, capsys, monkeypatch):
    keep = Store.keep

    def interrupted(store, key, text):
        keep(store, key, text)
        if len(list(store.folder.iterdir())) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(Store, "keep", interrupted)
    assert assesto(project) == 3
    assert "run again to go on" in capsys.readouterr().err
    assert [path.name for path in (project / "output").iterdir()] == [FOLDER]
    monkeypatch.setattr(Store, "keep", keep)
    assert main(["run", str(project), "--no-report"]) == 0
    out = capsys.readouterr().out
    assert f"taken over from earlier runs: 3 of {ALL} analyses, inputs unchanged" in out


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_no_process_is_left_behind(project, sent):
    """An interruption, or a kill, of the parent alone while two others work on something endless."""
    code = (
        "import os, sys, time\n"
        "from assessment import states\n"
        "from assessment.cli import main\n"
        "def endless(*_):\n"
        "    os.write(1, b'begun\\n')\n"
        "    time.sleep(600)\n"
        "states.push = endless\n"
        "sys.exit(main(['run', sys.argv[1], '--no-report', '--jobs', '2']))"
    )
    edit(project, '["+x"]', '["+x", "-x"]')
    started = subprocess.Popen(
        [sys.executable, "-c", code, str(project)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        assert started.stdout is not None
        assert [started.stdout.readline() for _ in range(2)] == ["begun\n", "begun\n"]
        started.send_signal(sent)
        _, err = started.communicate(timeout=60)  # ends where no process holds its pipes any more
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(started.pid, signal.SIGKILL)
    assert started.returncode == (3 if sent == signal.SIGINT else -signal.SIGKILL)
    assert "Traceback" not in err
    assert len(entries(project)) == 2  # self-weight and the pushdown


def test_what_was_not_used_for_longest_goes_first(tmp_path):
    store = Store(tmp_path)
    for key in ("a", "b", "c"):
        store.keep(key, key * 1000)
        os.utime(tmp_path / key, (1.0, 1.0 + ord(key)))
    (tmp_path / ".d.123.tmp").write_text("half-written", encoding="utf-8")
    assert store.find("a") == "a" * 1000  # used now
    store.prune(2500)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "c"]


def test_results_keep_every_bit():
    state = State(np.array([[0.1, 1 / 3, 1e-300]]), np.zeros((1, 3)), np.zeros(0))
    part = Part(
        {"a": (0.1, None, np.float64(1 / 7), np.int64(3))}, state, [{"x": 2.0}], ["w «é»\r\n"], [], 0.3
    )
    found = unpacked(packed(part))
    assert found.numbers == {"a": [0.1, None, 1 / 7, 3]}
    assert found.reached.positions.tobytes() == state.positions.tobytes()
    assert (found.reached.velocities.shape, found.reached.shear.shape) == ((1, 3), (0,))
    assert (found.quality, found.warnings, found.failures, found.seconds) == (
        [{"x": 2.0}],
        ["w «é»\r\n"],
        [],
        0.3,
    )
    assert packed(found) == packed(part)


def test_fingerprints_tell_every_content_and_type_apart():
    model, other = block_on_base(0.6, 4.2), block_on_base(0.6, 4.3)
    values = [1, 1.0, True, "1", None, [1], [[1]], {"1": 1}, [], {}, 0.0, -0.0, float("inf"), float("nan")]
    values += [np.zeros(2), np.ones(2), np.zeros((2, 1)), np.zeros(2, dtype=int), model, other, model.initial]
    assert len({digest(settle, (value,)) for value in values}) == len(values)
    assert digest(settle, (model, 1)) == digest(settle, (block_on_base(0.6, 4.2), 1))
    assert digest(settle, (model,)) != digest(run, (model,))
    _ = model.elastic_contacts  # what is derived from the content changes nothing
    assert digest(settle, (model,)) == digest(settle, (block_on_base(0.6, 4.2),))
    with pytest.raises(TypeError, match="no fingerprint"):
        digest(settle, (object(),))


def test_as_many_processes_as_asked_for():
    with Workers(jobs=2) as workers:
        pids = workers.each("wait", _pid, [(k,) for k in range(6)], [""] * 6, worthwhile=True)
    assert len({*pids} - {os.getpid()}) == 2
    with Workers(jobs=1) as workers:
        assert workers.each("wait", _pid, [(1,), (2,)], ["", ""], worthwhile=False) == [os.getpid()] * 2


def _pid(_: int) -> int:
    time.sleep(0.2)
    return os.getpid()


def test_an_error_in_another_process_is_the_error():
    with pytest.raises(ZeroDivisionError), Workers(jobs=2) as workers:
        workers.each("divide", _inverse, [(1,), (0,)], ["", ""], worthwhile=True)


def _inverse(number: int) -> float:
    return 1.0 / number


def test_the_summary_as_json_is_all_there_is_on_standard_output(project, capsys):
    assert assesto(project) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    results = json.loads((project / "output" / "results.json").read_text(encoding="utf-8"))
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
    edit(project, "increment_m = 0.1", "increment_m = 0.05")
    assert assesto(project) == 0
    second = capsys.readouterr()
    json.loads(second.out)
    for stage in ("self-weight: 1", "pushdown: 1", "pushover: 2", "history: 2", "incremental: 2"):
        assert f"· {stage}, " in first.err
    assert "· pushdown: 1, 1 taken over, inputs unchanged, " in second.err
    assert "· pushover: 2, 0." in second.err


def test_the_bar_moves_with_the_analyses():
    from io import StringIO

    from rich.console import Console

    from assessment.terminal import Bars

    bars = Bars(Console(file=StringIO(), force_terminal=True))
    bars.begin("history", 4, 1)
    bars.under_way("original, history of [wave]")
    bars.advance()
    [task] = bars.progress.tasks
    assert (task.completed, task.total) == (2, 4)
    assert task.description == "history: original, history of [wave]"
    bars.end()
    assert not bars.progress.tasks
