"""Results in the plain numbers that JSON has."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import chain
from typing import Any

from pydantic import BaseModel


def finite(value: float | None) -> float | None:
    """Return a number that is finite; None for NaN, infinity and None."""
    return value if value is not None and math.isfinite(value) else None


def ratio_decimals(value: float, decimals: int = 2) -> int:
    """Return the decimals of a ratio that is compared with 1: those, or more where they tell the wrong side of it."""
    while (float(f"{value:.{decimals}f}") >= 1.0) != (value >= 1.0) and decimals < 15:
        decimals += 1
    return decimals


def plain(value: Any) -> Any:
    """Return a value in dictionaries, lists, strings and Python's own numbers; null for NaN and infinity.

    Of a part of the results come the keys that were set, by their names in the file. A list of finite
    floats is returned itself.
    """
    if isinstance(value, float):  # first: they are most
        return float(value) if math.isfinite(value) else None
    if type(value) is list and _finite(value):
        return value
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, BaseModel):
        return value.model_dump(by_alias=True, exclude_unset=True)
    return value.item() if hasattr(value, "item") else value


def _finite(values: list[Any]) -> bool:
    """Whether lists, and lists within, hold finite floats alone: as those out of JSON do, with most of all numbers."""
    kinds = set(map(type, values))
    if kinds == {list}:
        return _finite(list(chain.from_iterable(values)))
    return kinds == {float} and math.isfinite(sum(values))
