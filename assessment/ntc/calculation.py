"""The trace of a calculation: every number with its formula, the numbers put in, and the paragraph it obeys.

A formula is plain arithmetic text (`1.56*pi*sqrt(d/(a*g))`) whose names are those of the inputs, so that a
reader, a spreadsheet or a test can compute the result again from what is printed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

_NAME = re.compile(r"[A-Za-z_]\w*")
_SIGNS = {"sqrt": "√", "pi": "π", "eta": "η", "alpha": "α", "Gamma": "Γ", "gamma": "γ", "psi": "ψ", "xi": "ξ"}
_SIGNS |= {"Sigma": "Σ", "delta": "δ", "zeta": "ζ", "theta": "θ", "lambda": "λ"}


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
    """Return the Step of a number that is given or read, not calculated; `source` says from where."""
    return step(symbol, "", value, unit, source)


def names(formula: str) -> list[str]:
    """Return the names in a formula, each once."""
    return list(dict.fromkeys(_NAME.findall(formula)))


def renamed(formula: str, other: Mapping[str, str]) -> str:
    """Return the formula with other names in the place of some of its own."""
    return _NAME.sub(lambda match: other.get(match[0], match[0]), formula)


def number(value: float, digits: int = 6) -> str:
    """Return a number as it is printed in a trace."""
    return f"{value:.{digits}g}"


def pretty(formula: str, subscript: Callable[[str], str] = "_{}".format) -> str:
    """Return a symbol or formula in the field's signs: √, π, Greek letters, ·, ^, and X* for X_star.

    `subscript` writes what stands after the first underscore of a name.
    """
    text = formula.replace("**", "^").replace("*", "·")

    def sign(match: re.Match[str]) -> str:
        head, *rest = [_SIGNS.get(part, part) for part in match[0].split("_") if part != "star"]
        star = "*" if "star" in match[0].split("_") else ""
        return head + star + (subscript("_".join(rest)) if rest else "")

    return _NAME.sub(sign, text)


def substituted(line: Step, digits: int = 6) -> str:
    """Return the formula of a step with its numbers in the place of the names."""

    def value(match: re.Match[str]) -> str:
        name = match[0]
        return number(line.inputs[name], digits) if name in line.inputs else name

    return pretty(_NAME.sub(value, line.formula))


def rows(trace: Iterable[Step], digits: int = 6) -> list[dict[str, str]]:
    """Return one row of text per step, for the report's annex and for a CSV table.

    Columns: symbol, formula (as it can be computed), inputs ("name = value; …"), numbers (the formula with
    the numbers put in), result, unit, paragraph.
    """
    return [
        {
            "symbol": line.symbol,
            "formula": line.formula,
            "inputs": "; ".join(f"{name} = {number(v, digits)}" for name, v in line.inputs.items()),
            "numbers": substituted(line, digits),
            "result": number(line.result, digits),
            "unit": line.unit,
            "paragraph": line.paragraph,
        }
        for line in trace
    ]


def numbers(trace: Iterable[Step]) -> list[dict[str, Any]]:
    """Return the steps as plain values for results.json."""
    return [
        {
            "symbol": line.symbol,
            "formula": line.formula,
            "inputs": dict(line.inputs),
            "result": line.result,
            "unit": line.unit,
            "paragraph": line.paragraph,
        }
        for line in trace
    ]
