"""Results of finished analyses in the output folder, found again by the fingerprint of their inputs.

An entry has two lines: digest and result as JSON, which executes nothing; a damaged one counts as absent.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from pydantic import BaseModel, ConfigDict, TypeAdapter

from assessment.runtime.files import file_digest, write_atomically
from mechanics.messages import put_together, taken_apart

if TYPE_CHECKING:
    from mechanics import Assembly


PACKAGES = ("numpy", "scipy", "piqp", "numba", "shapely", "ezdxf")  # that numbers can depend on
PRINTING = (  # that only products depend on
    "pandas", "matplotlib", "pillow", "jinja2", "markdown-it-py", "weasyprint", "python-docx", "pydantic",
)  # fmt: skip


def fingerprint(function: Callable[..., Any], arguments: tuple[Any, ...]) -> str:
    """Return a digest of a function, its arguments and the program: equal digests, equal results to the last bit.

    Raises TypeError for an argument whose content has no digest.
    """
    name = f"{function.__module__}.{function.__qualname__}"
    return digest([program(), name, [_content(each) for each in arguments]])


@cache
def program() -> str:
    """Return a digest of the source of both packages, the libraries below them and the kind of machine."""
    folders = (_root() / "assessment", _root() / "mechanics")
    sources = sorted(path for folder in folders for path in folder.rglob("*.py"))
    code = hashlib.sha256()
    for path in sources:
        code.update(path.relative_to(_root()).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    libraries = [installed(name) for name in PACKAGES]
    return digest([code.hexdigest(), libraries, platform.python_version(), platform.machine()])


@cache
def printing() -> str:
    """Return a digest of what tables, figures and report depend on beside the results and `program`."""
    folder = _root() / "templates"
    templates = [(path.name, file_digest(path)) for path in sorted(folder.iterdir()) if path.is_file()]
    return digest([templates, [installed(name) for name in PRINTING], platform.system()])


def installed(package: str) -> str:
    """Return the version of an installed package, "unknown" for one that is not there."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def _root() -> Path:
    return Path(__file__).parents[2]


def digest(tree: Any) -> str:
    """Return a digest (hexadecimal) of what JSON has a form for."""
    return hashlib.sha256(json.dumps(tree).encode()).hexdigest()


def _content(value: Any) -> Any:
    """Return nested lists that no value of other content or type shares."""
    import numpy as np  # late: a run that takes over all results needs neither

    from mechanics import Assembly

    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Assembly):
        return _assembly(value)
    if isinstance(value, np.ndarray):
        content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ["array", str(value.dtype), value.shape, content]
    if isinstance(value, BaseModel):
        named = {name: getattr(value, name) for name in type(value).model_fields}
        return [type(value).__name__, _content(named)]
    if is_dataclass(value) and not isinstance(value, type):
        named = {each.name: getattr(value, each.name) for each in fields(value)}
        return [type(value).__name__, _content(named)]
    if isinstance(value, Mapping):
        return ["mapping", [[_content(key), _content(item)] for key, item in value.items()]]
    if isinstance(value, tuple | list):
        return ["sequence", [_content(item) for item in value]]
    raise TypeError(f"{type(value).__name__}: no fingerprint of it is known")


@lru_cache(maxsize=32)
def _assembly(model: Assembly) -> str:
    """Return the digest of a model: every analysis of it needs it, it is computed once."""
    blocks, ties = _content(model.blocks), _content(model.ties)
    return digest([blocks, model.segments_per_joint, model.tolerance, model.collisions, ties])


FOLDER = ".stages"  # in the output folder
MOST_BYTES = 300_000_000  # of all entries; the least recently used are removed first
ARRAY = "·array"  # key of an object that is no table


def packed(result: Any) -> str:
    """Return a result of an analysis as JSON on one line; floats keep every bit, tuples become lists."""
    return json.dumps(taken_apart(result), default=_plain, ensure_ascii=False)


def unpacked(text: str, kind: Any) -> Any:
    """Return what `packed` was given, of the annotated type `kind`.

    Raises ValueError (pydantic's ValidationError is one), KeyError or RecursionError where the text is no such value.
    """
    found = _reader(kind).validate_python([json.loads(text, object_hook=_restored)])[0]
    if found == []:  # of several analyses in one there is a result of each
        raise ValueError("no result")
    return found


@cache
def _reader(kind: Any) -> TypeAdapter[list[Any]]:
    """Return what builds values of a type, dataclasses and parts of the results within, from plain ones."""
    return TypeAdapter(list[kind], config=ConfigDict(arbitrary_types_allowed=True))


@cache
def returned(function: Callable[..., Any]) -> Any:
    """Return the type that a function says it returns; Any where it says nothing."""
    try:
        return get_type_hints(function).get("return", Any)
    except (TypeError, AttributeError):  # a function in C, of the standard library
        return Any


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
        return {field.name: taken_apart(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, BaseModel):
        return taken_apart(value.model_dump(by_alias=True, exclude_unset=True))
    raise TypeError(f"{type(value).__name__}: not a result of an analysis")


def _restored(content: dict[str, Any]) -> Any:
    """Return an array or a message from its object, any other object as it is."""
    if ARRAY in content:
        import numpy as np

        return np.array(content[ARRAY], dtype=content["type"]).reshape(content["shape"])
    return put_together(content)
