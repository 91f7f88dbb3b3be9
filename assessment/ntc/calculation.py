"""The trace of a calculation: every number with its formula, the numbers put in, and the paragraph it obeys.

A formula is plain arithmetic text (`1.56*pi*sqrt(d/(a*g))`) whose names are those of the inputs, so that a
reader, a spreadsheet or a test can compute the result again from what is printed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

_NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True, slots=True)
class Step:
    """One line of a calculation: symbol = formula(inputs) = result [unit], paragraph.

    An empty formula marks a datum: a number given by the user or read from a table, a curve or a record.
    """

    symbol: str
    formula: str
    inputs: Mapping[str, float]
    result: float
    unit: str
    paragraph: str


Trace = tuple[Step, ...]


def step(symbol: str, formula: str, result: float, unit: str, paragraph: str, /, **inputs: float) -> Step:
    """Return a Step whose inputs are the keyword arguments, in their order."""
    numbers = {name: float(value) for name, value in inputs.items()}
    return Step(symbol, formula, MappingProxyType(numbers), float(result), unit, paragraph)


def datum(symbol: str, value: float, unit: str, source: str) -> Step:
    """Return the Step of a number that is given or read, not calculated; `source`: from where."""
    return step(symbol, "", value, unit, source)


def names(formula: str) -> list[str]:
    """Return the names in a formula, each once."""
    return list(dict.fromkeys(_NAME.findall(formula)))


def renamed(formula: str, other: Mapping[str, str]) -> str:
    """Return the formula with other names in the place of some of its own."""
    return _NAME.sub(lambda match: other.get(match[0], match[0]), formula)
