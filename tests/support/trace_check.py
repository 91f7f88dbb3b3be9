"""Recomputing the lines of a trace from what is printed in them."""

import math
import re
from collections.abc import Mapping
from typing import Any

MATHS: dict[str, Any] = {name: getattr(math, name) for name in ("sqrt", "pi", "exp", "log")}
MATHS |= {"min": min, "max": max, "abs": abs}
_POWER = re.compile(r"<sup>((?:(?!</?sup>).)*)</sup>")  # an innermost one


def recomputed(formula: str, inputs: Mapping[str, float]) -> float:
    """Evaluate a formula with its inputs alone: a name that is no input is an error."""
    return float(eval(formula, {"__builtins__": {}}, MATHS | dict(inputs)))


def from_csv(text: str) -> dict[str, float]:
    """Return the inputs of a line of tables/trace.csv: "name=value; …"."""
    pairs = (pair.split("=") for pair in text.split("; ")) if text else ()
    return {name: float(value) for name, value in pairs}


def from_report(formula: str, values: Mapping[str, float]) -> float:
    """Evaluate a formula as the annex prints it, in English: signs, scripts; the values by printed symbol."""
    longest = sorted(values, key=len, reverse=True)
    names = "|".join(map(re.escape, longest))
    symbol = re.compile(rf"(?<!\w)(?:{names})(?![\w*²]|<sub>)")
    text = symbol.sub(lambda match: repr(values[match[0]]), formula)
    while _POWER.search(text):
        text = _POWER.sub(r"**(\1)", text)
    text = re.sub(r"\|([^|]*)\|", r"abs(\1)", text)
    for sign, plain in {"·": "*", "√": "sqrt", "π": "pi", "ln": "log", "−": "-"}.items():
        text = text.replace(sign, plain)
    return recomputed(text, {})


def printed(value: str) -> float:
    """Return a printed number, without its unit."""
    power = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
    mantissa, _, exponent = value.split(" ", maxsplit=1)[0].replace("−", "-").partition("·10")
    return float(f"{mantissa}e{exponent.translate(power)}" if exponent else mantissa)
