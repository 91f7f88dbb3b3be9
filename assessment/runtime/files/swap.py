"""Finished files in the place of earlier ones: all of them or none.

Where the system can exchange two folders (Linux, macOS) that is one step: whoever looks, and whoever is killed, finds
the old files or the new ones. Elsewhere files are moved one by one, and back again where one cannot be.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path

from assessment.runtime.errors import ProjectError
from assessment.runtime.files.atomic_files import clear_left_over

SCRATCH = ".assesto-"  # prefix of the folders where files are written before they are moved
LAST = "results.json"  # moved last, and removed first: if it is new, all files are
OWN = frozenset(
    {"figures", "tables", "attachments", ".stages"}
)  # folders that may be within one that is exchanged
HERE, EXCHANGE = -100, 2  # AT_FDCWD; RENAME_EXCHANGE of Linux, RENAME_SWAP of macOS


def clear(folder: Path) -> None:
    """Remove unfinished files of runs that were killed; the folder has to be locked."""
    clear_left_over(folder)
    for left in [*folder.glob(f"{SCRATCH}*"), *folder.parent.glob(f".{folder.name}{SCRATCH}*")]:
        shutil.rmtree(left, ignore_errors=True)


def put_in_place(new: Path, folder: Path, made: Collection[str], gone: Collection[str]) -> None:
    """Put files made in `new`, a folder within `folder`, in the place of those `gone`; all else in `folder` stays.

    Names are relative, with slashes. The replaced files are left in `new`. Raises ProjectError that names a file which
    cannot be replaced (on Windows one that is open elsewhere), OSError otherwise; the folder is then unchanged.
    """
    for name in made:
        _flush(new / name)
    try:
        _exchange(new, folder.resolve(), {*made, *gone})
    except OSError:
        old = [name for name in {*gone, *made} if (folder / name).exists()]
        away = [(folder / name, new / ".old" / name) for name in sorted(old, key=LAST.__ne__)]
        try:
            _move([*away, *((new / name, folder / name) for name in sorted(made, key=LAST.__eq__))])
        except PermissionError as error:
            raise ProjectError(
                f"{error.filename}: cannot be replaced ({error.strerror}); close it where it is open and run again: "
                "nothing of the earlier result was changed, finished analyses are kept"
            ) from error


def _exchange(new: Path, folder: Path, ours: Collection[str]) -> None:
    """Exchange the two folders; files in the old one that are not `ours` are linked into the new one first.

    Raises OSError if the system or the disk cannot do it or the folder holds unknown folders, and if it should not be
    replaced: it is the working directory, or holds the project.
    """
    if Path.cwd().is_relative_to(folder) or any(folder.glob("project.*")):
        raise OSError(errno.EBUSY, "is somebody's place of work", str(folder))
    for name in _others(folder, ours):
        if not (new / name).exists():
            (new / name).parent.mkdir(exist_ok=True)
            os.link(folder / name, new / name)
    shutil.copystat(folder, new)
    if (new.stat().st_uid, new.stat().st_gid) != (folder.stat().st_uid, folder.stat().st_gid):
        raise PermissionError(errno.EPERM, "belongs to somebody else", str(folder))
    for each in (new, *(path for path in new.iterdir() if path.is_dir())):
        _flush(each)
    beside = folder.with_name(f".{folder.name}{new.name}")
    new.rename(beside)
    try:
        _exchange_names(beside, folder)
    except OSError:
        beside.rename(new)
        raise
    with suppress(OSError):  # left over beside: the next run removes it
        beside.rename(folder / new.name)
    _flush(folder.parent)


def _others(folder: Path, ours: Collection[str]) -> list[str]:
    """Return the files in a folder, and in our folders within it, that are not ours; OSError for anything else."""
    found = []
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink() and path.name in OWN:
            found += [f"{path.name}/{each.name}" for each in path.iterdir()]
        elif not path.name.startswith(SCRATCH):
            found.append(path.name)
    others = [name for name in found if name not in ours]
    for name in others:
        if (folder / name).is_symlink() or not (folder / name).is_file():
            raise OSError(errno.EINVAL, "no plain file", name)
    return others


def _exchange_names(one: Path, other: Path) -> None:
    """Exchange what two paths name, in one step; OSError where the system or the file system cannot."""
    try:
        system = ctypes.CDLL(None, use_errno=True)
        if hasattr(system, "renamex_np"):  # macOS
            failed = system.renamex_np(os.fsencode(one), os.fsencode(other), EXCHANGE)
        else:
            failed = system.renameat2(HERE, os.fsencode(one), HERE, os.fsencode(other), EXCHANGE)
    except (TypeError, AttributeError):  # Windows; a C library without it
        raise OSError(errno.ENOTSUP, "no exchange of folders") from None
    if failed:
        raise OSError(ctypes.get_errno(), "no exchange of folders")


def _move(moves: Sequence[tuple[Path, Path]]) -> None:
    """Rename files one by one; if one cannot be renamed, rename those before it back."""
    done: list[tuple[Path, Path]] = []
    try:
        for source, target in moves:
            target.parent.mkdir(parents=True, exist_ok=True)
            source.replace(target)
            done.append((source, target))
    except BaseException:
        for source, target in reversed(done):
            target.replace(source)
        raise


def _flush(path: Path) -> None:
    """Flush a file or a folder to the disk; Windows cannot flush a folder."""
    if path.is_dir() and os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
