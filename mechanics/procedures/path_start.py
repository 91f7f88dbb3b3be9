"""The first point of a capacity curve: a mechanism at its onset (rigid joints), or rest (elastic joints)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechanics.errors import ArgumentError, ConvergenceError, NoEquilibriumError, UnstableError
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.procedures.limit_analysis import Limit, flowing_iterate, limit_analysis, limit_in
from mechanics.program import Solution
from mechanics.steps.equilibrium import check_self_weight, rest, rest_size, unpressed
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.rest import come_down
from mechanics.steps.static_step import Equilibrium, StepProblem, equilibrium
from mechanics.steps.static_system import Sliding, StaticSystem, static_system
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array


@dataclass(frozen=True, slots=True)
class StartTolerances:
    """Tolerances of the start of a curve.

    `first`: loads of the first step of an elastic curve that are tried, as shares of the rigid multiplier: the smaller
    ones where hinges of a settlement close under little; `settled`: first step from
    a settled state, whose open hinges may close first, as a share of an increment; `least`: length of a first step, as
    a share of the compression under gravity; `resolved`: of that compression, the last digit of a position that does
    not hide it.
    """

    first: tuple[float, ...] = (0.02, 0.002, 0.0002)
    settled: float = 0.1
    least: float = 0.01
    resolved: float = 2e-6


START = StartTolerances()


@dataclass(frozen=True, eq=False)
class PathStart:
    """First point of a curve.

    `step`: its equilibrium; `rate` (b, 3): displacements per unit work (1/kN, rad/kNm) of the first step; `share`:
    length of that step as a share of an increment; `limit`: multiplier of limit analysis.
    """

    step: Equilibrium
    rate: Array
    share: float
    limit: float


def mechanism_start(
    model: Assembly, direction: Direction, state: State | None, increment: float, sliding: Sliding
) -> PathStart:
    """Return the onset of a rigid curve in a state at rest: the mechanism of limit analysis. Raises as limit_in.

    By Coulomb's law the least flow that is found in the state begins the curve, whatever forces a path has left there:
    these may press joints that nothing presses. `increment` (m): length of the curve's steps.
    """
    limit = limit_in(model, direction, model.starting(state), sliding)
    rate = limit.mechanism / float((model.lateral_load(direction) * limit.mechanism).sum())
    return PathStart(onset(limit, increment), rate, 1.0 if state is None else START.settled, limit.alpha)


def onset(limit: Limit, increment: float) -> Equilibrium:
    """Return the onset of a limit analysis as the start of a step in which a block moves by an increment (m).

    By Coulomb's law it has the gaps and slips of its flow: other flows have other multipliers, and a step that begins
    far from this one leads to the central flow. Flows with a dilation, or of ties that yield, are not followed.
    """
    begun, size = limit.state, LIMIT.onset * limit.model.size
    system = static_system(limit.model, "rigid", limit.sliding).around(begun.positions, size)
    problem = StepProblem(system, begun, limit.model.dead_load, size)
    index = np.arange(len(system.contacts))
    program, _ = problem.pose(begun.positions, None, index)
    moved = increment * limit.mechanism[limit.model.movable].ravel()
    found, iterate = Solution(limit.forces, limit.alpha, moved, limit.certificate), None
    if not limit.dilation and np.isinf(limit.contacts.strength[limit.contacts.ties]).all():
        iterate = flowing_iterate(program, found)
    step = equilibrium(problem, begun.positions, index, found, iterate, 1)
    return replace(step, state=begun, lifting=limit.sliding == "coulomb" and limit.dilation > 0.0)


def elastic_start(
    model: Assembly, direction: Direction, state: State | None, increment: float, sliding: Sliding
) -> PathStart:
    """Return the start of an elastic curve: rest, and the displacements under a small lateral load.

    `increment` (m): length of the curve's steps. Raises UnstableError if the structure has no rest, or no equilibrium
    leads away from it (ArgumentError: as joints are too stiff for rounding), NoEquilibriumError if none leads away from
    a given `state`.
    """
    start = settled(model, state, sliding)
    system = start.system
    lateral = model.lateral_load(direction)
    try:
        limit = limit_analysis(model, direction, sliding="associative").alpha
    except NoEquilibriumError:  # interlocked rigid blocks have no multiplier that gives the scale
        limit = 1.0
    size = rest_size(model, "elastic")
    tries = [(START.first[0], size)]
    if increment > size and (model.ties or state is not None):
        # ties, and hinges that a settlement has opened, hold only after more way than joints are compressed by
        tries += [(share, increment) for share in START.first]
    try:
        begun = _pushed_a_little(system, start, limit * lateral, tries)
    except (NoEquilibriumError, ConvergenceError) as stop:
        if state is not None:
            raise
        raise no_way_from_rest(model, stop.message) from stop
    moved = begun.state.positions - start.state.positions
    least = START.least * size  # a stiff tie moves less than the rest is known to
    share = min(1.0, max(float(abs(moved[:, :2]).max()), least) / increment)
    rate = moved / float((lateral * moved).sum())
    return PathStart(start, rate, share, limit)


def _pushed_a_little(
    system: StaticSystem, start: Equilibrium, lateral: Array, tries: Sequence[tuple[float, float]]
) -> Equilibrium:
    """Return an equilibrium near the start under a little of a lateral load (b, 3), kN and kNm.

    `tries`: shares of the load and how far away (m) it is looked for, one after the other. Raises NoEquilibriumError or
    ConvergenceError if none is found.
    """
    at = start.state.positions
    for share, size in tries:
        load = system.model.dead_load + share * lateral
        try:
            return find_equilibrium(StepProblem(system.around(at, size), start.state, load, size), at, start)
        except (NoEquilibriumError, ConvergenceError) as stop:
            error = stop
    raise error


def no_way_from_rest(model: Assembly, why: Message) -> UnstableError | ArgumentError:
    """Return the error of a structure that stands on elastic joints, but has no equilibrium beyond its rest.

    An ArgumentError where the joints are compressed by hardly more than the last digit of a position.
    """
    if model.rounding > START.resolved:
        return ArgumentError(
            f"normal_stiffness: joints are so stiff that the last digit of a position is {model.rounding:.1g} of their "
            "compression; make it smaller, use rigid contacts, or move the structure nearer to the origin"
        )
    return UnstableError(message(
        "with elastic joints no equilibrium leads away from rest: {reason}; joints too soft to keep the structure "
        "upright (check normal_stiffness, in kN/m³), or the increment is too large", reason=why,
    ))  # fmt: skip


def settled(model: Assembly, state: State | None, sliding: Sliding = "coulomb") -> Equilibrium:
    """Return the elastic rest under gravity that a state (default: as drawn) settles into.

    Raises UnstableError if there is none.
    """
    check_self_weight(model)
    begun = model.starting(state)
    size = rest_size(model, "elastic")
    system = static_system(model, "elastic", sliding).around(begun.positions, size)
    try:
        return come_down(rest(system, begun), size)
    except NoEquilibriumError as fall:
        if len(unpressed(model)):
            why = message(
                "with elastic joints the structure cannot stand under its own weight: {reason}; rigid joints would "
                "hold it by friction of faces that nothing presses; draw what bears these blocks", reason=fall.message,
            )  # fmt: skip
        else:
            why = message(
                "with elastic joints the structure cannot stand under its own weight: {reason}; "
                "rigid joints would hold it, these are too soft: check normal_stiffness, in kN/m³", reason=fall.message,
            )  # fmt: skip
        raise UnstableError(why) from fall
