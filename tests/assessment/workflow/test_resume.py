"""Analyses taken over from earlier runs: exactly what was computed, and only what has not changed."""

import json
import shutil
from pathlib import Path

import pytest

from assessment.report.figures import index as figures
from assessment.runtime import cache
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.progress import NAME as JOURNAL
from tests.support.block_project import edit, forget, timeless
from tests.support.every_stage import assesto, computed, counts, entries, planned, write_every_stage

pytestmark = pytest.mark.usefixtures("no_figures")


@pytest.fixture
def project(tmp_path):
    return write_every_stage(tmp_path / "block")


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The project, run once."""
    folder = write_every_stage(tmp_path_factory.mktemp("first") / "block")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "write_figures", lambda _, path: path.mkdir())
        patch.setattr(figures, "write_images", lambda *_: [])
        assert assesto(folder) == 0
    return folder


@pytest.fixture
def done(first, tmp_path):
    """A copy of it with its output."""
    return Path(shutil.copytree(first, tmp_path / "block"))


def output(folder: Path) -> dict[str, bytes]:
    """Return every file of results, without the one time that is not an analysis'."""
    files = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted((folder / "output").rglob("*"))
        if path.is_file() and not {FOLDER, JOURNAL} & {*path.parts}
    }
    content = json.loads(files["output/results.json"])
    del content["timing_s"]["assessment"]
    return files | {"output/results.json": json.dumps(content).encode()}


def test_what_is_taken_over_is_what_was_computed_byte_for_byte(project, capsys):
    computed, taken = counts(project, capsys)
    assert computed == sum(planned(project).values()) and taken == 0
    first = output(project)
    forget(project / "output")
    assert counts(project, capsys) == (0, computed)
    assert output(project) == first


# what is edited, and the share of each stage that is then computed again, OTHER for those that are not named;
# beside it what the stage has now and had not before
OTHER = ""
EVERYTHING = {OTHER: 1.0}
EDITS: dict[str, tuple[str, str, dict[str, float]]] = {
    "friction": ("friction = 0.7", "friction = 0.71", EVERYTHING),
    "the increment of the pushover": ("increment_m = 0.2", "increment_m = 0.1", {"pushover": 1.0}),
    "elastic contacts too": ('contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]', {}),
    # one state of the two
    "the movement": ("rotation_rad = -0.02", "rotation_rad = -0.03", {"self-weight": 0.0, "pushdown": 1.0, OTHER: 0.5}),
    # a scan runs the levels of the histories too
    "the record's scale": (
        'record = "wave.csv"', 'record = "wave.csv"\nscale = 0.9',
        {"history": 1.0, "incremental": 1.0, "finer: incremental": 1.0},
    ),
}  # fmt: skip


def expected(before: dict[str, int], now: dict[str, int], again: dict[str, float]) -> dict[str, int]:
    """Return how many analyses of each stage are to be computed after an edit."""
    return {
        stage: int(total * again.get(stage, again.get(OTHER, 0.0))) or max(0, total - before.get(stage, 0))
        for stage, total in now.items()
    }


@pytest.mark.parametrize("what", EDITS)
def test_only_what_depends_on_an_edit_is_computed_again(done, capsys, what):
    before = planned(done)
    assert min(before.values()) > 0
    old, new, again = EDITS[what]
    edit(done, old, new)
    assesto(done)
    found, due = computed(done), expected(before, planned(done), again)
    if again == {"pushover": 1.0}:  # it begins where the largest multiplier is, which may have moved
        assert found.pop("second solver") <= due.pop("second solver") + before["second solver"]
    assert found == due
    resumed = output(done)
    assert counts(done, capsys, "--fresh")[1] == 0
    fresh = output(done)
    assert resumed.keys() == fresh.keys()
    first, second = (json.loads(each["output/results.json"]) for each in (resumed, fresh))
    assert timeless(first) == timeless(second)


def test_another_version_of_the_program_takes_over_nothing(done, capsys, monkeypatch):
    every = sum(planned(done).values())
    monkeypatch.setattr(cache, "program", lambda: "of tomorrow")
    assert counts(done, capsys) == (every, 0)


@pytest.mark.parametrize("damage", ["flipped", "of another", "a folder"])
def test_a_damaged_entry_counts_as_absent(done, capsys, damage):
    before, every, (first, second, *_) = output(done), sum(planned(done).values()), entries(done)
    forget(done / "output")
    content = bytearray(first.read_bytes())
    if damage == "a folder":
        first.unlink()
        first.mkdir()
    else:
        content[-2] ^= 1
        broken = {"flipped": bytes(content), "of another": second.read_bytes()}
        first.write_bytes(broken[damage])
    assert counts(done, capsys) == (1, every - 1)
    found = [timeless(json.loads(each["output/results.json"])) for each in (before, output(done))]
    assert found[0] == found[1]


FORGED = (
    "", "null", "true", "1", '"text"', "[]", "[null]", "{}", "{", '{"found": 1}', '[{"found": {"rigid": 3}}]',
    '[{"failures": [3]}]', '{"reached": {"positions": [1, 2]}}',
    '{"reached": {"positions": {"·array": [0.0], "shape": [7], "type": "<f8"}}}',
    '{"reached": {"positions": {"·array": ["a"], "shape": [1], "type": "<U1"}}}',
    '{"warnings": [{"template": "{missing}", "fields": {}}]}', '{"seconds": "long"}',
    '{"·kind": "builtins:eval"}', "[" * 100_000,
)  # fmt: skip


@pytest.mark.parametrize("begin", [0, len(FORGED) // 2])
def test_entries_that_are_no_results_count_as_absent(done, capsys, begin):
    """Each has the digest of its content, and ended in a traceback; the record of the last run is one of them."""
    before, every = output(done), sum(planned(done).values())
    store = Store(done / "output" / FOLDER)
    for number, entry in enumerate(entries(done), begin):
        store.keep(entry.name, FORGED[number % len(FORGED)])
    again, taken = counts(done, capsys)
    # null is a result: nothing stands against self-weight
    assert again >= every - 2 and again + taken == every
    found = [timeless(json.loads(each["output/results.json"])) for each in (before, output(done))]
    assert found[0] == found[1]


def test_a_disk_that_refuses_entries_costs_no_results(project, capsys, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("assessment.runtime.cache.write_atomically", full)
    for _ in range(2):
        computed, taken = counts(project, capsys)
        assert computed == sum(planned(project).values()) and taken == 0
