"""What does not fit together in a project: names of nothing, missing files, tables that contradict each other."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path
from typing import Any

from assessment.project.schema.content import ProjectContent
from assessment.project.schema.index import tables_of
from assessment.project.schema.values import DISTINCT, MOST_ENTRIES, FileName, KeyPath, NameOf, Problem, Table
from assessment.runtime.errors import nearest
from assessment.runtime.files.pictures import SUFFIXES, read_picture
from mechanics.messages import layer_key

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
        text = f'"{name}" is no {" or ".join(SUFFIXES)} file; export it, a PDF page by page, as one'
        yield Problem(path, text)
    else:
        try:
            read_picture(folder / name)
        except ValueError as error:
            yield Problem(path, f'"{name}" cannot be read as a picture ({error}); export it again')


def _record_problems(folder: Path, path: KeyPath, pattern: str) -> Iterator[Problem]:
    """Yield a problem for a pattern that no file matches; "generate:7" is none."""
    if pattern.startswith("generate:"):
        return
    try:
        found = matches(folder, pattern)
    except ValueError as error:
        yield Problem(path, f'"{pattern}": {error}')
        return
    if not found:
        yield from missing_file(folder, path, pattern)


FILES = {"file": missing_file, "pattern": _record_problems, "picture": attachment_problems}


def content_problems(project: ProjectContent, folder: Path) -> Iterator[Problem]:
    """Yield every problem between the tables of a project, and of the files that they name, in the order of the tables.

    `folder`: of the project. Files that cannot be read are problems too, no errors.
    """
    valid = {
        "control point": [each.name for each in project.control],
        "support": [*project.supports],
        "settlement": [*project.unstrengthened[1:]],
        "state": [*project.states],
    }
    for path, table in _tables(project, ()):
        for key, field in type(table).model_fields.items():
            value = getattr(table, key)
            for mark in field.metadata:
                if isinstance(mark, NameOf):
                    for place, name in _named(value, (*path, key)):
                        if name not in (known := valid[mark.what]):
                            remedy = nearest(name, known) if known else f"add a {mark.what}"
                            yield Problem(place, f'no {mark.what} "{name}"; {remedy}')
                elif isinstance(mark, FileName):
                    for place, name in _named(value, (*path, key)):
                        yield from FILES[mark.kind](folder, place, name)
                elif mark == DISTINCT:
                    yield from _repeated(value, (*path, key))
        for found in table.contradictions(project):
            if isinstance(found, Problem):
                yield found
            else:
                where, text = found
                yield Problem((*path, where) if isinstance(where, str) else (*path, *where), text)


def _tables(table: Table, path: KeyPath) -> Iterator[tuple[KeyPath, Table]]:
    """Yield a table and those in it with their paths."""
    yield path, table
    for key, form in tables_of(type(table)).items():
        value: Any = getattr(table, key)
        if value is None:
            continue
        if form == "single":
            yield from _tables(value, (*path, key))
        else:
            for name, each in value.items() if form == "named" else enumerate(value):
                yield from _tables(each, (*path, key, name))


def _named(value: Any, path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """Yield the names in a value with their paths: of a table the values, or the keys of lists."""
    if isinstance(value, str):
        yield path, value
    elif isinstance(value, dict):
        for key, each in value.items():
            yield (*path, key), each if isinstance(each, str) else key
    elif value is not None:
        for index, each in enumerate(value):
            yield from _named(each, (*path, index))


def _repeated(tables: Any, path: KeyPath) -> Iterator[Problem]:
    """Yield a problem for each list entry with the name of an earlier one, and each second table of a layer."""
    earlier: dict[str, str] = {}
    if isinstance(tables, dict):
        for name in tables:
            if (other := earlier.setdefault(layer_key(name), name)) != name:
                yield Problem((*path, name), f'the layer of "{other}" again, spelt otherwise; keep one table')
        return
    for index, name in enumerate(each.name for each in tables):
        if name in earlier:
            yield Problem((*path, index, "name"), f'"{name}" is the name of an earlier entry; write another')
        if name is not None:
            earlier[name] = name
