"""Pushover: the multiplier of lateral loads against the displacement of a control point (paper, §4, eqs 4 and 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, Direction, State
from mechanics.block import Array
from mechanics.equilibrium import closed_program
from mechanics.errors import ControlError, ConvergenceError, NoEquilibriumError, require
from mechanics.limit import limit_of
from mechanics.onset import elastic_onset, mechanism_onset, no_way_from_rest
from mechanics.other_steps import ACROSS, HALVINGS, other_shares
from mechanics.program import Certificate
from mechanics.solvers import solve
from mechanics.static_step import Step, elimination_of, find_step

MOST_STEPS = 5000
SNAP = 4.0  # of the settlement's largest displacement: across which one of its hinges may snap shut
CLOSES = 0.25  # of it: the displacement within which that is what brings the multiplier down to zero
STILL = 1e-3  # of the largest displacement: a control point that takes no part
GROWTH = 1.5  # of steps that begin small
COARSER = 3  # doublings of the increment, across which a part may move by itself
ZERO = 1e-6  # of the largest multiplier: one that is none
CHORDS, MOST_CHORDS = 3, 8  # to get there, and nearly there
NEARLY = 1e-2  # of the largest multiplier: what is left after a few chords of a step of ordinary length
FLAT = 1e-3  # of the largest multiplier: a change that is none
JUMPED = 3.0  # increments that the control point goes in one: a part has moved by itself
LARGEST = 2.0  # a block may move this many increments where the control point moves less


@dataclass(frozen=True, eq=False)
class Pushover:
    """A capacity curve from a state's own equilibrium.

    `displacement` (k,) m of the control point, positive along the push; `multiplier` (k,); `states` of each point;
    `steps`: the equilibria behind the points (rigid: none at the onset). `reached_zero`: whether the curve was
    followed to α = 0, at its last point; `lost`: whether it ends because no equilibrium lies beyond that point; `end`:
    why it ends; `crossed` (n, 2) m: between which displacements a part moves by itself, until others hold it again.
    `certificates` of every step. `mechanism` (b, 3): virtual displacements at the point `formed`, where the mechanism
    is activated: the `peak`, or, where only a part without the control point moves there, the first point after it at
    which the control point moves; `forces` (c, 2) kN: the contact forces there.
    """

    displacement: Array
    multiplier: Array
    states: tuple[State, ...]
    steps: tuple[Step, ...]
    certificates: tuple[Certificate, ...]
    reached_zero: bool
    lost: bool
    end: str
    crossed: Array
    mechanism: Array
    formed: int
    forces: Array

    @property
    def peak(self) -> int:
        """Index of the largest multiplier, the first of equals.

        In a settled state the onset may be a local motion that closes a hinge of the settlement: the multiplier then
        rises before it falls.
        """
        return _peak(self.multiplier)


def pushover(
    model: Assembly,
    control: ArrayLike,
    direction: Direction = "+x",
    contacts: Behaviour = "rigid",
    increment: float = 0.001,
    state: State | None = None,
    until: float = 0.0,
) -> Pushover:
    """Push the assembly over, from onset (rigid) or rest (elastic) until the multiplier has come down to zero.

    `control`: drawn point (m) in or on a block; `increment` (m) of its displacement along the push; `until`: the share
    of its peak at which the multiplier has come down far enough. Every point is an
    equilibrium in its own displaced geometry, under a free multiplier whose loads do a given work (eq. 5; with
    compliance the same program traces the elastic curve through its peak); multiplier and forces of a rigid curve are
    those of limit analysis in that configuration (paper, §3), see `limit_of`. Where a step fails, a part may be moving
    by itself until others hold it again: equilibrium is sought half a step on, then a few steps on. Where there is none
    either, the structure has lost it, which further halves locate within an increment's 1/32.
    Raises UnstableError, ValueError for a control point outside every block, ControlError for one that takes no part
    in the mechanism, NoEquilibriumError where the load meets no mechanism.
    """
    require(0.0 < increment < np.inf, "increment", increment, "positive, in m")
    require(0.0 <= until < 1.0, "until", until, "a share of the peak")
    curve = _Curve(model, control, direction, contacts, increment, state, until)
    settlement = 0.0 if state is None else float(abs(state.positions - model.initial.positions)[:, :2].max())
    snap, share = SNAP * settlement, curve.first.share
    widest = max(2.0**COARSER, ACROSS * model.size / increment)
    largest, others = share, other_shares(share, share, widest)
    while not curve.end:
        closing = snap > 0.0 and (curve.waits or curve.displacement[-1] < CLOSES * settlement)
        try:
            work, step = curve.step(share, closing)
        except (NoEquilibriumError, ConvergenceError) as stop:
            if closing:  # a hinge of the settlement snaps shut: step across it
                share *= 2.0
                if (
                    share * increment > snap
                ):  # none is as wide: the curve begins like that of a structure as drawn
                    snap, share = 0.0, curve.first.share
                continue
            if not curve.failing:
                others = other_shares(share, largest, widest)
            share = next(others, 0.0)
            curve.fail(stop, last=share == 0.0)
            continue
        curve.append(work, step)
        share = min(1.0, GROWTH * share)
        largest = max(largest, share)
    return curve.finished()


class _Curve:
    """A capacity curve as far as it has been followed; `end`: why it goes no farther."""

    def __init__(
        self,
        model: Assembly,
        control: ArrayLike,
        direction: Direction,
        contacts: Behaviour,
        increment: float,
        state: State | None,
        until: float,
    ) -> None:
        self.model, self.contacts, self.increment, self.until = model, contacts, increment, until
        self.control, self.direction = np.asarray(control, dtype=float), direction
        self.block = model.block_at(control)
        self.lateral = model.lateral_load(direction)
        self.drawn = state is None
        self.first = (
            mechanism_onset(model, direction, state)
            if contacts == "rigid"
            else elastic_onset(model, direction, state, increment)
        )
        self.states, self.multiplier, self.displacement = [self.first.state], [self.first.alpha], [0.0]
        self.steps = [self.first.step] if self.first.step else []
        self.certificates = [self.first.certificate]
        # the next step from the rate of the last one: per unit work, how far the blocks and the control point move
        self.rate = self.first.rate
        little = 1e-6 * model.size / float(abs(self.rate[:, :2]).max())
        self.control_rate = self.along(self.first.state.positions + little * self.rate) / little
        self.plateau = (0.0, self.first.alpha)  # where α last changed, and to what
        self.crossed: list[tuple[float, float]] = []
        self.failing, self.why, self.end = False, "", ""
        self.snaps = False  # whether a hinge of the settlement closes by itself
        self.reached, self.lost, self.left = False, False, False

    def along(self, positions: Array) -> float:
        """Displacement (m) of the control point along the push."""
        now, begun = (
            self.model.point_displacement(self.control, self.block, at)[0]
            for at in (positions, self.states[0].positions)
        )
        return float(now - begun) if self.direction == "+x" else float(begun - now)

    @property
    def waits(self) -> bool:
        """Whether the structure has not moved as a whole yet."""
        return self.displacement[-1] < 0.5 * self.increment

    def step(self, share: float, closing: bool) -> tuple[float, Step]:
        """The work of a share of an increment, and the equilibrium to which it leads.

        `closing`: whether a hinge of the settlement may be what moves first. Raises NoEquilibriumError where only a
        part moves, or nothing stands.
        """
        now, rate = self.states[-1], self.rate
        fastest = float(abs(rate[:, :2]).max())
        whole = share * self.increment / max(self.control_rate, fastest / LARGEST)
        last = self.steps[-1] if self.steps else None

        def advance(work: float) -> Step:
            guess, size = now.positions + work * rate, whole * fastest
            model = self.model
            step = find_step(
                model, self.contacts, now, guess, model.dead_load, size, self.lateral, work, last
            )
            return limit_of(model, self.direction, step) if self.contacts == "rigid" else step

        step = advance(whole)
        self.left = True
        ahead = self.along(step.state.positions) - self.displacement[-1]
        stays = ahead < 0.5 * (self.increment if self.waits else whole * self.control_rate)
        self.snaps |= closing and step.alpha < 0.0
        if closing and (stays or self.snaps) and step.alpha < max(self.multiplier):
            raise NoEquilibriumError("a hinge of the settlement closes")
        if not closing and ahead < 0.0:
            raise NoEquilibriumError(
                f"the structure falls back: a step of {self.increment:.3g} m makes {ahead:.3g} m"
            )
        if step.alpha >= 0.0:
            return whole, step
        if share > 1.0 or (stays and not closing):
            raise NoEquilibriumError("another part falls")
        self.reached, self.end = True, "α = 0"
        return _down_to_zero(advance, self.multiplier[-1], whole, step, ZERO * max(self.multiplier))

    def fail(self, stop: NoEquilibriumError | ConvergenceError, last: bool) -> None:
        """A step has led nowhere; `last`: nor has any other, and the curve ends for the reason of the first."""
        if not self.failing:
            self.why = str(stop)
        self.failing = True
        if last:
            self.end, self.lost = self.why, isinstance(stop, NoEquilibriumError)

    def append(self, work: float, step: Step) -> None:
        """The next point."""
        self.rate = (step.state.positions - self.states[-1].positions) / work
        self.states.append(step.state)
        self.steps.append(step)
        self.certificates.append(step.certificate)
        self.multiplier.append(0.0 if self.reached else step.alpha)
        self.displacement.append(self.along(step.state.positions))
        before, now = self.displacement[-2:]
        self.control_rate = (now - before) / work
        if now - before > self.increment * (1.0 if self.failing else JUMPED):
            self.crossed.append((before, now))
        self.failing = self.snaps = False
        if abs(self.multiplier[-1] - self.plateau[1]) > FLAT * max(self.multiplier):
            self.plateau = (now, self.multiplier[-1])
        size = self.model.size
        if now - self.plateau[0] > size:
            alpha = self.multiplier[-1]
            self.end = f"the structure slides: α stays {alpha:.4g} over {size:.3g} m, and nothing ends that"
        if not self.end and not self.waits and self.multiplier[-1] <= self.until * max(self.multiplier):
            self.end = f"α has come down to {self.until:g} of its peak"
        if len(self.states) == MOST_STEPS and not self.end:
            self.end = f"{MOST_STEPS} points"

    def finished(self) -> Pushover:
        """The curve; ControlError where the control point takes no part in it."""
        if len(self.states) == 1 and self.contacts == "elastic" and self.drawn and not self.left:
            raise no_way_from_rest(self.end)
        moved = float(abs(self.states[-1].positions - self.states[0].positions)[:, :2].max())
        if len(self.states) == 1 or max(self.displacement) < STILL * moved:
            raise ControlError(
                f"control = {tuple(self.control.tolist())} takes no part in the mechanism along {self.direction}, "
                f"or the increment is too large: {self.end}"
            )
        formed, mechanism, forces = self._mechanism()
        return Pushover(
            np.array(self.displacement),
            np.array(self.multiplier),
            tuple(self.states),
            tuple(self.steps),
            tuple(self.certificates),
            self.reached,
            self.lost,
            self.end,
            np.array(self.crossed).reshape(-1, 2),
            mechanism,
            formed,
            forces,
        )

    def _mechanism(self) -> tuple[int, Array, Array]:
        """The point at which the mechanism is activated, its virtual displacements (b, 3), and the forces there."""
        peak = _peak(np.array(self.multiplier))
        for point in range(peak, len(self.states)):
            mechanism, forces = self._mechanism_at(point)
            if self._takes_part(point, mechanism):
                return point, mechanism, forces
        return peak, *self._mechanism_at(peak)

    def _mechanism_at(self, point: int) -> tuple[Array, Array]:
        """Virtual displacements (b, 3) and forces (c, 2) kN at a point; elastic: the motion that follows."""
        if self.contacts == "rigid" and point == 0:
            return self.first.rate, self.first.forces
        begin = min(point, len(self.states) - 2)
        motion = self.states[begin + 1].positions - self.states[begin].positions
        if self.contacts == "elastic":
            return motion, self.steps[point].forces
        step = self.steps[point - 1]
        there = replace(self.states[point], positions=step.at)
        return _mechanism(self.model, there, self.lateral, motion), step.forces

    def _takes_part(self, point: int, mechanism: Array) -> bool:
        """Whether the control point moves along the push in virtual displacements (b, 3) of a point."""
        fastest = float(abs(mechanism[:, :2]).max())
        little, at = 1e-6 * self.model.size / fastest, self.states[point].positions
        moved = self.along(at + little * mechanism) - self.along(at)
        return moved >= STILL * little * fastest


def _peak(multiplier: Array) -> int:
    """Index of the largest multiplier (k,), the first of those that differ by no more than rounding."""
    largest = float(multiplier.max())
    return int(np.argmax(multiplier >= largest - ZERO * abs(largest)))


def _mechanism(model: Assembly, state: State, lateral: Array, motion: Array) -> Array:
    """Virtual displacements (b, 3) over the contacts that touch or carry in a state; without any, its motion."""
    program, closed = closed_program(model, state, lateral)
    try:
        found = solve(program, layout=elimination_of(model, "rigid").take(closed))
    except (NoEquilibriumError, ConvergenceError):
        return motion
    mechanism = np.zeros_like(motion)
    mechanism[model.movable] = found.displacement.reshape(-1, 3)
    return mechanism


def _down_to_zero(
    advance: Callable[[float], Step], alpha: float, work: float, step: Step, tolerance: float
) -> tuple[float, Step]:
    """The work that brings the multiplier from α > 0 down to zero, and its step (false position, Illinois rule)."""
    low, high, least = (0.0, alpha), (work, step.alpha), work / 2.0**HALVINGS
    for count in range(MOST_CHORDS):
        if count >= CHORDS and abs(step.alpha) <= NEARLY / ZERO * tolerance:
            break
        chord = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
        if count and chord < least:
            break  # the multiplier jumps below zero within that
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
