"""A project's content as TOML text, read and written."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from assessment.project.schema import KeyPath
from assessment.runtime.errors import ProjectError, shortened

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_DECIMAL_COMMA = re.compile(r"(?<![\w.,])([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)(?![\w.]|,\d)")
_TEXT = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")  # in which no number is looked for
_LONG_KEY = re.compile(r"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){40}""")
MOST_BYTES = 2_000_000  # of a project file
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; raises ProjectError with line and column where it is none."""
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise ProjectError(
            f"{path.name}: file: more than {MOST_BYTES} bytes; keep what describes the project"
        )
    raw = raw.removeprefix(_BYTE_ORDER_MARK)
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        number = raw.count(b"\n", 0, error.start) + 1
        raise ProjectError(f"{path.name}: line {number}: not UTF-8 text; save the file as UTF-8") from None
    if key := _LONG_KEY.search(text):  # no key has so many, and the time to read one grows with their square
        number = text.count("\n", 0, key.start()) + 1
        raise ProjectError(
            f"{path.name}: line {number}: a key of 40 parts or more; write [table] and key = value"
        )
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ProjectError(f"{path.name}: file: brackets within brackets without end; close them") from None
    except ValueError as error:  # TOMLDecodeError, or a number of thousands of digits
        raise ProjectError(f"{path.name}: {_syntax(text, str(error))}") from None


def to_toml(content: Mapping[str, Any]) -> str:
    """Return the TOML text of a project's content: plain values, lists, tables and lists of tables."""
    lines: list[str] = []
    for path, table in toml_tables(content):
        lines += [*toml_header(path), *(toml_line(key, value) for key, value in plain_values(table).items())]
    return "\n".join(lines).strip() + "\n"


def toml_tables(table: Mapping[str, Any], path: KeyPath = ()) -> Iterator[tuple[KeyPath, Mapping[str, Any]]]:
    """Yield the tables of the content with their paths, in the order of the file; not those of tables only."""
    if plain_values(table) or not table:
        yield path, table
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from toml_tables(value, (*path, key))
        elif _is_tables(value):
            for number, entry in enumerate(value):
                yield from toml_tables(entry, (*path, key, number))


def plain_values(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a table holds beside tables and lists of tables."""
    return {key: value for key, value in table.items() if not _is_tables(value)}


def toml_header(path: KeyPath) -> list[str]:
    """Return the lines that open the table at `path`: an empty one and its name in brackets."""
    name = ".".join(_key(part) for part in path if isinstance(part, str))
    return ["", f"[[{name}]]" if isinstance(path[-1], int) else f"[{name}]"] if path else []


def toml_line(key: str, value: Any) -> str:
    """Return a key with its value."""
    return f"{_key(key)} = {_value(value)}"


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
    remedy = (
        f"write a decimal point, not a comma: {shortened(f'{comma[1]}.{comma[2]}')}"
        if comma
        else "texts stand in quotes, decimals have a point, a table or key appears once"
    )
    return f"line {number}, column {column}: {what[:1].lower()}{what[1:]}: {shortened(line)}; {remedy}"


def _is_tables(value: Any) -> bool:
    """Whether the value is a table or a list of tables, which stand after the plain values."""
    return isinstance(value, Mapping) or (
        isinstance(value, list | tuple) and bool(value) and all(isinstance(each, Mapping) for each in value)
    )


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _value(value: Any) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)


def _text(text: str) -> str:
    named = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
    return (
        '"'
        + "".join(named.get(c) or (c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}") for c in text)
        + '"'
    )
