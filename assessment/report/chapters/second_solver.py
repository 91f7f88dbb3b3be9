"""Sentences on limit analysis by a second program."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.report.text.quantities import COARSE
from assessment.results.configurations.hand_check import mechanisms
from assessment.results.schema import Results

AGREEMENT = 1e-6  # relative: two programs that differ by less agree


def comparison(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was compared and with what, or why nothing was; nothing without rigid curves."""
    rigid = [each for _, _, each in mechanisms(results)]
    if any(each.second_solver for each in rigid):
        yield words("text.second_solver", version=results.software.packages.get("scipy", ""))
        coulomb = any(each.sliding == "coulomb" for each in rigid)
        yield words("text.second_solver_coulomb" if coulomb else "text.second_solver_alpha_0")
    elif any("second_solver" in each.model_fields_set for each in rigid):
        yield words("text.no_second_solver")


def agreement(results: Results, words: Words) -> Iterator[Markup]:
    """Yield how far the two programs are apart at most, and where one of them has no result."""
    found = [each.second_solver for _, _, each in mechanisms(results) if each.second_solver]
    known = [abs(each.relative_difference) for each in found if each.relative_difference is not None]
    if known:
        agree = max(known) <= AGREEMENT
        key = f"judgement.second_{'agrees' if agree else 'differs'}"
        yield words(key, difference=words.number(max(known), COARSE))
    if len(known) < len(found):
        yield words("judgement.second_missing", count=len(found) - len(known))
