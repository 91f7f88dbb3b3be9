"""A settlement: a support moves, in plain numbers for results.json."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.found import Found
from assessment.analyses.static.paths import (
    configuration,
    crossings,
    lifts,
    local_loss,
    loss_sentence,
    quality_row,
    turns_on_rounding,
)
from assessment.results.configurations.frames import pushdown_frames
from assessment.results.configurations.ties import along_path, determined
from assessment.results.schema.static import PushdownPath
from mechanics import (
    Assembly,
    CollapseError,
    ConvergenceError,
    NoEquilibriumError,
    State,
    UnstableError,
    pushdown,
)
from mechanics.messages import Message, headed, message
from mechanics.model import Behaviour
from mechanics.procedures import Pushdown, settled, whole_movement
from mechanics.steps import Sliding

BACK = 1e-6  # of a block's size: supports nearer to where they were are there again

if TYPE_CHECKING:
    from assessment.project.schema import ControlTable, SettlementTable


@dataclass(frozen=True, eq=False)
class Settled:
    """A movement in plain numbers, and the state that it `reached`, at rest; None: the structure falls before."""

    path: PushdownPath
    reached: State | None


def settle(
    model: Assembly,
    settlement: SettlementTable,
    behaviour: Behaviour,
    sliding: Sliding,
    control: ControlTable | None,
    start: State | None = None,
) -> Found[Settled]:
    """Move a support as a scenario asks, from `start`, and return the path, with that of the control point if any."""
    began = time.perf_counter()
    found = Found[Settled]()
    title, whole = path_title(settlement.name, behaviour), _whole(model, settlement)
    increment, reached, path = whole / settlement.increments, None, None
    try:
        path = pushdown(
            model,
            settlement.support,
            settlement.displacement_m,
            settlement.rotation_rad,
            increment,
            behaviour,
            settlement.to_collapse,
            sliding,
            state=start,
        )
        reached = path.final
    except CollapseError as collapse:
        found.failures.append(headed(title, collapse.message))
        assert isinstance(collapse.path, Pushdown)
        path = collapse.path
    except (UnstableError, ConvergenceError, NoEquilibriumError) as error:
        found.failures.append(headed(title, error.message))
    if path is not None:
        moved = _pushdown_path(model, settlement, behaviour, sliding, control, path)
        found.value = Settled(moved, reached)
        if settlement.to_collapse and path.ultimate is None:
            none = message(
                "no ultimate movement up to {reached:.3g} m ({reason})",
                reached=float(path.movement[-1]),
                reason=path.end,
            )
            found.warnings.append(headed(title, none))
        found.warnings += crossings(title, path.crossed, increment) + lifts(title, path)
        found.scatters = turns_on_rounding(model, path)
        found.quality.append(quality_row(settlement.name, f"pushdown, {behaviour}", path))
        if moved.local_loss is not None:
            found.warnings.append(headed(title, loss_sentence(moved.local_loss)))
    found.seconds = time.perf_counter() - began
    return found


def rest_as_drawn(model: Assembly, sliding: Sliding) -> State | Message:
    """Return the rest under gravity that a structure as drawn comes to on elastic joints, or why it has none."""
    try:
        return settled(model, None, sliding).state
    except (UnstableError, ConvergenceError) as error:
        return error.message


def not_back(model: Assembly, reached: State, where: Message, before: State) -> Message | None:
    """Return what does not come back though all supports do; None where a support is elsewhere.

    `before`: the state that was `where` said, and `reached` the one at the end of the movements.
    """
    moved = reached.positions - before.positions
    if abs(moved[~model.movable]).max() > BACK * model.size:
        return None
    distance = np.hypot(*moved[:, :2].T)
    block = int(np.argmax(distance))
    if distance[block] <= BACK * model.size:
        return message("the supports are again where they were {where}, and so are the blocks", where=where)
    return message(
        "the supports are again where they were {where}; the blocks stay away by up to {distance:.3g} m (block "
        "{block}, turned by {turn:.3g} rad)",
        where=where,
        distance=float(distance[block]),
        block=block,
        turn=float(moved[block, 2]),
    )


def path_title(state: str, behaviour: Behaviour) -> Message:
    """Return the beginning of the warnings of a movement."""
    return message("{state}, {contacts} contacts", state=state, contacts=behaviour)


def _whole(model: Assembly, settlement: SettlementTable) -> float:
    """Return the largest component of the whole movement, m."""
    return whole_movement(model, settlement.support, settlement.displacement_m, settlement.rotation_rad)


def _pushdown_path(
    model: Assembly,
    settlement: SettlementTable,
    behaviour: Behaviour,
    sliding: Sliding,
    control: ControlTable | None,
    path: Pushdown,
) -> PushdownPath:
    """Return reactions, configurations and the movement at collapse."""
    whole = _whole(model, settlement)
    falls = path.ultimate is not None
    lost = local_loss(model, path.states, path.movement, path.steps[0].forces, falls) if path.steps else None
    found = PushdownPath(
        sliding=sliding,
        movement_m=path.movement.tolist(),
        reaction_x_kN=path.reaction[:, 0].tolist(),
        reaction_z_kN=path.reaction[:, 1].tolist(),
        ultimate_movement_m=path.ultimate,
        local_loss=lost,
        applied_movement_m=whole,
        end=path.end,
        configuration=configuration(model, path.final),
        ultimate_configuration=configuration(model, path.states[-1]) if falls else None,
        control_displacement_m=_control_path(model, control, path) if control else None,
        frames=pushdown_frames(model, path, whole),
    )
    asked = int(np.argmin(abs(path.movement - whole)))
    carried = [step.forces for step in path.steps]
    if not carried or not model.ties:
        return found
    if behaviour == "elastic":
        return found.replace(ties=along_path(model, carried, asked, carried[0]))
    moved = list(np.diff([state.positions for state in path.states], axis=0))
    known = determined(model, [*(moved[:1] or [np.zeros_like(path.states[0].positions)]), *moved])
    return found.replace(ties=along_path(model, carried, asked, None, known))


def _control_path(model: Assembly, control: ControlTable, path: Pushdown) -> list[list[float]]:
    """Return the displacement (k, 2) of the control point from the beginning of the path, m."""
    block = model.block_at(control.point_m)
    start = model.point_displacement(control.point_m, block, path.states[0].positions)
    return [
        (model.point_displacement(control.point_m, block, state.positions) - start).tolist()
        for state in path.states
    ]
