"""Capacity and checks of every state, computed from its pushover curves."""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from assessment.analyses.demand import Demands, confidence_source, demand_return_periods, site_acceleration
from assessment.analyses.found import Found
from assessment.analyses.lateral import FRICTION
from assessment.analyses.paths import loss_sentence, what_is_lost
from assessment.analyses.states import PAST_PEAK
from assessment.ntc import capacity_curve as oscillator
from assessment.ntc.capacity_curve import CapacityError, Curve, Way, fit_curve
from assessment.ntc.floor_spectrum import Spectrum, ground_of
from assessment.ntc.hazard import HazardCurve
from assessment.ntc.tables import farthest
from assessment.ntc.verification import THRUSTING_A_G, Method, verify, vertical_component
from assessment.project.project import Project
from assessment.results.schema import Capacity, Direction, finite, known, present, static
from assessment.results.schema import checks as parts
from assessment.results.schema.static import ElasticPush, LocalLoss, OtherLaw, Pushovers, RigidPush
from assessment.results.table import sense
from mechanics import Assembly
from mechanics.messages import Message, linked, message

BLOCKS = "pushover with rigid contacts, d* of the blocks over Γ*"  # where α0 and d_0 of the curve come from
OTHER_LAW = "pushover with rigid contacts, times α0 of the other law of friction over its own"
TOLD = 0.02  # relative difference of ζ_E between the two laws of friction that is reported
CONTRADICTION = 0.5  # relative difference of virtual work from the curve: another mechanism moves


class Assessed(NamedTuple):
    """The capacity in a direction, with the curves that it is of: the elastic one has the fitted yield point."""

    curves: Pushovers
    capacity: Capacity


def assess(
    project: Project, model: Assembly, pushovers: Mapping[Direction, Pushovers], demands: Demands
) -> dict[Direction, Found[Assessed]]:
    """Return capacity and checks of a state by direction, or why there are none, from its curves (C8.7.1.2)."""
    found: dict[Direction, Found[Assessed]] = {}
    for direction, curves in pushovers.items():
        try:
            found[direction] = _assessed(project, model, direction, curves, demands)
        except CapacityError as refusal:
            found[direction] = Found(failures=[refusal.message])
    return found


def capacities(assessed: Mapping[Direction, Found[Assessed]]) -> dict[Direction, Capacity]:
    """Return the capacities alone."""
    return {direction: each.value.capacity for direction, each in assessed.items() if each.value}


def told(assessed: Mapping[Direction, Found[Assessed]]) -> list[Message]:
    """Return what is to be told of each direction: why it has no capacity, or what to know about it."""
    return [
        towards(direction, text)
        for direction, each in assessed.items()
        for text in (*map(refused, each.failures), *each.warnings)
    ]


def towards(direction: str, text: str) -> Message:
    """Return a note on a direction."""
    return message("{direction}: {text}", direction=direction, text=text)


def refused(reason: str) -> Message:
    """Return why there is no capacity."""
    return message("no capacity: {reason}", reason=reason)


def _sound(project: Project, curves: Pushovers) -> RigidPush:
    """Return the rigid curve if a capacity may be taken from the curves. Raises CapacityError that says why not."""
    rigid, model = curves.rigid, known(project.assessment).model
    if rigid is None:
        raise CapacityError(message("it needs the rigid pushover curve"))
    # no finite multiplier is a contradiction too: the horizontal load does no work on the mechanism
    alpha, work = rigid.mechanism.alpha, math.inf if (w := rigid.virtual_work_alpha) is None else w
    if abs(work - alpha) > CONTRADICTION * abs(alpha):
        raise CapacityError(message(
            "virtual work on the mechanism gives α = {work:.3g}, the curve {alpha:.3g}: blocks "
            "slide or move by themselves there, and e*, Γ* are not those of a mechanism", work=work, alpha=alpha,
        ))  # fmt: skip
    loss, way = rigid.local_loss, np.array(rigid.curve.displacement_m[: rigid.peak + 1])
    if loss is not None and abs(way).max() >= loss.displacement_m:
        raise CapacityError(message(
            "α0 = {alpha:.4g} is reached after {lost}: the curve up to there alone counts",
            alpha=rigid.alpha_0, lost=loss_sentence(loss),
        ))  # fmt: skip
    asked = project.pushover.contacts if project.pushover else ()
    if curves.elastic is None and model != "none" and "elastic" in asked:
        raise CapacityError(message(
            "the elastic pushover was asked for and gave no curve (the warnings say why), and the "
            '{model} curve needs it; mend that, or set model = "none" (rigid branch alone)', model=model,
        ))  # fmt: skip
    return rigid


def _assessed(
    project: Project, model: Assembly, direction: Direction, curves: Pushovers, demands: Demands
) -> Found[Assessed]:
    """Return capacity and checks from the curves of one direction. Raises CapacityError where it is not defined."""
    assessment, rigid, elastic = known(project.assessment), _sound(project, curves), curves.elastic
    curve, other = (project, model, direction, curves, demands), None
    own = _by_law(*curve, rigid)
    with suppress(CapacityError):
        if (law := rigid.other_law) is not None and law.mechanism is not None:
            other = _by_law(*curve, law)
    capacity, fit, checks, method = own.capacity, own.capacity.fit, own.checks, own.method
    said = dict.fromkeys(note for check in checks.values() for note in check.notes)
    notes = cast("list[Message]", [*said])  # what is not read from a file is none but messages
    loss, given = rigid.local_loss, assessment.local_displacement_limit_m
    if loss is not None and given is not None and given > loss.displacement_m:
        notes.insert(0, message("local_displacement_limit_m = {given:.4g} m, but {reason}; write no more than that",
                                given=given, reason=loss_sentence(loss)))  # fmt: skip
    made = Capacity(
        sliding=own.sliding,
        mechanism=parts.Count(hinges=own.mechanism.hinges, sliding_joints=len(own.mechanism.sliding_joints)),
        alpha_0=fit.alpha_0, e_star=own.part.e_star, gamma_star=own.part.gamma_star,
        T_0_s=finite(capacity.T_0), model=fit.model, d_0_star_m=finite(capacity.d_0_star),
        notes=list(fit.notes), curve=curve_of(capacity),
        trace=[*own.part.steps(), *capacity.steps()[2:]],
    ).with_checks(checks_of(capacity, checks))  # fmt: skip
    if curves.run is not None:
        made = made.replace(run=curves.run)
    if other is not None:
        beside = OtherLaw(sliding=other.sliding, alpha_0=other.mechanism.alpha)
        mine, ratio = (present({name: x.zeta_E for name, x in each.checks.items()}) for each in (own, other))
        if ratios := _apart(mine, ratio):
            beside = beside.replace(zeta_E=ratio)
            notes.append(message("by {law} {ratios}", law=FRICTION[other.sliding], ratios=linked(ratios)))
        made = made.replace(other_law=beside)
    if vertical := _vertical(model, capacity, checks.get("SLV linear"), demands.spectra):
        made = made.replace(vertical=vertical)
    if project.incremental or project.campaign:
        made = made.replace(nominal=nominal_check(capacity, demands.spectra, method))
    if elastic is not None and fit.alpha_y is not None and fit.way is not None:
        d_y = float(fit.way.control_point(known(fit.d_y)))
        d_star = (capacity.gamma_star * fit.way.blocks(along_push(elastic.curve, direction)[0])).tolist()
        curves = curves.replace(elastic=elastic.replace(alpha_y=fit.alpha_y, d_y_m=d_y, d_star_m=d_star))
    return Found(Assessed(curves, made), warnings=notes)


class _ByLaw(NamedTuple):
    """Capacity and checks by one law of friction, and the mechanism that they are of."""

    sliding: static.Sliding
    mechanism: static.Mechanism
    part: oscillator.Participation
    capacity: oscillator.CapacityCurve
    method: Method
    checks: Mapping[str, parts.Check]


def _by_law(
    project: Project, model: Assembly, direction: Direction, curves: Pushovers, demands: Demands,
    law: RigidPush | OtherLaw,
) -> _ByLaw:  # fmt: skip
    """Return what follows from the curves by the law of friction of the rigid one, or by the other one.

    Of the latter limit analysis alone is known: the curves count times its α0 over theirs. Raises CapacityError.
    """
    assessment, rigid, elastic = known(project.assessment), known(curves.rigid), curves.elastic
    mechanism, activation = known(law.mechanism), activation_of(model, law.alpha_onset, law.onset)
    times = mechanism.alpha / rigid.mechanism.alpha
    displacements = np.array(mechanism.displacements)
    part = oscillator.mechanism_participation(model, displacements, mechanism.control_displacement_x)
    way = way_of_blocks(rigid, part.gamma_star, direction)
    d, alpha = rigid_branch(rigid, way)
    branch = None
    if elastic is not None:
        d_elastic, alpha_elastic = way.curve(along_push(elastic.curve, direction))
        branch = d_elastic, times * np.minimum(alpha_elastic, elastic.alpha_u)
    fit = fit_curve(assessment.model, (d, times * np.asarray(alpha)), branch)
    end = _elastic_end(elastic) if assessment.model != "none" else None
    fit = replace(fit, source=BLOCKS if times == 1.0 else OTHER_LAW, elastic_end=end, way=way)
    factor, source = assessment.confidence_factor, confidence_source(assessment)
    capacity = oscillator.capacity_curve(fit, part.e_star, part.gamma_star, factor, source, activation)
    method = with_loss(method_of(project, demands.hazard), rigid.local_loss)
    checks = verify(capacity, demands.spectra, method)
    return _ByLaw(law.sliding, mechanism, part, capacity, method, checks)


def _apart(ratios: Mapping[str, float], others: Mapping[str, float]) -> list[Message]:
    return [
        message("{check} has the ratio {other:.3g}, not {own:.3g}", check=name, other=others[name], own=own)
        for name, own in ratios.items()
        if name in others and abs(others[name] - own) > TOLD * own
    ]


def activation_of(
    model: Assembly, alpha: float | None, onset: static.Mechanism | None
) -> oscillator.Activation | None:
    """Return what activates the first mechanism, if not that of α0 (C8.7.1.2). Raises CapacityError without an e*."""
    if onset is None:
        return None
    try:
        e_star = oscillator.mass_share(model, np.array(onset.displacements))
    except CapacityError as why:
        raise CapacityError(message("the first mechanism, at α = {alpha:.4g}: {reason}", alpha=known(alpha),
                                    reason=why.message)) from why  # fmt: skip
    return oscillator.Activation(known(alpha), e_star)


def _elastic_end(elastic: ElasticPush | None) -> float | None:
    """Return the displacement (m) at which the elastic curve ends; None if it was cut beyond its peak.

    An end that is not decided limits as a loss of equilibrium does: no equilibrium is known beyond it.
    """
    if elastic is None:
        return None
    multiplier = elastic.curve.multiplier
    if multiplier[-1] <= PAST_PEAK * max(multiplier) and not (elastic.lost or elastic.reached_zero):
        return None
    return max(map(abs, elastic.curve.displacement_m))


def _vertical(
    model: Assembly, capacity: oscillator.CapacityCurve, linear: parts.Check | None, demands: Mapping[str, Spectrum]
) -> parts.VerticalCheck | None:  # fmt: skip
    """Return the linear check at SLV with the vertical component where a_g ≥ 0.15 g (NTC 2018, §7.2.2), else None.

    None too with loads without mass or joints that crush: strength is then not proportional to the weights.
    """
    ground = ground_of(demands["SLV"]) if linear is not None else None
    massive = all(block.load_has_mass or block.vertical_load == 0.0 for block in model.blocks)
    proportional = massive and not model.crushes
    if linear is None or ground is None or ground.ag < THRUSTING_A_G or not proportional:
        return None
    demand = known(linear.demand_a_star_g)
    return vertical_component(ground, capacity.activation.alpha, capacity.a_0_star, demand)


def nominal_check(
    capacity: oscillator.CapacityCurve, demands: Mapping[str, Spectrum], method: Method
) -> parts.NominalCheck:
    """Return the check of the farthest limit state with F_C = 1, as motions, which shake at the surface, know none."""
    limit = known(farthest(demands))
    check = verify(replace(capacity, confidence_factor=1.0), {limit: demands[limit]}, method)[limit]
    told = {name: getattr(check, name) for name in check.model_fields_set}
    return parts.NominalCheck(**told, limit_state=limit)


def along_push(curve: static.Curve, direction: Direction) -> Curve:
    """Return a curve of the results with displacements (m) positive along the push."""
    return sense(direction) * np.array(curve.displacement_m), np.array(curve.multiplier)


def way_of_blocks(rigid: RigidPush, gamma_star: float, direction: Direction) -> Way:
    """Return d*/Γ* of the blocks over the displacement of the control point along a rigid curve."""
    d, _ = along_push(rigid.curve, direction)
    return Way(np.asarray(d), np.array(known(rigid.d_star_m)) / gamma_star)


def rigid_branch(rigid: RigidPush, way: Way) -> Curve:
    """Return the rigid curve from where the mechanism forms on, over growing d*/Γ* (m), no higher than α0.

    If equilibrium is lost before α = 0, the capacity vanishes there: the branch ends with a vertical drop at d_0. The
    last multiplier of a curve that reaches zero is none.
    """
    multiplier = np.minimum(rigid.curve.multiplier, rigid.alpha_0)
    if rigid.reached_zero:
        multiplier[-1] = 0.0
    formed = rigid.mechanism.point
    d, alpha = way.equivalent[formed:], multiplier[formed:]
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
        behaviour_factor=assessment.behaviour_factor, circular=str(assessment.circular),
        scaling="return_period" if assessment.method == "grid" else "shape",
        displacement_demand=assessment.record_demand if assessment.spectrum == "record" else "maximum",
        hazard=hazard, site_acceleration=site_acceleration(project),
        return_periods=demand_return_periods(project),
        local_limits={} if limit is None else dict.fromkeys(("SLV", "SLC"), limit),
        local_reason=assessment.local_displacement_reason,
    )  # fmt: skip


def with_loss(method: Method, loss: LocalLoss | None) -> Method:
    """Return the method with the local loss of the path as its limit, if the project gives no limit (C8.7.1.2)."""
    if loss is None or method.local_limits:
        return method
    limits = dict.fromkeys(("SLV", "SLC"), loss.displacement_m)
    reason = message("pushover, {lost}", lost=what_is_lost(loss))
    return replace(method, local_limits=limits, local_reason=reason)


def checks_of(curve: oscillator.CapacityCurve, checks: Mapping[str, parts.Check]) -> dict[str, parts.Check]:
    """Return the checks of a capacity curve by their names, their traces without the steps of the curve.

    Linear ones have α and e* of what is activated first.
    """
    common = len(curve.steps())
    linear = {"alpha_0": curve.activation.alpha, "e_star": curve.activation.e_star}
    return {
        name: check.replace(trace=check.trace[common:], **(linear if check.method == "linear" else {}))
        for name, check in checks.items()
    }


def curve_of(curve: oscillator.CapacityCurve) -> parts.OscillatorCurve:
    """Return a capacity curve as a part of the results: d* (m) and a* (g), divided by the confidence factor."""
    return parts.OscillatorCurve(d_star_m=curve.displacement.tolist(), a_star_g=curve.acceleration.tolist())
