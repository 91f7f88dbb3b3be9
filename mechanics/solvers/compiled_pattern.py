"""The pattern of a matrix as compiled loops take it: out of one array."""

from __future__ import annotations

from typing import Any

from mechanics.solvers.compiler import compiler
from mechanics.solvers.dissection import Fronts
from mechanics.solvers.elimination import Pattern

compiled = compiler()
LISTS, NUMBERS = 15, 3


@compiled
def unpacked(pattern: Any) -> Any:
    """The pattern that elimination.packed has packed."""
    begins, places = pattern[: LISTS + 1], pattern[LISTS + 1]
    size, largest = pattern[LISTS + 2], pattern[LISTS + 3]
    lists = pattern[LISTS + 1 + NUMBERS :]
    fronts = Fronts(
        lists[begins[6] : begins[7]], lists[begins[7] : begins[8]], lists[begins[8] : begins[9]],
        lists[begins[9] : begins[10]], lists[begins[10] : begins[11]], lists[begins[11] : begins[12]],
        lists[begins[12] : begins[13]].reshape(-1, 4), lists[begins[13] : begins[14]],
        lists[begins[14] : begins[15]], size, largest,
    )  # fmt: skip
    return Pattern(
        lists[begins[0] : begins[1]], lists[begins[1] : begins[2]], lists[begins[2] : begins[3]],
        lists[begins[3] : begins[4]], places, lists[begins[4] : begins[5]], lists[begins[5] : begins[6]], fronts,
    )  # fmt: skip
