"""Mechanisms chosen by the user: α0 by virtual work, beside that of limit analysis (Circolare 7/2019, C8.7.1.2).

Macro-blocks rotate about given points: δ_x = −θ (z − z_C), δ_z = θ (x − x_C). If no closed joint penetrates or slides
against friction, contact forces do no work, and α0 = Σ W δ_z/Σ P δ_x is an upper bound of the true multiplier.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from assessment.analyses import kinematics
from assessment.analyses.capacity import checks_of, curve_of, method_of
from assessment.analyses.demand import Demands, confidence_source
from assessment.analyses.found import as_part
from assessment.analyses.paths import broken_tie
from assessment.ntc.capacity_curve import CapacityError, CurveFit, capacity_curve, fit_rigid, mass_share
from assessment.ntc.floor_spectrum import Spectrum
from assessment.ntc.tables import CONFIDENCE_FACTOR
from assessment.ntc.verification import Method, verify
from assessment.project.masonry import Chosen, chosen_mechanisms
from assessment.project.model import StateModel
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL
from assessment.results.joint_states import Met
from assessment.results.schema import StateResults, finite, known
from assessment.results.schema import checks as parts
from mechanics import Assembly
from mechanics.messages import Message, SaidError, message
from mechanics.model import Contacts, H, end_gaps, end_points, relative_motion
from mechanics.steps import LIMIT, static_system
from mechanics.types import Mask

Array = NDArray[np.float64]

CURVE = {"F_C", "a_0_star", "d_0", "d_0_star"}  # steps of the capacity curve beside those of virtual work


@dataclass(frozen=True, slots=True)
class GivenTolerances:
    """Tolerances of a mechanism that is given, over its largest displacement but for the last."""

    penetration: float = 0.02  # allowed for hinges set back from the edge
    rounding: float = 1e-4  # penetration from rounded coordinates
    still: float = 1e-6  # displacement of a control point below which it takes no part
    below: float = 1e-3  # relative, of the comparison with the multiplier of limit analysis


GIVEN = GivenTolerances()


@dataclass(frozen=True)
class FollowedPoint:
    """A point (x, z) m, from the origin, of a block, and its horizontal displacement `delta_x` in a mechanism."""

    point: tuple[float, float]
    block: int
    delta_x: float = 0.0


class MechanismError(SaidError, ValueError):
    """A mechanism that cannot move as it was given, or that no horizontal load can start."""


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Motion in the joints of a configuration under virtual displacements."""

    penetration: float  # the deepest one, between the blocks `pair`, over the largest displacement
    pair: tuple[int, int]
    contacts: Contacts
    shut: Mask  # (j,): which `contacts` are closed at one end or both
    slides: Mask  # (j,): which slide against friction

    def closed(self, positions: Array) -> kinematics.Closed:
        """Return blocks and ends of the closed contacts at `positions` (b, 3)."""
        ends = end_points(self.contacts, positions)
        return self.contacts.a[self.shut], self.contacts.b[self.shut], ends[self.shut]


def joint_motion(model: Assembly, positions: Array, delta: Array) -> JointMotion:
    """Return the motion of virtual displacements (b, 3) in the joints that are closed at `positions` (b, 3).

    Only closed ends of faces that overlap count. A joint slides against friction if its slip exceeds that of
    associative friction at the opening of a closed end, u_t > u_n/μ: friction would do work.
    """
    contacts = static_system(model, "rigid").around(positions, LIMIT.onset * model.size).contacts
    places = contacts.places(positions)
    faces = (places[:, H] > 0.0) & ~contacts.ties
    closed = (end_gaps(places) <= LIMIT.closed * model.size) & faces[:, None]
    u, phi, v = relative_motion(places, np.concatenate([delta[contacts.a], delta[contacts.b]], axis=1)).T
    half = places[:, H] * phi
    opening = np.where(closed, np.stack([u - half, u + half], axis=1), np.inf).min(axis=1)
    largest = float(abs(delta[:, :2]).max())
    worst = int(np.argmin(opening))
    least = np.maximum(contacts.friction, 1e-99)  # without friction nothing slides against it
    most = np.maximum(opening, 0.0) / least + GIVEN.rounding * largest / np.minimum(least, 1.0)
    shut, deepest = np.asarray(closed.any(axis=1)), max(0.0, -float(opening[worst]) / largest)
    pair = (int(contacts.a[worst]), int(contacts.b[worst]))
    return JointMotion(deepest, pair, contacts, shut, shut & (abs(v) > most))


def begun(model: Assembly, at: Array, chosen: Chosen) -> tuple[Array, JointMotion, kinematics.VirtualWork]:
    """Return virtual displacements (b, 3), motion in the joints, virtual work. Raises as `evaluate`."""
    delta = kinematics.virtual_displacements(model, at, chosen)
    motion = joint_motion(model, at, delta)
    if motion.penetration > GIVEN.penetration:  # by more than a hinge set back from the edge does
        raise MechanismError(message(
            "block {block} penetrates block {other} by {share:.3g} % of the largest displacement; "
            "correct centres, rotations (anticlockwise positive) or the choice of blocks",
            block=motion.pair[0], other=motion.pair[1], share=100.0 * motion.penetration,
        ))  # fmt: skip
    for tie, _ in kinematics.works(model, at, delta)[2]:
        if np.isinf(tie.yield_force):
            raise MechanismError(message('tie "{name}" would have to lengthen; give it a yield_force_kN, or a '
                                         "mechanism that it allows", name=tie.name))  # fmt: skip
    work = kinematics.virtual_work(model, at, chosen)
    if abs(work.lateral) <= 1e-9 * work.moving * float(abs(delta[:, :2]).max()):
        raise MechanismError(message("the weights do no horizontal work: no horizontal load starts it"))
    if work.alpha_0 <= 0.0:
        raise MechanismError(message("alpha_0 = {alpha:.4g}: the weights drive it without any horizontal load; change "
                                     "the sense of rotation", alpha=work.alpha_0))  # fmt: skip
    mass_share(model, delta)
    return delta, motion, work


def evaluate(
    model: Assembly, positions: Array, chosen: Chosen, confidence_factor: float,
    demands: Mapping[str, Spectrum], method: Method, controls: Mapping[str, FollowedPoint] | None = None,
    confidence_source: str = CONFIDENCE_FACTOR,
) -> parts.GivenMechanism:  # fmt: skip
    """Return α0 of a chosen mechanism at `positions` (b, 3), its direction, its checks and their steps.

    `confidence_source`: the paragraph that F_C follows from. `controls`: control point of each direction. If it takes
    no part in the mechanism, the block that moves farthest has the control point. Raises MechanismError if blocks
    penetrate, if no weight moves horizontally, or if the weights alone drive the motion, CapacityError without an e*.
    """
    delta, motion, work = begun(model, positions, chosen)
    direction: parts.Direction = "+x" if work.lateral > 0.0 else "-x"
    given = (controls or {}).get(direction)
    control = followed(positions, delta, given, 1.0 if direction == "+x" else -1.0)
    if given is None or (given.block, given.point) != (control.block, control.point):
        method = replace(method, local_limits={})  # the local loss is a displacement of another point
    for tie, longer in kinematics.works(model, positions, delta)[2]:
        far = tie.longest / longer * abs(control.delta_x)  # where its lengthening goes on as it begins
        if far < method.local_limits.get("SLV", np.inf):
            limits, breaks = dict.fromkeys(("SLV", "SLC"), far), broken_tie(tie.name, tie.longest)
            method = replace(method, local_limits=limits, local_reason=breaks)

    met = Met(model)
    sliding = met.numbers(motion.contacts, motion.slides)[motion.slides].tolist()
    notes = []
    if motion.penetration > GIVEN.rounding:
        notes.append(message(
            "block {block} penetrates block {other} by {share:.2g} % of the largest displacement, "
            "as with a hinge set back from the edge", block=motion.pair[0], other=motion.pair[1],
            share=100.0 * motion.penetration,
        ))  # fmt: skip
    if sliding:
        notes.append(message("joints that slide as the mechanism moves: {count}; their friction is left out, so that "
                             "alpha_0 is lower than with it", count=len(sliding)))  # fmt: skip
    fit = fit_rigid(([0.0, 1.0], [work.alpha_0, work.alpha_0]))
    if demands.keys() & {"SLV", "SLC"}:
        try:
            fit = _fit(model, positions, chosen, motion.closed(positions), control)
        except (kinematics.KinematicsError, CapacityError) as refusal:
            notes.append(message("no nonlinear check: {reason}", reason=refusal.message))
    by_hand = work.by_hand(control.delta_x)
    capacity = capacity_curve(fit, work.e_star, by_hand[-1].result, confidence_factor, confidence_source)
    steps = [*by_hand, *(line for line in capacity.steps() if line.symbol in CURVE)]
    checks = verify(capacity, demands, method)
    if capacity.d_0_star is None:  # the finite motion is not known
        checks = {name: check for name, check in checks.items() if check.method == "linear"}
    turned = [
        parts.GivenMacroBlock(
            about_m=model.as_drawn(part.about).tolist(), rotation=part.rotation, blocks=part.blocks.tolist()
        )
        for part in chosen.parts
    ]
    return as_part(
        parts.GivenMechanism, chosen, work, motion, direction=direction, gamma_star=capacity.gamma_star,
        control_m=model.as_drawn(control.point).tolist(), a_0_star_g=capacity.a_0_star,
        d_0_m=finite(capacity.fit.d_0), d_0_star_m=finite(capacity.d_0_star),
        curve=curve_of(capacity) if capacity.fit.d_0 is not None else None, moving_weight_kN=work.moving,
        macro_blocks=turned, displacements=(delta / abs(delta[:, :2]).max()).tolist(),
        sliding_joints=sliding, met=met.joints, notes=[*notes], trace=steps,
    ).with_checks(checks_of(capacity, checks))  # fmt: skip


def followed(positions: Array, delta: Array, control: FollowedPoint | None, sense: float) -> FollowedPoint:
    """Return the given control point, if it moves along the push, or the centroid that moves farthest, with its δ."""
    along = sense * delta[:, 0]
    if control is not None:
        arm = np.subtract(control.point, positions[control.block, :2])
        own = along[control.block] - sense * delta[control.block, 2] * arm[1]
        if own > GIVEN.still * float(abs(delta[:, :2]).max()):
            return replace(control, delta_x=float(sense * own))
    block = int(np.argmax(along))
    x, z = positions[block, :2].tolist()
    return FollowedPoint((x, z), block, float(delta[block, 0]))


def _fit(
    model: Assembly, positions: Array, chosen: Chosen, closed: kinematics.Closed, control: FollowedPoint
) -> CurveFit:
    """Return α over the displacement of the control point, m, along the finite motion (C8.7.1.2.1.2)."""
    places, alpha = kinematics.finite_motion(model, positions, chosen, kinematics.hinges_of(chosen, closed))
    x, z = np.subtract(control.point, positions[control.block, :2])
    turned = places[:, control.block, 2] - positions[control.block, 2]
    reached = places[:, control.block, 0] + np.cos(turned) * x - np.sin(turned) * z
    d = np.sign(control.delta_x) * (reached - control.point[0])
    if (np.diff(d) <= 0.0).any():
        back = message("the control point turns back before α = 0; choose one that does not")
        raise kinematics.KinematicsError(back)
    return replace(fit_rigid((d, alpha)), source="virtual work, hinges followed")


def compared(found: parts.GivenMechanism, alpha_0: float | None, onset: float | None) -> parts.GivenMechanism:
    """Return the mechanism with the α0 of its state in its direction, and a note if its own α0 is lower."""
    notes, own = list(known(found.notes)), known(found.alpha_0)
    if onset is not None and own < (1.0 - GIVEN.below) * onset:
        notes.append(message(
            "alpha_0 is below that of limit analysis, which no mechanism without sliding and penetration can be: "
            "the friction of the sliding joints, or the penetration, is what it leaves out"
        ))  # fmt: skip
    elif alpha_0 is not None and onset is not None and own < (1.0 - GIVEN.below) * alpha_0:
        notes.append(message(
            "alpha_0 is below that of the state, {alpha:.4g}: a hinge of the settlement closes from α = "
            "{onset:.4g} on, before that is reached", alpha=alpha_0, onset=onset,
        ))  # fmt: skip
    return found.replace(alpha_0_limit=alpha_0, notes=notes)


def assess_chosen(
    project: Project, models: Mapping[str, StateModel], states: Mapping[str, StateResults], demands: Demands,
    warnings: list[Message],
) -> list[parts.GivenMechanism]:  # fmt: skip
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
            controls: dict[str, FollowedPoint] = {}  # where each control point of the pushover is
            for direction in project.pushover.directions if project.pushover else ():
                point = project.pushover_control(direction).point_m
                block = model.block_at(point)
                x, z = (model.from_origin(point) + model.point_displacement(point, block, positions)).tolist()
                controls[direction] = FollowedPoint((x, z), block)
            answer = evaluate(model, positions, chosen, factor, demands.spectra, method, controls, source)
            pushed = state.pushover.get(known(answer.direction))
            rigid = pushed.rigid if pushed else None
            answer = compared(answer, rigid.alpha_0 if rigid else None, rigid.alpha_onset if rigid else None)
            name, notes = chosen.name, known(answer.notes)
            warnings += [message('mechanism "{name}": {text}', name=name, text=note) for note in notes]
        except (MechanismError, CapacityError) as refusal:
            answer = parts.GivenMechanism(name=chosen.name, state=chosen.state, refused=refusal.message)
            warnings.append(_of_mechanism(chosen.name, refusal))
        found.append(answer)
    return found


def _of_mechanism(name: str, refusal: SaidError) -> Message:
    return message('mechanism "{name}": refused: {reason}', name=name, reason=refusal.message)


def refused_as_drawn(project: Project, model: StateModel) -> Iterator[Message]:
    """Yield why mechanisms that the user chose on the structure as drawn, `model`, are refused, without an analysis."""
    for chosen in chosen_mechanisms(project, model.assembly):
        if chosen.state == ORIGINAL:
            try:
                begun(model.assembly, model.assembly.initial.positions, chosen)
            except (MechanismError, CapacityError) as refusal:
                yield _of_mechanism(chosen.name, refusal)
