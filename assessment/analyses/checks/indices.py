"""Indices of a state: ζ_E at SLV, indices for heritage and of risk, and the values that interventions must reach."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from assessment.analyses.checks.demand import demand_return_periods
from assessment.ntc.confidence import CONFIDENCE_FACTOR, confidence_factor
from assessment.ntc.indices import attained, heritage_and_risk_indices, required_zeta
from assessment.results.lines import lines
from assessment.results.schema.checks import Capacity, Check, Direction
from assessment.results.schema.indices import Indices, Knowledge
from assessment.results.schema.part import known

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
    life = _at_life(capacities)
    if life is None:
        return None
    direction, limit, check, zeta = life
    damage, collapse = _least(capacities, ["SLD", "SLD elastic"]), _least(capacities, ["SLC"])
    use_class, T_R = assessment.site.use_class, demand_return_periods(project).get("SLV")
    found = heritage_and_risk_indices(
        known(check.a_g_g),
        check.demand_a_g_g,
        zeta,
        use_class,
        check.return_period_years,
        T_R,
        damage.check.return_period_years if damage else None,
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


class _Least(NamedTuple):
    """The check with the least `ratio` of a_g borne to a_g demanded, by direction and limit state."""

    direction: Direction
    limit_state: str
    check: Check
    ratio: float


def _at_life(capacities: Mapping[Direction, Capacity]) -> _Least | None:
    """Return the least ratio at SLV, linear where a direction has no nonlinear one; None if a direction has neither."""
    found = [
        _least({direction: capacity}, ["SLV"]) or _least({direction: capacity}, ["SLV linear"])
        for direction, capacity in capacities.items()
    ]
    known = [each for each in found if each is not None]
    return min(known, key=lambda each: each.ratio, default=None) if len(known) == len(found) else None


def _least(capacities: Mapping[Direction, Capacity], limit_states: Iterable[str]) -> _Least | None:
    """Return the check with the least ratio at some limit states; None if no check has a ratio."""
    made = [
        _Least(direction, name, capacity.checks[name], capacity.ratios[name])
        for direction, capacity in capacities.items()
        for name in limit_states
        if name in capacity.ratios
    ]
    return min(made, key=lambda found: found.ratio, default=None)
