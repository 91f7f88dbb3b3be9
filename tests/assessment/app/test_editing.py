"""Changes of project.toml from the page: what they leave as it was, what they refuse, and what undo brings back."""

import tomllib

import pytest

from assessment.app.session import ConflictError, Versions, digest_of, edited
from assessment.runtime.errors import ProjectError
from tests.support.block_project import PROJECT

COMMENTED = PROJECT.replace("depth_m = 1.0", "depth_m = 1.0   # measured in May")


def changed(*changes):
    return tomllib.loads(edited(COMMENTED, changes))


def test_a_value_is_changed_in_its_place_and_all_else_stays():
    text = edited(COMMENTED, [(("material", "friction"), 0.55)])
    assert text == COMMENTED.replace("friction = 0.7", "friction = 0.55")


def test_tables_and_entries_are_made_where_there_are_none():
    content = changed(
        (("layers", "ARCH", "friction"), 0.5),
        (("settlements", 1), {"name": "sunk", "support": "base", "displacement_m": [0, -0.01]}),
        (("assessment", "site", "soil"), "C"),
        (("scatter",), 1),
        (("report", "attachments"), ["photo.png"]),
    )
    assert content["layers"]["ARCH"] == {"friction": 0.5}
    assert [each["name"] for each in content["settlements"]] == ["base turned", "sunk"]
    assert content["assessment"] == {"site": {"soil": "C"}}
    assert (content["scatter"], content["report"]["attachments"]) == (1, ["photo.png"])
    assert "# measured in May" in edited(COMMENTED, [(("scatter",), 1)])


def test_entries_are_deleted_with_their_comments_and_the_last_one_with_its_key():
    text = COMMENTED.replace('[[control]]\nname = "right"', '[[control]]  # the edge\nname = "right"')
    left = edited(text, [(("control", 0), None)])
    assert "# the edge" not in left
    assert [each["name"] for each in tomllib.loads(left)["control"]] == ["left"]
    gone = tomllib.loads(
        edited(text, [(("control", 0), None), (("control", 0), None), (("pushover",), None)])
    )
    assert "control" not in gone
    assert edited(text, [(("sensitivity",), None)]) == text


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("material", "friction"), -1, "project.toml: material.friction: -1 is wrong; write a number not less"),
        (("material", "friction"), "0,5", "0.5"),
        (("control", 0, "point_m"), [None, 4.2], "control[1].point_m[1]: null is wrong; write a number"),
        (("material", "colour"), "red", "material.colour: unknown key"),
        (("title",), "", "title"),
        (("geometry", "unit"), None, "geometry.unit: missing; add it"),
        ((), 1, "there is no such place"),
        (("title", "more"), 1, "there is no such place"),
        (("control", 7, "name"), "far", "control"),
    ],
)  # fmt: skip
def test_what_the_schema_refuses_is_said_at_its_key(path, value, said):
    with pytest.raises(ProjectError, match=said.replace("[", r"\[")):
        edited(COMMENTED, [(path, value)])


def test_undo_and_redo_to_the_byte(tmp_path):
    file = tmp_path / "project.toml"
    first = COMMENTED.replace("\n", "\r\n").encode()
    file.write_bytes(first)
    history = Versions(tmp_path)
    assert history.steps() == (False, False)
    second = history.write([(("title",), "Two")], digest_of(first))
    third = history.write([(("scatter",), 2)], second)
    assert history.steps() == (True, False)
    assert history.step(-1, third) == second
    assert history.step(-1, second) == digest_of(first)
    assert file.read_bytes() == first
    assert history.steps() == (False, True)
    with pytest.raises(ProjectError, match="nothing to undo"):
        history.step(-1, digest_of(first))
    assert history.step(1, digest_of(first)) == second
    history.write([(("title",), "Other")], second)
    assert history.steps() == (True, False)


def test_a_change_made_elsewhere_is_noticed_and_undone_too(tmp_path):
    file = tmp_path / "project.toml"
    file.write_text(COMMENTED, encoding="utf-8")
    history = Versions(tmp_path)
    known = history.write([(("title",), "Two")], digest_of(COMMENTED.encode()))
    by_editor = file.read_bytes() + b"# by hand\n"
    file.write_bytes(by_editor)
    with pytest.raises(ConflictError):
        history.write([(("title",), "Three")], known)
    assert file.read_bytes() == by_editor
    assert history.step(-1, digest_of(by_editor)) == known
    assert history.step(1, known) == digest_of(by_editor)


def test_a_full_disk_changes_nothing(tmp_path, monkeypatch):
    file = tmp_path / "project.toml"
    file.write_text(COMMENTED, encoding="utf-8")

    def full(*_):
        raise OSError(28, "No space left on device", str(file))

    monkeypatch.setattr("assessment.app.session.write_atomically", full)
    with pytest.raises(OSError, match="No space left"):
        Versions(tmp_path).write([(("scatter",), 2)], digest_of(COMMENTED.encode()))
    assert file.read_text(encoding="utf-8") == COMMENTED
