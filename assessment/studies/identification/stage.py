"""The identification of a project: every hypothesis fitted, compared with the others, and told."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import gammaincc

from assessment.project.structure.places import Gauge, gauges
from assessment.results.schema.studies import (
    Explanation,
    Fitted,
    Identification,
    MeasuredPoint,
    ReadySettlement,
    SupportMovement,
)
from assessment.runtime.progress import SILENCE
from assessment.studies.identification.findings import (
    findings,
    kinked_components,
    not_followed,
    open_movements,
)
from assessment.studies.identification.fit import Fit, Sureness, sureness
from assessment.studies.identification.search import Measured, Search
from assessment.studies.identification.unknowns import Unknowns, unknowns_of
from mechanics.messages import message
from mechanics.procedures import drawn_extent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from assessment.project.project import Project
    from assessment.project.schema import MeasurementTable
    from assessment.runtime.tasks import Workers
    from assessment.studies.variants import Study
    from mechanics import Assembly

# difference of AIC up to which hypotheses are not told from each other (Burnham and Anderson, 2002)
AS_GOOD = 2.0
CONTRADICTS = 3.0  # σ between what is measured and predicted
DIGITS_M, DIGITS_RAD = 6, 7  # of a movement in a project file


def identification(project: Project, model: Assembly, workers: Workers, study: Study) -> Identification:
    """Return the best movement of each hypothesis, compared; certificates, times and messages go to `study`.

    Raises KilledError where a process was ended from outside, ProjectError for a point at no joint or in no block.
    """
    assert project.identification is not None
    found = gauges(project, model)
    lever = 0.5 * float(np.ptp(drawn_extent(model), axis=0).max())
    search = Search(model, project.contacts.sliding, measured(project, found, lever), workers, study)
    asked = [
        unknowns_of(each, lever, project.identification.downward_only)
        for each in project.identification.hypotheses
    ]
    hypotheses = _all_explained(project, search, asked)
    known = [each.aic for each in hypotheses if each.aic is not None]
    least = min(known, default=math.nan)
    alike = [each.aic is not None and math.isclose(each.aic, least, abs_tol=1e-6) for each in hypotheses]
    best = alike.index(True) if known else None  # of those that explain alike the first
    if best is not None:
        hypotheses = [
            each.replace(distinguished=each.aic is None or each.aic > least + AS_GOOD) for each in hypotheses
        ]
    result = Identification(
        hypotheses=hypotheses,
        best=best,
        sites=[_site(each, gauge) for each, gauge in zip(project.measurement, found, strict=True)],
        settlements=[] if best is None else _ready(hypotheses[best]),
    )
    study.findings += findings(result)
    for each in asked:
        study.findings += not_followed(each, search.stopped[each])
    if best is None:
        study.failures.append(message("identification: no movement of any hypothesis could be followed"))
    return result


def measured(project: Project, found: Sequence[Gauge], lever: float) -> Measured:
    """Return what was measured; `lever` (m): of what a lean moves."""
    value = np.array([each.value for each in project.measurement])
    sigma = np.array([each.sigma for each in project.measurement])
    size = np.array([lever if each.kind == "lean" else 1.0 for each in project.measurement])
    largest = 1e-3 * float((size * np.maximum(abs(value), sigma)).max())
    return Measured(tuple(found), value, sigma, largest)


def _all_explained(project: Project, search: Search, asked: Sequence[Unknowns]) -> list[Explanation]:
    """Return the best movement of each hypothesis; one line of progress for all of their many short paths."""
    workers = search.workers
    show, workers.show = workers.show, SILENCE
    show.begin("identification", len(asked), 0, float(len(asked)))
    found: list[Explanation] = []
    try:
        for unknowns in asked:
            show.under_way(unknowns.title)
            found.append(_explained(project, search, unknowns))
            show.advance(float(len(found)))
    finally:
        workers.show = show
    show.end()
    return found


def _explained(project: Project, search: Search, unknowns: Unknowns) -> Explanation:
    """Return the best movement of one hypothesis."""
    fit, n = search.best(unknowns), len(unknowns)
    freedom = len(project.measurement) - n
    if fit is None:
        return Explanation(
            hypothesis=unknowns.title, unknowns=n, movement=[], chi_squared=None, degrees_of_freedom=freedom,
            probability=None, aic=None, distinguished=True, undetermined=[], kinked=[], contradicting=[],
            at_collapse=False, fit=[], configuration=None,
        )  # fmt: skip
    sure = sureness(fit, search.measured.largest)
    rows = [
        _fitted(each, float(residual))
        for each, residual in zip(project.measurement, fit.residual, strict=True)
    ]
    return Explanation(
        hypothesis=unknowns.title,
        unknowns=n,
        movement=_movement(unknowns, fit, sure),
        chi_squared=fit.chi_squared,
        degrees_of_freedom=freedom,
        probability=probability(fit.chi_squared, freedom) if freedom else None,
        aic=fit.chi_squared + 2.0 * n,
        distinguished=False,
        undetermined=[*open_movements(unknowns, sure.open)],
        kinked=[*kinked_components(unknowns, search.kinks(unknowns, fit, sure.error))],
        contradicting=[row.measurement for row in rows if abs(row.residual_in_sigma) > CONTRADICTS],
        at_collapse=fit.stopped,
        fit=rows,
        configuration=search.at(unknowns, fit.u).configuration,
    )


def probability(chi_squared: float, freedom: int) -> float:
    """Return the probability of a χ² as large with so many degrees of freedom: Q(ν/2, χ²/2)."""
    return float(gammaincc(0.5 * freedom, 0.5 * chi_squared))


def _movement(unknowns: Unknowns, fit: Fit, sure: Sureness) -> list[SupportMovement]:
    """Return the movement of each support with its standard errors."""
    errors = {
        each: float(error) if np.isfinite(error) else None
        for each, error in zip(unknowns.components, sure.error / unknowns.size, strict=True)
    }
    units = {"x": "m", "z": "m", "rotation": "rad"}
    found = []
    for each in unknowns.movements(fit.u):
        own = {
            f"{name}_standard_error_{units[name]}": error
            for (support, name), error in errors.items()
            if support == each.support
        }
        x, z = each.displacement
        found.append(SupportMovement(support=each.support, x_m=x, z_m=z, rotation_rad=each.rotation, **own))
    return found


def _fitted(each: MeasurementTable, residual: float) -> Fitted:
    return Fitted(
        measurement=each.name,
        kind=each.kind,
        unit=each.unit,
        predicted=each.value + residual * each.sigma,
        measured=each.value,
        sigma=each.sigma,
        residual=residual * each.sigma,
        residual_in_sigma=residual,
    )


def _site(each: MeasurementTable, gauge: Gauge) -> MeasuredPoint:
    found = MeasuredPoint(measurement=each.name, point_m=list(each.point_m), block=gauge.block)
    if each.kind != "relative":
        return found
    origin = None if gauge.origin is None else list(gauge.origin)
    return found.replace(from_m=origin, from_block=gauge.origin_block)


def _ready(best: Explanation) -> list[ReadySettlement]:
    """Return the movement as the project file has it; of several supports at once there is none."""
    moving = [each for each in best.movement if each.x_m or each.z_m or each.rotation_rad]
    if len(moving) != 1:
        return []
    [each] = moving
    return [
        ReadySettlement(
            name=f"{each.support}, as measured",
            support=each.support,
            displacement_m=[round(each.x_m, DIGITS_M), round(each.z_m, DIGITS_M)],
            rotation_rad=round(each.rotation_rad, DIGITS_RAD),
        )
    ]
