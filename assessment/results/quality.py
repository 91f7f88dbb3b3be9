"""Certificates and calculations of analyses as parts of the results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from assessment.ntc.calculation import Step
from assessment.results.schema.model import Line, Quality, QualityRow

WORST = ("worst_equilibrium_residual", "worst_penetration_m", "worst_complementarity", "worst_cone_violation")


def joined(state: str | None, stage: str, rows: Sequence[QualityRow]) -> QualityRow:
    """Return one row for the rows of several analyses."""
    lifting = sum(row.lifting or 0 for row in rows) or None
    return QualityRow(
        state=state, stage=stage, solves=sum(row.solves for row in rows), lifting=lifting, **_worst(rows)
    )


def quality_of(rows: Sequence[QualityRow], warnings: Sequence[str]) -> Quality:
    """Return the certificates and the warnings of a run; null: no analysis has such a certificate."""
    worst = dict.fromkeys(WORST) | _worst(rows)
    return Quality(
        solves=sum(row.solves for row in rows), warnings=list(warnings), by_stage=list(rows), **worst
    )


def _worst(rows: Sequence[QualityRow]) -> dict[str, float]:
    """Return the worst certificates of some rows; motions have no penetration and no cone violation."""
    known = {key: [value for row in rows if (value := getattr(row, key)) is not None] for key in WORST}
    return {key: max(values) for key, values in known.items() if values}


def lines(trace: Iterable[Step]) -> list[Line]:
    """Return the steps of a calculation as lines of results.json, in their order."""
    told = [{name: getattr(step, name) for name in Line.model_fields} for step in trace]
    return [Line(**each | {"inputs": dict(each["inputs"])}) for each in told]
