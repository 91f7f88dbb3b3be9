"""Factors of the banded matrices of static programs."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from mechanics.block import Array
from mechanics.solvers import kernels
from mechanics.solvers.band import Band


def _routines() -> ModuleType:
    compiled = kernels.fastest() is not kernels
    return importlib.import_module("mechanics.solvers." + ("cholesky" if compiled else "iterations"))


def blank(layout: Band) -> Array:
    """Room for a matrix of that layout: a row for each of its columns, from the diagonal down."""
    return np.zeros((len(layout.order), layout.width + _routines().PADDING))


@dataclass(frozen=True, eq=False)
class Factor:
    """L of a matrix LLᵀ, which it has replaced in its `band`."""

    band: Array
    layout: Band

    @classmethod
    def of(cls, matrix: Array, layout: Band) -> Factor | None:
        """The factor; None where the matrix is not positive definite."""
        return cls(matrix, layout) if _routines().factorise(matrix, layout.envelope) else None

    def solve(self, rhs: Array) -> Array:
        """X (m,) of LLᵀx = rhs."""
        x = rhs.copy()
        _routines().substitute(self.band, self.layout.envelope, x)
        return x
