"""Names of a project's tables: given once, and referred to as they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from assessment.project.errors import Problem
from assessment.project.schema import KeyPath
from assessment.runtime.errors import nearest


def repeated_names(table: str, names: list[str | None]) -> Iterator[Problem]:
    """Yield the entries of a table that have the name of an earlier one."""
    earlier: set[str] = set()
    for index, name in enumerate(names):
        if name is None:
            continue
        if name in earlier:
            yield Problem((table, index, "name"), f'"{name}" is the name of an earlier entry; write another')
        earlier.add(name)


def unknown_name(path: KeyPath, name: str, valid: Iterable[str], what: str) -> Iterator[Problem]:
    """Yield the problem of a name that is none of the `valid` ones; `what` is named."""
    names = list(valid)
    if name not in names:
        yield Problem(path, f'no {what} "{name}"; {nearest(name, names) if names else f"add a {what}"}')
