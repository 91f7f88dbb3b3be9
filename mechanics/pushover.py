"""Pushover: the multiplier of lateral loads against the displacement of a control point (paper, §4, eqs 4 and 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, Direction, State
from mechanics.block import Array
from mechanics.equilibrium import check_self_weight, closed_program, rest, rest_size
from mechanics.errors import ControlError, ConvergenceError, NoEquilibriumError, UnstableError, require
from mechanics.limit import limit_analysis
from mechanics.program import Certificate
from mechanics.solvers import solve
from mechanics.static_step import Step, find_step

MOST_STEPS = 5000
HALVINGS = 5
SNAP = 4.0  # of the settlement's largest displacement: across which one of its hinges may snap shut
STILL = 1e-3  # of the largest displacement: a control point that takes no part
GROWTH = 1.5  # of steps that begin small
FIRST = 0.02  # of the rigid multiplier: the first step of that branch
SETTLED_FIRST = 0.1  # of an increment: the first step from a settled state, whose open hinges may close first
ZERO = 1e-6  # of the largest multiplier: one that is none
CHORDS, MOST_CHORDS = 3, 8  # to get there, and nearly there
NEARLY = 1e-2  # of the largest multiplier: what is left after a few chords of a step of ordinary length
CARRYING = 1e-6  # of the weight: a contact force that is one
SOFT = 1e-2  # of the block size: a compression at which shears on the two faces of a joint carry moments
FLAT = 1e-3  # of the largest multiplier: a change that is none
LARGEST = 2.0  # a block may move this many increments where the control point moves less


@dataclass(frozen=True, eq=False)
class Pushover:
    """A capacity curve from a state's own equilibrium.

    `displacement` (k,) m of the control point, positive along the push; `multiplier` (k,); `states` of each point;
    `steps`: the equilibria behind the points (rigid: none at the onset). `reached_zero`: whether the curve was
    followed to α = 0, at its last point; `lost`: whether it ends because no equilibrium lies beyond that point; `end`:
    why it ends. `certificates` of every step. `mechanism` (b, 3):
    virtual displacements at the point `formed`, in which the control point moves: the onset, or in a settled state
    whose onset is local the first tenth of the path; `forces` (c, 2) kN: the contact forces there.
    """

    displacement: Array
    multiplier: Array
    states: tuple[State, ...]
    steps: tuple[Step, ...]
    certificates: tuple[Certificate, ...]
    reached_zero: bool
    lost: bool
    end: str
    mechanism: Array
    formed: int
    forces: Array

    @property
    def peak(self) -> int:
        """Index of the largest multiplier.

        In a settled state the onset may be a local motion that closes a hinge of the settlement: the multiplier then
        rises before it falls.
        """
        return int(np.argmax(self.multiplier))


def pushover(
    model: Assembly,
    control: ArrayLike,
    direction: Direction = "+x",
    contacts: Behaviour = "rigid",
    increment: float = 0.001,
    state: State | None = None,
) -> Pushover:
    """Push the assembly over, from onset (rigid) or rest (elastic) until the multiplier has come down to zero.

    `control`: drawn point (m) in or on a block; `increment` (m) of its displacement along the push. Every point is an
    equilibrium in its own displaced geometry, under a free multiplier whose loads do a given work (eq. 5; with
    compliance the same program traces the elastic curve through its peak). A step that fails is halved, so that a loss
    of equilibrium (a further hinge) is told from a coarse step and located within an increment's 1/32.
    Raises UnstableError, ValueError for a control point outside every block, ControlError for one that takes no part
    in the mechanism, NoEquilibriumError where the load meets no mechanism.
    """
    require(0.0 < increment < np.inf, "increment", increment, "positive, in m")
    block = model.block_at(control)
    lateral = model.lateral_load(direction)
    begin = _onset if contacts == "rigid" else _rest
    states, steps, multiplier, certificates, rate, first, shrink = begin(
        model, direction, lateral, state, increment
    )

    def along(at: Array) -> float:
        u = model.point_displacement(control, block, at) - model.point_displacement(
            control, block, states[0].positions
        )
        return float(u[0]) if direction == "+x" else -float(u[0])

    def takes_no_part(why: str) -> ControlError:
        point = tuple(np.asarray(control).tolist())
        return ControlError(
            f"control = {point} takes no part in the mechanism along {direction}, or the increment is too large: {why}"
        )

    snap = SNAP * float(abs(states[0].positions - model.initial.positions)[:, :2].max()) if state else 0.0
    # the next step from the rate of the last one: per unit work, how far the blocks and the control point move
    little = 1e-6 * model.size / float(abs(rate[:, :2]).max())
    control_rate = along(states[0].positions + little * rate) / little
    onset, onset_rate = rate, control_rate
    path, small, smallest = [0.0], shrink, 0.0
    plateau = (0.0, multiplier[0])  # where α last changed, and to what
    found, reached, lost, end = False, False, False, f"{MOST_STEPS} points"
    while len(path) < MOST_STEPS and not reached:
        now = states[-1]
        fastest = float(abs(rate[:, :2]).max())
        work = shrink * increment / max(control_rate, fastest / LARGEST)

        last = steps[-1] if steps else None

        def advance(
            gamma: float,
            now: State = now,
            rate: Array = rate,
            size: float = work * fastest,
            last: Step | None = last,
        ) -> Step:
            guess = now.positions + gamma * rate
            return find_step(model, contacts, now, guess, model.dead_load, size, lateral, gamma, last)

        waits = path[-1] < 0.5 * increment  # the structure has not moved as a whole yet
        try:
            step = advance(work)
            found = True
            ahead = along(step.state.positions) - path[-1]
            if ahead < 0.0 and not (waits and snap):
                raise NoEquilibriumError(
                    f"the structure falls back: a step of {increment:.3g} m makes {ahead:.3g} m"
                )
            stays = waits and ahead < 0.5 * increment and step.alpha < max(multiplier)
            if step.alpha < 0.0 and stays and not snap:
                raise NoEquilibriumError("another part falls")
            if step.alpha < 0.0 and not stays:
                work, step = _down_to_zero(advance, multiplier[-1], work, step, ZERO * max(multiplier))
                reached, end = True, "α = 0"
        except (NoEquilibriumError, ConvergenceError) as stop:
            end, stays = str(stop), waits
            if not (waits and snap):
                smallest = smallest or shrink * 0.5**HALVINGS
                shrink /= 2.0
                if shrink < smallest:
                    lost = isinstance(stop, NoEquilibriumError)
                    break
                continue
        if stays and snap:
            # a hinge of the settlement snaps shut: step across it
            shrink *= 2.0
            if (
                shrink * increment > snap
            ):  # none is as wide: the curve begins like that of a structure as drawn
                snap, shrink = 0.0, small
            continue
        states.append(step.state)
        steps.append(step)
        certificates.append(step.certificate)
        multiplier.append(0.0 if reached else step.alpha)
        path.append(along(step.state.positions))
        rate = (step.state.positions - now.positions) / work
        control_rate = (path[-1] - path[-2]) / work
        if abs(multiplier[-1] - plateau[1]) > FLAT * max(multiplier):
            plateau = (path[-1], multiplier[-1])
        if path[-1] - plateau[0] > model.size:
            end = f"the structure slides: α stays {multiplier[-1]:.4g} over {model.size:.3g} m, and nothing ends that"
            break
        if not smallest:
            shrink = min(1.0, GROWTH * shrink)
    if len(path) == 1 and contacts == "elastic" and state is None and not found:
        raise _no_way_from_rest(end)
    if len(path) == 1 or max(path) < STILL * float(
        abs(states[-1].positions - states[0].positions)[:, :2].max()
    ):
        raise takes_no_part(end)
    formed, mechanism, forces = 0, onset, first
    if multiplier[0] < max(multiplier) or onset_rate < 1e-3 * float(abs(onset[:, :2]).max()):
        # the onset was the closing of a settlement's hinge: the mechanism is read off once that is over
        peak = int(np.argmax(multiplier))
        over = path[peak] + max(0.5 * increment, SETTLED_FIRST * (path[-1] - path[peak]))
        formed = max(int(np.argmax(np.array(path) >= min(over, max(path)))) - 1, 0)
        mechanism = states[formed + 1].positions - states[formed].positions
        forces = steps[max(formed - (contacts == "rigid"), 0)].forces
        if contacts == "rigid":
            mechanism = _mechanism(model, states[formed], lateral, forces, mechanism)
    return Pushover(
        np.array(path),
        np.array(multiplier),
        tuple(states),
        tuple(steps),
        tuple(certificates),
        reached,
        lost,
        end,
        mechanism,
        formed,
        forces,
    )


def _mechanism(model: Assembly, state: State, lateral: Array, forces: Array, motion: Array) -> Array:
    """Virtual displacements (b, 3) over the contacts that touch or carry in a state; without any, its motion."""
    program, _ = closed_program(model, state, lateral, forces[:, 0] > CARRYING * model.weight)
    try:
        found = solve(program)
    except (NoEquilibriumError, ConvergenceError):
        return motion
    mechanism = np.zeros_like(motion)
    mechanism[model.movable] = found.displacement.reshape(-1, 3)
    return mechanism


def _down_to_zero(
    advance: Callable[[float], Step], alpha: float, work: float, step: Step, tolerance: float
) -> tuple[float, Step]:
    """The work that brings the multiplier from α > 0 down to zero, and its step (false position, Illinois rule)."""
    low, high = (0.0, alpha), (work, step.alpha)
    for count in range(MOST_CHORDS):
        if count >= CHORDS and abs(step.alpha) <= NEARLY / ZERO * tolerance:
            break
        chord = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
        try:
            work, step = chord, advance(chord)
        except (NoEquilibriumError, ConvergenceError):
            break  # the multiplier jumps below zero: the last chord is as near as it gets
        if abs(step.alpha) <= tolerance:
            break
        if step.alpha < 0.0:
            low, high = (low[0], 0.5 * low[1]), (work, step.alpha)
        else:
            low, high = (work, step.alpha), (high[0], 0.5 * high[1])
    return work, step


Onset = tuple[list[State], list[Step], list[float], list[Certificate], Array, Array, float]


def _onset(
    model: Assembly, direction: Direction, lateral: Array, state: State | None, increment: float
) -> Onset:
    """The rigid curve's first point, and the displacements per unit work of its mechanism."""
    limit = limit_analysis(model, direction, state)
    rate = limit.mechanism / float((lateral * limit.mechanism).sum())
    shrink = 1.0 if state is None else SETTLED_FIRST
    return [state or model.initial], [], [limit.alpha], [limit.certificate], rate, limit.forces, shrink


def _rest(
    model: Assembly, direction: Direction, lateral: Array, state: State | None, increment: float
) -> Onset:
    """The elastic curve's first point, the displacements per unit work of a small load, and how small to begin."""
    start = settled(model, state)
    try:
        alpha = FIRST * limit_analysis(model, direction).alpha
    except NoEquilibriumError:  # interlocked rigid blocks have no multiplier to go by
        alpha = FIRST
    size = rest_size(model, "elastic")
    load = model.dead_load + alpha * lateral
    try:
        begun = find_step(model, "elastic", start.state, start.state.positions, load, size, last=start)
    except NoEquilibriumError as stop:
        if state is not None:
            raise
        raise _no_way_from_rest(str(stop)) from stop
    moved = begun.state.positions - start.state.positions
    shrink = min(1.0, float(abs(moved[:, :2]).max()) / increment)
    rate = moved / float((lateral * moved).sum())
    return [start.state], [start], [0.0], [start.certificate], rate, start.forces, shrink


def _no_way_from_rest(why: str) -> UnstableError:
    return UnstableError(
        f"with elastic joints no equilibrium leads away from rest: {why}; joints too soft to keep the structure "
        "upright (check normal_stiffness, in kN/m³), or the increment is too large"
    )


def settled(model: Assembly, state: State | None) -> Step:
    """Elastic rest under gravity from a state (default: as drawn).

    Raises UnstableError where there is none, or where joints as drawn are too soft to be small beside the blocks.
    """
    check_self_weight(model)
    try:
        step = rest(model, "elastic", model.starting(state))
    except NoEquilibriumError as fall:
        raise UnstableError(
            f"with elastic joints the structure cannot stand under its own weight: {fall}"
        ) from fall
    joints = model.elastic_contacts
    compression = step.forces[:, 0] / joints.stiffness[:, 0]
    worst = int(np.argmax(compression))
    if state is None and compression[worst] > SOFT * model.size:
        first, second = sorted((int(joints.a[worst]), int(joints.b[worst])))
        raise UnstableError(
            f"gravity alone presses blocks {first} and {second} {compression[worst]:.3g} m into each other, more than "
            "a hundredth of a block: their joints are too soft; check normal_stiffness, in kN/m³"
        )
    return step
