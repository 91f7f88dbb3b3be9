"""What may stand where in a project's content, read off the schema: annotations, keys and tables at a path."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from assessment.project.schema import KeyPath, ProjectContent, Table
from assessment.project.schema.values import NameOf

Form = Literal["single", "list", "named"]
"""Of a table in the file: [name], [[name]] for each entry of a list, or [name.NAME] for each named entry."""


def alternatives(annotation: Any) -> tuple[Any, ...]:
    """Return the plain types behind an annotation: Annotated stripped, unions opened, None left out."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return alternatives(get_args(annotation)[0])
    if origin in (Union, UnionType):
        return tuple(plain for member in get_args(annotation) for plain in alternatives(member))
    return () if annotation is NoneType else (annotation,)


def annotation_at(path: KeyPath) -> Any:
    """Return the annotation of the value at `path` of the content, or None where no such key is."""
    annotation: Any = ProjectContent
    for part in path:
        annotation = _inside(annotation, part)
    return annotation


def table_at(path: KeyPath) -> type[Table] | None:
    """Return the table at `path` of the content, of each entry where it is a list; None where none is."""
    return _table_of(annotation_at(path))


def keys_at(path: KeyPath, language: str = "en") -> dict[str, str]:
    """Return the keys of the table at `path` with what they mean, required ones first; none where keys are free."""
    for plain in alternatives(annotation_at(path)):
        if isinstance(plain, type) and issubclass(plain, Table):
            fields = sorted(plain.model_fields.items(), key=lambda item: not item[1].is_required())
            if language != "it":
                return {key: field.description or "" for key, field in fields}
            words, name = _italian(), plain.__name__
            return {key: words.get(f"{name}.{key}", words.get(key, ["", ""]))[1] for key, _ in fields}
    return {}


@cache
def _italian() -> dict[str, list[str]]:
    """Return label and meaning of every key in Italian, by KEY or TABLE.KEY."""
    content = tomllib.loads((files("templates") / "app_it.toml").read_text("utf-8"))
    words: dict[str, list[str]] = content["keys"]
    return words


def named_at(path: KeyPath) -> str | None:
    """Return of what in the project the value at `path` is a name, None where it is none."""
    table = table_at(path[:-1]) if path else None
    field = table.model_fields.get(str(path[-1])) if table else None
    return next((mark.what for mark in field.metadata if isinstance(mark, NameOf)), None) if field else None


def tables_of(table: type[Table]) -> dict[str, Form]:
    """Return the keys of a table that are tables themselves, and in which form each stands in the file."""
    found: dict[str, Form] = {}
    for key, field in table.model_fields.items():
        if _table_of(field.annotation):
            kinds = {get_origin(plain) for plain in alternatives(field.annotation)}
            found[key] = "list" if tuple in kinds else "named" if dict in kinds else "single"
    return found


def _table_of(annotation: Any) -> type[Table] | None:
    for plain in alternatives(annotation):
        if isinstance(plain, type) and issubclass(plain, Table):
            return plain
        if get_origin(plain) in (tuple, dict):
            return _table_of(get_args(plain)[0 if get_origin(plain) is tuple else 1])
    return None


def _inside(annotation: Any, part: str | int) -> Any:
    for plain in alternatives(annotation):
        origin, args = get_origin(plain), get_args(plain)
        if origin is tuple and isinstance(part, int):
            return args[0]
        if origin is dict:
            return args[1]
        if isinstance(plain, type) and issubclass(plain, Table) and part in plain.model_fields:
            return plain.model_fields[str(part)].annotation
    return None
