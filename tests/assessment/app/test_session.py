"""What the page is told and may do, without a socket; the process that draws, and runs that go on by themselves."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib

import ezdxf
import pytest

from assessment.app.pictures import record_picture
from assessment.app.server import ANSWERS
from assessment.app.session import ConflictError, Session
from assessment.app.worker import Worker, WorkerError
from assessment.cli.main import main
from assessment.project.catalogue.new_project import made, proposal, write_drawing
from assessment.project.xlsx import to_xlsx
from assessment.runtime.errors import ProjectError
from assessment.runtime.progress import NAME as JOURNAL
from tests.support.block_project import ASSESSMENT, PROJECT, PUSHED, TURNED, edit, write_block

SLOW = 600  # times that something is looked for, with a tenth of a second between


@pytest.fixture(scope="module")
def worker():
    found = Worker()
    yield found
    found.end()


@pytest.fixture
def session(tmp_path, worker):
    """A session over a block whose project has everything."""
    found = Session(tmp_path, write_block(tmp_path / "block", PROJECT + ASSESSMENT))
    found.worker = worker
    return found


def ask(session, question, /, **sent):
    answer = ANSWERS[question](session, json.loads(json.dumps(sent))) or {}
    json.dumps(answer, allow_nan=False)
    return answer


def changed(session, *changes):
    return ask(session, "edit", digest=ask(session, "state")["digest"], changes=[*changes])


# ---- state, edits ----


@pytest.mark.parametrize("text", ["null", '{"a": ' + "[" * 100_000])
def test_results_that_no_run_has_written_are_none(session, text):
    (session.folder / "output").mkdir()
    (session.folder / "output" / "results.json").write_text(text, encoding="utf-8")
    assert ask(session, "state")["results"] is None


def test_a_project_file_that_is_gone_or_no_file_is_told(session):
    path = session.folder / "project.toml"
    content = path.read_bytes()
    path.unlink()
    assert "holds no project.toml" in ask(session, "state")["error"]
    if hasattr(os, "mkfifo"):
        os.mkfifo(path)  # to read it would take for ever
        assert "holds no project.toml" in ask(session, "state")["error"]
        path.unlink()
    path.write_bytes(content)
    assert ask(session, "state")["error"] is None


def test_the_state_is_content_and_problems_of_the_file(session):
    state = ask(session, "state")
    assert state["content"]["title"] == "Block"
    assert (state["problems"], state["error"], state["results"]) == ([], None, None)
    assert (state["undo"], state["run"]["running"], state["language"]) == (False, False, "it")


def test_an_edit_that_contradicts_is_written_and_told(session):
    changed(session, [["settlements", 0, "support"], "nowhere"])
    state = ask(session, "state")
    assert state["content"]["settlements"][0]["support"] == "nowhere"
    assert 'no support "nowhere"' in state["problems"][0]


def test_a_broken_file_is_told_with_its_line_and_undone(session):
    known = changed(session, [["title"], "Two"])["digest"]
    (session.folder / "project.toml").write_text("title = \n", encoding="utf-8")
    state = ask(session, "state")
    assert "line 1" in state["error"]
    assert state["content"] is None
    with pytest.raises(ProjectError, match="line 1"):
        changed(session, [["title"], "Three"])
    assert ask(session, "undo", digest=state["digest"]) == {"digest": known}
    assert ask(session, "state")["content"]["title"] == "Two"


def test_undo_brings_a_file_back_that_was_taken_away(session):
    path = session.folder / "project.toml"
    known = changed(session, [["title"], "Two"])["digest"]
    path.unlink()
    state = ask(session, "state")
    assert (state["digest"], state["undo"], state["redo"]) == (None, True, False)
    assert ask(session, "undo", digest=None) == {"digest": known}
    assert ask(session, "state")["content"]["title"] == "Two"
    with pytest.raises(ConflictError):
        ask(session, "undo", digest=None)


def test_a_page_of_another_project_changes_nothing_and_is_told(session):
    """Two copies of a project have the same digest: only the folder tells them apart."""
    known = ask(session, "state")
    mine = session.held(known["project"])
    session.open(write_block(session.home / "copy", PROJECT + ASSESSMENT))
    assert ask(session, "state")["digest"] == known["digest"]
    with pytest.raises(ConflictError):
        session.held(known["project"])
    with pytest.raises(ConflictError):
        session.held("")
    # asked before the other was opened
    ask(mine, "edit", digest=known["digest"], changes=[[["title"], "Mine"]])
    assert mine.receive("quake.csv", "record", RECORD)["name"] == "records/quake.csv"
    assert (session.home / "block" / "records" / "quake.csv").is_file()
    assert ask(session, "state")["content"]["title"] == "Block"
    assert ask(session.held(ask(session, "state")["project"]), "model")["tag"] == ask(session, "state")["tag"]


def test_of_a_long_record_the_extremes_are_drawn_at_their_own_times(tmp_path):
    (tmp_path / "long.txt").write_text("\n".join(f"{0.01 * k:.2f} {k % 7 / 10000:.6f}" for k in range(5000)))
    lines = (tmp_path / "long.txt").read_text().splitlines()
    lines[1234] = "12.34 -0.350000"
    (tmp_path / "long.txt").write_text("\n".join(lines))
    found = record_picture(tmp_path / "long.txt")
    assert len(found["time"]) == len(found["acceleration"]) <= 2000 and found["time"][-1] == 49.99
    assert found["acceleration"][found["time"].index(12.34)] == -0.35 == -found["pga"]


def test_a_record_of_one_column_is_kept_with_a_time_step(session):
    column = b"\n".join(b"%.4f" % (0.001 * (k % 7)) for k in range(500))
    with pytest.raises(ProjectError, match="time_step_s"):
        session.receive("column.csv", "record", column)
    assert not (session.folder / "records" / "column.csv").exists()
    assert session.receive("column.csv", "record", column, 0.01)["duration"] == pytest.approx(4.99)


def test_a_model_is_looked_at_again_for_all_that_a_run_reads_and_not_for_the_report(session):
    session.receive("quake.csv", "record", RECORD)
    tags = {ask(session, "state")["tag"]}
    changed(session, [["report", "client"], "Somebody"])
    assert {ask(session, "state")["tag"]} == tags
    changed(session, [["layers", "BLOCCO", "friction"], 0.4])
    tags.add(ask(session, "state")["tag"])
    changed(session, [["history", 0], {"name": "quake", "record": "records/quake.csv", "contacts": "rigid"}])
    tags.add(ask(session, "state")["tag"])
    assert ask(session, "model")["error"] is None
    (session.folder / "records" / "quake.csv").write_bytes(b"no record")
    tags.add(ask(session, "state")["tag"])
    assert len(tags) == 4
    assert "quake.csv" in ask(session, "model")["error"]


def test_a_spreadsheet_is_shown_not_written_and_can_be_converted(tmp_path, worker):
    folder = write_block(tmp_path / "block")
    content = tomllib.loads(PROJECT)
    (folder / "project.toml").unlink()
    (folder / "project.xlsx").write_bytes(to_xlsx(content))
    session = Session(tmp_path, folder)
    session.worker = worker
    assert ask(session, "state")["source"] == "project.xlsx"
    with pytest.raises(ProjectError, match="convert"):
        changed(session, [["title"], "Two"])
    assert ask(session, "convert") == {"kept": "project.xlsx.old"}
    assert changed(session, [["title"], "Two"])["digest"]


@pytest.mark.parametrize(
    ("name", "sent"),
    [
        ("edit", {"digest": "x", "changes": {}}), ("edit", {"digest": "x", "changes": [[["title"]]]}),
        ("edit", {"digest": "x", "changes": [["title", "Two"]]}),
        ("live", {"tag": "x", "support": "base", "target": [0, 0]}),
        ("live", {"tag": "x", "support": "base", "target": [0, 0, "x"]}),
        ("live", {"tag": "x", "support": "base", "target": [0, 0, 1e9]}), ("run", {"only": ["everything"]}),
        ("run", {"only": []}), ("record", {"name": "../../etc/passwd"}),
        ("record", {"name": "project.toml\0"}), ("judgement", {"text": 1}),
        ("judgement", {"text": "x" * 600_000}), ("open", {"folder": "nowhere"}),
        ("new", {"name": "../up", "template": "block"}), ("new", {"name": "", "template": "block"}),
        ("new", {"name": "block", "template": "block"}), ("new", {"name": "other", "template": "cathedral"}),
        ("new", {"name": "other", "example": "cathedral"}),
        ("new", {"name": "other", "drawing": "../block/geometry.dxf"}), ("convert", {}),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_and_changes_nothing(session, name, sent):
    before = {path: path.read_bytes() for path in session.home.rglob("*") if path.is_file()}
    with pytest.raises(ProjectError):
        ask(session, name, **sent)
    assert {path: path.read_bytes() for path in session.home.rglob("*") if path.is_file()} == before


# ---- the drawing ----


def test_the_model_is_blocks_joints_and_whether_they_stand(session):
    model = ask(session, "model")
    assert [block["support"] for block in model["blocks"]] == ["base", None]
    assert (len(model["joints"]), model["self_weight"], model["error"]) == (1, True, None)
    assert model["layers"] == {"BASE": 1, "BLOCCO": 1}


def overlapping(folder):
    layout = made("block", {})[0]
    layout["BLOCCO"] = [polygon - [0.0, 0.005] for polygon in layout["BLOCCO"]]
    write_drawing(folder / "geometry.dxf", layout)


def test_faults_have_places_and_a_repair_tells_its_changes_first(session):
    overlapping(session.folder)
    model = ask(session, "model")
    assert (model["repairable"], len(model["blocks"])) == (True, 2)
    assert model["faults"][0]["kind"] == "overlap"
    assert model["faults"][0]["points"]
    told = ask(session, "repair")
    assert told["changes"]
    assert told["drawing"] is None
    assert not (session.folder / "geometry-repaired.dxf").exists()
    made = ask(session, "repair", apply=True)
    assert made == {"changes": told["changes"], "drawing": "geometry-repaired.dxf"}
    changed(session, [["geometry", "drawing"], made["drawing"]])
    assert (ask(session, "model")["faults"], session.folder.joinpath("geometry.dxf").is_file()) == ([], True)


def test_a_support_is_followed_and_its_whole_way_is_that_of_the_project(session):
    tag = ask(session, "state")["tag"]
    target = [0.01, -0.02, 0.0]
    answer = ask(session, "live", tag=tag, support="base", target=target, home=True)
    while not answer["there"]:
        answer = ask(session, "live", tag=tag, support="base", target=target)
    whole = ask(session, "live", tag=tag, support="base", target=target, whole=True)
    assert whole["there"]
    assert whole["positions"][1] == pytest.approx(target, abs=1e-6)
    assert whole["reaction"] == pytest.approx([0.0, 0.6 * 4.2 * 18.0], rel=1e-6)
    fallen = ask(session, "live", tag=tag, support="base", target=[0.0, 0.0, 0.5], whole=True)
    assert fallen["fallen"]
    assert 0.1 < fallen["at"][2] < 0.15  # the block overturns at 0.3/2.1
    assert fallen["stopped"]["en"] != fallen["stopped"]["it"]


def test_the_spectra_are_those_of_the_site(session):
    found = ask(session, "spectrum")
    assert found["spectra"]["SLV"]["ag"] == 0.261
    assert max(found["spectra"]["SLV"]["Se"]) == pytest.approx(
        0.261 * found["spectra"]["SLV"]["S"] * 2.36, abs=1e-4
    )


def test_a_process_that_takes_too_long_is_ended_and_the_next_question_is_answered(session):
    impatient = Worker({"model": 0.0})
    session.worker = impatient
    with pytest.raises(ProjectError, match="not answered within 0 s"):
        ask(session, "model")
    impatient.limits = {}
    assert ask(session, "model")["error"] is None
    os.kill(impatient.process.pid, signal.SIGKILL)
    with pytest.raises(WorkerError, match="begins anew"):
        while True:
            ask(session, "model")
    assert ask(session, "model")["error"] is None
    impatient.end()


# ---- dropped files ----

RECORD = "\n".join(f"{0.01 * k:.2f} {0.1 * (-1) ** k * k / 100:.6f}" for k in range(300)).encode()


@pytest.mark.parametrize(
    ("name", "kind", "content"),
    [
        ("plan.dxf", "drawing", b"%PDF-1.4 no drawing"), ("plan.dxf", "drawing", b""),
        ("quake.csv", "record", b"a;b\n1;2\n"), ("quake.csv", "record", b"\x00\xff" * 500),
        ("grid.txt", "grid", b"not a grid"), ("photo.png", "picture", b"GIF89a"),
        ("photo.exe", "picture", b"MZ"), ("plan.dxf", "virus", b""),
    ],
)  # fmt: skip
def test_a_file_that_is_not_what_it_should_be_is_told_and_not_kept(session, name, kind, content):
    before = sorted(session.folder.rglob("*"))
    with pytest.raises(ProjectError) as refused:
        session.receive(name, kind, content)
    assert ".assesto" not in str(refused.value)
    assert [path for path in sorted(session.folder.rglob("*")) if ".assesto" not in path.parts] == before


@pytest.mark.parametrize("opened", [True, False])
def test_a_drawing_without_an_outline_is_refused(session, opened):
    document = ezdxf.new()
    document.modelspace().add_text("PROSPETTO")
    document.saveas(empty := session.home / "empty.dxf")
    if not opened:
        session.open(None)
    with pytest.raises(ProjectError, match="nothing closed is in model space"):
        session.receive("empty.dxf", "drawing", empty.read_bytes())


def test_a_new_project_begins_with_a_dropped_drawing(tmp_path, worker):
    session = Session(tmp_path, None)
    session.worker = worker
    write_drawing(tmp_path / "survey.dxf", made("arch", {})[0])
    dropped = session.receive("survey.dxf", "drawing", (tmp_path / "survey.dxf").read_bytes())
    assert dropped["unit"] == "m"
    assert any("appoggio" in each["it"] for each in dropped["notes"])
    assert sum(dropped["layers"].values()) > 10
    sent = {
        "name": "my arch", "drawing": "survey.dxf", "title": "My arch", "unit": "m", "depth_m": 1.0,
        "language": "en",
    }  # fmt: skip
    with pytest.raises(ProjectError, match="unit_weight_kN_m3"):
        ask(session, "new", **sent, unit_weight_kN_m3=None)
    assert not (tmp_path / "my arch").exists()
    ask(session, "new", **sent, unit_weight_kN_m3=18)
    state = ask(session, "state")
    assert state["content"]["title"] == "My arch"
    proposed, _ = proposal(tmp_path / "survey.dxf")
    for key, value in proposed.items():
        given = state["content"].get(key)
        assert given == value or key in ("title", "geometry", "material", "report"), key
    assert proposed["layers"]
    assert (state["content"]["report"]["language"], state["content"]["material"]["friction"]) == ("en", 0.6)
    assert (session.folder / state["content"]["geometry"]["drawing"]).read_bytes() == (
        tmp_path / "survey.dxf"
    ).read_bytes()


# ---- runs ----


def until(condition):
    for _ in range(SLOW):
        if condition():
            return
        time.sleep(0.1)
    raise AssertionError(condition)


@pytest.mark.usefixtures("quick")
def test_a_run_of_a_terminal_is_seen_and_stopped_and_goes_on(session, monkeypatch):
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    edit(session.folder, TURNED + PUSHED, PUSHED)  # one state has half the figures
    edit(session.folder, "increment_m = 0.2", "increment_m = 0.00002")
    command = [sys.executable, "-m", "assessment.cli", "run", str(session.folder), "--no-report"]
    terminal = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    until(lambda: ask(session, "state")["run"]["stages"])
    with pytest.raises(ProjectError, match="at work"):
        ask(session, "run")
    ask(session, "stop")
    assert terminal.wait() == 3
    state = ask(session, "state")["run"]
    assert (state["running"], state["exit_code"]) == (False, 3)
    edit(session.folder, "increment_m = 0.00002", "increment_m = 0.2")
    assert main(["run", str(session.folder), "--only", "pushover"]) == 0  # as of the page: the browser's test
    state = ask(session, "state")
    assert state["run"]["exit_code"] == 0, state["run"]
    assert "report.html" in state["results"]["files"]
    assert "<!--" in ask(session, "judgement")["text"]
    assert ask(session, "judgement", text="Sound.\n")["text"] == "Sound.\n"
    assert ask(Session(session.home, session.folder), "state")["run"]["exit_code"] == 0
    assert ask(session, "state")["results"]["stale"] == "numbers"  # of one stage of two
    changed(session, [["settlements"], None], [["assessment"], None])
    assert ask(session, "state")["results"]["stale"] is None
    changed(session, [["report", "language"], "en"])
    assert ask(session, "state")["results"]["stale"] == "page"
    changed(session, [["material", "friction"], 0.5])
    assert ask(session, "state")["results"]["stale"] == "numbers"
    changed(session, [["material", "friction"], 0.7], [["report", "language"], "it"])
    assert ask(session, "state")["results"]["stale"] is None
    geometry = session.folder / "geometry.dxf"
    geometry.write_bytes(geometry.read_bytes() + b"\n")
    assert ask(session, "state")["results"]["stale"] == "numbers"
    journal = session.folder / "output" / JOURNAL
    left = json.loads(journal.read_text()) | {"exit_code": None}
    journal.write_text(json.dumps(left))  # as of a run of a terminal that was killed
    assert ask(session, "state")["run"]["exit_code"] is None
