"""Finished files take the place of earlier ones at once: all of them or none, and nobody else's."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from assessment.runtime.errors import ProjectError
from assessment.runtime.files import swap
from assessment.runtime.files.swap import clear, put_in_place
from tests.support.block_project import contents

OLD = ("figures/a.svg", "figures/b.svg", "report.pdf", "results.json", "tables/t.csv")
NEW = ("figures/b.svg", "figures/c.svg", "report.pdf", "results.json", "tables/t.csv")
OTHERS = (".stages/entry", "figures/mine.txt", "notes.txt")


@pytest.fixture(params=["exchanged", "moved"])
def way(request, monkeypatch):
    """Whether the system can exchange two folders: Windows cannot."""
    if request.param == "moved":
        monkeypatch.setattr(swap, "_exchange_names", refused)
    return request.param


def refused(*_: Path) -> None:
    raise OSError


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "output"
    write(folder, "old", OLD)
    write(folder, "mine", OTHERS)
    write(folder / f"{swap.SCRATCH}1", "new", NEW)
    return folder


def write(folder: Path, text: str, names: tuple[str, ...]) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def texts(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*")
        if path.is_file() and not path.relative_to(folder).parts[0].startswith(swap.SCRATCH)
    }


def put(folder: Path) -> None:
    put_in_place(folder / f"{swap.SCRATCH}1", folder, NEW, OLD)


BEFORE = dict.fromkeys(OLD, "old") | dict.fromkeys(OTHERS, "mine")
AFTER = dict.fromkeys(NEW, "new") | dict.fromkeys(OTHERS, "mine")


@pytest.mark.usefixtures("way")
def test_new_files_take_the_place_of_the_old_and_others_stay(folder):
    assert texts(folder) == BEFORE
    put(folder)
    assert texts(folder) == AFTER
    clear(folder)
    assert texts(folder) == AFTER
    assert [path.name for path in folder.parent.iterdir()] == ["output"]
    assert not list(folder.glob(f"{swap.SCRATCH}*"))


def test_there_is_no_moment_with_some_of_either(folder, monkeypatch):
    """What is seen before the one step of the exchange, and after it."""
    exchange, seen = swap._exchange_names, []

    def watched(one: Path, other: Path) -> None:
        seen.append(texts(folder))
        exchange(one, other)
        seen.append(texts(folder))

    monkeypatch.setattr(swap, "_exchange_names", watched)
    put(folder)
    if len(seen) == 1:
        pytest.skip("no exchange of folders here")
    assert seen == [BEFORE, AFTER]


@pytest.mark.usefixtures("way")
def test_everything_is_on_the_disk_before_it_takes_its_place(folder, monkeypatch):
    """What the system was asked to flush, by the numbers of the files."""
    exchange, replace, fsync, flushed = swap._exchange_names, Path.replace, os.fsync, set()
    made = {(folder / f"{swap.SCRATCH}1" / name).stat().st_ino for name in NEW}

    def noted(descriptor: int) -> None:
        fsync(descriptor)
        flushed.add(os.fstat(descriptor).st_ino)

    def checked(step):
        def after_all(path: Path, target: Path) -> None:
            assert made <= flushed
            step(path, target)

        return after_all

    monkeypatch.setattr(os, "fsync", noted)
    monkeypatch.setattr(swap, "_exchange_names", checked(exchange))
    monkeypatch.setattr(Path, "replace", checked(replace))
    put(folder)
    assert texts(folder) == AFTER


@pytest.mark.parametrize("failing", range(len(OLD) + len(NEW)))
def test_where_one_file_cannot_be_moved_those_before_it_are_moved_back(folder, monkeypatch, failing):
    monkeypatch.setattr(swap, "_exchange_names", refused)
    replace, calls = Path.replace, iter(range(100))

    def fails_once(path: Path, target: Path) -> Path:
        if next(calls) == failing:
            raise PermissionError(13, "used by another process", str(path))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", fails_once)
    with pytest.raises(ProjectError):
        put(folder)
    assert texts(folder) == BEFORE


def test_a_file_that_is_open_elsewhere_is_named(folder, monkeypatch):
    """As in a viewer on Windows."""
    monkeypatch.setattr(swap, "_exchange_names", refused)
    replace = Path.replace

    def held(path: Path, target: Path) -> Path:
        if path == folder / "report.pdf":
            raise PermissionError(13, "used by another process", str(path))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", held)
    with pytest.raises(ProjectError) as caught:
        put(folder)
    assert str(caught.value).startswith(
        f"{folder / 'report.pdf'}: cannot be replaced (used by another process); close"
    )


def test_while_files_are_moved_no_results_are_there(folder, monkeypatch):
    """A kill in between leaves nothing that could be taken for the results of either run."""
    monkeypatch.setattr(swap, "_exchange_names", refused)
    replace, there = Path.replace, []

    def noted(path: Path, target: Path) -> Path:
        there.append((folder / "results.json").exists())
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", noted)
    put(folder)
    assert there == [True, *[False] * (len(there) - 1)]
    assert texts(folder) == AFTER


@pytest.mark.parametrize("strange", ["folder", "link"])
def test_a_folder_in_which_others_keep_more_than_files_is_not_exchanged(folder, tmp_path, strange):
    (tmp_path / "elsewhere").mkdir()
    if strange == "link":
        (folder / "theirs").symlink_to(tmp_path / "elsewhere")
    else:
        write(folder, "mine", ("theirs/too.txt",))
    before = folder.stat().st_ino
    put(folder)
    assert folder.stat().st_ino == before
    assert (folder / "theirs").is_symlink() == (strange == "link")
    assert AFTER.items() <= texts(folder).items()


def test_the_folder_of_the_command_is_not_exchanged(folder, monkeypatch):
    """A shell would be left in a folder that is gone."""
    before = folder.stat().st_ino
    monkeypatch.chdir(folder)
    put(Path())
    assert folder.stat().st_ino == before
    assert texts(folder) == AFTER


def test_the_folder_of_a_project_is_not_exchanged(folder):
    """Editors and shells are at work there."""
    (folder / "project.toml").touch()
    before = folder.stat().st_ino
    put(folder)
    assert folder.stat().st_ino == before
    assert AFTER.items() <= texts(folder).items()


@pytest.mark.usefixtures("way")
def test_a_link_to_the_folder_stays_one(folder, tmp_path):
    (tmp_path / "link").symlink_to(folder)
    put(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert texts(folder) == AFTER


@pytest.mark.usefixtures("way")
def test_a_folder_keeps_its_permissions(folder):
    folder.chmod(0o750)
    put(folder)
    assert folder.stat().st_mode & 0o777 == 0o750


def test_what_a_kill_left_is_cleared(folder):
    beside = folder.with_name(f".output{swap.SCRATCH}2")
    (folder / f"{swap.SCRATCH}1").rename(beside)
    write(folder / f"{swap.SCRATCH}3", "half made", ("figures/a.svg",))
    clear(folder)
    assert contents(folder.parent).keys() == {f"output/{name}" for name in (*OLD, *OTHERS)} - {
        "output/.stages/entry"
    }
