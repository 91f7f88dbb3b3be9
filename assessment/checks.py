"""Capacity and verification of every state from the stages' results, as plain numbers for results.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.capacity import CapacityCurve, Participation, capacity_curve, mechanism_participation
from assessment.hazard import HazardCurve
from assessment.idealisation import CapacityError, Curve, CurveFit, fit_curve
from assessment.spectrum import Spectrum
from assessment.trace import numbers
from assessment.verification import Check, Method, verify

if TYPE_CHECKING:
    from assessment.project import Project
    from assessment.project_schema import AssessmentTable
    from mechanics import Assembly


def assess(
    project: Project,
    model: Assembly,
    pushovers: Mapping[str, Mapping[str, Any]],
    demands: Mapping[str, Spectrum],
    hazard: HazardCurve | None,
    warnings: list[str],
) -> dict[str, Any]:
    """Capacity and checks of one state in each direction; fills the fitted values into the elastic curves."""
    assessment = project.assessment
    assert assessment is not None
    found = {}
    for direction, curves in pushovers.items():
        rigid = curves.get("rigid")
        if rigid is None:
            warnings.append(f"{direction}: no capacity without the rigid pushover curve")
            continue
        try:
            part = mechanism_participation(model, np.array(rigid["mechanism"]["displacements"]))
            elastic = curves.get("elastic")
            fit = fit_curve(assessment.model, rigid_branch(rigid), _elastic_branch(elastic))
            capacity = capacity_curve(fit, part.e_star, part.gamma_star, assessment.confidence_factor)
            checks = verify(capacity, demands, _method(project, assessment, hazard))
        except CapacityError as refusal:
            warnings.append(f"{direction}: no capacity: {refusal}")
            continue
        if elastic is not None and fit.alpha_y is not None:
            elastic |= {"alpha_y": fit.alpha_y, "d_y_m": fit.d_y}
        found[direction] = _numbers(part, fit, capacity, checks)
    return found


def rigid_branch(rigid: Mapping[str, Any]) -> Curve:
    """The rigid curve from its peak on, over growing displacements.

    Where equilibrium is lost before α = 0 the capacity falls to nothing there: the branch ends with a vertical drop,
    and d_0 is that displacement.
    """
    d = np.array(rigid["curve"]["displacement_m"])
    alpha = np.array(rigid["curve"]["multiplier"])
    peak = int(np.argmax(alpha))
    d, alpha = d[peak:], alpha[peak:]
    grows = np.concatenate([[True], d[1:] > np.maximum.accumulate(d)[:-1]])
    d, alpha = d[grows], alpha[grows]
    if rigid["lost"]:
        d, alpha = np.append(d, d[-1] * (1.0 + 1e-9) + 1e-15), np.append(alpha, 0.0)
    return d, alpha


def _method(project: Project, assessment: AssessmentTable, hazard: HazardCurve | None) -> Method:
    """How the checks are made; the displacement demand of a record is that at the period T, as in the paper (§7.1)."""
    limit = assessment.local_displacement_limit_m
    return Method(
        behaviour_factor=assessment.behaviour_factor,
        circular=str(assessment.circular),
        scaling="return_period" if assessment.method == "grid" else "shape",
        displacement_demand="at_period" if assessment.spectrum == "record" else "maximum",
        hazard=hazard,
        site_acceleration=site_acceleration(project),
        local_limits={} if limit is None else dict.fromkeys(("SLV", "SLC"), limit),
    )


def _elastic_branch(elastic: Mapping[str, Any] | None) -> Curve | None:
    return None if elastic is None else (elastic["curve"]["displacement_m"], elastic["curve"]["multiplier"])


def _numbers(
    part: Participation, fit: CurveFit, capacity: CapacityCurve, checks: Mapping[str, Check]
) -> dict[str, Any]:
    return {
        "e_star": part.e_star,
        "gamma_star": part.gamma_star,
        "T_0_s": capacity.T_0,
        "model": fit.model,
        "d_0_star_m": capacity.d_0_star,
        "notes": list(fit.notes),
        "curve": {"d_star_m": capacity.displacement.tolist(), "a_star_g": capacity.acceleration.tolist()},
        "trace": numbers((*part.steps(), *capacity.steps())),
        **{name: _check(check, len(capacity.steps())) for name, check in checks.items()},
    }


def _check(check: Check, common: int) -> dict[str, Any]:
    """The numbers of a check; its trace without the `common` first steps, which are the capacity curve's."""
    return {
        "method": check.method,
        "d_star_m": check.d_star,
        "a_star_g": check.a_star,
        "T_s": check.T,
        "a_g_g": check.a_g,
        "demand_a_g_g": check.demand_a_g,
        "zeta_E": check.zeta_E,
        "verified": check.verified,
        "damping": check.damping,
        "return_period_years": check.return_period,
        "governing": check.governing,
        "notes": list(check.notes),
        "trace": numbers(check.trace[common:]),
    }
