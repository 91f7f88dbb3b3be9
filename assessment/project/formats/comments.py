"""A project file that explains itself: the meaning beside each key, and what else could be written there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from assessment.project.formats.toml import plain_values, toml_header, toml_line, toml_tables
from assessment.project.schema import KeyPath, Table
from assessment.project.schema.index import keys_at, table_at, tables_of

COLUMN = 40  # where the meanings begin
MARK = {"en": "TO FILL IN: ", "it": "DA COMPILARE: "}


def commented_toml(content: Mapping[str, Any], marked: Collection[KeyPath] = ()) -> str:
    """TOML text of a project's content with the meaning of every table and key beside it.

    What the content leaves out stands there too, commented out with its default: keys below those of the first
    table of their kind, whole tables at the end. `marked`: keys whose meaning begins with MARK.
    """
    explained: set[type[Table]] = set()
    lines: list[str] = []
    absent: list[KeyPath] = []
    for path, given in toml_tables(content):
        lines += _header(path)
        for key, value in plain_values(given).items():
            mark = MARK["en"] if (*path, key) in marked else ""
            lines.append(_beside(toml_line(key, value), mark + keys_at(path).get(key, "")))
        table = table_at(path)
        if table and table not in explained:
            explained.add(table)
            lines += _left_out(path, given)
            absent = [(*path, *entry) for entry in _entries(table) if not given.get(str(entry[0]))] + absent
    for path in absent:
        lines += _table_left_out(path)
    return "\n".join(lines).strip() + "\n"


def unset_keys(path: KeyPath, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of the table at `path` that are not given, with their defaults (None: no default)."""
    table = table_at(path)
    fields = table.model_fields if table else {}
    inner = tables_of(table) if table else {}
    return {
        key: None if fields[key].is_required() else fields[key].default
        for key in keys_at(path)
        if key not in given and key not in inner
    }


def _header(path: KeyPath, mark: str = "") -> list[str]:
    if not path:
        return []
    named = (
        path[:-1] if len(path) > 1 and table_at(path[:-1]) is table_at(path) else path
    )  # an entry of a list
    blank, header = toml_header(path)
    return [blank, _beside(mark + header, keys_at(named[:-1]).get(str(named[-1])))]


def _left_out(path: KeyPath, given: Mapping[str, Any]) -> Iterator[str]:
    for key, default in unset_keys(path, given).items():
        line = f"{key} = …" if default is None else toml_line(key, default)
        yield _beside(f"# {line}", keys_at(path)[key])


def _table_left_out(path: KeyPath) -> Iterator[str]:
    yield from _header(path, mark="# ")
    yield from _left_out(path, {})
    table = table_at(path)
    for entry in _entries(table) if table else ():
        yield from _table_left_out((*path, *entry))


def _entries(table: type[Table]) -> list[KeyPath]:
    """Return the tables in a table, as the path of their first entry where there are several."""
    ends: dict[str, KeyPath] = {"single": (), "list": (0,), "named": ("NAME",)}
    return [(name, *ends[form]) for name, form in tables_of(table).items()]


def _beside(line: str, meaning: str | None) -> str:
    return f"{line:<{COLUMN}} # {meaning}" if meaning else line
