"""Files that a project names: whether they exist, and which files match a pattern."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path

from assessment.project.errors import Problem
from assessment.project.schema import MOST_ENTRIES, KeyPath
from assessment.runtime.errors import nearest
from assessment.runtime.files.pictures import SUFFIXES, read_picture

MOST_LOOKED_AT = 20_000  # names in folders that the search for a pattern reads at most
_WILD = re.compile(r"[*?[]")


def matches(folder: Path, pattern: str) -> list[Path]:
    """Return the files in `folder` that match a name, or a pattern such as "records/*.acc", sorted.

    Raises ValueError for `**`, for a pattern that would search more than MOST_LOOKED_AT names, and for more than
    MOST_ENTRIES files.
    """
    if _is_file(folder / pattern):
        return [folder / pattern]
    if "**" in pattern:
        raise ValueError("** is not understood; name the folders, * for each")
    found, looked_at = [folder], 0
    for part in Path(pattern).parts:
        if not _WILD.search(part):
            found = [path / part for path in found]
            continue
        within: list[Path] = []
        for path in found:
            for name in _names(path):
                looked_at += 1
                if looked_at > MOST_LOOKED_AT:
                    raise ValueError(f"more than {MOST_LOOKED_AT} names to look at; name the folders")
                if fnmatch(name, part) and (part.startswith(".") or not name.startswith(".")):
                    within.append(path / name)
        found = within
    files = sorted(path for path in found if _is_file(path))
    if len(files) > MOST_ENTRIES:
        raise ValueError(f"{len(files)} files, at most {MOST_ENTRIES}; choose among them")
    return files


def _names(folder: Path) -> Iterator[str]:
    """Yield the names in a folder; nothing where the folder does not exist or must not be read."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            yield entry.name


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # the name is too long or no valid one, or the folder must not be searched
        return False


def missing_file(folder: Path, path: KeyPath, name: str | None) -> Iterator[Problem]:
    """Yield a problem where a file is named that is not in the project folder.

    `path`: the key that names it; `name`: None where no file is named.
    """
    if name is not None and not _is_file(folder / name):
        parent = Path(name).parent
        names = islice(_names(folder / parent), MOST_ENTRIES)
        files = sorted(str(parent / each) for each in names if _is_file(folder / parent / each))
        remedy = nearest(name, files) if files else "put it there or correct the name"
        yield Problem(path, f'no file "{name}" in the project folder; {remedy}')


def attachment_problems(folder: Path, path: KeyPath, name: str) -> Iterator[Problem]:
    """Yield a problem for an attachment of the report that does not exist or is no picture that can be printed."""
    if missing := list(missing_file(folder, path, name)):
        yield from missing
    elif Path(name).suffix.lower() not in SUFFIXES:
        yield Problem(
            path, f'"{name}" is no {" or ".join(SUFFIXES)} file; export it, a PDF page by page, as one'
        )
    else:
        try:
            read_picture(folder / name)
        except ValueError as error:
            yield Problem(path, f'"{name}" cannot be read as a picture ({error}); export it again')
