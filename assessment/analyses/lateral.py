"""A state pushed over by lateral loads, direction by direction: curves, mechanisms, α0 by a second solver."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import get_args

import numpy as np

import mechanics
from assessment.analyses import paths
from assessment.analyses.found import Found, as_part
from assessment.ntc.capacity_curve import CapacityError, mass_share, mechanism_participation, yield_point
from assessment.project.project import Project
from assessment.project.schema import ControlTable
from assessment.results import frames
from assessment.results.joint_states import Met
from assessment.results.schema import finite, known, present, static
from assessment.results.table import sense
from mechanics import procedures
from mechanics.messages import Message, message
from mechanics.model import Behaviour, Direction
from mechanics.steps import Sliding

STILL = 1e-6  # of the largest virtual displacement: a control point that moves less takes no part
RESTS_OR_MOVES = 1.1  # ratio of the laws' multipliers up to which motions of rigid joints are not too small
DIFFERS = 0.01  # relative difference from α_0, by the other law of friction or farther on, that is reported


def rigid_push(control: ControlTable, path: procedures.Pushover) -> static.RigidPush:
    """Return a rigid curve, its mechanism at the point of α0 (C8.7.1.2), and α0 by the other law of friction."""
    model, direction, at, met = path.model, path.direction, path.states[path.formed], Met(path.model)
    mechanism = _mechanism(control, met, path.formed, float(path.multiplier[path.formed]), at, path)
    delta = np.array(mechanism.displacements)
    taken = mechanism.friction_work_kNm or 0.0
    if model.ties:  # those that yield take work too
        pulled, longer = frames.tensions(model, path.forces), frames.lengthenings(model, at.positions, delta)
        taken += float(np.where(frames.yielding(model, pulled), pulled, 0.0) @ longer)
    by_work = procedures.virtual_work_multiplier(model, delta, direction, taken)
    found = as_part(
        static.RigidPush, path, alpha_0=path.alpha_0, alpha_onset=float(path.multiplier[0]),
        # if equilibrium is lost before α = 0 the capacity ends there; a path that was cut short has no d_0
        d_0_m=float(path.displacement[-1]) if path.reached_zero or path.lost else None,
        local_loss=paths.local_loss(model, path.states, path.displacement, frames.normal_forces(path), path.lost),
        curve=_curve(path), d_star_m=_way_of_blocks(path, mechanism), mechanism=mechanism,
        virtual_work_alpha=finite(by_work), mechanism_configuration=model.displaced(at).tolist(),
        final_configuration=model.displaced(path.states[-1]).tolist(),
        frames=frames.path_frames(path, path.peak, path.formed, met=met),
        **present({"ties": frames.along_path(path, path.formed, rigid=True)}),
    )  # fmt: skip
    if path.formed:
        first = procedures.limit_in(model, direction, path.states[0], path.sliding)
        onset = _mechanism(control, met, 0, float(path.multiplier[0]), path.states[0], first)
        found = found.replace(onset=onset)
    # by Coulomb's law a joint that opens may slip more than it opens, and not be one that slides
    slides = mechanism.sliding_joints or (found.onset and found.onset.sliding_joints)
    if (slides or path.sliding == "coulomb") and (other := _other_law(found, control, path, met)):
        found = found.replace(other_law=other)
    return found


def elastic_push(path: procedures.Pushover) -> static.ElasticPush:
    """Return an elastic curve: its peak (α_u at d_u, m), end and yield point, which a check replaces by its own."""
    model = path.model
    yields = None  # where the control point does not advance as the load grows
    with suppress(CapacityError):
        yields = yield_point((path.displacement, np.minimum(path.multiplier, path.alpha_0)))
    return as_part(
        static.ElasticPush, path, alpha_u=path.alpha_0,
        d_u_m=float(path.displacement[path.peak]), curve=_curve(path),
        alpha_y=yields[1] if yields else None, d_y_m=yields[0] if yields else None,
        rest_configuration=model.displaced(path.states[0]).tolist(),
        peak_configuration=model.displaced(path.states[path.peak]).tolist(),
        frames=frames.path_frames(path, path.peak, path.formed),
        **present({"ties": frames.along_path(path, path.peak, rigid=False)}),
    )  # fmt: skip


def _mechanism(
    control: ControlTable, met: Met, point: int, alpha: float, at: mechanics.State,
    moving: procedures.Pushover | mechanics.Limit,
) -> static.Mechanism:  # fmt: skip
    """Return what is `moving` at a point of a curve of `alpha` and state `at`; new faces that slide go to `met`."""
    model, moved, contacts = moving.model, moving.mechanism, moving.contacts
    block, fastest = model.block_at(control.point_m), float(abs(moved[:, :2]).max())
    small = 1e-6 * model.size / fastest
    shift = model.point_displacement(control.point_m, block, at.positions + small * moved)
    rate = float((shift - model.point_displacement(control.point_m, block, at.positions))[0]) / small
    # 1 m of the control point along ±x; if that takes no part, the largest displacement is 1 m
    size = abs(rate) if abs(rate) > STILL * fastest else fastest
    displacements, control_dx = moved / size, rate / size
    found = procedures.hinges(model, contacts, at, displacements, moving.forces)
    slides = np.isin(np.arange(len(contacts)), found.sliding)
    e_star = gamma_star = None  # where they are not defined the capacity is refused later, with its reason
    with suppress(CapacityError):
        e_star = mass_share(model, displacements)
        gamma_star = mechanism_participation(model, displacements, control_dx).gamma_star
    slid = moving.sliding == "coulomb"
    work = procedures.friction_work(contacts, at, displacements, moving.forces) if slid else None
    return static.Mechanism(
        point=point, alpha=alpha, hinges=len(found.points), e_star=e_star, gamma_star=gamma_star,
        displacements=displacements.tolist(), control_displacement_x=control_dx,
        hinge_points_m=model.as_drawn(found.points).tolist(),
        sliding_joints=met.numbers(contacts, slides)[found.sliding].tolist(),
        moving_weight_kN=float(found.moving_weight), friction_work_kNm=work,
    )  # fmt: skip


def _way_of_blocks(path: procedures.Pushover, mechanism: static.Mechanism) -> list[float] | None:
    """Return d* (k,) m of the blocks: ΣPδu/ΣPδ, u how far each has gone since the mechanism formed; before Γ* d_C.

    None where Γ* is not defined. Of a mechanism that goes on as it begins it is Γ* d_C throughout (C8.7.1.2).
    """
    if mechanism.gamma_star is None:
        return None
    weighed = path.model.lateral_load(path.direction)[:, 0] * np.array(mechanism.displacements)[:, 0]
    x = np.array([state.positions[:, 0] for state in path.states])
    gone = sense(path.direction) * ((x - x[path.formed]) @ weighed) / float(weighed.sum())
    formed = path.displacement[path.formed]
    gone[: path.formed] = mechanism.gamma_star * (path.displacement[: path.formed] - formed)
    return (mechanism.gamma_star * formed + gone).tolist()


def _other_law(
    found: static.RigidPush, control: ControlTable, path: procedures.Pushover, met: Met
) -> static.OtherLaw | None:
    """Return limit analysis by the other law of friction, if its multipliers differ by DIFFERS; None without a flow."""
    law: Sliding = "coulomb" if found.sliding == "associative" else "associative"
    own = {k: float(path.multiplier[k]) for k in (0, path.formed, path.peak)}
    try:
        limits = {k: procedures.limit_in(path.model, path.direction, path.states[k], law) for k in own}
    except (mechanics.NoEquilibriumError, mechanics.ConvergenceError):  # the curve has its own multiplier
        return None
    if all(abs(limits[k].alpha - alpha) <= DIFFERS * abs(alpha) for k, alpha in own.items()):
        return None
    moving = {
        k: _mechanism(control, met, k, limits[k].alpha, path.states[k], limits[k])
        for k in dict.fromkeys((path.formed, 0))
    }
    alpha_0 = limits[path.peak].alpha
    if path.alpha_0 < own[path.peak]:  # more is not borne
        alpha_0 = min(alpha_0, path.alpha_0)
    other = static.OtherLaw(sliding=law, alpha_0=alpha_0, mechanism=moving[path.formed])
    return other.replace(alpha_onset=limits[0].alpha, onset=moving[0]) if path.formed else other


def _curve(path: procedures.Pushover) -> static.Curve:
    """Return the points of a curve; displacements (m) are along x: towards −x they are negative."""
    along_x = sense(path.direction) * path.displacement + 0.0  # + 0.0: no −0.0
    return static.Curve(displacement_m=along_x.tolist(), multiplier=path.multiplier.tolist())


FRICTION: dict[Sliding, Message] = {
    "coulomb": message("Coulomb friction, which does not lift what slides,"),
    "associative": message("associative friction, which lifts what slides,"),
}
AGREE = 1e-6  # relative difference of the multipliers of two solvers from which there is a warning
LEAST = 1e-2  # a multiplier below which differences are relative to this: solvers know α to 1e-9, not its digits at 0
CHOSEN = {"it": "scelto {direction}", "en": "chosen {direction}"}  # name of a control point
MEETS = 0.01  # of α0: a curve as drawn whose onset is lower by more rises where blocks meet others


@dataclass(frozen=True)
class PushSetting:
    """How a state is pushed over: behaviour and friction law of the joints, step of the control point (`increment`, m).

    `until`: share of the peak of an elastic curve at which it is followed no further.
    """

    behaviour: Behaviour
    sliding: Sliding
    increment: float
    until: float = 0.0


@dataclass(frozen=True, eq=False)
class Pushed:
    """A curve in plain numbers, and where a rigid one has its largest multiplier (`activated`)."""

    curves: static.Pushovers
    activated: mechanics.State | None = None


def push(
    model: mechanics.Assembly, name: str, state: mechanics.State | None, setting: PushSetting,
    directions: tuple[Direction, ...], controls: tuple[ControlTable, ...],
) -> list[Found[Pushed]]:  # fmt: skip
    """Push the state of that name over (None: as drawn), by its control point or, if that takes no part, one that does.

    A second direction is the mirror image of the first, and so is its curve: model and control points are each other's.
    """
    behaviour, parts = setting.behaviour, []
    followed: tuple[ControlTable, procedures.Pushover] | None = None
    for direction, control in zip(directions, controls, strict=True):
        began, found, image = time.perf_counter(), Found[Pushed](), None
        title = pushover_title(name, direction, behaviour)
        # where the control point of the first direction does not move, that of the other has its own curve
        if followed and followed[0] == controls[0] and (mirror := procedures.Mirror.of(model, behaviour)):
            image = mirror.pushover(followed[1])
        if image is not None:
            followed = control, image
        else:
            follow = partial(
                mechanics.pushover, model, direction=direction, contacts=behaviour, increment=setting.increment,
                state=state, until=setting.until, sliding=setting.sliding,
            )  # fmt: skip
            followed = _path(title, control, follow, found)
        if followed is not None:
            try:
                add_curve(title, setting, *followed, found)
            except (mechanics.NoEquilibriumError, mechanics.ConvergenceError) as error:
                # checks are of the first motion: no curve without it
                found.fail(title, message("the mechanism of the first motion is not found: {reason}",
                                          reason=error.message))  # fmt: skip
        path = followed[1] if followed and image is None else None
        found.quality.append(paths.quality_row(name, f"pushover, {behaviour}", path))
        found.seconds = time.perf_counter() - began
        parts.append(found)
    return parts


def pushover_title(state: str, direction: Direction, behaviour: Behaviour) -> Message:
    """Return the beginning of the warnings of a pushover."""
    return message(
        "{state}, pushover {direction}, {contacts} contacts", state=state, direction=direction,
        contacts=behaviour,
    )  # fmt: skip


def _path(
    title: str, control: ControlTable, follow: Callable[..., procedures.Pushover], found: Found[Pushed]
) -> tuple[ControlTable, procedures.Pushover] | None:
    """Return the control point, or one that takes part where it does not, and its curve; the reason is in `found`."""
    try:
        try:
            return control, follow(control.point_m)
        except mechanics.ControlError:
            path = follow()
    except (*paths.NO_ANSWER, mechanics.ControlError) as error:
        found.fail(title, error.message)
        return None
    x, z = path.control.tolist()
    other = ControlTable(name=f"({x:.4g}, {z:.4g}) m", point_m=(x, z))
    found.warn(title, message(
        'control point "{name}" takes no part: that of block {block} at {point} is followed, which goes farthest along '
        "the push", name=control.name, block=path.block, point=other.name,
    ))  # fmt: skip
    return other, path


def add_curve(
    title: str, setting: PushSetting, control: ControlTable, path: procedures.Pushover, found: Found[Pushed]
) -> None:
    """Add a curve to what is found, and the warnings about it; `title` begins each of them."""
    found.warn(title, *paths.crossings(path.crossed, setting.increment), *paths.lifts(path))
    found.scatters = paths.turns_on_rounding(path)
    rigid = setting.behaviour == "rigid"
    curves = static.Pushovers(control=control.name, control_m=list(control.point_m))
    if rigid:
        curve = rigid_push(control, path)
        found.value = Pushed(curves.replace(rigid=curve), path.states[path.peak])
        found.warn(title, *_rigid_notes(curve, path))
    else:
        found.value = Pushed(curves.replace(elastic=elastic_push(path)))
    beyond = path.multiplier[path.peak :].max()
    if beyond > (1.0 + DIFFERS) * path.alpha_0:
        found.warn(title, message(
            "under more than α = {alpha:.4g} held the structure falls; what the curve has beyond, up to {beyond:.4g}, "
            "is not used", alpha=path.alpha_0, beyond=float(beyond),
        ))  # fmt: skip
    # of an elastic curve the part up to its peak is used, of a rigid one the whole
    if not path.reached_zero and (rigid or path.multiplier[-1] > 0.5 * path.multiplier.max()):
        d, alpha = float(path.displacement[-1]), float(path.multiplier[-1])
        found.warn(title, message(
            "ends at d = {displacement:.4g} m, α = {multiplier:.4g}: {reason}", displacement=d, multiplier=alpha,
            reason=path.end,
        ))  # fmt: skip


def _rigid_notes(curve: static.RigidPush, path: procedures.Pushover) -> Iterator[Message]:
    """Yield what to know about a rigid curve: its onset, the other law of friction, local losses, its mechanism."""
    drawn = np.array_equal(path.states[0].positions, path.model.initial.positions)
    if drawn and curve.alpha_onset < (1.0 - MEETS) * curve.alpha_0:
        yield message(
            "blocks move from α = {onset:.4g} on; by d = {displacement:.3g} m they have met others or slide in another "
            "way, and α0 = {multiplier:.4g} is that of what moves then; the former activates the first mechanism: "
            "linear checks are of it",
            onset=curve.alpha_onset, displacement=float(path.displacement[path.peak]), multiplier=curve.alpha_0,
        )  # fmt: skip
    if path.model.crushes and curve.mechanism.sliding_joints:
        yield message(
            "joints slide and can be crushed: of several ways to slide the curve may take one whose α0 is some 5 % "
            "above that of joints without compressive_strength_kN_m2; compare them",
        )  # fmt: skip
    if len(path.dropped):
        yield message(
            "points left out of the curve or replaced: {count}, up to α = {multiplier:.4g}; in their states limit "
            "analysis finds less, which stands in their place, or only a mechanism that lifts what slides",
            count=len(path.dropped), multiplier=float(path.dropped[:, 1].max()),
        )  # fmt: skip
    other = curve.other_law  # it may be the onset alone that differs
    if other is not None and abs(other.alpha_0 - curve.alpha_0) > DIFFERS * abs(curve.alpha_0):
        yield message(
            "by {law} α0 is {other:.4g}, not {multiplier:.4g}", law=FRICTION[other.sliding],
            other=other.alpha_0, multiplier=curve.alpha_0,
        )  # fmt: skip
    if curve.local_loss is not None:
        yield paths.loss_sentence(curve.local_loss)
    if path.formed != path.peak:
        yield message(
            "the control point takes no part in the mechanism at α0: displacements, e*, Γ*, forces and hand "
            "check are those of d = {displacement:.4g} m, α = {multiplier:.4g}",
            displacement=float(path.displacement[path.formed]), multiplier=float(path.multiplier[path.formed]),
        )  # fmt: skip


def rests_or_moves(model: mechanics.Assembly, name: str, start: mechanics.State) -> Found[float]:
    """Return the largest ratio of the associative to Coulomb's multiplier of both directions, and warn of a large one.

    Rigid joints may move from Coulomb's multiplier on. Up to the associative one they may also rest, for forces within
    their bounds exist that balance; a motion rests wherever it can.
    """
    found = Found(1.0)
    for direction in get_args(Direction):
        with suppress(*paths.NO_ANSWER):
            moves = mechanics.limit_analysis(model, direction, start, "coulomb").alpha
            rests = mechanics.limit_analysis(model, direction, start, "associative").alpha
            found.value = max(known(found.value), rests / max(moves, LEAST))
            if rests > RESTS_OR_MOVES * moves:
                found.warn(name, message(
                    "{direction}: under α from {moves:.3g} to {rests:.3g} rigid joints may rest, wedged by friction, "
                    "or move: motions with rigid joints may be too small; run them with elastic joints too",
                    direction=direction, moves=moves, rests=rests,
                ))  # fmt: skip
    return found


def second_solver(
    model: mechanics.Assembly, name: str, direction: Direction, activated: mechanics.State, alpha_0: float
) -> Found[static.SecondSolver]:
    """Compare the associative multipliers of two programs in the state `activated`; `alpha_0`: of the curve there.

    With Coulomb's law no linear program has the multiplier. Nothing is `found` where joints crush.
    """
    began = time.perf_counter()
    found = Found[static.SecondSolver]()
    title = pushover_title(name, direction, "rigid")
    own = linear = None
    try:
        linear = procedures.static_theorem(model, direction, activated)
        if linear is None:
            found.warn(title, message("the linear program of limit analysis has no optimum by HiGHS"))
        own = procedures.limit_in(model, direction, activated, "associative").alpha
    except mechanics.ArgumentError:
        return found
    except (mechanics.NoEquilibriumError, mechanics.ConvergenceError) as error:
        found.warn(title, message("limit analysis where α0 is reached: {reason}", reason=error.message))
    difference = None
    if own is not None and linear is not None:
        difference = (linear - own) / max(abs(own), LEAST)
        if abs(difference) > AGREE:
            found.warn(title, message(
                "limit analysis where α0 is reached gives α = {own:.8g}, a linear program written apart (HiGHS) "
                "{linear:.8g}: relative difference {difference:.2g}", own=own, linear=linear, difference=difference,
            ))  # fmt: skip
    found.value = static.SecondSolver(
        alpha_0=alpha_0, alpha_program=own, alpha_linear_program=linear, relative_difference=difference
    )
    found.seconds = time.perf_counter() - began
    return found


def with_control(project: Project, model: mechanics.Assembly) -> tuple[Project, list[Message]]:
    """Return the project with a control point for each direction where it needs one and has none, and which these are.

    It is the corner that goes farthest along the push in the first mechanism of the structure as drawn, `model`: the
    same in every state, so that their displacements can be compared.
    """
    needed = project.pushover or project.history or project.incremental or project.campaign
    if project.control or not needed:
        return project, []
    directions: tuple[Direction, ...] = project.pushover.directions if project.pushover else ("+x",)
    points, notes = [], []
    for direction in directions:
        begun = model.initial.positions
        # that of the highest corner where nothing moves
        moved = begun + np.where(model.movable[:, None], (1.0, 0.0, 0.0), 0.0)
        with suppress(*paths.NO_ANSWER):
            limit = mechanics.limit_analysis(model, direction, sliding=project.contacts.sliding)
            moved = begun + 1e-6 * model.size * limit.mechanism
        (x, z), block = procedures.farthest_corner(model, begun, moved, direction)
        name = CHOSEN[project.report.language].format(direction=direction)
        points.append(ControlTable(name=name, point_m=(float(x), float(z))))
        notes.append(message(
            "no control point given: towards {direction} that of block {block} at ({x:.4g}, {z:.4g}) m is followed, "
            "which goes farthest along the push", direction=direction, block=block, x=float(x), z=float(z),
        ))  # fmt: skip
    changed: dict[str, object] = {"control": tuple(points)}
    if project.pushover:
        by_direction = {way: point.name for way, point in zip(directions, points, strict=True)}
        changed["pushover"] = project.pushover.model_copy(update={"control": by_direction})
    return project.model_copy(update=changed), notes
