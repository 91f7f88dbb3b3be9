"""Movements of supports, and what every path of equilibria tells: certificate, warnings, local loss.

A local loss (C8.7.1.2) is a joint that carries and whose faces part.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

import mechanics
from assessment.analyses.found import Found
from assessment.project.schema import ControlTable, SettlementTable
from assessment.results.frames import along_path, normal_forces, path_frames
from assessment.results.schema import LocalLoss, PushdownPath, QualityRow, known, present
from mechanics import Assembly, State
from mechanics.messages import Message, message
from mechanics.model import Behaviour, H
from mechanics.procedures import PATH, Pushdown, Pushover, settled, whole_movement
from mechanics.program import Certificate
from mechanics.steps import Sliding, check_self_weight, unpressed
from mechanics.types import Array

AT_LIMIT = 1e-5  # of the friction limit: a joint whose T is closer to it slides
PARTING = 0.02  # of the overlap at the start: most that a joint has left where its loss fells the structure
BEARS = 1e-3  # of the weight of the model: least force of a joint that carries
NO_ANSWER = (mechanics.UnstableError, mechanics.NoEquilibriumError, mechanics.ConvergenceError)
SLIDING_CARRIES = 1e-3  # of the weight of the model: the slide of a joint that carries less has no effect


def quality_row(state: str, stage: str, path: Pushdown | Pushover | None) -> QualityRow:
    """Return the worst certificate of the programs of a path; None: there is no path."""
    certificates, steps = (path.certificates, path.steps) if path is not None else ((), ())
    worst = reduce(Certificate.joined, certificates, Certificate(0.0, 0.0, 0.0, 0.0, 0.0))
    return QualityRow(
        state=state, stage=stage, solves=sum(step.solves for step in steps) + len(certificates) - len(steps),
        worst_equilibrium_residual=worst.equilibrium,
        worst_penetration_m=max([worst.penetration, *(step.penetration for step in steps)]),
        worst_complementarity=worst.complementarity, worst_cone_violation=worst.cone,
        lifting=(path.lifting or None) if path is not None else None,
    )  # fmt: skip


def lifts(path: Pushdown | Pushover) -> Iterator[Message]:
    """Yield a warning if points of a path were solved with a dilation."""
    if path.lifting:
        yield message(
            "Coulomb's law was not solved at {count} of {points} points: what slides lifts there; try a smaller "
            "increment", count=path.lifting, points=len(path.states),
        )  # fmt: skip


def stand(model: Assembly) -> Message | None:
    """Return why the structure cannot stand under its own weight; None if it can."""
    try:
        check_self_weight(model)
    except mechanics.UnstableError as error:
        return error.message
    return None


def pressed_in(model: Assembly) -> list[Message]:
    """Return a warning that names the blocks that friction alone holds in a structure that stands, if there are any."""
    held = unpressed(model).tolist()
    if not held:
        return []
    some = ", ".join(map(str, held[:10])) + (" …" if len(held) > 10 else "")
    return [message(
        "stands only if pressed in: nothing presses the faces that hold these blocks: {blocks}; rigid joints "
        "may hold them by friction, elastic ones let them fall", blocks=some,
    )]  # fmt: skip


def turns_on_rounding(path: Pushdown | Pushover) -> bool:
    """Whether a path amplifies the last digits of its input: a joint that carries slides, or a part jumps."""
    if len(path.crossed):
        return True
    least = SLIDING_CARRIES * path.model.weight
    for step in path.steps:
        carries = (step.forces[:, 0] > least) & ~step.contacts.ties
        N, T = step.forces[carries, 0], step.forces[carries, 2]
        if (abs(T) >= (1.0 - AT_LIMIT) * step.contacts.friction[carries] * N).any():
            return True
    return False


def crossings(crossed: Array, increment: float) -> Iterator[Message]:
    """Yield a warning for each stretch (n, 2) m, 1/32 `increment` or longer, in which a part moves by itself."""
    stretches: list[list[float]] = []
    for left, held in np.sort(crossed, axis=1):
        if held - left < 0.99 * PATH.shortest(increment):
            continue
        if stretches and left <= stretches[-1][1]:
            stretches[-1][1] = max(held, stretches[-1][1])
        else:
            stretches.append([left, held])
    for left, held in stretches:
        yield message(
            "between d = {start:.4g} and {end:.4g} m a part moves by itself, until others hold it again",
            start=left, end=held,
        )  # fmt: skip


def local_loss(
    model: Assembly, states: Sequence[State], displacement: Array, normal: Array, falls: bool
) -> LocalLoss | None:
    """Return the first loss along a path: a joint that carries, whose faces overlap no longer, or a tie that breaks.

    `displacement` (k,) m of the points `states`, between which the loss is interpolated, or that of the last one if the
    structure `falls` as the faces part; `normal` (k, j), kN, by which joints carry. None if there is no loss.
    """
    lost, none = [], np.zeros(len(model.ties))
    longer = np.array([none if state.lengthened is None else state.lengthened for state in states])
    for tie, blocks, yielded in zip(model.ties, model.tie_blocks.tolist(), longer.T, strict=True):
        if yielded[-1] > tie.longest:
            far = float(np.interp(tie.longest, yielded, displacement))
            lost.append(LocalLoss(
                displacement_m=far, joint=None, blocks=blocks, overlap_m=None, tie=tie.name, longest_m=tie.longest
            ))  # fmt: skip
    if parted := _parted(model, states, displacement, normal, falls):
        lost.append(parted)
    return min(lost, key=lambda each: each.displacement_m, default=None)


def _parted(
    model: Assembly, states: Sequence[State], displacement: Array, normal: Array, falls: bool
) -> LocalLoss | None:
    """Return the first joint that carries at first or up to there, and comes to overlap no longer."""
    overlap = np.array([2.0 * model.contacts.places(state.positions)[:, H] for state in states])
    carries = normal > BEARS * model.weight
    gone = (overlap <= 0.0) & (overlap[0] > 0.0) & (carries[0] | np.vstack([carries[:1], carries[:-1]]))
    if not gone.any():
        bears = carries[0] & (overlap[0] > 0.0)
        left = np.where(bears, overlap[-1] / np.where(bears, overlap[0], 1.0), np.inf)
        joint = int(np.argmin(left))
        return _loss(model, joint, displacement[-1], overlap) if falls and left[joint] < PARTING else None
    at = int(np.argmax(gone.any(axis=1)))
    before, after = overlap[at - 1], overlap[at]
    share = np.where(gone[at], before / np.where(gone[at], before - after, 1.0), np.inf)
    joint = int(np.argmin(share))
    d_1, d_2 = displacement[at - 1], displacement[at]
    return _loss(model, joint, d_1 + share[joint] * (d_2 - d_1), overlap)


def _loss(model: Assembly, joint: int, displacement: float, overlap: Array) -> LocalLoss:
    drawn = model.contacts
    return LocalLoss(
        displacement_m=float(displacement), joint=joint, blocks=[int(drawn.a[joint]), int(drawn.b[joint])],
        overlap_m=float(overlap[0, joint]),
    )  # fmt: skip


def loss_sentence(loss: LocalLoss) -> Message:
    """Return the text of a local loss for messages."""
    lost = what_is_lost(loss)
    return message("{lost} at d = {displacement:.4g} m", lost=lost, displacement=loss.displacement_m)


def broken_tie(tie: str, longest: float) -> Message:
    """Return that a tie of that name breaks, having yielded by so much, m."""
    return message('the tie "{tie}", which has yielded by {longest:.3g} m, breaks', tie=tie, longest=longest)


def what_is_lost(loss: LocalLoss) -> Message:
    """Return what a local loss is of."""
    if loss.tie is not None:
        return broken_tie(loss.tie, known(loss.longest_m))
    a, b = loss.blocks
    return message("the faces of blocks {first} and {second} slide off each other", first=a, second=b)


BACK = 1e-6  # of a block's size: supports nearer to where they were are there again


@dataclass(frozen=True, eq=False)
class Settled:
    """A movement in plain numbers, and the state that it `reached`, at rest; None: the structure falls before."""

    path: PushdownPath
    reached: State | None


def settle(
    model: Assembly, settlement: SettlementTable, behaviour: Behaviour, sliding: Sliding,
    control: ControlTable | None, start: State | None = None,
) -> Found[Settled]:  # fmt: skip
    """Move a support as a scenario asks, from `start`, and return the path, with that of the control point if any."""
    began = time.perf_counter()
    found = Found[Settled]()
    title = path_title(settlement.name, behaviour)
    moves = (settlement.displacement_m, settlement.rotation_rad)
    whole = whole_movement(model, settlement.support, *moves)
    increment, reached, path = whole / settlement.increments, None, None
    try:
        path = mechanics.pushdown(
            model, settlement.support, *moves, increment, behaviour, settlement.to_collapse, sliding,
            state=start,
        )  # fmt: skip
        reached = path.final
    except mechanics.CollapseError as collapse:
        found.fail(title, collapse.message)
        assert isinstance(collapse.path, Pushdown)
        path = collapse.path
    except NO_ANSWER as error:
        found.fail(title, error.message)
    if path is not None:
        moved = _pushdown_path(path, whole, behaviour, control)
        found.value = Settled(moved, reached)
        if settlement.to_collapse and path.ultimate is None:
            far = float(path.movement[-1])
            found.warn(title, message("no ultimate movement up to {reached:.3g} m ({reason})", reached=far,
                                      reason=path.end))  # fmt: skip
        found.warn(title, *crossings(path.crossed, increment), *lifts(path))
        found.scatters = turns_on_rounding(path)
        found.quality.append(quality_row(settlement.name, f"pushdown, {behaviour}", path))
        if moved.local_loss is not None:
            found.warn(title, loss_sentence(moved.local_loss))
    found.seconds = time.perf_counter() - began
    return found


def rest_as_drawn(model: Assembly, sliding: Sliding) -> State | Message:
    """Return the rest under gravity that a structure as drawn comes to on elastic joints, or why it has none."""
    try:
        return settled(model, None, sliding).state
    except (mechanics.UnstableError, mechanics.ConvergenceError) as error:
        return error.message


def not_back(model: Assembly, reached: State, where: Message, before: State) -> Message | None:
    """Return what does not come back to `before`, the state `where` says, though all supports do; else None."""
    moved = reached.positions - before.positions
    if abs(moved[~model.movable]).max() > BACK * model.size:
        return None
    distance = np.hypot(*moved[:, :2].T)
    block = int(np.argmax(distance))
    if distance[block] <= BACK * model.size:
        return message("the supports are again where they were {where}, and so are the blocks", where=where)
    return message(
        "the supports are again where they were {where}; the blocks stay away by up to {distance:.3g} m (block "
        "{block}, turned by {turn:.3g} rad)", where=where, distance=float(distance[block]), block=block,
        turn=float(moved[block, 2]),
    )  # fmt: skip


def path_title(state: str, behaviour: Behaviour) -> Message:
    """Return the beginning of the warnings of a movement."""
    return message("{state}, {contacts} contacts", state=state, contacts=behaviour)


def _pushdown_path(
    path: Pushdown, whole: float, behaviour: Behaviour, control: ControlTable | None
) -> PushdownPath:
    """Return reactions, configurations and the movement at collapse; `whole` (m): the movement that was asked for."""
    model, falls = path.model, path.ultimate is not None
    lost = local_loss(model, path.states, path.movement, normal_forces(path), falls) if path.steps else None
    along = None
    if control:  # displacements (k, 2) of the control point from the beginning of the path, m
        point, block = control.point_m, model.block_at(control.point_m)
        moved_to = [model.point_displacement(point, block, state.positions) for state in path.states]
        along = [(each - moved_to[0]).tolist() for each in moved_to]
    asked = int(np.argmin(abs(path.movement - whole)))
    ties: Any = along_path(path, asked, behaviour == "rigid") if path.steps else None
    return PushdownPath(
        sliding=path.sliding, movement_m=path.movement.tolist(), reaction_x_kN=path.reaction[:, 0].tolist(),
        reaction_z_kN=path.reaction[:, 1].tolist(), ultimate_movement_m=path.ultimate, local_loss=lost,
        applied_movement_m=whole, end=path.end, configuration=model.displaced(path.final).tolist(),
        ultimate_configuration=model.displaced(path.states[-1]).tolist() if falls else None,
        control_displacement_m=along, frames=path_frames(path, asked), **present({"ties": ties}),
    )  # fmt: skip
