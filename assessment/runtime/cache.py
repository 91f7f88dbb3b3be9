"""Results of finished analyses in the output folder, found again by the fingerprint of their inputs.

An entry is a file of two lines: the digest of the second, and the result as JSON. It is written whole or not at all,
and read as a value of the type that the analysis returns: one that is damaged, or of another type, counts as absent.
Nothing in it is executed, as what libraries for such stores (diskcache, joblib) pickle would be.
"""

from __future__ import annotations

import builtins
import hashlib
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from assessment.runtime.files import write_atomically

FOLDER = ".stages"  # in the output folder
MOST_BYTES = 300_000_000  # of all entries; the least recently used are removed first
MESSAGE, ARRAY = "·message", "·array"  # keys of an object that is no table


def packed(result: Any) -> str:
    """Return a result of an analysis as JSON on one line; floats keep every bit, tuples become lists."""
    return json.dumps(_marked(result), default=_plain, ensure_ascii=False)


def unpacked(text: str, kind: Any) -> Any:
    """Return what `packed` was given, of the type `kind` as annotations name it.

    Raises ValueError, TypeError, KeyError or RecursionError where the text is no such value.
    """
    found = _built(json.loads(text, object_hook=_restored), kind, {})
    if found == []:  # of several analyses in one there is a result of each
        raise ValueError("no result")
    return found


@cache
def returned(function: Callable[..., Any]) -> Any:
    """Return the type that a function says it returns; Any where it says nothing."""
    return _hints(function).get("return", Any)


@dataclass(frozen=True)
class Store:
    """Entries in a folder, one file per fingerprint."""

    folder: Path

    def find(self, key: str) -> str | None:
        """Return the packed result that was kept under a fingerprint; None where there is none, or it is damaged."""
        text = self.read(key)
        if text is not None:
            with suppress(OSError):
                os.utime(self.folder / key)
        return text

    def read(self, key: str) -> str | None:
        """Return the same without recording that it was used: nothing is written."""
        path = self.folder / key
        try:
            if not path.is_file() or path.stat().st_size > MOST_BYTES:
                return None
            digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        except (OSError, UnicodeDecodeError):
            return None
        return text if digest == _digest(key, text) else None

    def keep(self, key: str, text: str) -> None:
        """Keep a packed result; if it cannot be written, the run goes on without it."""
        with suppress(OSError):
            write_atomically(self.folder / key, f"{_digest(key, text)}\n{text}".encode())

    def prune(self, most: int = MOST_BYTES) -> None:
        """Remove temporary files of killed runs and, beyond `most` bytes in all, the least recently used entries."""
        with suppress(OSError):
            used = [(path.stat(), path) for path in self.folder.iterdir()]
            room = most
            for status, path in sorted(used, key=lambda item: -item[0].st_mtime_ns):
                room -= status.st_size
                if room < 0 or path.name.startswith("."):
                    path.unlink()


def _digest(key: str, text: str) -> str:
    return hashlib.sha256(f"{key}\n{text}".encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Return what JSON has no form for as one that it has."""
    import numpy as np  # late: a run that takes over all results needs none

    if isinstance(value, np.ndarray):
        return {ARRAY: value.tolist(), "shape": value.shape, "type": value.dtype.str}
    if isinstance(value, np.generic):
        return value.item()
    if is_dataclass(value):
        return {field.name: _marked(getattr(value, field.name)) for field in fields(value)}
    if _is_part(type(value)):
        return _marked(value.model_dump(by_alias=True, exclude_unset=True))
    raise TypeError(f"{type(value).__name__}: not a result of an analysis")


def _marked(value: Any) -> Any:
    """Return a value with its messages as objects that `_restored` knows: JSON takes them for plain strings.

    Lists of numbers are left as they are, by their first item.
    """
    from mechanics.messages import Message

    if isinstance(value, Message):
        return {MESSAGE: value.template, "fields": _marked(value.fields)}
    if isinstance(value, dict):
        return {name: _marked(item) for name, item in value.items()}
    if isinstance(value, list | tuple) and value and not isinstance(value[0], int | float):
        return [_marked(item) for item in value]
    return value


def _restored(content: dict[str, Any]) -> Any:
    """Return an array or a message from its object, any other object as it is."""
    if ARRAY in content:
        import numpy as np

        return np.array(content[ARRAY], dtype=content["type"]).reshape(content["shape"])
    if MESSAGE in content:
        from mechanics.messages import Message

        return Message(content[MESSAGE], content["fields"])
    return content


def _built(value: Any, kind: Any, bound: Mapping[Any, Any]) -> Any:
    """Return a value as one of a type, tables as the classes that they are of; `bound`: types of type variables.

    Raises TypeError where it is of another type, and pydantic's ValidationError for a part of the results.
    """
    kind = bound.get(kind, Any) if isinstance(kind, TypeVar) else kind
    origin, arguments = get_origin(kind) or kind, get_args(kind)
    if kind is Any:
        return value
    if origin in {Union, UnionType}:
        for each in arguments:
            with suppress(TypeError, ValueError):
                return _built(value, each, bound)
    elif origin in {list, Sequence} and isinstance(value, list):
        return [_built(item, arguments[0], bound) for item in value]
    elif origin in {dict, Mapping} and isinstance(value, dict):
        return {name: _built(item, arguments[1], bound) for name, item in value.items()}
    elif is_dataclass(origin) and isinstance(value, dict):
        own = dict(zip(getattr(origin, "__parameters__", ()), arguments, strict=False))
        hints = _hints(origin)  # type: ignore[arg-type]
        if value.keys() != {field.name for field in fields(origin)}:
            raise TypeError(f"{', '.join(value)}: no {kind}")
        return origin(**{name: _built(item, hints[name], own) for name, item in value.items()})  # type: ignore[operator]
    elif isinstance(origin, type) and _is_part(origin) and isinstance(value, dict):
        return origin(**value)
    elif _is_plain(value, origin, arguments):
        return value
    raise TypeError(f"{type(value).__name__}: no {kind}")


def _is_plain(value: Any, origin: Any, arguments: Sequence[Any]) -> bool:
    """Whether a value is one of a plain type: a number, a text, an array, nothing."""
    if origin is Literal:
        return value in arguments
    if origin is float:
        return type(value) in {int, float}
    if origin is int:
        return type(value) is int
    if origin in {None, NoneType}:
        return value is None
    if not isinstance(origin, type) or not isinstance(value, origin):
        return False
    if arguments and hasattr(value, "dtype"):  # an array: shape and type of its numbers
        return any(value.dtype == number for number in get_args(arguments[-1]))
    return True


def _is_part(kind: type) -> bool:
    from assessment.results.schema.part import Part  # late: as above

    return issubclass(kind, Part)


@cache
def _hints(annotated: Any) -> dict[str, Any]:
    """Return the annotations of a function or a class as types; Any for names that only type checkers see."""

    class Names(dict[str, Any]):
        def __missing__(self, _: str) -> Any:
            return Any

    module = sys.modules.get(getattr(annotated, "__module__", None) or "", builtins)
    try:
        return get_type_hints(annotated, localns=Names(vars(builtins) | vars(module)))
    except (TypeError, AttributeError):  # a function in C, of the standard library
        return {}
