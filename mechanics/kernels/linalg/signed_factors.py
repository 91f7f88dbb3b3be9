"""LDLᵀ of a banded matrix that need not be definite, without pivots: how many of D are negative."""

from __future__ import annotations

from typing import Any

from mechanics.kernels.jit import compiler
from mechanics.types import Array

compiled = compiler("contract", "reassoc", allocates=False)


@compiled
def factorise_signed(band: Array, places: int, last: Any) -> int:
    """L (unit) and 1/D in place of the matrix; returns the number of negative pivots, −1 where one vanishes."""
    n = len(last)
    negative = 0
    for j in range(n):
        at = j * places
        count = last[j] - j
        d = band[at]
        if not abs(d) > 0.0:
            return -1
        if d < 0.0:
            negative += 1
        inverse = 1.0 / d
        column = band[at + 1 : at + 1 + count]
        for e in range(count):
            share = column[e] * inverse
            if share != 0.0:
                rows = count - e
                target = band[(j + 1 + e) * places : (j + 1 + e) * places + rows]
                source = column[e:]
                for q in range(rows):
                    target[q] -= share * source[q]
        for e in range(count):
            column[e] *= inverse
        band[at] = inverse
    return negative


@compiled
def substitute_signed(band: Array, places: int, last: Any, x: Array) -> None:
    """The solution of LDLᵀx = b in place of b (m,)."""
    n = len(last)
    for j in range(n):
        count = last[j] - j
        column = band[j * places + 1 : j * places + 1 + count]
        below = x[j + 1 : j + 1 + count]
        a = x[j]
        for e in range(count):
            below[e] -= a * column[e]
    for j in range(n):
        x[j] *= band[j * places]
    for j in range(n - 1, -1, -1):
        count = last[j] - j
        column = band[j * places + 1 : j * places + 1 + count]
        below = x[j + 1 : j + 1 + count]
        a = 0.0
        for e in range(count):
            a += below[e] * column[e]
        x[j] -= a
