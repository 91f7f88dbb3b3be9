"""A calculation of the standard as results.json has it, line by line."""

from __future__ import annotations

from collections.abc import Iterable

from assessment.ntc.calculation import Step
from assessment.results.schema.model import Line


def lines(trace: Iterable[Step]) -> list[Line]:
    """Return the steps of a calculation as lines of results.json, in their order."""
    return [
        Line(
            symbol=step.symbol,
            formula=step.formula,
            inputs=dict(step.inputs),
            result=step.result,
            unit=step.unit,
            paragraph=step.paragraph,
        )
        for step in trace
    ]
