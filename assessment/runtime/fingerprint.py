"""What an analysis depends on, as one digest: its arguments, bit for bit, and the program that computes it."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from assessment.runtime.files import file_digest

if TYPE_CHECKING:
    from mechanics import Assembly

PACKAGES = ("numpy", "scipy", "piqp", "numba", "shapely", "ezdxf")  # that numbers can depend on
# that only products depend on
PRINTING = (
    "pandas",
    "matplotlib",
    "pillow",
    "jinja2",
    "markdown-it-py",
    "weasyprint",
    "python-docx",
    "pydantic",
)


def fingerprint(function: Callable[..., Any], arguments: tuple[Any, ...]) -> str:
    """Return a digest (hexadecimal) of a function's name, its arguments and the program.

    Equal digests: the same numbers to the last bit. Raises TypeError for an argument whose content has no digest.
    """
    name = f"{function.__module__}.{function.__qualname__}"
    return digest([program(), name, [_plain(each) for each in arguments]])


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


def _plain(value: Any) -> Any:
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
        return [type(value).__name__, _plain(named)]
    if is_dataclass(value) and not isinstance(value, type):
        named = {each.name: getattr(value, each.name) for each in fields(value)}
        return [type(value).__name__, _plain(named)]
    if isinstance(value, Mapping):
        return ["mapping", [[_plain(key), _plain(item)] for key, item in value.items()]]
    if isinstance(value, tuple | list):
        return ["sequence", [_plain(item) for item in value]]
    raise TypeError(f"{type(value).__name__}: no fingerprint of it is known")


@lru_cache(maxsize=32)
def _assembly(model: Assembly) -> str:
    """Return the digest of a model: every analysis of it needs it, it is computed once."""
    blocks, ties = _plain(model.blocks), _plain(model.ties)
    return digest([blocks, model.segments_per_joint, model.tolerance, model.collisions, ties])
