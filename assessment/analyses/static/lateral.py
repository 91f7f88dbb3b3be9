"""A state pushed over by lateral loads, direction by direction; its control point, and α0 by a second solver."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.found import Found
from assessment.analyses.static.curve_numbers import elastic_push, rigid_push
from assessment.analyses.static.paths import crossings, lifts, loss_sentence, quality_row, turns_on_rounding
from assessment.project.schema import ControlTable
from assessment.results.schema.static import Pushovers, RigidPush, SecondSolver
from mechanics import (
    ArgumentError,
    Assembly,
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    State,
    UnstableError,
    limit_analysis,
    pushover,
)
from mechanics.messages import Message, headed, message
from mechanics.model import Behaviour, Direction
from mechanics.procedures import Mirror, Pushover, farthest_corner, limit_in, static_theorem
from mechanics.steps import Sliding

FRICTION: dict[Sliding, Message] = {
    "coulomb": message("Coulomb friction, which does not lift what slides,"),
    "associative": message("associative friction, which lifts what slides,"),
}
AGREE = 1e-6  # relative difference of the multipliers of two solvers from which there is a warning
LEAST = 1e-2  # a multiplier below which differences are relative to this: solvers know α to 1e-9, not its digits at 0
CHOSEN = {"it": "scelto {direction}", "en": "chosen {direction}"}  # name of a control point
MEETS = 0.01  # of α0: a curve as drawn whose onset is lower by more rises where blocks meet others


if TYPE_CHECKING:
    from assessment.project.project import Project


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

    curves: Pushovers
    activated: State | None = None


def push(
    model: Assembly,
    name: str,
    state: State | None,
    setting: PushSetting,
    directions: tuple[Direction, ...],
    controls: tuple[ControlTable, ...],
) -> list[Found[Pushed]]:
    """Push the state of that name over (None: as drawn), by its control point or, if that takes no part, one that does.

    A second direction is the mirror image of the first, and so is its curve: model and control points are each other's.
    """
    behaviour, parts = setting.behaviour, []
    followed: tuple[ControlTable, Pushover] | None = None
    for direction, control in zip(directions, controls, strict=True):
        began = time.perf_counter()
        found = Found[Pushed]()
        title = pushover_title(name, direction, behaviour)
        # where the control point of the first direction does not move, that of the other has its own curve
        image = None
        if followed is not None and followed[0] == controls[0]:
            image = mirror_of(model, behaviour).pushover(followed[1])
        if image is not None:
            followed = control, image
        else:
            follow = partial(
                pushover,
                model,
                direction=direction,
                contacts=behaviour,
                increment=setting.increment,
                state=state,
                until=setting.until,
                sliding=setting.sliding,
            )
            followed = _path(title, control, follow, found)
        if followed is not None:
            add_curve(title, model, setting, direction, *followed, found)
        path = followed[1] if followed and image is None else None
        found.quality.append(quality_row(name, f"pushover, {behaviour}", path))
        found.seconds = time.perf_counter() - began
        parts.append(found)
    return parts


def pushover_title(state: str, direction: Direction, behaviour: Behaviour) -> Message:
    """Return the beginning of the warnings of a pushover."""
    return message(
        "{state}, pushover {direction}, {contacts} contacts",
        state=state,
        direction=direction,
        contacts=behaviour,
    )


def mirror_of(model: Assembly, behaviour: Behaviour) -> Mirror:
    """Return the mirror of a model that has one."""
    mirror = Mirror.of(model, behaviour)
    assert mirror is not None
    return mirror


def _path(
    title: str, control: ControlTable, follow: Callable[..., Pushover], found: Found[Pushed]
) -> tuple[ControlTable, Pushover] | None:
    """Return the control point, or one that takes part where it does not, and its curve; the reason is in `found`."""
    try:
        try:
            return control, follow(control.point_m)
        except ControlError:
            path = follow()
    except (UnstableError, ConvergenceError, NoEquilibriumError, ControlError) as error:
        found.failures.append(headed(title, error.message))
        return None
    x, z = path.control.tolist()
    other = ControlTable(name=f"({x:.4g}, {z:.4g}) m", point_m=(x, z))
    reason = message(
        'control point "{name}" takes no part: that of block {block} at {point} is followed, which goes farthest along '
        "the push",
        name=control.name,
        block=path.block,
        point=other.name,
    )
    found.warnings.append(headed(title, reason))
    return other, path


def add_curve(
    title: str,
    model: Assembly,
    setting: PushSetting,
    direction: Direction,
    control: ControlTable,
    path: Pushover,
    found: Found[Pushed],
) -> None:
    """Add a curve to what is found, and the warnings about it; `title` begins each of them."""
    found.warnings += crossings(title, path.crossed, setting.increment) + lifts(title, path)
    found.scatters = turns_on_rounding(model, path)
    rigid, curves = (
        setting.behaviour == "rigid",
        Pushovers(control=control.name, control_m=list(control.point_m)),
    )
    if rigid:
        curve = rigid_push(model, control, setting.sliding, direction, path)
        found.value = Pushed(curves.replace(rigid=curve), path.states[path.peak])
        found.warnings += [headed(title, note) for note in _rigid_notes(model, curve, path)]
    else:
        found.value = Pushed(curves.replace(elastic=elastic_push(model, setting.sliding, direction, path)))
    # of an elastic curve the part up to its peak is used, of a rigid one the whole
    if not path.reached_zero and (rigid or path.multiplier[-1] > 0.5 * max(path.multiplier)):
        end = message(
            "ends at d = {displacement:.4g} m, α = {multiplier:.4g}: {reason}",
            displacement=float(path.displacement[-1]),
            multiplier=float(path.multiplier[-1]),
            reason=path.end,
        )
        found.warnings.append(headed(title, end))


def _rigid_notes(model: Assembly, curve: RigidPush, path: Pushover) -> Iterator[Message]:
    """Yield what to know about a rigid curve: its onset, the other law of friction, local losses, its mechanism."""
    drawn = np.array_equal(path.states[0].positions, model.initial.positions)
    if drawn and curve.alpha_onset < (1.0 - MEETS) * curve.alpha_0:
        yield message(
            "blocks move from α = {onset:.4g} on and meet others by d = {displacement:.3g} m: α0 = {multiplier:.4g} is "
            "that of what moves together then; the former activates the first mechanism: linear checks are of it",
            onset=curve.alpha_onset,
            displacement=float(path.displacement[path.peak]),
            multiplier=curve.alpha_0,
        )
    if curve.other_law is not None:
        yield message(
            "by {law} α0 is {other:.4g}, not {multiplier:.4g}",
            law=FRICTION[curve.other_law.sliding],
            other=curve.other_law.alpha_0,
            multiplier=curve.mechanism.alpha,
        )
    if curve.local_loss is not None:
        yield loss_sentence(curve.local_loss)
    if path.formed != path.peak:
        yield message(
            "the control point takes no part in the mechanism at α0: displacements, e*, Γ*, forces and hand "
            "check are those of d = {displacement:.4g} m, α = {multiplier:.4g}",
            displacement=float(path.displacement[path.formed]),
            multiplier=float(path.multiplier[path.formed]),
        )


def second_solver(
    model: Assembly, name: str, direction: Direction, activated: State, alpha_0: float
) -> Found[SecondSolver]:
    """Compare the associative multipliers of two programs in the state `activated` of the state of that name.

    `alpha_0`: multiplier of the curve that has its peak there, a third number beside them.
    The law is associative whatever that of the curve: with Coulomb's the multiplier is not unique, and no linear
    program has it. Nothing is `found` where joints crush.
    """
    began = time.perf_counter()
    found = Found[SecondSolver]()
    title = pushover_title(name, direction, "rigid")
    try:
        linear = static_theorem(model, direction, activated)
    except ArgumentError:
        return found
    own: float | None = None
    try:
        own = limit_in(model, direction, activated, "associative").alpha
    except (NoEquilibriumError, ConvergenceError) as error:
        note = message("limit analysis where α0 is reached: {reason}", reason=error.message)
        found.warnings.append(headed(title, note))
    if linear is None:
        note = message("the linear program of limit analysis has no optimum by HiGHS")
        found.warnings.append(headed(title, note))
    difference = None
    if own is not None and linear is not None:
        difference = (linear - own) / max(abs(own), LEAST)
        if abs(difference) > AGREE:
            note = message(
                "limit analysis where α0 is reached gives α = {own:.8g}, a linear program written apart (HiGHS) "
                "{linear:.8g}: relative difference {difference:.2g}",
                own=own,
                linear=linear,
                difference=difference,
            )
            found.warnings.append(headed(title, note))
    found.value = SecondSolver(
        alpha_0=alpha_0,
        alpha_program=own,
        alpha_linear_program=linear,
        relative_difference=difference,
    )
    found.seconds = time.perf_counter() - began
    return found


def with_control(project: Project, model: Assembly) -> tuple[Project, list[Message]]:
    """Return the project with a control point for each direction where it needs one and has none, and which these are.

    It is the corner that goes farthest along the push in the first mechanism of the structure as drawn, `model`: the
    same in every state, so that their displacements can be compared.
    """
    needed = project.pushover or project.history or project.incremental or project.campaign
    if project.control or not needed:
        return project, []
    directions: tuple[Direction, ...] = project.pushover.directions if project.pushover else ("+x",)
    found = [_chosen(project, model, direction) for direction in directions]
    notes = [
        message(
            "no control point given: towards {direction} that of block {block} at ({x:.4g}, {z:.4g}) m is followed, "
            "which goes farthest along the push",
            direction=direction,
            block=block,
            x=point.point_m[0],
            z=point.point_m[1],
        )
        for direction, (point, block) in zip(directions, found, strict=True)
    ]
    points = tuple(point for point, _ in found)
    changed: dict[str, object] = {"control": points}
    if project.pushover:
        by_direction = {way: point.name for way, point in zip(directions, points, strict=True)}
        changed["pushover"] = project.pushover.model_copy(update={"control": by_direction})
    return project.model_copy(update=changed), notes


def _chosen(project: Project, model: Assembly, direction: Direction) -> tuple[ControlTable, int]:
    """Return the control point of a direction and its block; that of the highest corner where nothing moves."""
    begun = model.initial.positions
    moved = begun + model.movable[:, None] * [1.0, 0.0, 0.0]
    with suppress(UnstableError, NoEquilibriumError, ConvergenceError):
        limit = limit_analysis(model, direction, sliding=project.contacts.sliding)
        moved = begun + 1e-6 * model.size * limit.mechanism
    (x, z), block = farthest_corner(model, begun, moved, direction)
    name = CHOSEN[project.report.language].format(direction=direction)
    return ControlTable(name=name, point_m=(float(x), float(z))), block
