"""What is wrong in a project: keys, types, ranges; then what does not fit together. `FILE: KEY: what; what to do`."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from glob import has_magic, iglob
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from assessment.project.schema import GENERATED, ProjectContent, entries_of, keys_at, tables_of
from assessment.project.schema import values as kinds
from assessment.runtime.errors import ProjectError, alike, nearest, shortened
from assessment.runtime.files import SUFFIXES, read_picture
from mechanics.messages import layer_key

_QUOTED = re.compile(r"\s*([+-]?\d+)([.,]\d+)?\s*")  # a number that was written as a text

_MOST_TOLD = 24  # problems of a file: one screen

_EXPECTED = {
    "float_type": "a number",
    "finite_number": "a finite number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "string_type": "a text",
    "tuple_type": "a list in brackets",
    "dict_type": "a table",
    "model_type": "a table",
    "greater_than_equal": "a number not less than {ge:g}",
    "less_than": "a number less than {lt:g}",
    "less_than_equal": "a number not greater than {le:g}",
    "literal_error": "{expected}",
    "missing": "two numbers",  # only of a pair: a missing key is another message
    "too_long": "at most {max_length} entries",
    "too_short": "a list of {min_length} or more entries",
    "string_too_long": "at most {max_length} characters",
    "string_pattern_mismatch": "a text without control characters or blanks at its ends, not empty",
    "string_unicode": "a text of whole characters",
}


def project_error(
    file: str, problems: Iterable[kinds.Problem], cells: Mapping[kinds.KeyPath, str]
) -> ProjectError:
    """The problems of one file as one error of one screen; `cells`: where the values are in a spreadsheet."""
    told = dict[str, None]()
    for path, text in problems:
        at = next((cells[path[:n]] for n in range(len(path), 0, -1) if path[:n] in cells), "")
        told[f"{file}: {kinds.key_of(path)}{f' ({at})' if at else ''}: {text}"] = None
    lines = [*told]
    if (more := len(lines) - _MOST_TOLD) > 0:
        lines[_MOST_TOLD:] = [f"{file}: project: {more} more problems; correct these first"]
    return ProjectError("\n".join(lines))


def schema_problems(error: ValidationError, content: Mapping[str, Any]) -> list[kinds.Problem]:
    """Return what is wrong in `content` for each of pydantic's errors, alternatives of a value joined."""
    expected: dict[kinds.KeyPath, list[str]] = {}
    problems: dict[kinds.KeyPath, str] = {}
    meant, missing = set[kinds.KeyPath](), set[kinds.KeyPath]()
    for detail in error.errors(include_url=False):
        kind, context = detail["type"], detail.get("ctx", {})
        path, node = _walk(detail["loc"], content)
        value = detail["input"]
        parts = value if path[-1:] == ("region_m",) and isinstance(value, list) else [value]
        if kind == "extra_forbidden":
            key, names = path[-1], (str(path[-1]), keys_at(path[:-1]))
            homes = [f"[{entry[0]}]" for entry in entries_of(ProjectContent) if key in keys_at(entry)]
            if any(each.startswith(f"{key}_") for each in names[1]):  # its unit is left out
                homes = []
            remedy = f"it is a key of {' and '.join(homes)}" if homes else nearest(*names)
            problems[path] = f"unknown key; {remedy}"
            meant |= {(*path[:-1], each) for each in alike(*names) if not homes}
        elif kind == "missing" and isinstance(node, dict):
            missing.add(place := (*path, key := str(detail["loc"][-1])))
            problems[place] = f"missing; add it ({keys_at(path)[key]})"
        elif "region_m" in path and any(isinstance(part, list) for part in parts):
            flat = f"{_shown(value)} is wrong; write one flat list: [x1, z1, x2, z2, …]"
            problems.setdefault(path[: path.index("region_m") + 1], flat)
        elif kind == "value_error":
            problems[path] = str(context["error"])
        else:
            expected.setdefault(path, []).append(_phrase(path, detail).replace("'", '"'))
            problems[path] = f"{_shown(value)} is wrong; write {' or '.join(expected[path])}"
    # Of the alternatives of one value, the one that was understood further gives the message.
    shallow = {path[:n] for path in problems for n in range(len(path)) if path[:n] in expected}
    there = missing & meant  # under another name
    return [kinds.Problem(path, text) for path, text in problems.items() if path not in shallow | there]


def _walk(location: tuple[str | int, ...], content: Any) -> tuple[kinds.KeyPath, Any]:
    """Return the part of pydantic's location that the user wrote, and the value there."""
    path: kinds.KeyPath = ()
    node = content
    for part in location:
        children = dict(enumerate(node)) if isinstance(node, list) else node
        if isinstance(children, dict) and part in children:
            node, path = children[part], (*path, part)
    return path, node


def _phrase(path: kinds.KeyPath, detail: Mapping[str, Any]) -> str:
    """Return what is expected in the place of a value that pydantic refuses."""
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    if kind == "tuple_type" and isinstance(value, dict) and len(path) == 1:
        return f"[[{path[-1]}]] with double brackets, one per entry"
    if kind == "model_type" and isinstance(value, list):
        return f"[{kinds.key_of(path)}] with single brackets, once"
    if kind == "greater_than_equal" and 0.0 < context["ge"] < 0.01 and not value > 0.0:
        return "a number greater than 0"
    if kind == "too_long" and context["max_length"] == 2:  # [0,6] of one number, or [0,6, 0,8] of two
        return "two numbers" + (", with decimal points" if all(type(each) is int for each in value) else "")
    expected = _EXPECTED[kind].format(**context) if kind in _EXPECTED else str(detail["msg"])
    if kind == "float_type" and isinstance(value, str) and _QUOTED.fullmatch(value):
        point = "with a decimal point and " if "," in value else ""
        expected += f", {point}without quotes: {shortened(value.strip().replace(',', '.'), kinds.SHOWN)}"
    if kind == "tuple_type" and isinstance(value, str):
        expected += f": {_shown([value])}"
    return expected


def _shown(value: Any) -> str:
    text = json.dumps(_pruned(value), ensure_ascii=False, default=str)
    for name, own in (("-Infinity", "-inf"), ("Infinity", "inf"), ("NaN", "nan")):
        text = own if text == name else text
    return shortened(text, kinds.SHOWN)


def _pruned(value: Any, levels: int = 3) -> Any:
    """Return as much of a value as a message shows: of nested ones, and of numbers of thousands of digits, little."""
    if isinstance(value, int) and value.bit_length() > 1000:
        return f"a number of some {0.30103 * value.bit_length():.0f} digits"
    if not isinstance(value, dict | list | tuple):
        return value
    if levels == 0:
        return "…"
    if isinstance(value, dict):
        return {str(key): _pruned(each, levels - 1) for key, each in islice(value.items(), kinds.SHOWN)}
    return [_pruned(each, levels - 1) for each in value[: kinds.SHOWN]]


def matches(folder: Path, pattern: str) -> list[Path]:
    """Return the files in `folder` that match a name, or a pattern such as "records/*.acc", sorted.

    Raises ValueError for `**`, patterns in more than two parts, whose search may never end, and too many files.
    """
    if _is_file(folder / pattern):
        return [folder / pattern]
    if "**" in pattern:
        raise ValueError("** is not understood; name the folders, * for each")
    if sum(map(has_magic, Path(pattern).parts)) > 2:
        raise ValueError("patterns in more than two parts; name the folders")
    named = iglob(pattern, root_dir=folder)  # noqa: PTH207 - of an absolute pattern too
    found = filter(_is_file, map(folder.joinpath, named))
    files = sorted(islice(found, kinds.MOST_ENTRIES + 1))
    if len(files) > kinds.MOST_ENTRIES:
        raise ValueError(f"more than {kinds.MOST_ENTRIES} files; choose among them")
    return files


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # the name is too long or no valid one, or the folder must not be searched
        return False


def wrong_file(kind: str, folder: Path, name: str) -> str | None:
    """Return what is wrong with the name of a file, pattern or picture, None: nothing; `kind`: see FileName."""
    if kind in ("pattern", "records"):
        try:
            if (kind == "records" and name.startswith(GENERATED)) or matches(folder, name):
                return None
        except ValueError as error:
            return f'"{name}": {error}'
    if not _is_file(folder / name):
        parent = Path(name).parent
        names = iglob("*", root_dir=folder / parent)  # noqa: PTH207 - of a folder that cannot be read none
        beside = islice(names, kinds.MOST_ENTRIES)
        files = sorted(str(parent / each) for each in beside if _is_file(folder / parent / each))
        same_kind = [each for each in files if Path(each).suffix.lower() == Path(name).suffix.lower()]
        remedy = nearest(name, same_kind) if same_kind else "put it there or correct the name"
        if (folder / name).is_dir():
            return f'"{name}" is a folder; name a file'
        return f'no file "{name}" in the project folder; {remedy}'
    if kind == "picture" and Path(name).suffix.lower() not in SUFFIXES:
        return f'"{name}" is no {" or ".join(SUFFIXES)} file; export it, a PDF page by page, as one'
    if kind == "picture":
        try:
            read_picture(folder / name)
        except ValueError as error:
            return f'"{name}" cannot be read as a picture ({error}); export it again'
    return None


def content_problems(project: ProjectContent, folder: Path) -> Iterator[kinds.Problem]:
    """Yield every problem between the tables of a project in `folder`, and of files that they name, in order."""
    valid = {
        "control point": [each.name for each in project.control], "support": [*project.supports],
        "settlement": [*project.unstrengthened[1:]], "state": [*project.states],
    }  # fmt: skip
    for path, table in _tables(project, ()):
        for key, field in type(table).model_fields.items():
            value = getattr(table, key)
            for mark in field.metadata:
                if isinstance(mark, kinds.NameOf):
                    for place, name in _named(value, (*path, key)):
                        if name not in (known := valid[mark.what]):
                            remedy = nearest(name, known) if known else f"add a {mark.what}"
                            yield kinds.Problem(place, f'no {mark.what} "{name}"; {remedy}')
                elif isinstance(mark, kinds.FileName):
                    for place, name in _named(value, (*path, key)):
                        if wrong := wrong_file(mark.kind, folder, name):
                            yield kinds.Problem(place, wrong)
                elif mark == kinds.DISTINCT:
                    yield from _repeated(value, (*path, key))
        for found in table.contradictions(project):
            if isinstance(found, kinds.Problem):
                yield found
            else:
                where, text = found
                yield kinds.Problem((*path, where) if isinstance(where, str) else (*path, *where), text)


def _tables(
    table: kinds.ProjectTable, path: kinds.KeyPath
) -> Iterator[tuple[kinds.KeyPath, kinds.ProjectTable]]:
    yield path, table
    for key, form in tables_of(type(table)).items():
        value: Any = getattr(table, key)
        if form != "single":
            for name, each in value.items() if form == "named" else enumerate(value):
                yield from _tables(each, (*path, key, name))
        elif value is not None:
            yield from _tables(value, (*path, key))


def _named(value: Any, path: kinds.KeyPath) -> Iterator[tuple[kinds.KeyPath, str]]:
    """Yield the names in a value with their paths: of a table the values, or the keys of lists."""
    if isinstance(value, str):
        yield path, value
    elif isinstance(value, dict):
        for key, each in value.items():
            yield (*path, key), each if isinstance(each, str) else key
    elif value is not None:
        for index, each in enumerate(value):
            yield from _named(each, (*path, index))


def _repeated(tables: Any, path: kinds.KeyPath) -> Iterator[kinds.Problem]:
    """Yield a problem for each list entry with the name of an earlier one, and each second table of a layer."""
    earlier: dict[str, str] = {}
    if isinstance(tables, dict):
        for name in tables:
            if (other := earlier.setdefault(layer_key(name), name)) != name:
                text = f'the layer of "{other}" again, spelt otherwise; keep one table'
                yield kinds.Problem((*path, name), text)
        return
    names = [each.name for each in tables]
    for index, name in enumerate(names):
        if name is not None and name in names[:index]:
            text = f'"{name}" is the name of an earlier entry; write another'
            yield kinds.Problem((*path, index, "name"), text)
