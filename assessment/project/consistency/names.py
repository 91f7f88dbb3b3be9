"""Names in a project file: each given once, and every reference to one that exists."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from assessment.project.errors import Problem
from assessment.project.schema import KeyPath
from assessment.runtime.errors import nearest


def repeated_names(table: str, names: list[str | None]) -> Iterator[Problem]:
    """Yield a problem for each entry of a table with the name of an earlier one; None: an entry without a name."""
    earlier: set[str] = set()
    for index, name in enumerate(names):
        if name is None:
            continue
        if name in earlier:
            yield Problem((table, index, "name"), f'"{name}" is the name of an earlier entry; write another')
        earlier.add(name)


def unknown_name(path: KeyPath, name: str, valid: Iterable[str], what: str) -> Iterator[Problem]:
    """Yield a problem for a reference to a `name` that is not among the `valid` ones; `what`: what it should name."""
    names = list(valid)
    if name not in names:
        yield Problem(path, f'no {what} "{name}"; {nearest(name, names) if names else f"add a {what}"}')
