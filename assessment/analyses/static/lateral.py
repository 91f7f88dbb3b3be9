"""A state pushed over by lateral loads, direction by direction, in plain numbers for results.json."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from assessment.analyses.static.curve_numbers import LIFTED, elastic_push, rigid_push
from assessment.analyses.static.local_loss import loss_sentence
from assessment.analyses.static.paths import PathResult, Quality, crossings, turns_on_rounding
from assessment.project.schema import ControlTable
from assessment.results.schema.static import Pushovers, RigidPush
from mechanics import (
    Assembly,
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    State,
    UnstableError,
    pushover,
)
from mechanics.messages import Message, headed, message
from mechanics.model import Behaviour, Direction
from mechanics.procedures import Mirror, Pushover
from mechanics.steps import Sliding

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


def push(
    model: Assembly,
    name: str,
    state: State | None,
    setting: PushSetting,
    directions: tuple[Direction, ...],
    controls: tuple[ControlTable, ...],
) -> list[PathResult[Pushovers]]:
    """Push the state of that name over (None: as drawn), by its control point or, if that takes no part, one that does.

    A second direction is the mirror image of the first, and so is its curve: model and control points are each other's.
    """
    behaviour = setting.behaviour
    parts = []
    found: tuple[ControlTable, Pushover] | None = None
    for direction, control in zip(directions, controls, strict=True):
        began = time.perf_counter()
        result, quality = PathResult[Pushovers](), Quality(name, f"pushover, {behaviour}")
        title = pushover_title(name, direction, behaviour)
        # where the control point of the first direction does not move, that of the other has its own curve
        image = None
        if found is not None and found[0] == controls[0]:
            image = mirror_of(model, behaviour).pushover(found[1])
        if image is not None:
            found = control, image
        else:
            followed = partial(
                pushover,
                direction=direction,
                contacts=behaviour,
                increment=setting.increment,
                state=state,
                until=setting.until,
                sliding=setting.sliding,
            )
            found = _path(title, model, control, followed, result)
            if found is not None:
                quality.add(found[1])
        if found is not None:
            add_curve(title, model, setting, direction, *found, result)
        result.quality.append(quality.row)
        result.seconds = time.perf_counter() - began
        parts.append(result)
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
    title: str,
    model: Assembly,
    control: ControlTable,
    followed: Callable[..., Pushover],
    result: PathResult[Pushovers],
) -> tuple[ControlTable, Pushover] | None:
    """Return the control point, or one that takes part where it does not, and its curve; the reason is in `result`."""
    try:
        try:
            return control, followed(model, control.point_m)
        except ControlError:
            path = followed(model)
    except (UnstableError, ConvergenceError, NoEquilibriumError, ControlError) as error:
        result.failures.append(headed(title, error.message))
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
    result.warnings.append(headed(title, reason))
    return other, path


def add_curve(
    title: str,
    model: Assembly,
    setting: PushSetting,
    direction: Direction,
    control: ControlTable,
    path: Pushover,
    result: PathResult[Pushovers],
) -> None:
    """Add a curve to the result, and the warnings about it; `title` begins each of them."""
    result.warnings += crossings(title, path.crossed, setting.increment)
    result.scatters = turns_on_rounding(model, path)
    rigid = setting.behaviour == "rigid"
    if rigid:
        result.activated = path.states[path.peak]
        curve = rigid_push(model, control, setting.sliding, direction, path)
        result.found = Pushovers(control=control.name, control_m=list(control.point_m), rigid=curve)
        result.warnings += [headed(title, note) for note in _rigid_notes(model, curve, path)]
    else:
        elastic = elastic_push(model, setting.sliding, direction, path)
        result.found = Pushovers(control=control.name, control_m=list(control.point_m), elastic=elastic)
    # of an elastic curve the part up to its peak is used, of a rigid one the whole
    if not path.reached_zero and (rigid or path.multiplier[-1] > 0.5 * max(path.multiplier)):
        end = message(
            "ends at d = {displacement:.4g} m, α = {multiplier:.4g}: {reason}",
            displacement=float(path.displacement[-1]),
            multiplier=float(path.multiplier[-1]),
            reason=path.end,
        )
        result.warnings.append(headed(title, end))


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
    if curve.alpha_0_coulomb is not None:
        yield message(
            "with friction that does not lift what slides (Coulomb) α0 is {coulomb:.4g}, not {multiplier:.4g}; "
            "what its flow lifts is settled to {residual:.1g} of its largest displacement",
            coulomb=curve.alpha_0_coulomb,
            multiplier=curve.alpha_0,
            residual=curve.sliding_residual or 0.0,
        )
    elif (curve.sliding_residual or 0.0) > LIFTED:
        yield message(
            "no flow was found in which friction does not lift what slides (Coulomb): α0 by it is not known; what the "
            "nearest one lifts changes by {residual:.1g} of its largest displacement",
            residual=curve.sliding_residual or 0.0,
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
