"""Capacity and verification of every state from the stages' results, as plain numbers for results.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.capacity import CapacityCurve, Participation, capacity_curve, mechanism_participation
from assessment.hazard import HazardCurve, return_period, site_curve
from assessment.idealisation import CapacityError, Curve, CurveFit, fit_curve
from assessment.messages import ProjectError
from assessment.spectrum import ElasticSpectrum, RecordSpectrum, Spectrum
from assessment.trace import Trace
from assessment.verification import Check, Method, verify

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion
    from assessment.project import Project
    from assessment.project_schema import AssessmentTable, SiteTable
    from mechanics import Assembly

DAMPING = 0.05
DAMPED = {"SLV": 0.08, "SLC": 0.10}  # Circolare 7/2019 C8.7.1.2
PERIODS = np.linspace(0.0, 4.0, 401)


def demand_spectra(
    project: Project, shaking: Sequence[BaseMotion] = ()
) -> tuple[dict[str, Spectrum], HazardCurve | None]:
    """The demand spectrum of each limit state, and the site's hazard curve where a grid gives it.

    spectrum = "ntc": the site's elastic spectra; "record": that of the first [[history]] record, whole and scaled, for
    every limit state. Raises ProjectError for a site that the grid does not hold, and for a record that is to be
    followed along a grid.
    """
    assessment = project.assessment
    assert assessment is not None
    if assessment.spectrum == "record":
        if assessment.method == "grid":
            text = 'a record has no return period; write "demand-shape", or spectrum = "ntc"'
            raise ProjectError(f"{project.source}: assessment.method: {text}")
        record = shaking[0].original
        demand = RecordSpectrum(record.acceleration, record.time_step, DAMPING)
        return dict.fromkeys(assessment.limit_states, demand), None
    return _site_spectra(project, assessment)


def site_acceleration(project: Project) -> dict[str, float]:
    """Return a_g S (g) of the site per limit state where the demand is a record's spectrum and a site is given.

    The capacity that the record's shape gives is compared with the site's demand, without a site with the record's PGA.
    """
    assessment = project.assessment
    if assessment is None or assessment.spectrum != "record" or assessment.site is None:
        return {}
    return {
        name: spectrum.ag * spectrum.S for name, spectrum in _site_spectra(project, assessment)[0].items()
    }


def _site_spectra(
    project: Project, assessment: AssessmentTable
) -> tuple[dict[str, Spectrum], HazardCurve | None]:
    site = assessment.site
    if site is None:
        raise ProjectError(f"{project.source}: assessment.site: missing; give the site's hazard")
    curve = _hazard_curve(project, site)
    spectra: dict[str, Spectrum] = {}
    for limit_state in assessment.limit_states:
        if curve is not None:
            hazard = curve.at(return_period(limit_state, site.nominal_life_years, site.use_class))
            ag, F0, Tc_star = hazard.ag, hazard.F0, hazard.Tc_star
        else:
            typed = getattr(site, limit_state)
            ag, F0, Tc_star = typed.ag_g, typed.F0, typed.Tc_star_s
        spectra[limit_state] = ElasticSpectrum(ag, F0, Tc_star, site.soil, site.topography, DAMPING)
    return spectra, curve


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


def spectra_numbers(demands: Mapping[str, Spectrum]) -> dict[str, Any]:
    """The demand spectra as tables of numbers."""
    numbers = {}
    for name, spectrum in demands.items():
        entry = {
            "T_s": PERIODS.tolist(),
            "S_e_g": spectrum.acceleration(PERIODS).tolist(),
            "S_De_m": spectrum.displacement(PERIODS).tolist(),
        }
        if isinstance(spectrum, RecordSpectrum):
            damped = spectrum.with_damping(DAMPED.get(name, DAMPING))
            entry |= {
                "a_g_g": spectrum.ag,
                "damping": damped.damping,
                "damped_S_e_g": damped.acceleration(PERIODS).tolist(),
                "damped_S_De_m": damped.displacement(PERIODS).tolist(),
            }
        if isinstance(spectrum, ElasticSpectrum):
            entry |= {
                "a_g_g": spectrum.ag,
                "F0": spectrum.F0,
                "Tc_star_s": spectrum.Tc_star,
                "soil": spectrum.soil,
                "topography": spectrum.topography,
            }
        numbers[name] = entry
    return numbers


def _hazard_curve(project: Project, site: SiteTable) -> HazardCurve | None:
    if site.grid is None or site.latitude is None or site.longitude is None:
        return None
    try:
        return site_curve(project.path(site.grid), site.latitude, site.longitude)
    except ValueError as error:
        raise ProjectError(f"{project.source}: assessment.site: {error}") from None


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
        "trace": _trace((*part.steps(), *capacity.steps())),
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
        "trace": _trace(check.trace[common:]),
    }


def _trace(steps: Trace) -> list[dict[str, Any]]:
    return [
        {
            "symbol": s.symbol,
            "formula": s.formula,
            "inputs": dict(s.inputs),
            "result": s.result,
            "unit": s.unit,
            "paragraph": s.paragraph,
        }
        for s in steps
    ]
