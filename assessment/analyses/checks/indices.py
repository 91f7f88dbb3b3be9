"""Indices of a state: ζ_E at SLV, indices for heritage and of risk, and the values that interventions must reach."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from assessment.analyses.checks.demand import demand_return_periods
from assessment.ntc.confidence import CONFIDENCE_FACTOR, confidence_factor
from assessment.ntc.indices import attained, heritage_and_risk_indices, required_zeta
from assessment.results.quality import lines
from assessment.results.schema.checks import Capacity, Direction, Governing, Indices, Knowledge, SafetyIndex
from assessment.results.schema.part import known
from assessment.results.table import indices

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import AssessmentTable, KnowledgeTable
    from assessment.results.schema import State


def state_indices(
    project: Project, capacities: Mapping[Direction, Capacity], before: State | None = None
) -> Indices | None:
    """Return the indices of a state from the least favourable check of its directions at each limit state.

    `before`: the state that it strengthens, from which interventions count; None: it is none that is strengthened.
    None if a direction has no ratio at SLV, and if the demand is a record: its a_g does not refer to rock.
    """
    assessment = project.assessment
    if assessment is None or assessment.site is None or assessment.spectrum == "record":
        return None
    # at SLV the linear check stands in for a nonlinear one without a number; None if a direction has neither
    at_life = {direction: indices(each) for direction, each in _at(capacities, "SLV", "SLV linear").items()}
    if (life := _least(at_life)) is None or not all(at_life.values()):
        return None
    zeta, direction, limit = life
    check = capacities[direction].checks[limit]
    damage, collapse = _least(_at(capacities, "SLD", "SLD elastic")), _least(_at(capacities, "SLC"))
    T_SLD = capacities[damage.direction].checks[damage.check].return_period_years if damage else None
    use_class, T_R = assessment.site.use_class, demand_return_periods(project).get("SLV")
    found = heritage_and_risk_indices(
        known(check.a_g_g),
        check.demand_a_g_g,
        zeta,
        use_class,
        check.return_period_years,
        T_R,
        T_SLD,
    )
    made = Indices(
        direction=direction,
        check=limit,
        zeta_SLV=zeta,
        zeta_SLC=collapse.ratio if collapse else None,
        ratio_SLD=damage.ratio if damage else None,
        T_SLV_years=check.return_period_years,
        T_SLV_stated=check.return_period_stated,
        T_R_SLV_years=T_R,
        I_S=found.I_S,
        f_a=found.f_a,
        acceptable_nominal_life_years=found.nominal_life,
        IS_V=found.is_v,
        IS_V_class=found.is_v_class,
        PAM=found.pam,
        PAM_class=found.pam_class,
        risk_class=found.risk_class,
        use_class=use_class,
        required_zeta=required_zeta(zeta, use_class),
        trace=lines(found.trace),
    )
    if before is None:
        return made
    zeta_before = before.indices.zeta_SLV if before.indices else None
    required = required_zeta(zeta_before, use_class)
    return made.replace(zeta_before=zeta_before, required_zeta=required, attained=attained(zeta, required))


def knowledge_of(knowledge: KnowledgeTable) -> Knowledge:
    """Return F_C, its components, and the calculation of F_C from them."""
    found = confidence_factor(knowledge.level, knowledge.components)
    return Knowledge(
        F_C=found.factor,
        level=knowledge.level,
        components=knowledge.components,
        origins=knowledge.origins,
        trace=lines(found.trace),
    )


def confidence_source(assessment: AssessmentTable | None) -> str:
    """Return what F_C follows from: the paragraph of its components, or of the level of knowledge.

    Without an assessment F_C is 1, by no paragraph.
    """
    if assessment is None:
        return "no assessment asked for"
    knowledge = assessment.knowledge
    if knowledge is None:
        return CONFIDENCE_FACTOR
    return confidence_factor(knowledge.level, knowledge.components).trace[-1].paragraph


def governing(capacities: Mapping[Direction, Capacity]) -> Governing | None:
    """Return the check with the least ratio, by direction and limit state; None if no check has a ratio."""
    least = _least({direction: each.ratios for direction, each in capacities.items()})
    if least is None:
        return None
    return Governing(direction=least.direction, limit_state=least.check, ratio=least.ratio)


def safety_index(capacities: Mapping[Direction, Capacity]) -> SafetyIndex | None:
    """Return ζ_E of a state: the least ratio at SLV and SLC (NTC 2018, §8.3), by direction and limit state."""
    least = _least({direction: indices(each.ratios) for direction, each in capacities.items()})
    if least is None:
        return None
    return SafetyIndex(direction=least.direction, limit_state=least.check, zeta_E=least.ratio)


class _Least(NamedTuple):
    """The least `ratio` of a_g borne to a_g demanded, by direction and name of the check."""

    ratio: float
    direction: Direction
    check: str


def _least(ratios: Mapping[Direction, Mapping[str, float]]) -> _Least | None:
    """Return the least of the ratios by direction and check; None where there is none."""
    return min(
        (
            _Least(ratio, direction, check)
            for direction, each in ratios.items()
            for check, ratio in each.items()
        ),
        default=None,
    )


def _at(capacities: Mapping[Direction, Capacity], *limit_states: str) -> dict[Direction, dict[str, float]]:
    """Return the ratios of the checks of these names."""
    return {
        direction: {name: ratio for name, ratio in each.ratios.items() if name in limit_states}
        for direction, each in capacities.items()
    }
