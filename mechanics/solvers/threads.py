"""Number of threads of the BLAS of NumPy and SciPy."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the OpenBLAS of NumPy's and SciPy's wheels to one thread; no effect with another BLAS.

    A band of a hundred rows is factored in half a millisecond, an inner product of ten thousand numbers takes a
    hundredth of that: threads that wait for each other make them ten times as long, a hundred times where other
    programs want the processor too.
    """
    before = [(give, ask()) for ask, give in _libraries()]
    for give, _ in before:
        give(1)
    try:
        yield
    finally:
        for give, threads in before:
            give(threads)


@cache
def _libraries() -> tuple[tuple[Any, Any], ...]:
    """Yield for each library its number of threads and the function that sets it."""
    found = []
    for package, suffix in ((np, "64_"), (scipy, "")):
        folder = Path(str(package.__file__)).parent
        for path in (
            *folder.parent.glob(f"{folder.name}.libs/*openblas*"),
            *folder.glob(".dylibs/*openblas*"),
        ):
            library = ctypes.CDLL(str(path))
            if hasattr(library, f"scipy_openblas_set_num_threads{suffix}"):
                ask, give = (
                    getattr(library, f"scipy_openblas_{verb}_num_threads{suffix}") for verb in ("get", "set")
                )
                found.append((ask, give))
    return tuple(found)
