"""A project's content as TOML text: read, and written with the meaning beside each key."""

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from assessment.project.schema import KeyPath, ProjectTable, entries_of, keys_at, table_at, tables_of
from assessment.runtime.errors import ProjectError, shortened

_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_DECIMAL_COMMA = re.compile(r"(?<![\w.,])([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)(?![\w.]|,\d)")
_TEXT = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")  # in which no number is looked for
_LONG_KEY = re.compile(r"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){40}""")
MOST_BYTES = 2_000_000  # of a project file
COLUMN = 40  # where the meanings begin
MARK = {"en": "TO FILL IN: ", "it": "DA COMPILARE: "}


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; raises ProjectError with line and column where it is none."""
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        text = f"more than {MOST_BYTES} bytes; keep what describes the project"
        raise ProjectError(f"{path.name}: file: {text}")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        number = error.object.count(b"\n", 0, error.start) + 1
        raise ProjectError(f"{path.name}: line {number}: not UTF-8 text; save the file as UTF-8") from None
    if key := _LONG_KEY.search(text):  # no key has so many, and the time to read one grows with their square
        number = text.count("\n", 0, key.start()) + 1
        text = "a key of 40 parts or more; write [table] and key = value"
        raise ProjectError(f"{path.name}: line {number}: {text}")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ProjectError(f"{path.name}: file: brackets within brackets without end; close them") from None
    except ValueError as error:  # TOMLDecodeError, or a number of thousands of digits
        raise ProjectError(f"{path.name}: {_syntax(text, str(error))}") from None


def commented_toml(content: Mapping[str, Any], marked: Collection[KeyPath] = ()) -> str:
    """TOML text of a project's content with the meaning of every table and key beside it.

    What is left out is commented out with its default, whole tables at the end. `marked`: keys that begin with MARK.
    """
    explained: set[type[ProjectTable]] = set()
    lines: list[str] = []
    absent: list[KeyPath] = []
    for path, given in _tables(content):
        lines += _header(path)
        for key, value in _plain(given).items():
            mark = MARK["en"] if (*path, key) in marked else ""
            lines.append(_beside(_line(key, value), mark + keys_at(path).get(key, "")))
        if (table := table_at(path)) and table not in explained:
            explained.add(table)
            lines += _left_out(path, given)
            absent = [(*path, *entry) for entry in entries_of(table) if not given.get(str(entry[0]))] + absent
    for path in absent:
        lines += _table_left_out(path)
    return "\n".join(lines).strip() + "\n"


def _header(path: KeyPath, mark: str = "") -> list[str]:
    if not path:
        return []
    # an entry of a list
    named = path[:-1] if len(path) > 1 and table_at(path[:-1]) is table_at(path) else path
    return ["", _beside(mark + toml_header(path), keys_at(named[:-1]).get(str(named[-1])))]


def _left_out(path: KeyPath, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of the table at `path` that are not given, with their defaults."""
    table = table_at(path) or ProjectTable
    for key, meaning in keys_at(path).items():
        if key not in given and key not in tables_of(table):
            field = table.model_fields[key]
            known = not field.is_required() and field.default is not None
            yield _beside(f"# {_line(key, field.default) if known else f'{key} = …'}", meaning)


def _table_left_out(path: KeyPath) -> Iterator[str]:
    yield from _header(path, mark="# ")
    yield from _left_out(path, {})
    for entry in entries_of(table_at(path) or ProjectTable):
        yield from _table_left_out((*path, *entry))


def _beside(line: str, meaning: str | None) -> str:
    return f"{line:<{COLUMN}} # {meaning}" if meaning else line


def _tables(table: Mapping[str, Any], path: KeyPath = ()) -> Iterator[tuple[KeyPath, Mapping[str, Any]]]:
    """Yield the tables of the content with their paths, in the order of the file; not those of tables only."""
    if _plain(table) or not table:
        yield path, table
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _tables(value, (*path, key))
        elif _is_tables(value):
            for number, entry in enumerate(value):
                yield from _tables(entry, (*path, key, number))


def _plain(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a table holds beside tables and lists of tables."""
    return {key: value for key, value in table.items() if not _is_tables(value)}


def toml_header(path: KeyPath) -> str:
    """Return the name of the table at `path` in brackets."""
    name = ".".join(_key(part) for part in path if isinstance(part, str))
    return f"[[{name}]]" if isinstance(path[-1], int) else f"[{name}]"


def _line(key: str, value: Any) -> str:
    return f"{_key(key)} = {inline(value)}"


def inline(value: Any) -> str:
    """Return a value on one line, tables in braces."""
    import tomlkit

    if isinstance(value, Mapping):
        return f"{{ {', '.join(_line(key, each) for key, each in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(inline, value))}]"
    return str(tomlkit.item(value).as_string())


def _syntax(text: str, message: str) -> str:
    lines = text.splitlines() or [""]
    place = _PLACE.search(message)
    if place is None or place[1] is None:
        number = max((n for n, line in enumerate(lines, 1) if line.strip()), default=1)
        column = len(lines[number - 1]) + 1
    else:
        number, column = int(place[1]), int(place[2])
    what = shortened(message[: place.start()] if place else message)
    line = text.split("\n")[number - 1].strip()
    comma = _DECIMAL_COMMA.search(_TEXT.sub('""', line))
    if comma:
        given = line.partition("#")[0].strip() if '"' not in line else line
        meant = f"write a decimal point, not a comma: {shortened(f'{comma[1]}.{comma[2]}')}"
        return f"line {number}: {shortened(given)}; {meant}"
    remedy = "texts stand in quotes, decimals have a point, a table or key appears once"
    return f"line {number}, column {column}: {what[:1].lower()}{what[1:]}: {shortened(line)}; {remedy}"


def _is_tables(value: Any) -> bool:
    """Whether the value is a table or a list of tables, which stand after the plain values."""
    listed = isinstance(value, list | tuple) and bool(value)
    return isinstance(value, Mapping) or (listed and all(isinstance(each, Mapping) for each in value))


def _key(key: str) -> str:
    import tomlkit  # late: a run that only reads does not need it

    return tomlkit.key(key).as_string()
