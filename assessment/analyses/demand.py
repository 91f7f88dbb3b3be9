"""The seismic demand on a project, at ground, at height or of a record; indices of safety and risk of a state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from assessment.analyses.found import as_part
from assessment.ntc import floor_spectrum, tables
from assessment.ntc.floor_spectrum import Spectrum, ground_of
from assessment.ntc.hazard import HazardCurve, HazardError, return_period_steps, site_curve
from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from assessment.ntc.tables import CONFIDENCE_FACTOR, ROCK, SURFACE, confidence_factor, return_period
from assessment.ntc.verification import ACTIVATION_DAMPING, RULES
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema import AssessmentTable
from assessment.results.schema import Line, StateResults, known
from assessment.results.schema import checks as parts
from assessment.results.table import indices
from assessment.runtime.errors import ProjectError

PERIODS = np.concatenate([np.arange(400) / 100.0, np.arange(80, 201) / 20.0])  # s: finer up to 4 s


@dataclass(frozen=True)
class Demands:
    """The spectrum of each limit state, none without an assessment; the site's hazard curve, None without a grid."""

    spectra: Mapping[str, Spectrum] = field(default_factory=dict)
    hazard: HazardCurve | None = None


def demand_spectra(project: Project, shaking: Sequence[BaseMotion] = ()) -> Demands:
    """Return the demand spectrum of each limit state, and the site's hazard curve where a grid gives it.

    With spectrum = "record" that of the first base motion of [[history]] (`shaking`). Raises ProjectError for a site
    outside the grid, and for method = "grid" with a record.
    """
    assessment = known(project.assessment)
    if assessment.spectrum == "record":
        if assessment.method == "grid":
            text = 'a record has no return period; write "demand-shape", or spectrum = "ntc"'
            raise ProjectError(f"{project.source}: assessment.method: {text}")
        record = shaking[0].original
        demand = RecordSpectrum(record.acceleration, record.time_step, ACTIVATION_DAMPING)
        return Demands(dict.fromkeys(assessment.limit_states, demand))
    return _site_spectra(project, assessment)


def site_acceleration(project: Project) -> dict[str, float]:
    """Return a_g S (g) by limit state of a site beside a record, which capacities from its shape are compared with."""
    assessment = project.assessment
    if assessment is None or assessment.spectrum != "record" or assessment.site is None:
        return {}
    spectra = _site_spectra(project, assessment).spectra
    return {name: spectrum.ag * spectrum.S for name, spectrum in spectra.items()}


def demand_return_periods(project: Project) -> dict[str, float]:
    """Return T_R (years) of the demand by limit state: of V_N and C_U with a grid, as typed where it was."""
    assessment = project.assessment
    if assessment is None or assessment.spectrum == "record" or assessment.site is None:
        return {}
    site = assessment.site
    if not site.typed:
        life = site.nominal_life_years
        return {name: return_period(name, life, site.use_class) for name in assessment.limit_states}
    typed = {name: site.typed[name].return_period_years for name in assessment.limit_states}
    return {name: T_R for name, T_R in typed.items() if T_R is not None}


def _site_spectra(project: Project, assessment: AssessmentTable) -> Demands:
    site = assessment.site
    if site is None:
        raise ProjectError(f"{project.source}: assessment.site: missing; give the site's hazard")
    curve = None
    if not site.typed:
        try:
            curve = site_curve(site.grid and project.path(site.grid), site.latitude, site.longitude)
        except HazardError as error:
            raise ProjectError(f"{project.source}: assessment.site: {error}") from None
    spectra: dict[str, Spectrum] = {}
    for limit_state in assessment.limit_states:
        if curve is not None:
            hazard = curve.at(return_period(limit_state, site.nominal_life_years, site.use_class))
            ag, F0, Tc_star = hazard.ag, hazard.F0, hazard.Tc_star
        else:
            typed = site.typed[limit_state]
            ag, F0, Tc_star = typed.ag_g, typed.F0, typed.Tc_star_s
        ground = ElasticSpectrum(ag, F0, Tc_star, site.soil, site.topography, ACTIVATION_DAMPING)
        spectra[limit_state] = _at_height(ground, assessment)
    return Demands(spectra, curve)


def _at_height(ground: ElasticSpectrum, assessment: AssessmentTable) -> Spectrum:
    floor = assessment.floor
    if floor is None or floor.height_m == 0.0:
        return ground
    T_1 = floor.period_s or floor_spectrum.fundamental_period(floor.building_height_m).result
    heights = floor.height_m, floor.building_height_m
    first = floor_spectrum.first_mode(T_1, floor.storeys, *heights, floor.damping_ratio)
    if assessment.circular == 2009:
        return floor_spectrum.FloorSpectrum2009(ground, first)
    higher = zip(floor.higher_periods_s, floor.higher_participations, strict=True)
    modes = (floor_spectrum.Mode(period, share, 1.0, floor.damping_ratio) for period, share in higher)
    return floor_spectrum.FloorSpectrum(ground, (first, *modes))


def demand_parts(project: Project, demands: Demands) -> dict[str, parts.DemandSpectrum]:
    """Return the demand spectra by limit state and how their parameters follow (NTC 2018, §3.2.3; Circolare C7.2.3)."""
    assessment, found, periods = known(project.assessment), {}, demand_return_periods(project)
    site, floor = assessment.site, assessment.floor
    for name, spectrum in demands.spectra.items():
        rule, ground = RULES.get((str(assessment.circular), name)), ground_of(spectrum)
        damping = rule.damping if rule else ACTIVATION_DAMPING  # that of the check
        damped, recorded = spectrum.with_damping(damping), isinstance(spectrum, RecordSpectrum)
        built: Literal["ground", "floor"] = "ground" if ground is spectrum else "floor"
        part = parts.DemandSpectrum(
            kind="record" if recorded else built, a_g_g=spectrum.ag, S=spectrum.S, pga_g=spectrum.ag * spectrum.S,
            reference=SURFACE if recorded else ROCK, T_s=PERIODS.tolist(),
            S_e_g=spectrum.acceleration(PERIODS).tolist(), S_De_m=spectrum.displacement(PERIODS).tolist(),
            damping=damping, damped_S_e_g=damped.acceleration(PERIODS).tolist(),
            damped_S_De_m=damped.displacement(PERIODS).tolist(),
        )  # fmt: skip
        if name in periods:
            part = part.replace(return_period_years=periods[name])
        if ground is not None:
            steps: list[Line] = []  # of return period, hazard and, at height, the period of the building
            if demands.hazard is not None and site is not None:
                by_life = return_period_steps(name, site.nominal_life_years, site.use_class)
                steps = [*by_life, *demands.hazard.steps(by_life[-1].result)[1:]]
            if floor is not None and floor.period_s is None and ground is not spectrum:
                steps.append(floor_spectrum.fundamental_period(floor.building_height_m))
            part = part.replace(
                F0=ground.F0, Tc_star_s=ground.Tc_star, soil=ground.soil, topography=ground.topography,
                T_B_s=ground.T_B, T_C_s=ground.T_C, T_D_s=ground.T_D, trace=[*steps, *ground.parameter_steps()],
            )  # fmt: skip
        found[name] = part
    return found


def state_indices(
    project: Project, capacities: Mapping[parts.Direction, parts.Capacity], before: StateResults | None = None
) -> parts.Indices | None:
    """Return the indices of a state from the least favourable check of its directions at each limit state.

    `before`: the state that it strengthens, from which interventions count; None: it is none that is strengthened.
    None if a direction has no ratio at SLV, and if the demand is a record: its a_g does not refer to rock.
    """
    assessment = project.assessment
    if assessment is None or assessment.site is None or assessment.spectrum == "record":
        return None
    # at SLV the linear check stands in for a nonlinear one without a number; None if a direction has neither
    at_life = {
        way: {name: ratio for name, ratio in indices(each.ratios).items() if name != "SLC"}
        for way, each in capacities.items()
    }
    if (life := _least(at_life)) is None or not all(at_life.values()):
        return None
    (zeta, direction, name), ratios = life, {way: each.ratios for way, each in capacities.items()}
    check = capacities[direction].checks[name]
    damage, collapse = _least(ratios, "SLD", "SLD elastic"), _least(ratios, "SLC")
    T_SLD = capacities[damage[1]].checks[damage[2]].return_period_years if damage else None
    use_class, T_R = assessment.site.use_class, demand_return_periods(project).get("SLV")
    T_SLV = check.return_period_years
    a_g, demanded = known(check.a_g_g), check.demand_a_g_g
    made = as_part(
        parts.Indices, tables.heritage_and_risk_indices(a_g, demanded, zeta, use_class, T_SLV, T_R, T_SLD),
        direction=direction, check=name, zeta_SLV=zeta, zeta_SLC=collapse[0] if collapse else None,
        ratio_SLD=damage[0] if damage else None, T_SLV_years=T_SLV,
        T_SLV_stated=check.return_period_stated, T_R_SLV_years=T_R, use_class=use_class,
        required_zeta=tables.required_zeta(zeta, use_class),
    )  # fmt: skip
    if before is None:
        return made
    earlier = before.indices.zeta_SLV if before.indices else None
    required = tables.required_zeta(earlier, use_class)
    return made.replace(zeta_before=earlier, required_zeta=required, attained=tables.attained(zeta, required))


def confidence_source(assessment: AssessmentTable | None) -> str:
    """Return the paragraph of F_C: of its components or its level; without an assessment it is 1, by none."""
    if assessment is None:
        return "no assessment asked for"
    knowledge = assessment.knowledge
    if knowledge is None:
        return CONFIDENCE_FACTOR
    return confidence_factor(knowledge.level, knowledge.components).paragraph


def _least(
    ratios: Mapping[parts.Direction, Mapping[str, float]], *checks: str
) -> tuple[float, parts.Direction, str] | None:
    """Return the least of the ratios (of some checks alone), its direction and check; None where there is none."""
    each = ((ratio, way, name) for way, own in ratios.items() for name, ratio in own.items())
    return min((found for found in each if not checks or found[2] in checks), default=None)
