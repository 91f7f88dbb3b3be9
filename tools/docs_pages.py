"""The parts of docs/ that are made from the program: keys of the files, validation table, templates, pictures.

`python -m tools.docs_pages` makes them anew.

A part stands between two comments of its page; what is around it is written by hand.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator
from inspect import cleandoc
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel

from assessment.project import schema
from assessment.project.toml import inline, toml_header
from assessment.results.schema import Results
from tools import floor_spectra, templates

ROOT = Path(__file__).parents[1]
NAMES = {float: "number", int: "whole number", str: "text", bool: "true or false", Any: "any value"}


def results_keys() -> str:
    """Return a section for each table of results.json, in the order in which they are met."""
    return "\n".join(_section(table) for table in dict.fromkeys(tables(Results)))


def tables(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield every table below an annotation, as often as it is met; one within itself is met once."""
    yield from _tables(annotation, ())


def _tables(annotation: Any, around: tuple[Any, ...]) -> Iterator[type[BaseModel]]:
    if annotation in around:
        return
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        for field in annotation.model_fields.values():
            yield from _tables(field.annotation, (*around, annotation))
    for inner in get_args(annotation):
        yield from _tables(inner, around)


def _section(table: type[BaseModel]) -> str:
    lines = [
        f"### {table.__name__}",
        "",
        cleandoc(table.__doc__ or ""),
        "",
        "| key | value | unit | is |",
        "|---|---|---|---|",
    ]
    for name, field in table.model_fields.items():
        extra = field.json_schema_extra
        unit = extra.get("unit", "") if isinstance(extra, dict) else ""
        kind = _kind(field.annotation) + ("" if field.is_required() else ", optional")
        lines.append(f"| `{field.alias or name}` | {kind} | {unit} | {field.description} |")
    return "\n".join([*lines, ""])


def _kind(annotation: Any) -> str:
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin in (Union, UnionType):
        plain = [each for each in inner if each is not NoneType]
        return " or ".join([*map(_kind, plain), *["null"] * (NoneType in inner)])
    if origin is Annotated:
        return _kind(inner[0])
    if origin is list:
        return f"list of {_several(inner[0])}"
    if origin is dict:
        return f"{_kind(inner[1])} by name"
    if origin is Literal:
        return " or ".join(f"`{each}`" for each in inner)
    if annotation in NAMES:
        return NAMES[annotation]
    return f"[{annotation.__name__}](#{annotation.__name__.lower()})"


def _several(annotation: Any) -> str:
    many = {float: "numbers", int: "whole numbers", str: "texts"}
    if annotation in many:
        return many[annotation]
    if get_origin(annotation) is Annotated:
        return _several(get_args(annotation)[0])
    if get_origin(annotation) is list:
        return f"lists of {_several(get_args(annotation)[0])}"
    return _kind(annotation)


def validation_table() -> str:
    """Return what the program is validated against, with the test of each row."""
    cases = tomllib.loads((ROOT / "templates" / "validation.toml").read_text(encoding="utf-8"))["case"]
    lines = ["| case | source | expected | computed | test |", "|---|---|---|---|---|"]
    for each in cases:
        case, source = each["en"]["case"], each["en"]["source"]
        lines.append(f"| {case} | {source} | {each['expected']} | {each['computed']} | `{each['test']}` |")
    return "\n".join([*lines, ""])


def project_keys() -> str:
    """Return a section for each table of the project file, with its keys, their defaults and meanings."""
    return "\n".join(_project_sections((), set()))


def _project_sections(path: schema.KeyPath, told: set[type[BaseModel]]) -> Iterator[str]:
    """Yield the sections of a table and of those in it that are not told yet."""
    table = schema.table_at(path) or schema.ProjectContent
    told.add(table)
    base = table.__base__
    known = base.model_fields.keys() if base in told and base is not None else ()
    inner, about = schema.tables_of(table), cleandoc(table.__doc__ or "").partition("\n")[0]
    header, meaning = toml_header(path) if path else "", about.partition(": ")[2] or about
    lines = [f"### `{header}`" if header else "### At the top", "", meaning[:1].upper() + meaning[1:], ""]
    lines += ["| key | default | meaning |", "|---|---|---|"]
    for key, field in table.model_fields.items():
        if key not in inner and key not in known:
            absent = field.is_required() or field.default in (None, "", ())
            default = (
                "**required**" if field.is_required() else "" if absent else f"`{inline(field.default)}`"
            )
            lines.append(f"| `{key}` | {default} | {(field.description or '').replace('|', chr(92) + '|')} |")
    yield "\n".join([*lines, ""])
    for entry in schema.entries_of(table):
        if schema.table_at((*path, *entry)) not in told:
            yield from _project_sections((*path, *entry), told)


PARTS: dict[str, Callable[[], str]] = {
    "results.md": results_keys,
    "howto/project_file.md": project_keys,
    "validation.md": validation_table,
    "howto/templates.md": templates.dimensions,
}


def page(name: str) -> str:
    """Return a page with its part made anew."""
    text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    made = f"<!-- made: python -m tools.docs_pages -->\n\n{PARTS[name]()}\n<!-- end -->"
    found, count = re.subn(r"<!-- made: .*?<!-- end -->", lambda _: made, text, flags=re.DOTALL)
    assert count == 1, name
    return found


if __name__ == "__main__":
    for each in PARTS:
        (ROOT / "docs" / each).write_text(page(each), encoding="utf-8")
    floor_spectra.write()
    templates.write()
