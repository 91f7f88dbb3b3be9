"""Contradictions in [identification] and [[measurement]]."""

from __future__ import annotations

from collections.abc import Iterator

from assessment.project.consistency.names import repeated_names, unknown_name
from assessment.project.errors import Problem
from assessment.project.schema import KeyPath, MeasurementTable, ProjectContent
from assessment.project.schema.identification import SIGMA_KEYS, VALUE_KEYS

PLACING = ("component", "from_m")  # keys of relative measurements alone


def identification_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem for each hypothesis that names no support or asks too much, and each measurement that is none."""
    asked = project.identification
    if asked is None:
        if project.measurement:
            yield Problem(("measurement",), "nothing uses the measurements; add [identification]")
        return
    if not project.measurement:
        yield Problem(("identification",), "there is nothing to explain; add [[measurement]]")
    for index, hypothesis in enumerate(asked.hypotheses):
        path: KeyPath = ("identification", "hypotheses", index)
        for support in hypothesis:
            yield from unknown_name((*path, support), support, project.supports, "support")
        if hypothesis in asked.hypotheses[:index]:
            yield Problem(path, "the same as an earlier hypothesis; leave it out")
        unknowns, given = sum(map(len, hypothesis.values())), len(project.measurement)
        if 0 < given < unknowns:
            text = f"{unknowns} unknowns from {given} measurements: many movements fit exactly"
            yield Problem(path, f"{text}; measure more, or leave unknowns out")
    yield from repeated_names("measurement", [each.name for each in project.measurement])
    for index, each in enumerate(project.measurement):
        yield from _measurement_problems(("measurement", index), each)


def _measurement_problems(path: KeyPath, each: MeasurementTable) -> Iterator[Problem]:
    """Yield a problem for each key that a measurement of its kind lacks, or does not have."""
    own = {VALUE_KEYS[each.kind], SIGMA_KEYS[each.kind]}
    own |= set(PLACING) if each.kind == "relative" else set()
    keys = {*VALUE_KEYS.values(), *SIGMA_KEYS.values(), *PLACING}
    for key in sorted(keys):
        if key in own and getattr(each, key) is None:
            yield Problem((*path, key), f'missing; a measurement of kind "{each.kind}" needs it')
        elif key not in own and getattr(each, key) is not None:
            text = f'does not go with kind = "{each.kind}", which has {", ".join(sorted(own))}; leave it out'
            yield Problem((*path, key), text)
    value = getattr(each, VALUE_KEYS[each.kind])
    if each.kind in ("crack", "slip") and value is not None and value < 0.0:
        yield Problem(
            (*path, VALUE_KEYS[each.kind]), f"{value:g} is negative; it has no sign, write 0 or more"
        )
    if each.kind == "relative" and each.from_m == each.point_m:
        yield Problem((*path, "from_m"), 'the same point as point_m; write another point, or "benchmark"')
