"""Pushdown: reaction and configuration against the movement of a support (paper, §4, eqs 6 and 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.equilibrium import check_self_weight, reaction, rest, rest_size
from mechanics.errors import CollapseError, ConvergenceError, NoEquilibriumError, require
from mechanics.other_steps import ACROSS, other_shares
from mechanics.program import Certificate
from mechanics.relaxation import come_to_rest, lifted
from mechanics.static_step import Step, find_step
from mechanics.types import Array

MOST_CLOSINGS = 6  # without an improvement
FINEST = 0.01  # of an increment: the last of the ever smaller steps towards the whole movement
ONSET = (
    1e-3  # of an increment, at most of a block: a movement small enough to tell the reaction at its beginning
)
SETTLED = 2e-4  # of the block size: what a gap left by dilatant sliding may be when the movement stops


@dataclass(frozen=True, eq=False)
class Pushdown:
    """The path of a moving support.

    `movement` (k,) m: its largest component, from zero (a pure turn: the arc at the support's farthest corner);
    `reaction` (k, 2) kN: x, z force of the support on the structure (at zero, rigid: as the movement begins);
    `states` of each point and `final`, at rest after the whole movement. `ultimate` m: the movement beyond which no
    equilibrium is found, bracketed to an increment's 1/32 (None: not sought or not reached); `end` says why. `crossed`
    (n, 2) m: between which movements a part moves by itself, until others hold it again.
    """

    movement: Array
    reaction: Array
    states: tuple[State, ...]
    final: State
    ultimate: float | None
    end: str
    crossed: Array
    steps: tuple[Step, ...]
    certificates: tuple[Certificate, ...]


def pushdown(
    model: Assembly,
    support: str,
    displacement: ArrayLike = (0.0, 0.0),
    rotation: float = 0.0,
    increment: float = 0.001,
    contacts: Behaviour = "rigid",
    to_collapse: bool = False,
) -> Pushdown:
    """Move a support by `displacement` (2,) m and `rotation` (rad, about its drawn centroid), in increments.

    `increment` (m) is of the largest component. With `to_collapse` the movement goes on in the same direction to the
    last equilibrium, after `final` has been taken. Where an increment fails, half of it is tried, then a few, up to a
    tenth of a block, then smaller parts, so that a fall is told from a coarse step and from a loose brick. Raises
    UnstableError where the structure as drawn cannot stand, CollapseError where it collapses before the whole
    movement is applied (it carries the path up to there), ValueError for bad arguments.
    """
    index = model.support(support)
    target = np.asarray(displacement, dtype=float)
    require(
        target.shape == (2,) and bool(np.isfinite(target).all()), "displacement", displacement, "(x, z) in m"
    )
    require(bool(np.isfinite(rotation)), "rotation", rotation, "finite, in rad")
    require(0.0 < increment < np.inf, "increment", increment, "positive, in m")
    full = whole_movement(model, support, target, rotation)
    require(full > 0.0, "displacement", displacement, "a movement: displacement and rotation are both zero")
    check_self_weight(model)

    def moved(state: State, movement: float) -> Array:
        share = movement / full
        return model.moved_support(state.positions, support, share * target, share * rotation)

    swing = max(
        1.0, whole_movement(model, support, (0.0, 0.0), rotation) / full
    )  # a turn may outdo the translation

    def advance(state: State, past: Array, movement: float, by: float, last: Step, size: float = 0.0) -> Step:
        guess = moved(State(state.positions + past * by, state.velocities), movement + by)
        expected = max(swing * max(by, size), smallest)
        # a structure at rest is no neighbour of one that begins to move: which hinges open is open
        near = last if past.any() else None
        return find_step(model, contacts, state, guess, model.dead_load, expected, last=near)

    smallest = rest_size(model, contacts) if contacts == "elastic" else 0.0
    start = rest(model, contacts, model.initial)
    begun = (
        start
        if contacts == "elastic"
        else advance(
            model.initial,
            np.zeros_like(moved(model.initial, 0.0)),
            0.0,
            ONSET * min(increment, model.size),
            start,
        )
    )
    states, path = [start.state], [0.0]
    reactions = [reaction(model, contacts, begun, index)[:2]]
    steps, certificates = [start], [start.certificate, begun.certificate]
    final: State | None = None
    ultimate, end = None, "the whole movement is applied"
    past, by = np.zeros_like(start.state.positions), increment
    widest, others, crossed = ACROSS * model.size / increment, None, []
    limit = full if not to_collapse else max(full, float(np.ptp(drawn_extent(model), axis=0).max()))
    while path[-1] < limit * (1.0 - 1e-9):
        now, here = states[-1], path[-1]
        aim = full if final is None else limit
        stride = min(by, aim - here)
        if final is None and contacts == "rigid" and aim - here < 1.5 * increment:
            stride = min(stride, max(0.5 * (aim - here), FINEST * increment))
        try:
            # what dilatant sliding lifted in whole increments comes down in these, however short
            step = advance(now, past, here, stride, steps[-1], increment if stride < by else 0.0)
        except (NoEquilibriumError, ConvergenceError) as stop:
            if others is None:
                end, others = str(stop), other_shares(stride / increment, 1.0, widest)
            by = increment * next((share for share in others if share * increment != stride), 0.0)
            if by:
                continue
            if isinstance(stop, NoEquilibriumError):
                ultimate = here
            elif final is None:
                raise
            break
        if stride > 0.5 * by:  # the rate of a tiny step is mostly rounding
            past = (step.state.positions - now.positions) / stride
        states.append(step.state)
        path.append(here + stride)
        steps.append(step)
        certificates.append(step.certificate)
        reactions.append(reaction(model, contacts, step, index)[:2])
        if others is not None and stride > increment:
            crossed.append((here, here + stride))
        others, by = None, min(increment, 1.5 * by)
        if final is None and path[-1] >= full * (1.0 - 1e-9):
            try:
                final = settle(model, contacts, step, increment, certificates)
            except NoEquilibriumError as stop:
                ultimate, end = here, str(stop)
                break
        elif final is not None and rotation == 0.0 and _rides(model, now, step.state, stride / full * target):
            end = "the structure moves with its support as a whole"
            break
    path_so_far = Pushdown(
        np.array(path),
        np.array(reactions),
        tuple(states),
        final or states[-1],
        ultimate,
        end,
        np.array(crossed).reshape(-1, 2),
        tuple(steps),
        tuple(certificates),
    )
    if final is None:
        if path[-1] >= full * (1.0 - 1e-9):
            raise CollapseError(
                f"the structure collapses after the whole movement of {full:.4g} m: {end}", path_so_far
            )
        raise CollapseError(
            f"the structure collapses at a movement of {path[-1]:.4g} m, before the whole of {full:.4g} m: {end}",
            path_so_far,
        )
    return path_so_far


def whole_movement(model: Assembly, support: str, displacement: ArrayLike, rotation: float) -> float:
    """Largest component of a support's movement, m; of a pure turn, the arc at the support's farthest corner."""
    corners = np.concatenate([model.blocks[i].polygon for i in model.support(support)])
    reach = float(np.hypot(*(corners - model.support_centre(support)).T).max())
    return float(abs(np.asarray(displacement, dtype=float)).max()) or abs(rotation) * reach


def _rides(model: Assembly, before: State, after: State, moved: Array) -> bool:
    """Whether every movable block made just the support's translation (2,)."""
    apart = abs((after.positions - before.positions)[model.movable] - [*moved, 0.0]).max()
    return bool(apart < 1e-6 * float(abs(moved).max()))


def settle(
    model: Assembly, contacts: Behaviour, step: Step, size: float, certificates: list[Certificate]
) -> State:
    """Close the gaps that dilatant sliding left under joints that carry, with no further movement of the support.

    What slides as it comes down lifts something else a little less, as a rule: the state with the least gaps is taken.
    """
    if contacts == "elastic":
        rested = come_to_rest(model, step)
        if rested is not step:
            certificates.append(rested.certificate)
        return rested.state
    best, least, since = step, lifted(model, contacts, step), 0
    while least > SETTLED * model.size and since < MOST_CLOSINGS:
        try:
            step = rest(model, contacts, step.state, size, step)
        except (NoEquilibriumError, ConvergenceError):
            break  # what stood is lost in closing: the best so far stands
        certificates.append(step.certificate)
        gap, since = lifted(model, contacts, step), since + 1
        if gap < least:
            best, least, since = step, gap, 0
    return best.state


def drawn_extent(model: Assembly) -> Array:
    """Corners (2, 2) of the drawing's bounding box, m."""
    points = np.concatenate([b.polygon for b in model.blocks])
    return np.stack([points.min(axis=0), points.max(axis=0)])
