"""One thread for SciPy's LAPACK while narrow bands are factored."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import scipy


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep the OpenBLAS of SciPy's wheels to one thread; without effect where SciPy brings another LAPACK.

    A band of a hundred rows is factored in half a millisecond: threads that wait for each other make it ten times as
    long, a hundred times where other programs want the processor too.
    """
    library = _library()
    if library is None:
        yield
        return
    before = library.scipy_openblas_get_num_threads()
    library.scipy_openblas_set_num_threads(1)
    try:
        yield
    finally:
        library.scipy_openblas_set_num_threads(before)


@cache
def _library() -> ctypes.CDLL | None:
    package = Path(scipy.__file__).parent
    for path in (*package.parent.glob("scipy.libs/*openblas*"), *package.glob(".dylibs/*openblas*")):
        library = ctypes.CDLL(str(path))
        if hasattr(library, "scipy_openblas_set_num_threads"):
            return library
    return None
