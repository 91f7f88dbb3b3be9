"""numba's compiler with a cache on disk that is never out of date."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba

SOURCES = (
    "cholesky", "compiled", "compiled_columns", "compiled_impacts", "compiled_interior_step", "compiled_iterations",
    "compiled_runs", "compiler", "interior_step", "iterations", "kernels",
)  # fmt: skip


def compiler(*fastmath: str) -> Callable[[Callable[..., Any]], Any]:
    """A decorator that compiles with those liberties in arithmetic, none by default.

    numba looks whether the file of a function has changed, not those of the functions and constants that it uses: so
    the cache goes by a name that tells the sources of all.
    """

    def compile_(function: Callable[..., Any]) -> Any:
        function.__qualname__ += f"_{_sources()}"
        return numba.njit(cache=True, fastmath=set(fastmath), error_model="numpy")(function)

    return compile_


@cache
def _sources() -> str:
    return digest(Path(__file__).with_name(f"{name}.py") for name in SOURCES)


def digest(paths: Iterable[Path]) -> str:
    """A short name for what is in files."""
    return sha256(b"\0".join(path.read_bytes() for path in paths)).hexdigest()[:16]
