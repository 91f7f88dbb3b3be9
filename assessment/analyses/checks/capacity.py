"""Capacity and checks of every state, computed from its pushover curves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assessment.analyses.checks.check_result import check_of, checks_of, curve_of
from assessment.analyses.checks.chosen_mechanism import Control, MechanismError, begun, compared, evaluate
from assessment.analyses.checks.demand import Demands, demand_return_periods, ground_of, site_acceleration
from assessment.analyses.checks.indices import confidence_source
from assessment.analyses.checks.refusals import other_mechanism, refused, towards
from assessment.analyses.static.local_loss import loss_sentence
from assessment.analyses.static.states import PAST_PEAK
from assessment.ntc.capacity.curve import (
    Activation,
    CapacityCurve,
    Participation,
    capacity_curve,
    mechanism_participation,
)
from assessment.ntc.capacity.curve_fit import CapacityError, Curve, CurveFit, Way, fit_curve
from assessment.ntc.demand.hazard import HazardCurve
from assessment.ntc.demand.spectrum import Spectrum
from assessment.ntc.limit_states import QUOTED
from assessment.ntc.verification import Check, Method, verify
from assessment.ntc.vertical import THRUSTING_A_G, vertical_component
from assessment.project.schema import ORIGINAL
from assessment.project.structure.mechanisms import chosen_mechanisms
from assessment.results.lines import lines
from assessment.results.plain import finite
from assessment.results.schema import checks as parts
from assessment.results.schema import static
from assessment.results.schema.checks import Capacity, Direction, GivenMechanism
from assessment.results.schema.part import known
from assessment.results.schema.static import ElasticPush, LocalLoss, Pushovers, RigidPush
from assessment.results.table import indices, sense
from mechanics.messages import Message, message

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import AssessmentTable
    from assessment.project.structure.state_models import StateModel
    from assessment.results.schema import State
    from mechanics import Assembly


BLOCKS = "pushover with rigid contacts, d* of the blocks over Γ*"  # where α0 and d_0 of the curve come from
CONTRADICTION = 0.5  # relative difference of virtual work from the curve: another mechanism moves


class Assessed(NamedTuple):
    """The capacity in a direction, with the curves that it is of: the elastic one has the fitted yield point."""

    curves: Pushovers
    capacity: Capacity


def assess(
    project: Project,
    model: Assembly,
    pushovers: Mapping[Direction, Pushovers],
    demands: Demands,
    warnings: list[Message],
) -> dict[Direction, Assessed]:
    """Return capacity and checks of one state by direction, from its curves (Circolare 7/2019, C8.7.1.2).

    A direction whose capacity is not defined is left out. What is missing or refused is added to `warnings`.
    """
    found = {}
    for direction, curves in pushovers.items():
        if curves.rigid is None:
            warnings.append(towards(direction, message("no capacity without the rigid pushover curve")))
            continue
        try:
            found[direction] = _assessed(project, model, direction, curves, demands, warnings)
        except CapacityError as refusal:
            warnings.append(towards(direction, refused(refusal.message)))
    return found


def capacities(assessed: Mapping[Direction, Assessed]) -> dict[Direction, Capacity]:
    """Return the capacities alone."""
    return {direction: each.capacity for direction, each in assessed.items()}


def _assessed(
    project: Project,
    model: Assembly,
    direction: Direction,
    curves: Pushovers,
    demands: Demands,
    warnings: list[Message],
) -> Assessed:
    """Return capacity and checks from the curves of one direction. Raises CapacityError where it is not defined."""
    assessment, rigid, elastic = known(project.assessment), known(curves.rigid), curves.elastic
    _refuse_other_mechanism(rigid)
    if elastic is None and assessment.model != "none" and _asked_for_elastic(project):
        raise CapacityError(
            message(
                "the elastic pushover was asked for and gave no curve (the warnings say why), and the "
                '{model} curve needs it; mend that, or set model = "none" (rigid branch alone)',
                model=assessment.model,
            )
        )
    mechanism = rigid.mechanism
    part = mechanism_participation(model, np.array(mechanism.displacements), mechanism.control_displacement_x)
    way = way_of_blocks(rigid, part.gamma_star, direction)
    branch = None if elastic is None else way.curve(along_push(elastic.curve, direction))
    fit = fit_curve(assessment.model, rigid_branch(rigid, way), branch)
    end = _elastic_end(elastic) if assessment.model != "none" else None
    fit = replace(fit, source=BLOCKS, elastic_end=end, way=way)
    capacity = capacity_curve(
        fit,
        part.e_star,
        part.gamma_star,
        assessment.confidence_factor,
        confidence_source(assessment),
        activation_of(rigid),
    )
    method = with_loss(method_of(project, demands.hazard), rigid.local_loss)
    beyond = _beyond_loss(assessment, rigid.local_loss)
    checks = verify(capacity, demands.spectra, method)
    notes = dict.fromkeys(note for check in checks.values() for note in check.notes)
    warnings += [towards(direction, note) for note in (*beyond, *notes)]

    made = _capacity(mechanism, part, fit, capacity, checks)
    if curves.run is not None:
        made = made.replace(run=curves.run)
    if vertical := _vertical(model, capacity, checks.get("SLV linear"), demands.spectra):
        made = made.replace(vertical=vertical)
    if demands.hazard is not None and "SLV" in demands.spectra:
        made = made.replace(scalings=_scalings(capacity, checks["SLV"], demands.spectra["SLV"], method))
    if project.incremental:
        made = made.replace(nominal=_nominal(capacity, demands.spectra, method))
    if elastic is not None and fit.alpha_y is not None:
        d_y = float(way.control_point(known(fit.d_y)))
        d_star = (part.gamma_star * way.blocks(along_push(elastic.curve, direction)[0])).tolist()
        fitted = elastic.replace(alpha_y=fit.alpha_y, d_y_m=d_y, d_star_m=d_star)
        curves = curves.replace(elastic=fitted)
    return Assessed(curves, made)


def activation_of(rigid: RigidPush) -> Activation | None:
    """Return what activates the first mechanism, where that of α0 moves only once blocks have met others (C8.7.1.2)."""
    if rigid.onset is None:
        return None
    return Activation(rigid.alpha_onset, known(rigid.onset.e_star))


def _refuse_other_mechanism(rigid: RigidPush) -> None:
    """Raise CapacityError where virtual work on the mechanism contradicts the multiplier of the curve.

    No finite multiplier is a contradiction too: the mechanism moves, and the horizontal load does no work on it.
    """
    alpha, by_work = rigid.mechanism.alpha, rigid.virtual_work_alpha
    virtual_work = math.inf if by_work is None else by_work
    if abs(virtual_work - alpha) > CONTRADICTION * abs(alpha):
        raise CapacityError(other_mechanism(virtual_work, alpha))


def _elastic_end(elastic: ElasticPush | None) -> float | None:
    """Return the displacement (m) at which the elastic curve ends; None if it was cut beyond its peak.

    An end that is not decided limits as a loss of equilibrium does: no equilibrium is known beyond it.
    """
    if elastic is None:
        return None
    multiplier = elastic.curve.multiplier
    cut = multiplier[-1] <= PAST_PEAK * max(multiplier)
    if cut and not (elastic.lost or elastic.reached_zero):
        return None
    return max(map(abs, elastic.curve.displacement_m))


def _scalings(
    capacity: CapacityCurve, used: Check, spectrum: Spectrum, method: Method
) -> dict[str, parts.ScaledCheck]:
    """Return the check at SLV by both ways of scaling the demand; the check itself has the trace of the one `used`."""
    ways = {"shape": "demand-shape", "return_period": "grid"}
    own = check_of(parts.ScaledCheck, replace(used, trace=()), 0, used=True)
    found = {ways[method.scaling]: own}
    for scaling in ways.keys() - {method.scaling}:
        other = verify(capacity, {"SLV": spectrum}, replace(method, scaling=scaling))["SLV"]
        found[ways[scaling]] = check_of(parts.ScaledCheck, other, len(capacity.steps()), used=False)
    return found


def _vertical(
    model: Assembly, capacity: CapacityCurve, linear: Check | None, demands: Mapping[str, Spectrum]
) -> parts.VerticalCheck | None:
    """Return the linear check at SLV with the vertical component where a_g ≥ 0.15 g (NTC 2018, §7.2.2).

    None with loads without mass or joints that crush: strength is then not proportional to the weights.
    """
    ground = ground_of(demands["SLV"]) if linear is not None else None
    proportional = all(block.load_has_mass or block.vertical_load == 0.0 for block in model.blocks) and all(
        np.isinf(block.material.compressive_strength) for block in model.blocks
    )
    if linear is None or ground is None or ground.ag < THRUSTING_A_G or not proportional:
        return None
    assert linear.demand_a_star is not None
    made = vertical_component(ground, capacity.activation.alpha, capacity.a_0_star, linear.demand_a_star)
    return parts.VerticalCheck(
        a_v_g=made.a_v,
        alpha_0=made.alpha_0,
        a_0_star_g=made.a_0_star,
        demand_a_star_g=linear.demand_a_star,
        ratio=made.ratio,
        verified=made.ratio >= 1.0,
        trace=lines(made.trace),
    )


def _nominal(capacity: CapacityCurve, demands: Mapping[str, Spectrum], method: Method) -> parts.NominalCheck:
    """Return the check of the farthest limit state with F_C = 1, for comparison with the dynamic capacity.

    A dynamic analysis shakes the model at the surface: its PGA at collapse contains neither F_C nor S.
    """
    limit = next(limit for limit in QUOTED if limit in demands)
    check = verify(replace(capacity, confidence_factor=1.0), {limit: demands[limit]}, method)[limit]
    return check_of(parts.NominalCheck, check, 0, limit_state=limit)


def _asked_for_elastic(project: Project) -> bool:
    return project.pushover is not None and "elastic" in project.pushover.contacts


def along_push(curve: static.Curve, direction: Direction) -> Curve:
    """Return a curve of the results with displacements (m) positive along the push."""
    return sense(direction) * np.array(curve.displacement_m), np.array(curve.multiplier)


def way_of_blocks(rigid: RigidPush, gamma_star: float, direction: Direction) -> Way:
    """Return d*/Γ* of the blocks over the displacement of the control point along a rigid curve."""
    d, _ = along_push(rigid.curve, direction)
    return Way(np.asarray(d), np.array(known(rigid.d_star_m)) / gamma_star)


def rigid_branch(rigid: RigidPush, way: Way) -> Curve:
    """Return the rigid curve from its peak on, over growing d*/Γ* (m).

    If equilibrium is lost before α = 0, the capacity vanishes there: the branch ends with a vertical drop at d_0.
    """
    multiplier = np.array(rigid.curve.multiplier)
    peak = int(np.argmax(multiplier))
    d, alpha = way.equivalent[peak:], multiplier[peak:]
    grows = np.concatenate([[True], d[1:] > np.maximum.accumulate(d)[:-1]])
    d, alpha = d[grows], alpha[grows]
    if rigid.lost:
        d, alpha = np.append(d, d[-1] * (1.0 + 1e-9) + 1e-15), np.append(alpha, 0.0)
    return d, alpha


def method_of(project: Project, hazard: HazardCurve | None) -> Method:
    """Return how the checks of a project are made."""
    assessment = project.assessment
    assert assessment is not None
    limit = assessment.local_displacement_limit_m
    return Method(
        behaviour_factor=assessment.behaviour_factor,
        circular=str(assessment.circular),
        scaling="return_period" if assessment.method == "grid" else "shape",
        displacement_demand=assessment.record_demand if assessment.spectrum == "record" else "maximum",
        hazard=hazard,
        site_acceleration=site_acceleration(project),
        return_periods=demand_return_periods(project),
        local_limits={} if limit is None else dict.fromkeys(("SLV", "SLC"), limit),
        local_reason=assessment.local_displacement_reason,
    )


def with_loss(method: Method, loss: LocalLoss | None) -> Method:
    """Return the method with the local loss of the path as its limit, if the project gives no limit (C8.7.1.2)."""
    if loss is None or method.local_limits:
        return method
    first, second = loss.blocks
    return replace(
        method,
        local_limits=dict.fromkeys(("SLV", "SLC"), loss.displacement_m),
        local_reason=message(
            "pushover, the faces of blocks {first} and {second} slide off each other",
            first=first,
            second=second,
        ),
    )


def _beyond_loss(assessment: AssessmentTable, loss: LocalLoss | None) -> Iterator[Message]:
    """Yield a warning if the project's local limit lies beyond the local loss of the path."""
    given = assessment.local_displacement_limit_m
    if loss is not None and given is not None and given > loss.displacement_m:
        yield message(
            "local_displacement_limit_m = {given:.4g} m, but {reason}; write no more than that",
            given=given,
            reason=loss_sentence(loss),
        )


def governing(capacities: Mapping[Direction, Capacity]) -> parts.Governing | None:
    """Return the check with the least ratio, by direction and limit state; None if no check has a ratio."""
    least = _least({direction: each.ratios for direction, each in capacities.items()})
    if least is None:
        return None
    ratio, direction, name = least
    return parts.Governing(direction=direction, limit_state=name, ratio=ratio)


def safety_index(capacities: Mapping[Direction, Capacity]) -> parts.SafetyIndex | None:
    """Return ζ_E of a state: the least ratio at SLV and SLC (NTC 2018, §8.3), by direction and limit state."""
    least = _least({direction: indices(each.ratios) for direction, each in capacities.items()})
    if least is None:
        return None
    zeta, direction, name = least
    return parts.SafetyIndex(direction=direction, limit_state=name, zeta_E=zeta)


def _least(ratios: Mapping[Direction, Mapping[str, float]]) -> tuple[float, Direction, str] | None:
    """Return the least of the ratios by direction and check, with these; None where there is none."""
    return min(
        (
            (value, direction, name)
            for direction, of_direction in ratios.items()
            for name, value in of_direction.items()
        ),
        default=None,
    )


def assess_chosen(
    project: Project,
    models: Mapping[str, StateModel],
    states: Mapping[str, State],
    demands: Demands,
    warnings: list[Message],
) -> list[GivenMechanism]:
    """Return the mechanisms that the user chose, each in its state's configuration; a refused one has its reason."""
    found = []
    factor = project.assessment.confidence_factor if project.assessment else 1.0
    source = confidence_source(project.assessment)
    method = method_of(project, demands.hazard) if project.assessment else Method()
    for chosen in chosen_mechanisms(project, models[ORIGINAL].assembly):
        state, model = states[chosen.state], models[chosen.state].assembly
        positions = model.initial.positions + np.array(state.configuration)
        try:
            if project.settlement_of(chosen.state) and not any(map(any, state.configuration)):
                raise MechanismError(message("its state was not reached"))
            controls = _controls(project, model, positions)
            answer = evaluate(model, positions, chosen, factor, demands.spectra, method, controls, source)
            pushed = state.pushover.get(known(answer.direction))
            rigid = pushed.rigid if pushed else None
            answer = compared(answer, rigid.alpha_0 if rigid else None, rigid.alpha_onset if rigid else None)
            warnings += [
                message('mechanism "{name}": {text}', name=chosen.name, text=note)
                for note in known(answer.notes)
            ]
        except MechanismError as refusal:
            answer = GivenMechanism(name=chosen.name, state=chosen.state, refused=refusal.message)
            warnings.append(_of_mechanism(chosen.name, refusal))
        found.append(answer)
    return found


def _of_mechanism(name: str, refusal: MechanismError) -> Message:
    return message('mechanism "{name}": refused: {reason}', name=name, reason=refusal.message)


def refused_as_drawn(project: Project, model: StateModel) -> Iterator[Message]:
    """Yield why mechanisms that the user chose on the structure as drawn, `model`, are refused, without an analysis."""
    for chosen in chosen_mechanisms(project, model.assembly):
        if chosen.state == ORIGINAL:
            try:
                begun(model.assembly, model.assembly.initial.positions, chosen)
            except MechanismError as refusal:
                yield _of_mechanism(chosen.name, refusal)


def _controls(project: Project, model: Assembly, positions: NDArray[np.float64]) -> dict[str, Control]:
    """Return the control point of each pushover direction at its place in a configuration (b, 3)."""
    found: dict[str, Control] = {}
    for direction in project.pushover.directions if project.pushover else ():
        point = project.pushover_control(direction).point_m
        block = model.block_at(point)
        x, z = (model.from_origin(point) + model.point_displacement(point, block, positions)).tolist()
        found[direction] = Control((x, z), block)
    return found


def _capacity(
    mechanism: static.Mechanism,
    part: Participation,
    fit: CurveFit,
    capacity: CapacityCurve,
    checks: Mapping[str, Check],
) -> Capacity:
    """Return capacity curve and checks as a part of the results, with the steps of e* and Γ*."""
    return Capacity(
        mechanism=parts.Count(hinges=mechanism.hinges, sliding_joints=len(mechanism.sliding_joints)),
        alpha_0=fit.alpha_0,
        e_star=part.e_star,
        gamma_star=part.gamma_star,
        T_0_s=finite(capacity.T_0),
        model=fit.model,
        d_0_star_m=finite(capacity.d_0_star),
        notes=list(fit.notes),
        curve=curve_of(capacity),
        trace=lines((*part.steps(), *capacity.steps()[2:])),
    ).with_checks(checks_of(capacity, checks))
