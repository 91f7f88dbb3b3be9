"""Finished files take the place of earlier ones at once; what killed processes left goes, and nobody else's."""

import os
from pathlib import Path

import pytest

from assessment.runtime.errors import ProjectError
from assessment.runtime.files import SCRATCH, WRITTEN, clear, put_in_place

OLD = ("figures/a.svg", "figures/b.svg", "report.pdf", "results.json", "tables/t.csv")
NEW = ("figures/b.svg", "figures/c.svg", "report.pdf", "results.json", "tables/t.csv")
OTHERS = (".stages/entry", "figures/mine.txt", "notes.txt")


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "output"
    write(folder, "old", OLD)
    write(folder, "mine", OTHERS)
    write(folder / f"{SCRATCH}1", "new", NEW)
    return folder


def write(folder: Path, text: str, names: tuple[str, ...]) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def texts(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*")
        if path.is_file() and not path.relative_to(folder).parts[0].startswith(SCRATCH)
    }


def put(folder: Path) -> None:
    put_in_place(folder / f"{SCRATCH}1", folder, NEW, OLD)


BEFORE = dict.fromkeys(OLD, "old") | dict.fromkeys(OTHERS, "mine")
AFTER = dict.fromkeys(NEW, "new") | dict.fromkeys(OTHERS, "mine")


def test_new_files_take_the_place_of_the_old_and_others_stay(folder):
    assert texts(folder) == BEFORE
    put(folder)
    assert texts(folder) == AFTER
    clear(folder)
    assert texts(folder) == AFTER
    assert [path.name for path in folder.parent.iterdir()] == ["output"]
    assert not list(folder.glob(f"{SCRATCH}*"))


def test_everything_is_on_the_disk_before_it_takes_its_place(folder, monkeypatch):
    """What the system was asked to flush, by the numbers of the files."""
    replace, fsync, flushed = Path.replace, os.fsync, set()
    made = {(folder / f"{SCRATCH}1" / name).stat().st_ino for name in NEW}

    def noted(descriptor: int) -> None:
        fsync(descriptor)
        flushed.add(os.fstat(descriptor).st_ino)

    def checked(step):
        def after_all(path: Path, target: Path) -> None:
            assert made <= flushed
            step(path, target)

        return after_all

    monkeypatch.setattr(os, "fsync", noted)
    monkeypatch.setattr(Path, "replace", checked(replace))
    put(folder)
    assert texts(folder) == AFTER


def moves_fail(monkeypatch, which, error):
    """Of the moves of files those that are `which` end in an error."""
    replace, calls = Path.replace, iter(range(100))

    def moved(path: Path, target: Path) -> Path:
        if next(calls) in which:
            raise error
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", moved)


@pytest.mark.parametrize("failing", range(len(OLD) + len(NEW)))
def test_where_one_file_cannot_be_moved_those_before_it_are_moved_back(folder, monkeypatch, failing):
    moves_fail(monkeypatch, [failing], PermissionError(13, "used by another process"))
    with pytest.raises(ProjectError):
        put(folder)
    assert texts(folder) == BEFORE


@pytest.mark.parametrize("moves", range(1, len(OLD) + len(NEW)))
def test_a_kill_between_two_moves_leaves_no_results(folder, monkeypatch, moves):
    """The next run then writes them: results.json goes first and comes last."""
    moves_fail(
        monkeypatch, range(moves, 100), KeyboardInterrupt
    )  # again where the others are to be moved back
    with pytest.raises(KeyboardInterrupt):
        put(folder)
    assert "results.json" not in texts(folder)


def test_what_a_killed_process_left_goes(tmp_path):
    others = [".a.tmp", "a.1.tmp", ".a.b.tmp", ".a.svg.3.tmp"]
    for name in (".a.svg.2.tmp", ".project.xlsx.2.tmp", *others):
        (tmp_path / name).touch()
        written = (tmp_path / name).stat().st_mtime - (0.0 if name == others[-1] else 2.0 * WRITTEN)
        os.utime(tmp_path / name, (written, written))
    clear(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*others}
