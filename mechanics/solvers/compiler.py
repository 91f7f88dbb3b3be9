"""numba's compiler with a cache on disk that is never out of date."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba
from llvmlite import ir
from numba.core.compiler import Compiler
from numba.core.types import float64
from numba.extending import intrinsic

SOURCES = (
    "band", "cholesky", "compiled", "compiled_columns", "compiled_impacts", "compiled_interior_step",
    "compiled_iterations", "compiled_pattern", "compiled_runs", "compiler", "dissection", "elimination", "kernels",
    "runs", "tiles",
)  # fmt: skip


_Compiler: Any = Compiler
_intrinsic: Any = intrinsic


class _Apart(_Compiler):  # type: ignore[misc]
    """Takes it for granted that what a function writes is in none of its other arrays."""

    def define_pipelines(self) -> Any:
        self.state.flags.noalias = True
        return super().define_pipelines()


def compiler(*fastmath: str, apart: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """A decorator that compiles with those liberties in arithmetic, none by default.

    `apart`: the arrays among the arguments do not overlap, so that loops over any number of them become vector
    instructions; otherwise those over few enough to look do.

    numba looks whether the file of a function has changed, not those of the functions and constants that it uses: so
    the cache goes by a name that tells the sources of all.
    """
    pipeline: Any = _Apart if apart else Compiler

    def compile_(function: Callable[..., Any]) -> Any:
        function.__qualname__ += f"_{_sources()}"
        return numba.njit(
            cache=True, nogil=True, fastmath=set(fastmath), error_model="numpy", pipeline_class=pipeline
        )(function)

    return compile_


@_intrinsic
def larger(typing_context: Any, a: Any, b: Any) -> Any:
    """The larger of two numbers, which both are numbers: unlike `max` it leaves a loop to vector instructions."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = ir.DoubleType()
        function = builder.module.declare_intrinsic(
            "llvm.maxnum", [number], ir.FunctionType(number, [number, number])
        )
        return builder.call(function, arguments, fastmath=("nnan", "nsz"))

    return float64(float64, float64), generate


@cache
def _sources() -> str:
    return digest(Path(__file__).with_name(f"{name}.py") for name in SOURCES)


def digest(paths: Iterable[Path]) -> str:
    """A short name for what is in files."""
    return sha256(b"\0".join(path.read_bytes() for path in paths)).hexdigest()[:16]
