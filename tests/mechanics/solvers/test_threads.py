"""One thread for BLAS while the program is solved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy

from mechanics.solvers.interior import _libraries, one_thread


def test_one_thread_within_and_as_many_as_before_afterwards() -> None:
    """Of the BLAS that each of the two wheels brings."""
    wheels = [path.parent for path in (Path(np.__file__).parent, Path(scipy.__file__).parent)]
    names = ("numpy", "scipy")
    assert len(_libraries()) == sum(
        any(wheel.glob(f"{name}.libs/*openblas*")) for wheel, name in zip(wheels, names, strict=True)
    )
    before = [ask() for ask, _ in _libraries()]
    try:
        for _, give in _libraries():
            give(2)
        with one_thread():
            assert all(ask() == 1 for ask, _ in _libraries())
        assert all(ask() == 2 for ask, _ in _libraries())
    finally:
        for (_, give), threads in zip(_libraries(), before, strict=True):
            give(threads)
