"""Symbols and formulas of a calculation set in HTML: Greek letters, subscripts, superscripts, roots, sums, true minus.

`a_0_star` is a with the subscript 0 and a star; what stands after further underscores joins the subscript. A formula is
the plain arithmetic text of `assessment.ntc.calculation`.
"""

from __future__ import annotations

import re

from markupsafe import Markup

from assessment.report.text.language import Words

_NAME = re.compile(r"[A-Za-z_]\w*")
_SIGNS = {
    "sqrt": "√",
    "log": "ln",
    "pi": "π",
    "eta": "η",
    "alpha": "α",
    "Gamma": "Γ",
    "gamma": "γ",
    "psi": "ψ",
}
_SIGNS |= {"xi": "ξ", "Sigma": "Σ", "delta": "δ", "zeta": "ζ", "theta": "θ", "lambda": "λ"}
_WHOLE = {  # names whose parts are no subscripts: sums over the weights that move, and an index of D.M. 58/2017
    "Sigma_P": "ΣP",
    "Sigma_P_delta": "ΣPδ<sub>x</sub>",
    "Sigma_P_delta_2": "ΣPδ<sub>x</sub>²",
    "IS_V": "IS-V",
}
_SUM = re.compile(r"Sigma_\w+$")
_EXPONENT = re.compile(r"[\w.]+")


def typeset(formula: str, words: Words) -> Markup:
    """Write a symbol or a formula; where the decimal mark is a comma, arguments are parted by a semicolon."""
    text = _powers(str(Markup.escape(formula)), words)
    mark = words.plain("value.decimal_mark")
    if mark == ".":
        return Markup(text)
    return Markup(re.sub(r"(\d)\.(\d)", rf"\1{mark}\2", text.replace(", ", "; ")))


def _powers(formula: str, words: Words) -> str:
    """Write what stands before the first power, the power, and what follows."""
    base, power, rest = formula.partition("**")
    if not power:
        return _flat(base, words)
    base = _SUM.sub(lambda match: f"({match[0]})", base)  # (Σ…)², beside a sum of squares
    exponent = rest[: _end_of_exponent(rest)]
    inner = exponent[1:-1] if exponent.startswith("(") else exponent
    raised = f"<sup>{_powers(inner, words)}</sup>"
    return _flat(base, words) + raised + _powers(rest[len(exponent) :], words)


def _end_of_exponent(text: str) -> int:
    """Return where the exponent ends with which a text begins: after its bracket, its number or its name."""
    if match := _EXPONENT.match(text):
        return match.end()
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return place + 1
    raise ValueError(f"formula: exponent {text!r} has no end")


def _flat(formula: str, words: Words) -> str:
    """Write a part without powers."""
    text = re.sub(r"abs\(([^()]*)\)", r"|\1|", formula).replace("*", "·").replace("-", "−")
    return _NAME.sub(lambda match: _symbol(match[0], words), text)


def _symbol(name: str, words: Words) -> str:
    if name in _WHOLE:
        return _WHOLE[name]
    head, *rest = name.split("_")
    known = words.strings["subscript"]
    parts = [_SIGNS.get(part, known.get(part, part)) for part in rest if part != "star"]
    subscript = f"<sub>{','.join(parts)}</sub>" if parts else ""
    return _SIGNS.get(head, head) + subscript + ("*" if "star" in rest else "")
