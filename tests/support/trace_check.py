"""Recomputing the lines of a trace from what is printed in them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

MATHS: dict[str, Any] = {name: getattr(math, name) for name in ("sqrt", "pi", "exp", "log")}
MATHS |= {"min": min, "max": max, "abs": abs}
_NAME = re.compile(r"[^\W\d]\w*\*?(?:<sub>[^<]*</sub>)?")  # with its star and its subscript


def recomputed(formula: str, inputs: Mapping[str, float]) -> float:
    """Evaluate a formula with its inputs alone: a name that is no input is an error."""
    return float(eval(formula, {"__builtins__": {}}, MATHS | dict(inputs)))


def from_csv(text: str) -> dict[str, float]:
    """Return the inputs of a line of tables/trace.csv: "name=value; …"."""
    pairs = (pair.split("=") for pair in text.split("; ")) if text else ()
    return {name: float(value) for name, value in pairs}


def from_report(formula: str, values: Mapping[str, float]) -> float:
    """Evaluate a formula as the annex prints it, in English: signs, subscripts; the values by printed symbol."""

    def value(match: re.Match[str]) -> str:
        return repr(values[match[0]]) if match[0] in values else match[0]

    text = (
        _NAME.sub(value, formula).replace("·", "*").replace("^", "**").replace("√", "sqrt").replace("π", "pi")
    )
    return recomputed(text, {})


def printed(value: str) -> float:
    """Return a printed number, without its unit."""
    power = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
    mantissa, _, exponent = value.split(" ", maxsplit=1)[0].replace("−", "-").partition("·10")
    return float(f"{mantissa}e{exponent.translate(power)}" if exponent else mantissa)
